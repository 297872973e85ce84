"""Interventions: for each other value of a quantity, the state and the event with nothing else changed."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import islice, product
from typing import assert_never

from exover.dataclass import dataclass
from exover.explain.intervals import Interval, described, intervals, refined
from exover.explain.paths import Surroundings
from exover.explain.relevance import Factor, Mention, ValueKey, compared, cuts
from exover.model.event import Args, Ask, Event, Observe, Report
from exover.model.model import Model, Parameter
from exover.model.state import Slot, State
from exover.model.types import Bool, Enum, Int, Real, Type, Value, resting_value
from exover.model.wording import named_text, slot_text, value_text

COMBINATIONS = 12
"""The most combinations of arguments that are tried for one slot or past."""


Moment = tuple[State, Event]
Put = Callable[[State, Event, Value], Moment]
"""Returns a state and an event with a value as some quantity."""
Follow = Callable[[State, Event], object]
"""Goes through all that is compared when a state and an event are tried."""


@dataclass(frozen=True, slots=True)
class Intervention:
    """One change: `subject` and `predicate` in words ("nd.speed", "were 0.3"), and the state and event after it.

    `interval`: of a number, else None; options of one quantity with adjacent intervals can be told as one. `put`: puts
    another number. `whole`: the text for all options of a quantity with this text together, whatever the arguments.
    """

    subject: str
    predicate: str
    state: State
    event: Event
    interval: Interval | None = None
    type: Int | Real | None = None
    put: Put | None = None
    whole: str = ""

    @property
    def text(self) -> str:
        """The change in words, to follow `if`."""
        return f"{self.subject} {self.predicate}"

    def meets(self, other: "Intervention") -> bool:
        """Return whether both are intervals of a number, and the other follows this one with no number between."""
        return self.interval is not None and other.interval is not None and self.interval.meets(other.interval)


def merged(first: Intervention, last: Intervention) -> str:
    """Return the text of all options of a number from `first` to `last`."""
    if first.interval is None or last.interval is None or first.type is None:
        return first.text
    return f"{first.subject} were {described(first.interval, last.interval, first.type)}"


def at_sample(option: Intervention) -> Intervention:
    """Return an option that tells of an interval only the number that was tried."""
    if option.interval is None:
        return option
    return replace(option, predicate=f"were {value_text(option.interval.sample)}", interval=None)


@dataclass(frozen=True)
class Interventions:
    """The interventions in a state and an event; `mentions`: the comparisons whose truth an intervention may change.

    `compared`: the values that anything in the model is compared with; they are told of what is imagined.
    """

    model: Model
    state: State
    event: Event
    mentions: tuple[Mention, ...]
    compared: frozenset[ValueKey]
    follow: Follow

    def of(self, quantity: Factor) -> Iterator[Intervention]:
        """Yield an intervention for each other value of the quantity, numbers in ascending order."""
        name = quantity.name
        match quantity.kind:
            case "given":
                yield from self._given(quantity)
            case "reading":
                values = self._values(name, ("", name), self._type(name), self.state.readings[name], _reading(name))
                yield from (option for _, option in values)
            case "level":
                level = self.state.levels[name]
                values = self._values(f"level({name})", ("", name), self._type(name), level, _level(name))
                yield from (option for _, option in values)
            case "slot":
                yield from self._slot(name, quantity.index)
            case "place":
                if self.state.places[name]:
                    yield Intervention("nothing", f"waited at {name}", self.state.with_place(name, None), self.event)
            case "past":
                yield from self._past(name)
            case "last":
                for outcome in ("none", "ok", "failed", "interrupted"):
                    if outcome != self.state.last[name]:
                        state = replace(self.state, last={**self.state.last, name: outcome})
                        yield Intervention(f"last({name})", f"were {outcome}", state, self.event)
            case _:
                assert_never(quantity.kind)

    def _type(self, name: str) -> Type:
        """Return the type of a poster, state, level or latch."""
        if name in self.model.variable:
            return self.model.variable[name].type
        return Int(0, self.model.resource[name].capacity) if name in self.state.levels else Bool()

    def _values(
        self, subject: str, key: ValueKey, kind: Type, present: Value, put: Put
    ) -> Iterator[tuple[Value, Intervention]]:
        """Yield each other value, of a number one per interval, with the intervention that puts it."""
        match kind:
            case Bool() | Enum():
                values: tuple[Value, ...] = (False, True) if isinstance(kind, Bool) else kind.values
                for value in values:
                    if value != present:
                        text = f"were {value_text(value)}"
                        yield value, Intervention(subject, text, *put(self.state, self.event, value))
            case Int() | Real():
                assert isinstance(present, int | float)
                for interval in self._intervals(key, kind, present, put):
                    sample = interval.sample
                    if sample != present:
                        text = f"were {described(interval, interval, kind)}"
                        made = put(self.state, self.event, sample)
                        yield sample, Intervention(subject, text, *made, interval, kind, put)
            case _:
                assert_never(kind)

    def _intervals(self, key: ValueKey, kind: Int | Real, present: int | float, put: Put) -> Iterator[Interval]:
        """Yield intervals of the numbers of a type in each of which all numbers have one answer."""

        def around(number: int | float) -> Surroundings:
            near = Surroundings(number)
            self.follow(*put(self.state, self.event, near.probe()))
            return near

        for interval in intervals(kind, self._cuts(key), present):
            yield from refined(interval, present, around)

    def _cuts(self, key: ValueKey) -> set[Fraction]:
        found = cuts(self.model, self.state, self.event, self.mentions, key)
        if key[0] == "" and key[1] in self.state.levels and isinstance(self.event, Ask):
            clauses = self.model.request[self.event.request].consumptions
            found |= {Fraction(clause.amount) for clause in clauses if clause.resource == key[1]}
            found.add(Fraction(sum(clause.amount for clause in clauses if clause.resource == key[1])))
        return found

    def _given(self, quantity: Factor) -> Iterator[Intervention]:
        """Yield the interventions on a value that the event carries."""
        name, index, event = quantity.name, quantity.index, self.event
        match event:
            case Ask(args=old):
                field = self.model.request[name].params[index]
                found = self._values(
                    f"the asked {field.name}", (name, field.name), field.type, old[index], _asked(index)
                )
            case Report(results=old):
                field = self.model.request[name].results[index]
                subject = f"the reported {field.name}"
                found = self._values(subject, (name, field.name), field.type, old[index], _reported(index))
            case Observe():
                found = self._values(f"the observed {name}", ("", name), self._type(name), event.value, _observed)
            case _:
                raise AssertionError(f"{event} gives nothing")
        yield from (option for _, option in found)

    # ---- slots and pasts ----

    def _slot(self, name: str, index: int) -> Iterator[Intervention]:
        """Yield the slot as idle, and with other arguments, or if it is idle as running with each combination."""
        slot, called = self.state.slots[name][index], slot_text(self.model, name, index)
        params = self.model.request[name].params
        if slot is not None:
            yield Intervention(called, "were idle", self.state.with_slot((name, index), None), self.event)
        elif None in self.state.slots[name][:index]:
            return  # idle slots of one request are alike
        phase = slot.phase if slot else "running"

        def put(state: State, event: Event, args: Args) -> Moment:
            return state.with_slot((name, index), Slot(phase, args)), event

        whole = f"{called} {'had other arguments' if slot else 'were running'}"
        for args, told, complete in self._arguments(name, params, slot.args if slot else None, put):
            predicate = f"had {told}" if slot else f"were running with {told}" if told else "were running"
            moment = put(self.state, self.event, args)
            yield Intervention(called, predicate, *moment, whole=whole if complete else "")

    def _past(self, name: str) -> Iterator[Intervention]:
        request, past = self.model.request[name], self.state.past[name]
        if past is not None:
            yield Intervention(f"past({name})", "were forgotten", self.state.with_past(name, None), self.event)

        def put(state: State, event: Event, values: Args) -> Moment:
            return state.with_past(name, values), event

        whole = f"past({name}) {'had other values' if past else 'were there'}"
        for values, told, complete in self._arguments(name, (*request.params, *request.results), past, put):
            predicate = f"had {told}" if told else "were there"
            moment = put(self.state, self.event, values)
            yield Intervention(f"past({name})", predicate, *moment, whole=whole if complete else "")

    def _arguments(
        self,
        name: str,
        fields: tuple[Parameter, ...],
        present: Args | None,
        put: Callable[[State, Event, Args], Moment],
    ) -> Iterator[tuple[Args, str, bool]]:
        """Yield other arguments than the present ones, with the words for those that anything is compared with.

        The last value: whether the answers to all that are yielded are the answers to whatever arguments.
        """
        now = present or tuple(resting_value(field.type) for field in fields)
        read = compared(self.mentions)
        varied = [(name, field.name) in read for field in fields]
        shown = [(name, field.name) in self.compared for field in fields]
        columns: list[list[Value]] = []
        for index, field in enumerate(fields):

            def put_one(state: State, event: Event, value: Value, index: int = index) -> Moment:
                return put(state, event, (*now[:index], value, *now[index + 1 :]))

            key = (name, field.name)
            others = self._values("", key, field.type, now[index], put_one) if varied[index] else ()
            columns.append([now[index], *(value for value, _ in others)])
        numbers = any(is_varied and isinstance(f.type, Int | Real) for f, is_varied in zip(fields, varied, strict=True))
        if present is None:
            complete = varied == shown and (not numbers or sum(varied) == 1)
        else:  # another value of what is not read, or of a number that is not told from it, is an other one, too
            complete = all(varied) and not numbers
        complete &= math.prod(map(len, columns)) <= COMBINATIONS
        for values in islice(product(*columns), COMBINATIONS):
            if values != present:
                told = [
                    named_text((f,), (v,)) for f, v, is_shown in zip(fields, values, shown, strict=True) if is_shown
                ]
                yield values, ", ".join(told), complete


def _reading(name: str) -> Put:
    return lambda state, event, value: (state.with_reading(name, value), event)


def _level(name: str) -> Put:
    def put(state: State, event: Event, value: Value) -> Moment:
        assert isinstance(value, int)
        return state.with_level(name, value), event

    return put


def _asked(index: int) -> Put:
    def put(state: State, event: Event, value: Value) -> Moment:
        assert isinstance(event, Ask)
        return state, replace(event, args=(*event.args[:index], value, *event.args[index + 1 :]))

    return put


def _reported(index: int) -> Put:
    def put(state: State, event: Event, value: Value) -> Moment:
        assert isinstance(event, Report)
        return state, replace(event, results=(*event.results[:index], value, *event.results[index + 1 :]))

    return put


def _observed(state: State, event: Event, value: Value) -> Moment:
    assert isinstance(event, Observe)
    return state, Observe(event.name, value)
