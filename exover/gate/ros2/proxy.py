"""The ROS 2 transport: takes messages as bytes, tells the gate, and does its effects, without I/O (docs/gate.md)."""

from collections.abc import Callable
from functools import partial
from typing import assert_never

from exover.gate.binding import BindingKind, Watch
from exover.gate.fields import UnreadableField
from exover.gate.gate import Gate, Tell
from exover.gate.outer import (
    Alarm,
    CallId,
    ClientGone,
    Finish,
    Forward,
    Hold,
    OuterEffect,
    Refuse,
    SlotSaid,
    Stop,
)
from exover.gate.ros2 import cdr
from exover.gate.ros2.action import ActionProxy
from exover.gate.ros2.cdr import BODY, HEAD, ID, Stamp
from exover.gate.ros2.names import SERVICES, Port, PortPart, absolute
from exover.gate.ros2.outside import MessageCodec, Outside, OwnRequests, Send, bound_to
from exover.gate.ros2.service import ServiceProxy
from exover.gate.watching import Watching

LEAST: dict[PortPart, int] = {
    "send_goal": HEAD + ID,
    "cancel_goal": HEAD + ID,
    "get_result": HEAD + ID,
    "feedback": BODY + ID,
    "call": HEAD,
}
"""The fewest bytes of a client's message, or of a server's feedback, on a port."""
PARTS: dict[BindingKind, tuple[PortPart, ...]] = {"action": (*SERVICES, "feedback", "status"), "service": ("call",)}
"""The ports of an action and of a service."""
Unit = ActionProxy | ServiceProxy


class Ros2Proxy:
    """The proxies of all actions and services of a binding, and its watches.

    `send` sends messages; `mark`: 8 bytes that no other client of the servers has; `new_id` returns new goal ids.
    """

    name = "ros2"
    kinds: tuple[BindingKind, ...] = ("action", "service")

    def __init__(
        self,
        gate: Gate,
        codec: MessageCodec,
        send: Send,
        tell: Tell,
        now: Callable[[], Stamp],
        new_id: Callable[[], bytes],
        mark: bytes,
    ) -> None:
        self.gate = gate
        self._outside = Outside(gate, send, codec, tell, now, new_id, OwnRequests(mark), self.name)
        self._watching = Watching(gate, lambda watch: None)
        self._units: list[Unit] = []
        self._named: dict[tuple[BindingKind, str], Unit] = {}
        """Proxies by kind and inner name."""
        self._takers: dict[Port, Callable[..., None]] = {}
        """The function that takes the messages of a port."""
        self._of: dict[str, Unit] = {}
        """Proxies by request."""
        for kind, outer in dict.fromkeys((each.kind, absolute(each.outer)) for each in gate.binding.requests):
            bounds = bound_to(gate.binding, kind, outer)
            unit: Unit
            if kind == "action":
                unit = ActionProxy(self._outside, bounds)
            else:
                unit = ServiceProxy(self._outside, bounds, self._watching)
            self._units.append(unit)
            self._named[kind, unit.inner] = unit
            for part in PARTS[kind]:
                self._takers[Port("outer", unit.outer, part)] = partial(unit.from_client, part)
                self._takers[Port("inner", unit.inner, part)] = partial(unit.from_server, part)
            self._of |= dict.fromkeys(unit.requests, unit)
        for watch in gate.binding.watches:
            if watch.kind == "topic":
                self._takers[Port("inner", absolute(watch.source), "message")] = partial(self._topic, watch)
        gate.attach(self)

    # ---- what happens ----

    def start(self) -> None:
        """Tell the gate that the slots of unbound requests are idle."""
        for slot in sorted(self.gate.state.unsaid):
            if slot[0] not in self._of:
                self.gate.tell(SlotSaid(slot, False))

    def take(self, port: Port, data: bytes, peer: int = 0) -> None:
        """Take a message of a client or a server; drop one that is not XCDR1 or too short."""
        if not cdr.plain(data, LEAST[port.part] if port.side == "outer" or port.part == "feedback" else BODY):
            self._outside.tell(f"a message of {port.name} was dropped: it is not XCDR1, or too short")
        else:
            self._takers[port](data, peer)

    def _topic(self, watch: Watch, data: bytes, peer: int) -> None:
        try:
            document = self._outside.codec.read(str(watch.type), data[BODY:])
        except UnreadableField as why:
            self._watching.failed(watch, str(why))
        else:
            self._watching.shown(watch, document)

    def servers(self, kind: BindingKind, name: str, found: frozenset[str]) -> None:
        """Take the keys of the processes that serve an inner name now."""
        self._named[kind, name].servers(found)

    def client_gone(self, peer: int) -> None:
        """Take that a client has gone."""
        client = self._outside.client(peer)
        self.gate.tell(ClientGone(client))
        for unit in self._units:
            unit.client_gone(client)

    def tick(self) -> None:
        """Tell the gate, the proxies and the watches of deadlines that have passed."""
        self.gate.tick()
        for unit in self._units:
            unit.tick()
        self._watching.tick(True)

    @property
    def due(self) -> float:
        """The next time at which `tick` has something to do; infinite if there is none."""
        return min(self._watching.due(True), self.gate.state.due, *(unit.due for unit in self._units))

    @property
    def stopping(self) -> bool:
        """Whether a slot is stopping and not lost, so that its server may still report its end."""
        return any(held.phase == "stopping" and not held.lost for held in self.gate.state.slots.values())

    # ---- what goes out ----

    def do(self, effect: OuterEffect) -> None:
        """Do an effect of the gate, by the proxy of its action or service."""
        match effect:
            case Forward(call, slot, args):
                self._of[slot[0]].forward(call, slot, args)
            case Hold(call, _, _):
                for unit in self._knowing(call):
                    unit.hold(call)
            case Refuse(call, rule, because):
                for unit in self._knowing(call):
                    unit.refuse(call, rule, because)
            case Stop(slot, _, _):
                self._of[slot[0]].stop(slot)
            case Finish(call, slot, outcome):
                self._of[slot[0]].finish(slot, call, outcome)
            case Alarm():
                self._outside.tell(str(effect))
            case _:
                assert_never(effect)

    def _knowing(self, call: CallId) -> list[Unit]:
        """Return the proxy that has this open call; an empty list if there is none, as after its client has gone."""
        return [unit for unit in self._units if unit.knows(call)]
