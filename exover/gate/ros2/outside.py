"""What the proxies of actions and services share: the gate, sending, the gate's own requests, reading of calls."""

from collections.abc import Callable, Collection
from dataclasses import field, replace
from itertools import count
from typing import Any, NamedTuple, Protocol

from exover.dataclass import dataclass
from exover.gate.binding import Binding, BindingKind, RequestBinding
from exover.gate.fields import FieldPath, UnreadableField, select
from exover.gate.gate import Gate, Tell
from exover.gate.outer import Alarm, CallId, ModuleGone
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import Stamp
from exover.gate.ros2.names import Port, absolute
from exover.gate.watching import outcome_of
from exover.model.state import SlotId

Send = Callable[[Port, bytes, int], None]
"""Sends a message on a port; the number is the peer that it answers, 0 if it answers none."""


class MessageCodec(Protocol):
    """Reads and writes messages of loaded types (`Interfaces`)."""

    def read(self, name: str, body: bytes) -> Any:
        """Return the fields of a message. Raises `UnreadableField`."""
        ...

    def reader(self, name: str, paths: Collection[FieldPath]) -> Callable[[bytes], Any]:
        """Return a function that reads these paths of bodies of a type; it raises as `read` does."""
        ...

    def write(self, name: str, values: Any = ()) -> bytes:
        """Return the body of a message with these values at paths, all else zero. Raises `UnreadableField`."""
        ...


class OwnRequests:
    """The gate's open requests to servers, by sequence number; `mark`: 8 bytes that identify the gate in a header."""

    def __init__(self, mark: bytes) -> None:
        self._mark = mark
        self._numbers = count(1)
        self._open: dict[int, tuple[Port, Any]] = {}

    def header(self, port: Port, about: Any) -> bytes:
        """Return the 16 bytes of header of a request on a port; `answered` gives `about` back for its reply.

        A request that is repeated, since no reply has come, has the header that it had: one reply is taken.
        """
        request = port, about
        number = next((number for number, each in self._open.items() if each == request), None) or next(self._numbers)
        self._open[number] = request
        return self._mark + number.to_bytes(8, "little")

    def answered(self, port: Port, data: bytes) -> Any:
        """Return what the request of a reply was about, and close it; None if the gate has no such open request."""
        header = data[cdr.BODY : cdr.HEAD]
        number = int.from_bytes(header[8:], "little")
        if header[:8] != self._mark or self._open.get(number, (None,))[0] != port:
            return None
        return self._open.pop(number)[1]

    def close(self, about: object) -> None:
        """Forget the open requests about something that has ended."""
        self._open = {number: each for number, each in self._open.items() if each[1] is not about}

    def forget(self, name: str) -> None:
        """Forget the open requests to the server of this inner name."""
        self._open = {number: each for number, each in self._open.items() if each[0].name != name}


@dataclass(slots=True)
class Outside:
    """What the proxies of actions and services use: the gate, its I/O, the time of day and ids."""

    gate: Gate
    send: Send
    codec: MessageCodec
    tell: Tell
    now: Callable[[], Stamp]
    new_id: Callable[[], bytes]
    own: OwnRequests
    name: str
    numbers: "count[int]" = field(default_factory=lambda: count(1))

    def call(self, peer: int) -> CallId:
        """Return a new call id for a peer."""
        return CallId(self.client(peer), next(self.numbers))

    def client(self, peer: int) -> str:
        """Return the client name of a peer."""
        return f"{self.name}/{peer}"


class Servers:
    """The processes that serve one action or service of this inner name; `call`: the word for a call, for messages."""

    def __init__(self, outside: Outside, inner: str, requests: frozenset[str], call: str) -> None:
        self._outside = outside
        self._inner = inner
        self._requests = requests
        self._call = call
        self._there: frozenset[str] = frozenset()
        self._used: set[str] = set()
        self._known: set[str] = set()
        self.again = False
        """Whether one of the processes that came last has served it before."""

    def __bool__(self) -> bool:
        return bool(self._there)

    def become(self, found: frozenset[str], gone: Callable[[bool], None], came: Callable[[bool], None]) -> None:
        """Take the keys of the processes that serve it now.

        If one of the previous ones has left, `gone` is called, with whether all have, and the gate is told: what ran
        may have run there. Then, and if there were none before, `came` is called if there are some, with whether one of
        them may run what was sent.
        """
        before, self._there = self._there, found
        if before - found:
            gone(not before & found)
            self._outside.gate.tell(ModuleGone(self._requests))
        self.again = not self._known.isdisjoint(found)
        self._known |= found
        if found and (before - found or not before):
            came(bool(found & self._used))
        if len(found) > 1 and len(before) < 2:
            told = f"{len(found)} servers have the name {self._inner}: each {self._call} may run in all of them"
            self._outside.tell(told)

    def used(self) -> None:
        """Note that something that runs was sent to the processes that are there."""
        self._used |= self._there


def bound_to(binding: Binding, kind: BindingKind, outer: str) -> tuple[RequestBinding, ...]:
    """Return the bindings of this kind and full outer name, with full names, in the order of the file."""
    return tuple(
        replace(each, outer=outer, inner=absolute(each.inner))
        for each in binding.requests
        if each.kind == kind and absolute(each.outer) == outer
    )


class MeantCall(NamedTuple):
    """The request that a call means, with its arguments; or without arguments, the rule that refuses it and why."""

    request: str
    args: dict[str, Any] | None = None
    rule: str = ""
    because: str = ""


class CallReader:
    """Finds the request that a call of one action or service means; `type_`: the message type of its arguments."""

    def __init__(self, outside: Outside, bounds: tuple[RequestBinding, ...], type_: str) -> None:
        self._longest = outside.gate.binding.gate.max_line
        self._bounds = bounds
        self._first = bounds[0].request if len(bounds) == 1 else bounds[0].outer
        paths = {field.path for each in bounds for field in each.arguments}
        paths |= {path for each in bounds for path, _ in each.when}
        self._read: Callable[[bytes], Any] = outside.codec.reader(type_, paths) if paths else lambda body: {}

    def __call__(self, body: bytes) -> MeantCall:
        """Return the request and arguments of a call with this body, or the rule that refuses it."""
        if len(body) > self._longest:
            return MeantCall(self._first, None, "unreadable", f"it is longer than {self._longest} bytes")
        try:
            arguments = self._read(body)
            for bound in self._bounds:
                if bound.meant(arguments):
                    return MeantCall(bound.request, {each.name: each.read(arguments) for each in bound.arguments})
            return MeantCall(self._first, None, "unbound", "its arguments are those of no request")
        except UnreadableField as why:
            return MeantCall(self._first, None, "unreadable", str(why))


def ending(
    outside: Outside, bound: RequestBinding, slot: SlotId, well: bool, read: Callable[[], Any]
) -> dict[str, Any]:
    """Return the entries of a report for a result, which `read` decodes if the binding needs it.

    `well` iff the protocol reports success.
    """
    report = bound.report
    document: Any = {}
    if report.status is not None or report.results:
        try:
            document = read()
        except UnreadableField as why:
            outside.gate.tell(Alarm("invalid", *slot, f"its result cannot be read: {why}"))
            return {"outcome": "failed"}
    if report.status is None or bound.started:
        return outcome_of(report, "ok" if well else "failed", None, document)
    status = select(document, report.status)
    found = report.meaning(status)
    if not well:
        return outcome_of(report, "failed", status, document)
    if found is None or found == "running":
        outside.gate.tell(Alarm("unknown-status", *slot, f"the status {status!r:.60} is no end in the binding"))
        return {"outcome": "failed"}
    return outcome_of(report, found, status, document)
