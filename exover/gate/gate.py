"""One gate of one robot: the state machine, a checker that decides, and a journal that is told first."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol, assert_never

from exover.gate.binding import Binding, BindingKind
from exover.gate.machine import GateMachine
from exover.gate.outer import (
    Alarm,
    Called,
    CallId,
    Finish,
    Forward,
    Hold,
    Observed,
    OuterEffect,
    OuterEvent,
    Refuse,
    Reported,
    Stop,
    Ticked,
)
from exover.gate.state import Times
from exover.model.event import Abort, Action, Ask, Event, Invalid, Observe, Report
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.state import SlotId
from exover.model.texts import WireTexts, encode
from exover.model.types import Bool
from exover.model.wire_reading import read_entries
from exover.ocrd.tables import Tables
from exover.run.simulate import Engine

Clock = Callable[[], float]
"""Seconds that only grow."""


class Journal(Protocol):
    """Who is told what was decided, as the objects of docs/gate.md but for their time, before it goes out."""

    def __call__(self, entry: str) -> None:
        """Take the text of one entry."""


class Transport(Protocol):
    """What speaks a protocol: it tells the gate what happens outside, and does what the gate wants done there.

    The clients in its calls have names that begin with its own, up to a `/` if there is one.
    """

    name: str
    """What the names of its clients begin with."""
    kinds: tuple[BindingKind, ...]
    """Which kinds of bindings its modules carry out."""

    def do(self, effect: OuterEffect) -> None:
        """Do an effect; alarms come to every transport."""
        ...


class Gate:
    """What transports share: each tells it outer events, and each effect is done by the transport that it is for.

    Not thread-safe: all of it happens in one thread. What happens while effects are being done happens after them.
    """

    def __init__(self, model: Model, binding: Binding, checker: Engine, clock: Clock, journal: Journal) -> None:
        self.model = model
        self.binding = binding
        slots = frozenset(ModelIndex(model).slots)
        times = {each.request: Times(each.wait, each.answer, each.stop) for each in binding.requests}
        self._machine = GateMachine(slots, times, binding.gate.client_death == "abort")
        self._checker = checker
        self._clock = clock
        self._journal = journal
        self._texts = WireTexts(model)
        self._faulty = False
        self._transports: dict[str, Transport] = {}
        self._modules: dict[str, Transport] = {}
        self._waiting: deque[OuterEvent | OuterEffect] = deque()
        self._busy = False
        self._failures: list[Exception] = []
        self.state = self._machine.start()

    def attach(self, transport: Transport) -> None:
        """Let a transport do the effects that are for its clients, and for the modules of its kinds."""
        self._transports[transport.name] = transport
        for bound in self.binding.requests:
            if bound.kind in transport.kinds:
                self._modules[bound.request] = transport

    def tell(self, *happened: OuterEvent | OuterEffect) -> None:
        """Take outer events, or effects of the gate itself, and do what follows; it is in the journal by then.

        What fails in a transport or in the journal is raised once all else is done: it keeps no stop from being sent.
        """
        self._waiting += happened
        if self._busy:
            return
        self._busy = True
        try:
            while self._waiting:
                first = self._waiting.popleft()
                if isinstance(first, OuterEffect):
                    self._attempt(self._do, first)
                else:
                    self._waiting.extendleft(reversed(self._follow(first)))
        finally:
            self._busy = False
        if self._failures:
            first_failure, self._failures = self._failures[0], []
            raise first_failure

    def _attempt(self, do: Callable[..., None], *given: object) -> None:
        """Do something; if it fails, keep why until the rest is done."""
        try:
            do(*given)
        except Exception as failure:
            self._failures.append(failure)

    def _do(self, effect: OuterEffect) -> None:
        match effect:
            case Alarm():
                self._attempt(self._journal, alarm_text(effect))
                for transport in self._transports.values():
                    self._attempt(transport.do, effect)
                return
            case Hold(call, _, _) | Refuse(call, _, _):
                found = self._transports.get(call.client.split("/")[0])
            case Forward(_, slot, _) | Stop(slot, _, _) | Finish(_, slot, _):
                found = self._modules.get(slot[0])
            case _:
                assert_never(effect)
        if found:
            found.do(effect)

    def _follow(self, outer: OuterEvent) -> list[OuterEffect]:
        """Return the effects of an outer event; the journal has what was decided."""
        started = self.state.started
        effects: list[OuterEffect] = []
        for part in self._machine.parts(self.state, outer, self._clock()):
            effects += self._one(part)
        if self.state.started and not started:
            effects += self._follow(Ticked())
        return effects

    def _one(self, outer: OuterEvent) -> Iterable[OuterEffect]:
        event = self._machine.question(self.state, outer)
        actions = () if event is None else self._checker.step(event)
        self.state, effects = self._machine.answer(self.state, outer, event, actions, self._clock())
        if event is not None:
            self._attempt(self._decided, event, actions)
        elif isinstance(outer, Called):
            denial = self.state.denial(outer.ask.request)
            self._attempt(self._journal, refusal_text(outer.ask.request, *(denial or ("", None))))
        return (*effects, *self._fault())

    def _decided(self, event: Event, actions: tuple[Action, ...]) -> None:
        self._journal(self._texts.decision(event, actions))

    def _fault(self) -> list[OuterEffect]:
        """Once the checker is faulty, tell it and stop what runs."""
        number = getattr(self._checker, "fault", 0)
        if not number or self._faulty:
            return []
        self._faulty = True
        effects: list[OuterEffect] = [Alarm("faulty", detail=f"exover_status {number}")]
        for slot, held in self.state.slots.items():
            if held.phase == "running":
                effects += self._abort(slot)
        return effects

    def _abort(self, slot: SlotId) -> Iterable[OuterEffect]:
        actions = self._checker.step(Abort(*slot))
        self.state, effects = self._machine.answer(self.state, Ticked(), Abort(*slot), actions, self._clock())
        return effects

    # ---- outer objects ----

    def call(self, call: CallId, request: str, args: Mapping[str, Any]) -> None:
        """Let a client ask for a request with these arguments, as its call has them."""
        event = read_entries(self.model, {"ask": request, "args": dict(args)})
        match event:
            case Ask():
                self.tell(Called(call, event))
            case Invalid(code, detail):
                self.refuse(call, request, code, detail)

    def refuse(self, call: CallId, name: str, rule: str, because: str) -> None:
        """Refuse a call that no checker is asked about; `name` is its request, or its outer name if it has none."""
        self._attempt(self._journal, refusal_text(name, rule, because))
        self.tell(Refuse(call, rule, because))

    def report(self, slot: SlotId, entries: Mapping[str, Any]) -> None:
        """Let a module report the end of a slot; results that are none are a failure all the same."""
        event = read_entries(self.model, {"report": slot[0], "instance": slot[1], **entries})
        match event:
            case Report():
                self.tell(Reported(event))
            case Invalid(code, detail):
                self.tell(Alarm("invalid", *slot, f"{code}: {detail}"), Reported(Report(*slot, "failed")))

    def observe(self, name: str, value: Any) -> None:
        """Let a poster, or a level, read a value."""
        event = read_entries(self.model, {"observe": name, "value": value})
        match event:
            case Observe():
                self.tell(Observed(event))
            case Invalid(code, detail):
                self.tell(Alarm("invalid", detail=f"{code}: {detail}"))
                self.unread(name)

    def unread(self, name: str) -> None:
        """Let a poster that cannot be read take its `else` value, if it has one."""
        known = self.model.variable.get(name)
        if known is not None and known.fallback is not None:
            broken = not isinstance(known.type, Bool)  # a bool has no reading outside of its domain
            self.tell(Observed(Observe(name, known.fallback, broken)))


def refusal_text(name: str, rule: str, because: str | None) -> str:
    """Return a refusal of the gate itself as an entry of the journal."""
    return encode({"refused": name, "rule": rule} | ({"because": because} if because else {}))


def alarm_text(alarm: Alarm) -> str:
    """Return an alarm as an entry of the journal."""
    found: dict[str, Any] = {"alarm": alarm.kind}
    for key, value in (("request", alarm.request), ("instance", alarm.slot), ("detail", alarm.detail or None)):
        if value is not None:
            found[key] = value
    return encode(found)


def checker_of(model: Model, tables: Tables) -> tuple[Engine, str]:
    """Return who decides, in the initial state, and why that is not the emitted C, if it is not."""
    from exover.engines.compiler import NativeUnavailable
    from exover.run.inprocess import InProcessEngine

    try:
        return InProcessEngine(model, tables), ""
    except NativeUnavailable as reason:
        from exover.ocrd.machine import Machine

        return Machine(model, tables), str(reason)
