"""Random event streams for a model: mostly valid, with the values and the events that matter."""

import json
import math
from collections.abc import Iterator
from random import Random
from typing import Any

from exover.model.conditions import comparisons, conditions
from exover.model.event import Action, Event, Invalid
from exover.model.expression import Const
from exover.model.model import Model, Parameter
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Bool, Enum, Int, Real, Type, Value, contains
from exover.model.wire import answer_line
from exover.model.wire_reading import read_event

Line = dict[str, Any]


def constants(model: Model) -> tuple[Value, ...]:
    """Return the numbers that conditions, launches and initial values of the model name, increasing."""
    compared = (each for request, cond in conditions(model) for _, each in comparisons(cond, request))
    named = [side.value for each in compared for side in (each.left, each.right) if isinstance(side, Const)]
    named += [variable.initial for variable in model.variables]
    return tuple(sorted({each for each in named if isinstance(each, int | float) and not isinstance(each, bool)}))


class Stream:
    """An environment for a model: it knows the state that the reference interpreter is in."""

    def __init__(self, model: Model, seed: int) -> None:
        self.model = model
        self.random = Random(seed)
        self.reference = Reference(model)
        self.state: State = self.reference.start()
        self.constants = constants(model)

    def lines(self, length: int) -> Iterator[str]:
        """Yield so many lines."""
        return (line for line, _event, _actions in self._steps(length))

    def answered(self, length: int) -> Iterator[tuple[str, str]]:
        """Yield so many lines, each with the line by which the reference interpreter answers it."""
        for step, (line, _event, actions) in enumerate(self._steps(length), 1):
            yield line, answer_line(self.model, step, actions)

    def events(self, length: int) -> Iterator[tuple[Event, tuple[Action, ...]]]:
        """Yield the events of so many lines, each with what the reference interpreter answers; some lines are none."""
        for _line, event, actions in self._steps(length):
            if not isinstance(event, Invalid):
                yield event, actions

    def _steps(self, length: int) -> Iterator[tuple[str, Event | Invalid, tuple[Action, ...]]]:
        for _ in range(length):
            line = json.dumps(self.line())
            event = read_event(self.model, line)
            actions: tuple[Action, ...] = (event,) if isinstance(event, Invalid) else ()
            if not isinstance(event, Invalid):
                self.state, actions = self.reference.step(self.state, event)
            yield line, event, actions

    def line(self) -> Line:
        active = self.state.active()
        kind = self.random.randrange(100)
        if kind < 4:
            return self._broken()
        if kind < 34 and active:
            return self._report(*self.random.choice(self.state.stopping() or active if kind < 20 else active))
        if kind < 52:
            return self._observe() or self._ask()
        if kind < 57 and active:
            name, slot = self.random.choice(active)
            return {"abort": name, "instance": slot}
        waiting = [name for name, place in self.state.places.items() if place]
        if kind < 60 and waiting:
            return {"abort": self.random.choice(waiting), "waiting": True}
        return self._ask()

    def _ask(self) -> Line:
        free = [request for request in self.model.requests if not self.state.places[request.name]]
        request = self.random.choice(free if free and self.random.randrange(4) else self.model.requests)
        known = [slot.args for slot in self.state.slots[request.name] if slot]
        known += [launch.args for launch in self.model.launches if launch.request == request.name]
        if known and self.random.randrange(4) == 0:
            values = self.random.choice(known)
            pairs = zip(request.params, values, strict=True)
            return {"ask": request.name, "args": {parameter.name: value for parameter, value in pairs}}
        return {"ask": request.name, "args": self._values(request.params)}

    def _report(self, name: str, slot: int) -> Line:
        request = self.model.request[name]
        outcome = self.random.choice(("ok", "ok", "ok", "failed", "interrupted"))
        line: Line = {"report": name, "instance": slot, "outcome": outcome}
        if outcome == "ok" and request.results:
            line["results"] = self._values(request.results)
        if outcome == "failed" and request.statuses and self.random.randrange(2):
            line["status"] = self.random.choice(request.statuses)
        return line

    def _observe(self) -> Line | None:
        posters = [variable for variable in self.model.variables if variable.kind == "poster"]
        levels = [resource for resource in self.model.resources if resource.consumable]
        if not posters and not levels:
            return None
        number = self.random.randrange(len(posters) + len(levels))
        if number >= len(posters):
            resource = levels[number - len(posters)]
            return {"observe": resource.name, "value": self.random.randint(0, resource.capacity)}
        poster = posters[number]
        return {"observe": poster.name, "value": self._value(poster.type)}

    # ---- values ----

    def _values(self, parameters: tuple[Parameter, ...]) -> Line:
        return {parameter.name: self._value(parameter.type) for parameter in parameters}

    def _value(self, kind: Type) -> Value:
        """Return a value of the type; a number is most often one that something is compared with, or next to it."""
        match kind:
            case Bool():
                return self.random.randrange(2) == 0
            case Enum(values):
                return self.random.choice(values)
            case Int(low, high):
                near = [int(number) + step for number in self.constants for step in (-1, 0, 1)]
                near = [number for number in [*near, low, high] if low <= number <= high]
                return self.random.choice(near) if self.random.randrange(3) else self.random.randint(low, high)
            case Real(low, high):
                return self._real(kind, max(low, -1e3), min(high, 1e3))

    def _real(self, kind: Real, low: float, high: float) -> float:
        present = [value for value in self.state.readings.values() if isinstance(value, float)]
        held = [value for name, slot in self.state.active() for value in self.state.slots[name][slot].args]  # type: ignore[union-attr]
        near: list[float] = [float(number) for number in self.constants] + present
        near += [value for value in held if isinstance(value, float)]
        near += [math.nextafter(value, way) for value in near for way in (-math.inf, math.inf)]
        near = [value for value in [*near, low, high] if contains(kind, value)]
        value = self.random.choice(near) if self.random.randrange(5) else self.random.uniform(low, high)
        return -0.0 if value == 0 and self.random.randrange(2) else value

    # ---- what is wrong ----

    def _broken(self) -> Line:
        """Return an event that is none, or an out-of-range reading."""
        name = self.random.choice(self.model.requests).name
        readings = [variable for variable in self.model.variables if variable.kind == "poster"]
        match self.random.randrange(8):
            case 0:
                return {"ask": name + "x"}
            case 1:
                return {"ask": name, "args": {"nothing": 1}}
            case 2:
                return {"report": name, "instance": self.random.randrange(4), "outcome": "interrupted"}
            case 3:
                return {"abort": name, "instance": self.random.randrange(2)}
            case 4:
                return {"abort": name, "waiting": True}
            case 5:
                return {"report": name, "outcome": "failed", "status": "unheard"}
            case _ if readings:
                return {"observe": self.random.choice(readings).name, "value": self._outside()}
            case _:
                return {"tell": name}

    def _outside(self) -> Value:
        return self.random.choice((1e300, -5, math.nan, math.inf, "violet", True, 0.7))
