"""The proxy of one service: decides what is done with each request and reply, without I/O (docs/gate.md)."""

import math
from functools import partial

from exover.dataclass import dataclass
from exover.gate.binding import RequestBinding
from exover.gate.fields import UnreadableField
from exover.gate.outer import Alarm, CallId, CancelRefused, SlotSaid, reason_text
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import HEAD
from exover.gate.ros2.names import Port, PortPart
from exover.gate.ros2.outside import CallReader, Outside, Servers, ending
from exover.gate.watching import Watching
from exover.model.event import Args, Ending
from exover.model.state import SlotId

REASON = "{reason}"
"""The placeholder for rule and reason in texts of `refused`."""


@dataclass(slots=True)
class ServiceCall:
    """A client's call that is not answered yet, with its request's body; `answer`: the body of the server's reply."""

    request: str
    peer: int
    header: bytes
    body: bytes
    answer: bytes | None = None


class ServiceProxy:
    """One service, bound to one or more requests: a server of the outer name, a client of the inner name."""

    def __init__(self, outside: Outside, bounds: tuple[RequestBinding, ...], watching: Watching) -> None:
        self._outside = outside
        self._gate = outside.gate
        self._bounds = {each.request: each for each in bounds}
        self._type = str(bounds[0].type)
        self._watching = watching
        self.outer, self.inner = bounds[0].outer, bounds[0].inner
        self.requests = frozenset(self._bounds)
        self._meaning = CallReader(outside, bounds, f"{self._type}_Request")
        self._calls: dict[CallId, ServiceCall] = {}
        self._asked: dict[SlotId, int] = {}
        """The number of the request to the server that carries out a slot."""
        self._round = 0
        self._servers = Servers(outside, self.inner, self.requests, "call")
        self.due = math.inf

    # ---- messages ----

    def from_client(self, part: PortPart, data: bytes, peer: int) -> None:
        """Take a request of a client."""
        call = self._outside.call(peer)
        found = self._meaning(data[HEAD:])
        request = found.request if found.request in self._bounds else next(iter(self._bounds))
        self._calls[call] = ServiceCall(request, peer, data[cdr.BODY : HEAD], data[HEAD:])
        if found.args is None:
            self._gate.refuse(call, found.request, found.rule, found.because)
        else:
            self._gate.call(call, found.request, found.args)

    def from_server(self, part: PortPart, data: bytes, peer: int) -> None:
        """Take a reply of the server, which may have been cut off since it was asked."""
        if not self._servers:
            return
        about = self._outside.own.answered(Port("inner", self.inner, "call"), data)
        if not isinstance(about, tuple):
            return
        slot, number = about
        held = self._gate.state.slots.get(slot)
        if held is None or self._asked.get(slot) != number:
            return
        del self._asked[slot]
        found = self._calls.get(held.call) if held.call else None
        if found:
            found.answer = data[HEAD:]
        bound = self._bounds[slot[0]]
        if bound.started and bound.report.watch is not None:
            self._watching.begun(slot, bound.report.watch)
            if held.call:
                self._answer(held.call)
        else:
            read = partial(self._outside.codec.read, f"{self._type}_Response", data[HEAD:])
            self._gate.report(slot, ending(self._outside, bound, slot, True, read))

    def client_gone(self, client: str) -> None:
        """Forget the calls of a client; the gate has been told."""
        self._calls = {call: each for call, each in self._calls.items() if call.client != client}

    # ---- effects ----

    def knows(self, call: CallId) -> bool:
        """Return whether a call is an open call of this service."""
        return call in self._calls

    def forward(self, call: CallId | None, slot: SlotId, args: Args) -> None:
        """Send the request of a call to the server; without a call, make a request of the gate's own and send that."""
        found = self._calls.get(call) if call else None
        try:
            body = found.body if found else self._own_body(slot, args)
        except UnreadableField as why:
            self._gate.tell(Alarm("invalid", *slot, f"its request cannot be written: {why}"))
            self._gate.report(slot, {"outcome": "failed"})
            return
        self._round += 1
        self._asked[slot] = self._round
        self._watching.forget(slot)
        self._servers.used()
        port = Port("inner", self.inner, "call")
        self._outside.send(port, cdr.service(self._outside.own.header(port, (slot, self._round)), body), 0)

    def _own_body(self, slot: SlotId, args: Args) -> bytes:
        return self._outside.codec.write(f"{self._type}_Request", self._bounds[slot[0]].own_values(args))

    def hold(self, call: CallId) -> None:
        """Do nothing: the client of a held call just waits for the response."""

    def refuse(self, call: CallId, rule: str, because: str | None) -> None:
        """Answer a call with the values in `refused` of its binding."""
        found = self._calls.pop(call)
        reason = f"refused by {reason_text(rule, because)}"
        values = [
            (path, value.replace(REASON, reason) if isinstance(value, str) else value)
            for path, value in self._bounds[found.request].refused
        ]
        self._up(found, self._outside.codec.write(f"{self._type}_Response", values))

    def stop(self, slot: SlotId) -> None:
        """Tell the gate that the cancel is refused: ROS 2 cannot cancel a service call."""
        self._gate.tell(CancelRefused(slot))

    def finish(self, slot: SlotId, call: CallId | None, outcome: Ending) -> None:
        """Give the client the server's reply; without one, refuse its call as `interrupted`."""
        self._asked.pop(slot, None)
        self._watching.forget(slot)
        if call is not None and call in self._calls:
            self._answer(call)

    def _answer(self, call: CallId) -> None:
        found = self._calls.get(call)
        if found is None:
            return
        if found.answer is None:
            self.refuse(call, "interrupted", "its server has not answered")
        else:
            del self._calls[call]
            self._up(found, found.answer)

    def _up(self, call: ServiceCall, body: bytes) -> None:
        self._outside.send(Port("outer", self.outer, "call"), cdr.service(call.header, body), call.peer)

    # ---- whether the server is there ----

    def servers(self, found: frozenset[str]) -> None:
        """Take the keys of the processes that serve this service now."""
        self._servers.become(found, lambda _: None, self._came)

    def _came(self, seen: bool) -> None:
        if not seen:
            self._outside.own.forget(self.inner)
        for slot in sorted(self._gate.state.unsaid):
            known = slot[0] in self.requests and self._bounds[slot[0]].starts_idle
            if known and not (seen and slot in self._gate.state.slots):
                self._gate.tell(SlotSaid(slot, False))

    def tick(self) -> None:
        """Do nothing: a service has no deadlines of its own."""
