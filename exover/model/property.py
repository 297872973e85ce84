"""Properties of runs and assumptions on runs: the content of a properties file (docs/language.md section 8).

A property is about the moments of a run: the start, and the moment after each step. Its formula uses the closed
core below; every form of the language is translated to it. CTL as in Clarke, Emerson 1981, LTL as in Pnueli 1977.
"""

from collections.abc import Iterator
from dataclasses import field
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.expression import Cond
from exover.model.model import NOWHERE, Location, Rule

Label = tuple[str, ...]
"""The label of a mark of the closed loop (`exover.loop.finite.program.Mark`)."""
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

    The arguments that were asked for, or those of the slot, satisfy `where`. At the start it is false.
    """

    occurrence: Occurrence
    request: str
    where: Cond | None = None


@dataclass(frozen=True, slots=True)
class Passed:
    """The step that led to the moment passed a mark of the closed loop.

    Only claims of checks contain it; a properties file cannot. At the start it is false.
    """

    label: Label


@dataclass(frozen=True, slots=True)
class Broken:
    """The rule's F holds in the state of a moment; `once_stopped`: with the stopping slots taken as idle.

    For a rule that stands for each slot of a request: F holds for some active slot.
    """

    rule: Rule
    once_stopped: bool


@dataclass(frozen=True, slots=True)
class Negation:
    """Not `part`."""

    part: "Formula"


@dataclass(frozen=True, slots=True)
class Conjunction:
    """The conjunction of `parts`; the empty one is true."""

    parts: tuple["Formula", ...]


@dataclass(frozen=True, slots=True)
class Disjunction:
    """The disjunction of `parts`; the empty one is false."""

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
"""An atom: a formula without operators, true or false at one moment."""
Formula = Momentary | Negation | Conjunction | Disjunction | SomeNext | SomeUntil | SomeAlways | Next | Until
"""A state formula of CTL (without `Next` and `Until`) or a path formula of LTL (without `Some…`)."""
Temporal = SomeNext | SomeUntil | SomeAlways | Next | Until
"""A formula whose outermost operator is temporal."""

TRUE = Conjunction(())
FALSE = Disjunction(())


@dataclass(frozen=True, slots=True)
class Property:
    """A named property; `formula` is of LTL iff `form` is `ltl`, else of CTL.

    `premise`: must be true at some reachable moment, or the property holds vacuously; None if the form has none.
    `text`: the string after the name, None if there is none.
    """

    name: str
    text: str | None
    form: Form
    formula: Formula
    premise: Formula | None
    location: Location


@dataclass(frozen=True, slots=True)
class Assumption:
    """The assumption that this formula, which has no temporal operator, is true after every step."""

    formula: Formula
    location: Location


@dataclass(frozen=True, slots=True)
class Properties:
    """The content of a properties file; `fair`: every slot is idle or being reported infinitely often.

    `file`: the name of the file, None if there is none.
    """

    properties: tuple[Property, ...] = ()
    assumptions: tuple[Assumption, ...] = ()
    fair: bool = False
    file: str | None = field(default=None, compare=False)
    fair_at: Location = field(default=NOWHERE, compare=False)
    """The place of `assume fair reports`."""


NO_PROPERTIES = Properties()


def formulas(properties: Properties) -> Iterator[Formula]:
    """Yield the formula and the premise of each property, then the formulas of the assumptions."""
    for each in properties.properties:
        yield each.formula
        if each.premise is not None:
            yield each.premise
    for assumption in properties.assumptions:
        yield assumption.formula


def happened(properties: Properties) -> Iterator[Happened | Passed]:
    """Yield the atoms that are about steps (`Happened`, `Passed`), in the order of `formulas`."""
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
    """Return `A [left U right]`, as `not E [not right U (not left and not right)] and not EG not right`."""
    neither = Conjunction((Negation(left), Negation(right)))
    return Conjunction((Negation(SomeUntil(Negation(right), neither)), Negation(SomeAlways(Negation(right)))))


def until_of(formula: Formula) -> tuple[Formula, Formula] | None:
    """Return the two parts of a formula that `all_until` has made; None if it has not."""
    match formula:
        case Conjunction((Negation(SomeUntil(Negation(right), Conjunction((Negation(left), _)))), _)):
            return (left, right) if formula == all_until(left, right) else None
        case _:
            return None


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
    """Return the operands of a formula; an atom has none."""
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
    """Yield a formula and its subformulas in the order of the text, each before its own parts (preorder)."""
    yield formula
    for part in parts_of(formula):
        yield from subformulas(part)


def momentary(formula: Formula) -> bool:
    """Return True iff a formula has no temporal operator."""
    return not isinstance(formula, Temporal) and all(map(momentary, parts_of(formula)))
