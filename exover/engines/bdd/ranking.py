"""Rankings: proofs that no fair run stays among some states (Manna, Pnueli 1991).

A state has the rank of the layer that it is in. No step that stays among the states leads up, and in each layer
something is missing for ever: so a run that stays would stay in one layer at last, and not be fair.
"""

from collections.abc import Generator, Iterator

from exover.dataclass import dataclass
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.space import Set
from exover.model.property import (
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    Next,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    subformulas,
)


@dataclass(frozen=True, slots=True)
class Layer:
    """States that never meet the constraint of this number, nor does a step from one to another of them.

    None: no step leads from one of them to another at all, but only into layers before, and out.
    """

    never: int | None
    states: Set


def ranking(fixpoints: Fixpoints, part: Set) -> Iterator[Layer]:
    """Yield the layers of the states of `part` from which no fair run stays in it, the lowest first.

    They are what the greatest fixpoint `Fixpoints.always` takes away, piece by piece: a step from a layer that stays in
    `part` leads into it or into one before.
    """
    found = part & fixpoints.steps.universe
    while True:
        before = found
        found = yield from _led_out(fixpoints, found)
        for number, constraint in enumerate(fixpoints.constraints):
            kept = fixpoints.meets(constraint, found)
            if kept != found:
                yield Layer(number, found & ~kept)
                found = yield from _led_out(fixpoints, kept)
        if found == before:
            return


def _led_out(fixpoints: Fixpoints, part: Set) -> Generator[Layer, None, Set]:
    """Yield by layers the states of `part` from which every run leads out of it, and return the others."""
    while True:
        kept = fixpoints.before(part, part)
        if kept == part:
            return part
        yield Layer(None, part & ~kept)
        part = kept


def distinct(formula: Formula) -> Formula:
    """Return an equivalent formula of LTL in which no two temporal operators are the same subformula.

    So the product with its tableau has a promise for each of them, in whatever order they are numbered.
    """
    return _distinct(formula, set())


def _distinct(formula: Formula, seen: set[Formula]) -> Formula:
    found: Formula
    match formula:
        case Negation(part):
            return Negation(_distinct(part, seen))
        case Conjunction(parts):
            return Conjunction(tuple(_distinct(part, seen) for part in parts))
        case Disjunction(parts):
            return Disjunction(tuple(_distinct(part, seen) for part in parts))
        case Next(part):
            part = _distinct(part, seen)
            while (found := Next(part)) in seen:
                part = Conjunction((part,))
        case Until(left, right):
            left, right = _distinct(left, seen), _distinct(right, seen)
            while (found := Until(left, right)) in seen:
                right = Conjunction((right,))
        case _:
            return formula
    seen.add(found)
    return found


def temporal(formula: Formula) -> Iterator[Formula]:
    """Yield the temporal operators of a formula as they are numbered: each before those within it."""
    operators = SomeNext | SomeUntil | SomeAlways | Next | Until
    return (each for each in subformulas(formula) if isinstance(each, operators))
