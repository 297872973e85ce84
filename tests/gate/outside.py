"""Clients and modules that do anything at any time, and a ledger of what a gate has told them."""

from collections import Counter
from random import Random

from exover.gate.machine import GateMachine
from exover.gate.outer import (
    Called,
    CallId,
    Cancelled,
    CancelRefused,
    ClientGone,
    Finish,
    Forward,
    Hold,
    ModuleGone,
    Observed,
    OuterEffect,
    OuterEvent,
    Refuse,
    Reported,
    SlotSaid,
    Ticked,
)
from exover.gate.state import GateState, Times
from exover.model.event import Args, Ask, Observe, Report
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Bool, Enum, Int, Real, Type, Value
from exover.run.simulate import Engine

CLIENTS = ("a", "b")


class Outside:
    """Random outer events of a model."""

    def __init__(self, model: Model, seed: int) -> None:
        self._model = model
        self._random = Random(seed)
        self._calls: list[CallId] = []
        self._slots = [(each.name, slot) for each in model.requests for slot in range(each.instances)]

    def event(self) -> OuterEvent:
        """Return the next event; most are asks and reports."""
        kinds = (self._called, self._reported, self._observed, self._declared, self._cancelled, self._gone, self._late)
        (make,) = self._random.choices(kinds, (8, 6, 4, 2, 2, 1, 1))
        return make()

    def _called(self) -> OuterEvent:
        request = self._random.choice(self._model.requests)
        call = CallId(self._random.choice(CLIENTS), len(self._calls))
        self._calls.append(call)
        return Called(call, Ask(request.name, self._args(request.params)))

    def _reported(self) -> OuterEvent:
        name, slot = self._random.choice(self._slots)
        request = self._model.request[name]
        outcome = self._random.choice(("ok", "failed", "interrupted"))
        results = self._args(request.results) if outcome == "ok" else ()
        return Reported(Report(name, slot, outcome, results))  # type: ignore[arg-type]

    def _observed(self) -> OuterEvent:
        index = ModelIndex(self._model)
        kinds: dict[str, Type] = {each.name: each.type for _, each in index.posters}
        kinds |= {each.name: Int(0, each.capacity) for each in index.consumables}
        if not kinds:
            return Ticked()
        name = self._random.choice(sorted(kinds))
        return Observed(Observe(name, self._value(kinds[name])))

    def _declared(self) -> OuterEvent:
        return SlotSaid(self._random.choice(self._slots), self._random.random() < 0.2)

    def _cancelled(self) -> OuterEvent:
        if not self._calls:
            return Ticked()
        return Cancelled(self._random.choice(self._calls[-6:]))

    def _gone(self) -> OuterEvent:
        slot = self._random.choice(self._slots)
        if self._random.random() < 0.4:
            return ModuleGone(frozenset({slot[0]}))
        return CancelRefused(slot) if self._random.random() < 0.5 else ClientGone(self._random.choice(CLIENTS))

    def _late(self) -> OuterEvent:
        return Ticked()

    def _args(self, parameters: tuple[Parameter, ...]) -> Args:
        return tuple(self._value(each.type) for each in parameters)

    def _value(self, kind: Type) -> Value:
        match kind:
            case Bool():
                return self._random.random() < 0.5
            case Int(low, high):
                return self._random.randint(max(low, -3), min(high, 5))
            case Real(low, high):
                return float(self._random.randint(int(max(low, -2.0)), int(min(high, 3.0))))
            case Enum(values):
                return self._random.choice(values)


class Ledger:
    """What every call was told: it is told at most one end, and nothing afterwards."""

    def __init__(self) -> None:
        self.told: dict[CallId, str] = {}
        self.effects: Counter[str] = Counter()

    def note(self, effects: tuple[OuterEffect, ...]) -> None:
        for effect in effects:
            self.effects[type(effect).__name__] += 1
            if isinstance(effect, Forward | Hold | Refuse | Finish) and effect.call:
                before = self.told.get(effect.call)
                allowed = {None: "Forward Hold Refuse", "Hold": "Forward Refuse", "Forward": "Finish Refuse"}
                assert type(effect).__name__ in allowed.get(before, "").split(), (before, effect)
                self.told[effect.call] = type(effect).__name__

    def open(self) -> set[CallId]:
        """Return the calls that are held or forwarded, and were told no end."""
        return {call for call, told in self.told.items() if told in ("Forward", "Hold")}


class Compared:
    """A gate beside the reference interpreter, which is told the same and says what really is active."""

    def __init__(self, model: Model, *checkers: Engine) -> None:
        slots = frozenset((each.name, slot) for each in model.requests for slot in range(each.instances))
        self.machine = GateMachine(slots, {each.name: Times(3, 5, 2) for each in model.requests})
        self.state: GateState = self.machine.start()
        self._reference = Reference(model)
        self.known: State = self._reference.start()
        self._checkers = checkers
        self.ledger = Ledger()
        self.given_up: set[CallId] = set()

    def tell(self, outer: OuterEvent, now: float) -> tuple[OuterEffect, ...]:
        """Let it happen, and compare what is known with what is so."""
        said: list[OuterEffect] = []
        for part in self.machine.parts(self.state, outer, now):
            before = self.state
            if isinstance(part, Cancelled) and isinstance(self.state.where(part.call), str):
                self.given_up.add(part.call)
            event = self.machine.question(self.state, part)
            actions = ()
            if event is not None:
                self.known, actions = self._reference.step(self.known, event)
                for checker in self._checkers:
                    assert checker.step(event) == actions
            self.state, effects = self.machine.answer(self.state, part, event, actions, now)
            assert before == self._frozen(before, part, event, actions, now)
            self._compare()
            self.ledger.note(effects)
            said += effects
        return tuple(said)

    def _frozen(self, before, part, event, actions, now):  # type: ignore[no-untyped-def]
        """Return the state before, once the function was called again: it must give the same, and change nothing."""
        assert self.machine.answer(before, part, event, actions, now)[0] == self.state
        return before

    def _compare(self) -> None:
        active = {
            (name, number): (slot.phase, slot.args)
            for name, slots in self.known.slots.items()
            for number, slot in enumerate(slots)
            if slot
        }
        assert {slot: (held.phase, held.args) for slot, held in self.state.slots.items()} == active
        taken = {name: place.launch_rule for name, place in self.known.places.items() if place}
        assert {name: queued.origin for name, queued in self.state.places.items()} == taken
