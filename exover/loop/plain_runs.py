"""Plain runs: numbers replaced by simple ones that no condition tells from them.

Of all values that no condition tells from the given one, a plain run has the nearest to the poster's initial value or,
of arguments and results, to 0: `wind = 46` where a limit is 45. Two values are told apart iff they are on different
sides of a constant that they are compared with. Numbers that are compared with other numbers, or are part of a sum, are
left alone. States that differ in such values only are bisimilar (Milner 1989), so the plain run shows the same, and a
lasso stays a lasso.
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace
from decimal import Decimal
from functools import cached_property

from exover.dataclass import dataclass
from exover.loop.tracked_predicates import property_conditions
from exover.model.conditions import comparisons, conditions
from exover.model.event import Action, Ask, Event, Launched, Observe, Report
from exover.model.expression import Compare, Const, ModelTerm, Own, Param, Reading, leaves, mirrored
from exover.model.model import Model, Parameter
from exover.model.property import Properties
from exover.model.semantics import Reference
from exover.model.trace import Disagreement, Moment, Trace, run
from exover.model.types import Int, Real, Value

DIGITS = 4
"""A plain real has fewer than so many digits more than the cut next to it."""
Cut = tuple[float, int]
"""A constant that separates the values below it from the others (0), or those above it from the others (1)."""


@dataclass(frozen=True, slots=True)
class _Number:
    """The type of a number, its cuts in order, and the value to which its plain value should be near."""

    kind: Int | Real
    cuts: tuple[Cut, ...]
    near: float

    def plain(self, value: float) -> float:
        """Return a simple value near to `near` among those that the cuts do not tell from this one."""
        place = self._place(value)
        if self._place(self.near) == place:
            return self.near
        up = self.near < value
        bound = self.cuts[place - 1 if up else place][0]
        alike = (each for each in self._from(bound, up) if self.kind.low <= each <= self.kind.high)
        return next((each for each in alike if self._place(each) == place), value)

    def alike(self, one: float, other: float) -> bool:
        """Return whether two values are not told apart, and both are of the type."""
        return self._place(one) == self._place(other) and self.kind.low <= other <= self.kind.high

    def _place(self, value: float) -> int:
        """Return the number of cuts that a value lies beyond."""
        return bisect_right(self.cuts, (value, 0))

    def _from(self, bound: float, up: bool) -> Iterator[float]:
        """Yield a bound and numbers next to it: of an int the next, of a real one with as many digits after the point,
        then with more.
        """
        yield bound
        if isinstance(self.kind, Int):
            yield bound + 1 if up else bound - 1
            return
        exact = Decimal(repr(bound)).normalize()
        for digits in range(DIGITS):
            step = Decimal(1).scaleb(min(0, int(exact.as_tuple().exponent)) - digits)
            yield float(exact + step if up else exact - step)


Key = tuple[str | None, str]
"""A request and a parameter or result of it, or None and a poster."""


@dataclass(frozen=True)
class PlainRuns:
    """Makes runs of a model plain; conditions of the model and of the properties tell values apart."""

    model: Model
    properties: Properties

    def of(self, trace: Trace, reference: Reference) -> Trace:
        """Return the run with plain numbers; raises `Disagreement` if its answers differ by more than these numbers."""
        events = tuple(map(self._event, trace.events))
        if events == trace.events:
            return trace
        try:
            found = run(reference, events, trace.loop_start)
        except ValueError as error:
            raise Disagreement(f"a run of plain numbers: {error}") from error
        if found.moments != tuple(map(self._moment, trace.moments)):
            raise Disagreement(f"a run of {len(events)} steps is answered otherwise where its numbers are plain")
        return found

    def _moment(self, moment: Moment) -> Moment:
        return Moment(self._event(moment.event), tuple(map(self._action, moment.actions)))

    def _event(self, event: Event) -> Event:
        return _filled(event, [_plain([each]) for each in self.given(event)])

    def given(self, event: Event) -> "list[GivenValue]":
        """Return the values that an event gives."""
        match event:
            case Ask(request, args):
                return self._each(request, self.model.request[request].params, args)
            case Report(request, results=results):
                return self._each(request, self.model.request[request].results, results)
            case Observe(name, value, False):
                return [GivenValue(name, value, self._numbers.get((None, name)))]
            case _:
                return []

    def _each(self, request: str, parameters: Sequence[Parameter], values: Sequence[Value]) -> "list[GivenValue]":
        pairs = zip(parameters, values, strict=False)
        return [GivenValue(each.name, value, self._numbers.get((request, each.name))) for each, value in pairs]

    def _action(self, action: Action) -> Action:
        match action:
            case Launched(name, args=args):
                given = self._each(name, self.model.request[name].params, args)
                return replace(action, args=tuple(_plain([each]) for each in given))
            case _:
                return action

    @cached_property
    def _numbers(self) -> dict[Key, _Number]:
        """The numbers that are compared with constants only."""
        cuts, whole = self._compared
        return {
            key: _Number(kind, tuple(sorted(cuts.get(key, ()))), near)
            for key, kind, near in self._declared()
            if key not in whole
        }

    def _declared(self) -> Iterator[tuple[Key, Int | Real, float]]:
        """Yield the numbers that events give, with their types and the values that they should be near to."""
        for poster in self.model.variables:
            if isinstance(poster.type, Int | Real) and not isinstance(poster.initial, str):
                yield (None, poster.name), poster.type, poster.initial
        for request in self.model.requests:
            for each in (*request.params, *request.results):
                if isinstance(each.type, Int | Real):
                    zero = 0 if isinstance(each.type, Int) else 0.0
                    yield (request.name, each.name), each.type, min(max(zero, each.type.low), each.type.high)

    @cached_property
    def _compared(self) -> tuple[dict[Key, set[Cut]], set[Key]]:
        """The cuts of each number, and the numbers whose exact values matter."""
        cuts: dict[Key, set[Cut]] = {}
        whole: set[Key] = set()
        for owner, subject, compare in self._comparisons():
            for side, other, operator in _sides(compare):
                key = _key(side, subject, owner)
                if key is not None and isinstance(other, Const):
                    cuts.setdefault(key, set()).update(_cuts(operator, other.value))
                else:
                    whole.update(key for leaf in leaves(side) if (key := _key(leaf, subject, owner)) is not None)
        return cuts, whole

    def _comparisons(self) -> Iterator[tuple[str | None, str | None, Compare]]:
        """Yield each comparison of a condition, with the request whose condition it is and the one that it is about."""
        stated = ((None, condition) for condition in property_conditions(self.properties))
        for owner, condition in (*conditions(self.model), *stated):
            yield from ((owner, subject, compare) for subject, compare in comparisons(condition, owner))


@dataclass(frozen=True, slots=True)
class GivenValue:
    """A value that an event gives, and its cuts; None: its exact value matters."""

    name: str
    value: Value
    number: _Number | None


def _plain(given: Sequence[GivenValue]) -> Value:
    """Return a plain value for one that is given to several versions, and that none of them tells from it."""
    value = given[0].value
    numbers = [each.number for each in given if each.number is not None and each.value == value]
    if isinstance(value, str) or len(numbers) < len(given) or len({type(each.kind) for each in numbers}) > 1:
        return value
    tried = (number.plain(value) for number in numbers)
    return next((each for each in tried if all(number.alike(value, each) for number in numbers)), value)


def _filled(event: Event, values: Sequence[Value]) -> Event:
    """Return an event that gives these values instead of its own."""
    match event:
        case Ask():
            return replace(event, args=tuple(values))
        case Report():
            return replace(event, results=tuple(values))
        case Observe(broken=False):
            return replace(event, value=values[0])
        case _:
            return event


def plain_pair(sides: Sequence[PlainRuns], both: Sequence[Event | None]) -> tuple[Event | None, Event | None]:
    """Return the events that two versions get at once, with plain numbers that neither tells from the given ones."""
    given = [[] if event is None else side.given(event) for side, event in zip(sides, both, strict=True)]
    named: dict[str, list[GivenValue]] = {}
    for each in (each for found in given for each in found):
        named.setdefault(each.name, []).append(each)
    pairs = zip(both, given, strict=True)
    old, new = (event and _filled(event, [_plain(named[each.name]) for each in found]) for event, found in pairs)
    return old, new


def _key(leaf: ModelTerm, subject: str | None, owner: str | None) -> Key | None:
    match leaf:
        case Param(name):
            return subject, name
        case Own(name):
            return owner, name
        case Reading(name):
            return None, name
        case _:
            return None


def _sides(compare: Compare) -> Iterator[tuple[ModelTerm, ModelTerm, str]]:
    """Yield each side with the other, and the operator with that side on its left."""
    yield compare.left, compare.right, compare.operator
    yield compare.right, compare.left, mirrored(compare.operator)


def _cuts(operator: str, value: Value) -> tuple[Cut, ...]:
    """Return the cuts that a comparison with a constant makes."""
    if isinstance(value, bool | str):
        return ()
    below = () if operator in ("<=", ">") else ((value, 0),)
    return below if operator in ("<", ">=") else (*below, (value, 1))
