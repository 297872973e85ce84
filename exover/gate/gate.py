"""One gate of one robot: its state machine, the checker that decides, and the journal, written before the effects."""

from collections import Counter, deque
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
"""Returns a monotonic time in seconds."""
Tell = Callable[[str], None]
"""Shows a person a text: an alarm, or what was dropped or cannot be written."""
Journal = Callable[[str], None]
"""Takes each decision before its effects go out: the text of an object of the log (docs/gate.md), without its time."""


class Transport(Protocol):
    """One side of the gate that speaks a protocol: it tells the gate outer events and does outer effects.

    In its calls, the client's name up to the first `/` is the transport's name.
    """

    name: str
    """The part of its clients' names before the first `/`."""
    kinds: tuple[BindingKind, ...]
    """The kinds of bindings that its modules carry out."""

    def do(self, effect: OuterEffect) -> None:
        """Do an effect; every transport gets every alarm."""
        ...


class Gate:
    """The gate that all transports share: they tell it outer events, and it gives each effect to its transport.

    Not thread-safe: use one thread. Outer events told while effects are being done are taken afterwards.
    """

    def __init__(self, model: Model, binding: Binding, checker: Engine, clock: Clock, journal: Journal) -> None:
        self.model = model
        self.binding = binding
        slots = frozenset(ModelIndex(model).slots)
        times = {each.request: Times(each.wait, each.answer, each.stop) for each in binding.requests}
        self._machine = GateMachine(slots, times, binding.gate.client_death == "abort")
        self._checker = checker
        self.clock = clock
        self._journal = journal
        self._texts = WireTexts(model)
        self._faulty = False
        self._transports: dict[str, Transport] = {}
        self._modules: dict[str, Transport] = {}
        self._waiting: deque[OuterEvent | OuterEffect] = deque()
        self._busy = False
        self._failures: list[Exception] = []
        self.raised: Counter[str] = Counter()
        """How many reports have raised the level of a resource, by resource."""
        self.state = self._machine.start()

    def attach(self, transport: Transport) -> None:
        """Register a transport for the effects on its clients and on the requests bound to its kinds."""
        self._transports[transport.name] = transport
        for bound in self.binding.requests:
            if bound.kind in transport.kinds:
                self._modules[bound.request] = transport

    def tell(self, *happened: OuterEvent | OuterEffect) -> None:
        """Take outer events, or effects of the gate itself, and do their effects; decisions are in the journal before.

        The first exception of a transport or the journal is raised once all effects are done, so every stop is sent.
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

    def tick(self) -> None:
        """Take that time has passed, if the next deadline has."""
        if self.state.due <= self.clock():
            self.tell(Ticked())

    def _attempt(self, do: Callable[..., None], *given: object) -> None:
        """Call `do`; keep its exception, if there is one, until the rest is done."""
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
        """Return the effects of an outer event, and write what was decided to the journal."""
        started = self.state.started
        effects: list[OuterEffect] = []
        for part in self._machine.parts(self.state, outer, self.clock()):
            effects += self._one(part)
        if self.state.started and not started:
            effects += self._follow(Ticked())
        return effects

    def _one(self, outer: OuterEvent) -> Iterable[OuterEffect]:
        event = self._machine.question(self.state, outer)
        actions = () if event is None else self._checker.step(event)
        self.state, effects = self._machine.answer(self.state, outer, event, actions, self.clock())
        if isinstance(event, Report) and event.outcome == "ok":
            self.raised.update({share.resource for share in self.model.request[event.request].productions})
        if event is not None:
            self._attempt(self._decided, event, actions)
        elif isinstance(outer, Called):
            denial = self.state.denial(outer.ask.request)
            self._attempt(self._journal, refusal_text(outer.ask.request, *(denial or ("", None))))
        return (*effects, *self._fault())

    def _decided(self, event: Event, actions: tuple[Action, ...]) -> None:
        self._journal(self._texts.decision(event, actions))

    def _fault(self) -> list[OuterEffect]:
        """Return, once the checker is faulty, the alarm and the effects that stop what runs; later, nothing."""
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
        self.state, effects = self._machine.answer(self.state, Ticked(), Abort(*slot), actions, self.clock())
        return effects

    # ---- outer objects ----

    def call(self, call: CallId, request: str, args: Mapping[str, Any]) -> None:
        """Take a client's call of a request; `args` by name, as the fields of the binding read them."""
        event = read_entries(self.model, {"ask": request, "args": dict(args)})
        match event:
            case Ask():
                self.tell(Called(call, event))
            case Invalid(code, detail):
                self.refuse(call, request, code, detail)

    def refuse(self, call: CallId, name: str, rule: str, because: str) -> None:
        """Refuse a call without asking the checker; `name` is its request, or its outer name if it is bound to none."""
        self._attempt(self._journal, refusal_text(name, rule, because))
        self.tell(Refuse(call, rule, because))

    def report(self, slot: SlotId, entries: Mapping[str, Any]) -> None:
        """Take a module's report that a slot has ended; one that is invalid counts as `failed`, with an alarm."""
        event = read_entries(self.model, {"report": slot[0], "instance": slot[1], **entries})
        match event:
            case Report():
                self.tell(Reported(event))
            case Invalid(code, detail):
                self.tell(Alarm("invalid", *slot, f"{code}: {detail}"), Reported(Report(*slot, "failed")))

    def observe(self, name: str, value: Any) -> None:
        """Take a reading of a poster or a level; one that is no value counts as unread, with an alarm."""
        event = read_entries(self.model, {"observe": name, "value": value})
        match event:
            case Observe():
                self.tell(Observed(event))
            case Invalid(code, detail):
                self.tell(Alarm("invalid", detail=f"{code}: {detail}"))
                self.unread(name)

    def falls_back(self, name: str) -> bool:
        """Return whether a poster has an `else` value, which it reads when it cannot be read."""
        return name in self.model.variable and self.model.variable[name].fallback is not None

    def unread(self, name: str) -> None:
        """Observe the `else` value of a poster that cannot be read, if it has one."""
        known = self.model.variable.get(name)
        if known is not None and known.fallback is not None:
            broken = not isinstance(known.type, Bool)  # a bool has no reading outside of its domain
            self.tell(Observed(Observe(name, known.fallback, broken)))


def refusal_text(name: str, rule: str, because: str | None) -> str:
    """Return the journal entry for a call that the gate itself refuses."""
    return encode({"refused": name, "rule": rule} | ({"because": because} if because else {}))


def alarm_text(alarm: Alarm) -> str:
    """Return the journal entry for an alarm."""
    found: dict[str, Any] = {"alarm": alarm.kind}
    for key, value in (("request", alarm.request), ("instance", alarm.slot), ("detail", alarm.detail or None)):
        if value is not None:
            found[key] = value
    return encode(found)


def checker_of(model: Model, tables: Tables) -> tuple[Engine, str]:
    """Return a checker in its initial state, and why it is not the emitted C; an empty text if it is."""
    from exover.engines.compiler import NativeUnavailable
    from exover.run.inprocess import InProcessEngine

    try:
        return InProcessEngine(model, tables), ""
    except NativeUnavailable as reason:
        from exover.ocrd.machine import Machine

        return Machine(model, tables), str(reason)
