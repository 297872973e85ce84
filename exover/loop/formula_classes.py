"""What kind of question a formula is: of the start, of one run, or of what is possible from everywhere."""

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
    """A formula of LTL such that a run of which it is true shows a formula of CTL; `exact`: only such a run does."""

    formula: Formula
    exact: bool = True


def path_of(formula: Formula, positive: bool = True) -> Path | None:
    """Return what a single run must satisfy to show a formula of CTL, or its negation; None if none can show it."""
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
        """What a run that shows it satisfies, of LTL."""
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
    """The formula that says so."""


def way_of(formula: Formula) -> ExistsUntil | None:
    """Return the way that a formula of CTL asks for."""
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
    """Return what a formula of CTL says, if it says that there is no way from somewhere."""
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
    """F (since and G stays): a run that from some moment on stays where it is."""

    since: Formula
    stays: Formula

    @property
    def whole(self) -> Formula:
        """What is true of the moment from which on the run stays."""
        return Conjunction((self.since, self.stays))


def lingering_of(path: Formula) -> Lingering | None:
    """Return what a formula of LTL says, if it says that a run stays somewhere for ever."""
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
    """The formula is true iff what this asks is not."""

    part: "QuestionClass"


@dataclass(frozen=True, slots=True)
class Joined:
    """The formula is true iff what the parts ask is: each, if `every`, or one of them."""

    parts: tuple["QuestionClass", ...]
    every: bool


@dataclass(frozen=True, slots=True)
class Unclassed:
    """No single run shows the formula, and it does not ask for ways from everywhere."""


QuestionClass = AtStart | Opposite | Joined | ExistsUntil | Stuck | Path | Unclassed


def question_of(formula: Formula) -> QuestionClass:
    """Return which question a formula of CTL is: of the start, of runs, of ways, or made of such."""
    if momentary(formula):
        return AtStart(formula)
    match formula:
        case Negation(part):
            return Opposite(question_of(part))
        case Conjunction(parts) | Disjunction(parts):
            return Joined(tuple(map(question_of, parts)), isinstance(formula, Conjunction))
        case _:
            return way_of(formula) or stuck_of(formula) or path_of(formula) or Unclassed()
