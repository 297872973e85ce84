"""Interventions: for each other value of a quantity, the state and the event with nothing else changed."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import islice, product
from typing import assert_never

from exover.dataclass import dataclass
from exover.explain.intervals import Interval, described, intervals
from exover.explain.relevance import Factor, Mention, ValueKey, cuts
from exover.model.event import Args, Ask, Event, Observe, Report
from exover.model.expression import Own, Param, leaves
from exover.model.model import Model, Parameter
from exover.model.state import Slot, State
from exover.model.types import Bool, Enum, Int, Real, Type, Value, least
from exover.model.wording import named_text, slot_text, value_text

COMBINATIONS = 12
"""The most combinations of arguments that are tried for one slot or past."""


@dataclass(frozen=True, slots=True)
class Intervention:
    """One change: `subject` and `predicate` in words ("nd.speed", "were 0.3"), and the state and event after it.

    `interval`: of a number, else None; options of one quantity with adjacent intervals can be told as one. `whole`: the
    text for all options of a quantity with this text together, whatever the arguments.
    """

    subject: str
    predicate: str
    state: State
    event: Event
    interval: Interval | None = None
    type: Int | Real | None = None
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


@dataclass(frozen=True)
class Interventions:
    """The interventions in a state and an event; `mentions`: the comparisons whose truth an intervention may change."""

    model: Model
    state: State
    event: Event
    mentions: tuple[Mention, ...]

    def of(self, quantity: Factor) -> Iterator[Intervention]:
        """Yield an intervention for each other value of the quantity, numbers in ascending order."""
        name = quantity.name
        match quantity.kind:
            case "given":
                yield from self._given(quantity)
            case "reading":
                for value, option in self._values(name, ("", name), self._type(name), self.state.readings[name]):
                    yield replace(option, state=self.state.with_reading(name, value))
            case "level":
                level = self.state.levels[name]
                for value, option in self._values(f"level({name})", ("", name), self._type(name), level):
                    yield replace(option, state=self.state.with_level(name, int(value)))
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

    def _values(self, subject: str, key: ValueKey, kind: Type, present: Value) -> Iterator[tuple[Value, Intervention]]:
        """Yield each other value, of a number one per interval, with an intervention that does not apply it yet."""
        match kind:
            case Bool() | Enum():
                values: tuple[Value, ...] = (False, True) if isinstance(kind, Bool) else kind.values
                for value in values:
                    if value != present:
                        yield value, Intervention(subject, f"were {value_text(value)}", self.state, self.event)
            case Int() | Real():
                assert isinstance(present, int | float)
                for interval in intervals(kind, self._cuts(key), present):
                    if interval.sample != present:
                        text = f"were {described(interval, interval, kind)}"
                        yield interval.sample, Intervention(subject, text, self.state, self.event, interval, kind)
            case _:
                assert_never(kind)

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
                for value, option in self._values(
                    f"the asked {field.name}", (name, field.name), field.type, old[index]
                ):
                    yield replace(option, event=replace(event, args=(*old[:index], value, *old[index + 1 :])))
            case Report(results=old):
                field = self.model.request[name].results[index]
                found = self._values(f"the reported {field.name}", (name, field.name), field.type, old[index])
                for value, option in found:
                    yield replace(option, event=replace(event, results=(*old[:index], value, *old[index + 1 :])))
            case Observe():
                found = self._values(f"the observed {name}", ("", name), self._type(name), event.value)
                for value, option in found:
                    yield replace(option, event=Observe(name, value))
            case _:
                raise AssertionError(f"{event} gives nothing")

    # ---- slots and pasts ----

    def _slot(self, name: str, index: int) -> Iterator[Intervention]:
        """Yield the slot as idle, and with other arguments, or if it is idle as running with each combination."""
        slot, called = self.state.slots[name][index], slot_text(self.model, name, index)
        params = self.model.request[name].params
        if slot is not None:
            yield Intervention(called, "were idle", self.state.with_slot((name, index), None), self.event)
        elif None in self.state.slots[name][:index]:
            return  # idle slots of one request are alike
        for args, told in self._arguments(name, params, slot.args if slot else None):
            predicate = f"had {told}" if slot else f"were running with {told}" if told else "were running"
            content = Slot(slot.phase if slot else "running", args)
            whole = f"{called} {'had other arguments' if slot else 'were running'}"
            yield Intervention(called, predicate, self.state.with_slot((name, index), content), self.event, whole=whole)

    def _past(self, name: str) -> Iterator[Intervention]:
        request, past = self.model.request[name], self.state.past[name]
        if past is not None:
            yield Intervention(f"past({name})", "were forgotten", self.state.with_past(name, None), self.event)
        for values, told in self._arguments(name, (*request.params, *request.results), past):
            predicate = f"had {told}" if told else "were there"
            whole = f"past({name}) {'had other values' if past else 'were there'}"
            yield Intervention(f"past({name})", predicate, self.state.with_past(name, values), self.event, whole=whole)

    def _arguments(self, name: str, fields: tuple[Parameter, ...], present: Args | None) -> Iterator[tuple[Args, str]]:
        """Yield other arguments than the present ones, with the words for those that some comparison reads."""
        columns: list[list[Value]] = []
        read = [self._is_read(name, field.name) for field in fields]
        for index, field in enumerate(fields):
            now = present[index] if present else _first(field.type)
            others = self._values("", (name, field.name), field.type, now) if read[index] else ()
            columns.append([now, *(value for value, _ in others)])
        for values in islice(product(*columns), COMBINATIONS):
            if values != present:
                told = [named_text((f,), (v,)) for f, v, shown in zip(fields, values, read, strict=True) if shown]
                yield values, ", ".join(told)

    def _is_read(self, request: str, name: str) -> bool:
        for mention in self.mentions:
            terms = {*leaves(mention.compare.left), *leaves(mention.compare.right)}
            if (request == mention.subject and Param(name) in terms) or (request == mention.own and Own(name) in terms):
                return True
        return False


def _first(kind: Type) -> Value:
    """Return some value of a type."""
    return float(intervals(kind, (), 0.0)[0].sample) if isinstance(kind, Real) else least(kind)
