"""Properties of runs and assumptions on them: what a properties file says (docs/language.md section 8).

A property speaks of the moments of a run: the start, and the moment after each step. Its formula is over the closed
core below; every form of the language is one of these formulas. CTL as in Clarke, Emerson 1981, LTL as in Pnueli 1977.
"""

from collections.abc import Iterator
from dataclasses import field
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.expression import Cond
from exover.model.model import NOWHERE, Location, Rule

Label = tuple[str, ...]
"""What a mark of the closed loop is called (`exover.loop.finite.program.Mark`)."""
Occurrence = Literal["asked", "launched", "rejected", "killed", "ended"]
Form = Literal[
    "never", "always", "possible", "always possible", "from possible", "leads to", "precedes", "until", "ctl", "ltl"
]


@dataclass(frozen=True, slots=True)
class Atom:
    """A condition that holds in the state of a moment."""

    condition: Cond


@dataclass(frozen=True, slots=True)
class Happened:
    """The step that led to the moment asked, launched, rejected, killed or ended (reported) the request.

    With arguments that satisfy `where`: those asked for, or those of the slot. At the start nothing has happened.
    """

    occurrence: Occurrence
    request: str
    where: Cond | None = None


@dataclass(frozen=True, slots=True)
class Passed:
    """The step that led to the moment passed a mark of the closed loop.

    No properties file can say it; what the checks claim does. At the start nothing has been passed.
    """

    label: Label


@dataclass(frozen=True, slots=True)
class Broken:
    """The rule's F holds in the state of a moment; `once_stopped`: with the stopping slots taken as idle.

    Of a rule for each slot of a request: for some active slot.
    """

    rule: Rule
    once_stopped: bool


@dataclass(frozen=True, slots=True)
class Negation:
    """Not `part`."""

    part: "Formula"


@dataclass(frozen=True, slots=True)
class Conjunction:
    """All of `parts`; of nothing it is true."""

    parts: tuple["Formula", ...]


@dataclass(frozen=True, slots=True)
class Disjunction:
    """One of `parts`; of nothing it is false."""

    parts: tuple["Formula", ...]


@dataclass(frozen=True, slots=True)
class SomeNext:
    """CTL `EX part`."""

    part: "Formula"


@dataclass(frozen=True, slots=True)
class SomeUntil:
    """CTL `E [left U right]`."""

    left: "Formula"
    right: "Formula"


@dataclass(frozen=True, slots=True)
class SomeAlways:
    """CTL `EG part`."""

    part: "Formula"


@dataclass(frozen=True, slots=True)
class Next:
    """LTL `X part`."""

    part: "Formula"


@dataclass(frozen=True, slots=True)
class Until:
    """LTL `left U right`."""

    left: "Formula"
    right: "Formula"


Momentary = Atom | Happened | Passed | Broken
"""An atom: what is true or false of one moment."""
Formula = Momentary | Negation | Conjunction | Disjunction | SomeNext | SomeUntil | SomeAlways | Next | Until
"""A state formula of CTL (without `Next` and `Until`) or a path formula of LTL (without `Some…`)."""
Temporal = SomeNext | SomeUntil | SomeAlways | Next | Until
"""A formula whose outermost operator is temporal."""

TRUE = Conjunction(())
FALSE = Disjunction(())


@dataclass(frozen=True, slots=True)
class Property:
    """A named property; `formula` is of LTL iff `form` is `ltl`.

    `premise`: what must be true in some reachable moment, lest the property hold without saying anything; None where
    the form has no premise. `text`: what the engineer wrote beside the name.
    """

    name: str
    text: str | None
    form: Form
    formula: Formula
    premise: Formula | None
    location: Location


@dataclass(frozen=True, slots=True)
class Assumption:
    """Only steps are looked at after which this formula, which has no temporal operator, is true."""

    formula: Formula
    location: Location


@dataclass(frozen=True, slots=True)
class Properties:
    """What a properties file says; `fair`: every slot is, again and again, idle or being reported.

    `file`: its name, None if there is none.
    """

    properties: tuple[Property, ...] = ()
    assumptions: tuple[Assumption, ...] = ()
    fair: bool = False
    file: str | None = field(default=None, compare=False)
    fair_at: Location = field(default=NOWHERE, compare=False)
    """Where fair reports are assumed."""


NO_PROPERTIES = Properties()


def formulas(properties: Properties) -> Iterator[Formula]:
    """Yield the formulas of properties, their premises, and the assumptions."""
    for each in properties.properties:
        yield each.formula
        if each.premise is not None:
            yield each.premise
    for assumption in properties.assumptions:
        yield assumption.formula


def happened(properties: Properties) -> Iterator[Happened | Passed]:
    """Yield the predicates on steps, in the order of the text."""
    for formula in formulas(properties):
        for atom in atoms(formula):
            if isinstance(atom, Happened | Passed):
                yield atom


def some_finally(part: Formula) -> Formula:
    """Return `EF part`."""
    return SomeUntil(TRUE, part)


def all_next(part: Formula) -> Formula:
    """Return `AX part`."""
    return Negation(SomeNext(Negation(part)))


def all_finally(part: Formula) -> Formula:
    """Return `AF part`."""
    return Negation(SomeAlways(Negation(part)))


def all_always(part: Formula) -> Formula:
    """Return `AG part`."""
    return Negation(some_finally(Negation(part)))


def all_until(left: Formula, right: Formula) -> Formula:
    """Return `A [left U right]`: neither is `right` avoided for ever, nor `left` given up before it."""
    neither = Conjunction((Negation(left), Negation(right)))
    return Conjunction((Negation(SomeUntil(Negation(right), neither)), Negation(SomeAlways(Negation(right)))))


def finally_(part: Formula) -> Formula:
    """Return LTL `F part`."""
    return Until(TRUE, part)


def always(part: Formula) -> Formula:
    """Return LTL `G part`."""
    return Negation(finally_(Negation(part)))


def implies(left: Formula, right: Formula) -> Formula:
    """Return `left -> right`."""
    return Disjunction((Negation(left), right))


def parts_of(formula: Formula) -> tuple[Formula, ...]:
    """Return the formulas of which a formula is made."""
    match formula:
        case Atom() | Happened() | Passed() | Broken():
            return ()
        case Negation(part) | SomeNext(part) | SomeAlways(part) | Next(part):
            return (part,)
        case Conjunction(parts) | Disjunction(parts):
            return parts
        case SomeUntil(left, right) | Until(left, right):
            return (left, right)
        case _:
            assert_never(formula)


def atoms(formula: Formula) -> Iterator[Momentary]:
    """Yield the atoms of a formula in the order of the text."""
    return (each for each in subformulas(formula) if isinstance(each, Momentary))


def subformulas(formula: Formula) -> Iterator[Formula]:
    """Yield a formula and all that it is made of, in the order of the text, each before those within it."""
    yield formula
    for part in parts_of(formula):
        yield from subformulas(part)


def momentary(formula: Formula) -> bool:
    """Return true iff a formula has no temporal operator."""
    return not isinstance(formula, Temporal) and all(map(momentary, parts_of(formula)))
