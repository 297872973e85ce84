"""Classes of formulas: about the start, about one run, or about what is possible from everywhere."""

from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.model.property import (
    FALSE,
    TRUE,
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    Next,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    momentary,
)


@dataclass(frozen=True, slots=True)
class Path:
    """A formula of LTL, true of a run only if that run shows a formula of CTL; `exact`: if and only if."""

    formula: Formula
    exact: bool = True


def path_of(formula: Formula, positive: bool = True) -> Path | None:
    """Return what a run must satisfy to show a formula of CTL (unless `positive`, its negation); None if none can."""
    if momentary(formula):
        return Path(formula if positive else Negation(formula))
    match formula:
        case Negation(part):
            return path_of(part, not positive)
        case Conjunction(parts) | Disjunction(parts):
            found = [path_of(part, positive) for part in parts]
            if isinstance(formula, Conjunction) != positive:
                able = [path for path in found if path is not None]
                whole = len(able) == len(found) and all(path.exact for path in able)
                return Path(Disjunction(tuple(path.formula for path in able)), whole) if able else None
            if any(path is None for path in found):
                return None
            temporal = [part for part in parts if not momentary(part)]
            exact = len(temporal) == 1 and all(path.exact for path in found if path)
            return Path(Conjunction(tuple(path.formula for path in found if path)), exact)
        case SomeNext(part) if positive:
            after = path_of(part)
            return None if after is None else Path(Next(after.formula), after.exact)
        case SomeUntil(left, right) if positive:
            first, last = path_of(left), path_of(right)
            if first is None or last is None:
                return None
            return Path(Until(first.formula, last.formula), momentary(left) and last.exact)
        case SomeAlways(part) if positive:
            always = path_of(part)
            if always is None:
                return None
            return Path(Negation(Until(TRUE, Negation(always.formula))), momentary(part))
        case _:
            return None


def undoubled(formula: Formula) -> Formula:
    """Return a formula without negations of negations at its top."""
    while isinstance(formula, Negation) and isinstance(formula.part, Negation):
        formula = formula.part.part
    return formula


def conjuncts(formula: Formula, positive: bool = True) -> Iterator[Formula]:
    """Yield formulas whose conjunction is the formula, or its negation."""
    match formula:
        case Negation(part):
            if isinstance(part, Negation | Conjunction | Disjunction):
                yield from conjuncts(part, not positive)
            else:
                yield formula if positive else part
        case Conjunction(parts) if positive:
            for part in parts:
                yield from conjuncts(part)
        case Disjunction(parts) if not positive:
            for part in parts:
                yield from conjuncts(part, positive=False)
        case _:
            yield formula if positive else Negation(formula)


@dataclass(frozen=True, slots=True)
class ExistsUntil:
    """E [allowed U goal], after a step first if `strict`."""

    allowed: Formula
    goal: Formula
    strict: bool

    @property
    def path(self) -> Formula:
        """The formula of LTL that a run which shows it satisfies."""
        if self.strict and self.allowed == FALSE:
            return Next(self.goal)
        until = Until(self.allowed, self.goal)
        return Next(until) if self.strict else until


@dataclass(frozen=True, slots=True)
class Stuck:
    """EF (since and not the way): a moment from which there is no way to the goal."""

    since: Formula
    way: ExistsUntil
    formula: Formula
    """The formula of CTL that says this."""


def way_of(formula: Formula) -> ExistsUntil | None:
    """Return a formula of CTL as E [allowed U goal] or EX of it; None if it is none."""
    match formula:
        case SomeNext(SomeUntil(allowed, goal)) if momentary(allowed) and momentary(goal):
            return ExistsUntil(allowed, goal, strict=True)
        case SomeUntil(allowed, goal) if momentary(allowed) and momentary(goal):
            return ExistsUntil(allowed, goal, strict=False)
        case SomeNext(goal) if momentary(goal):
            return ExistsUntil(FALSE, goal, strict=True)
        case _:
            return None


def stuck_of(formula: Formula) -> Stuck | None:
    """Return a formula of CTL as EF (since and not the way); None if it is none."""
    match formula:
        case SomeUntil(Conjunction(()), bad):
            found = list(conjuncts(bad))
            temporal = [part for part in found if not momentary(part)]
            if len(temporal) == 1 and isinstance(temporal[0], Negation):
                way = way_of(temporal[0].part)
                since = Conjunction(tuple(part for part in found if momentary(part)))
                return None if way is None else Stuck(since, way, formula)
        case _:
            pass
    return None


@dataclass(frozen=True, slots=True)
class Lingering:
    """F (since and G stays): from some moment on, `stays` is true for ever; at that moment `since` is true as well."""

    since: Formula
    stays: Formula

    @property
    def whole(self) -> Formula:
        """What is true of the moment from which on the run stays."""
        return Conjunction((self.since, self.stays))


def lingering_of(path: Formula) -> Lingering | None:
    """Return a formula of LTL as F (since and G stays); None if it is none."""
    since: list[Formula] = []
    stays: list[Formula] = []
    inside = path
    match path:
        case Until(Conjunction(()), right):
            inside = right
    for part in conjuncts(inside):
        match part:
            case Negation(Until(Conjunction(()), given_up)):
                stays.append(Negation(given_up))
            case _ if momentary(part):
                since.append(part)
            case _:
                return None
    if not stays or not all(momentary(part) for part in stays):
        return None
    return Lingering(Conjunction(tuple(since)), Conjunction(tuple(stays)))


@dataclass(frozen=True, slots=True)
class AtStart:
    """A formula of one moment: is it true at the start?"""

    formula: Formula


@dataclass(frozen=True, slots=True)
class Opposite:
    """The negation of another question."""

    part: "QuestionClass"


@dataclass(frozen=True, slots=True)
class Joined:
    """The conjunction of questions if `every`, else their disjunction."""

    parts: tuple["QuestionClass", ...]
    every: bool


@dataclass(frozen=True, slots=True)
class Unclassed:
    """A formula in none of these classes."""


QuestionClass = AtStart | Opposite | Joined | ExistsUntil | Stuck | Path | Unclassed


def question_of(formula: Formula) -> QuestionClass:
    """Return the class of a formula of CTL."""
    if momentary(formula):
        return AtStart(formula)
    match formula:
        case Negation(part):
            return Opposite(question_of(part))
        case Conjunction(parts) | Disjunction(parts):
            return Joined(tuple(map(question_of, parts)), isinstance(formula, Conjunction))
        case _:
            return way_of(formula) or stuck_of(formula) or path_of(formula) or Unclassed()
