"""What the parts of the proxy share: the gate, where messages go, and the gate's own requests."""

from collections.abc import Callable, Collection
from dataclasses import field, replace
from itertools import count
from typing import Any, NamedTuple, Protocol

from exover.dataclass import dataclass
from exover.gate.binding import Binding, BindingKind, RequestBinding
from exover.gate.fields import FieldPath, UnreadableField, select
from exover.gate.gate import Gate
from exover.gate.outer import Alarm, CallId, ModuleGone
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import Stamp
from exover.gate.ros2.names import Port, absolute
from exover.gate.watching import outcome_of
from exover.model.event import Args
from exover.model.state import SlotId

Send = Callable[[Port, bytes, int], None]
"""Takes a message and the peer that it is for, 0 if it is for nobody alone."""


class MessageCodec(Protocol):
    """Messages of known types as objects."""

    def read(self, name: str, body: bytes) -> Any:
        """Return the fields of a message. Raises `UnreadableField`."""
        ...

    def reader(self, name: str, paths: Collection[FieldPath]) -> Callable[[bytes], Any]:
        """Return what reads these paths of messages of a type, as `read` does."""
        ...

    def write(self, name: str, values: Any = ()) -> bytes:
        """Return the body of a message with values at paths, all else being zero. Raises `UnreadableField`."""
        ...


class OwnRequests:
    """The requests of the gate to servers, by number; `mark` are the 8 bytes that stand for the gate."""

    def __init__(self, mark: bytes) -> None:
        self._mark = mark
        self._numbers = count(1)
        self._open: dict[int, tuple[Port, Any]] = {}

    def header(self, port: Port, about: Any) -> bytes:
        """Return the header of a new request on a port; `about` is given back with its reply."""
        number = next(self._numbers)
        self._open[number] = port, about
        return self._mark + number.to_bytes(8, "little")

    def answered(self, port: Port, data: bytes) -> Any:
        """Return what a reply is about, None if the gate has not asked for it, or has its answer."""
        header = data[cdr.BODY : cdr.HEAD]
        number = int.from_bytes(header[8:], "little")
        if header[:8] != self._mark or self._open.get(number, (None,))[0] != port:
            return None
        return self._open.pop(number)[1]

    def forget(self, name: str) -> None:
        """Forget what the server of a name has been asked."""
        self._open = {number: each for number, each in self._open.items() if each[0].name != name}


@dataclass(slots=True)
class Outside:
    """What is outside of one action or service."""

    gate: Gate
    send: Send
    codec: MessageCodec
    tell: Callable[[str], None]
    clock: Callable[[], float]
    now: Callable[[], Stamp]
    new_id: Callable[[], bytes]
    own: OwnRequests
    name: str = "ros2"
    numbers: "count[int]" = field(default_factory=lambda: count(1))

    def call(self, peer: int) -> CallId:
        """Return a new call of a peer."""
        return CallId(self.client(peer), next(self.numbers))

    def client(self, peer: int) -> str:
        """Return what the gate calls a peer."""
        return f"{self.name}/{peer}"


class Servers:
    """Which processes serve one action or service, of this inner name; `call`: what they are called with."""

    def __init__(self, outside: Outside, inner: str, requests: frozenset[str], call: str) -> None:
        self._outside = outside
        self._inner = inner
        self._requests = requests
        self._call = call
        self._there: frozenset[str] = frozenset()
        self._seen: set[str] = set()

    def __bool__(self) -> bool:
        return bool(self._there)

    def become(self, found: frozenset[str], gone: Callable[[], None], came: Callable[[bool], None]) -> None:
        """Take which processes serve it now.

        `gone` is called if none of those before does, `came` if those that do are others, with whether one of them has
        served it at any time.
        """
        before, self._there = self._there, found
        if before and not before & found:
            self._outside.own.forget(self._inner)
            gone()
            self._outside.gate.tell(ModuleGone(self._requests))
        if found and not before & found:
            came(bool(found & self._seen))
        if len(found) > 1 and len(before) < 2:
            told = f"{len(found)} servers have the name {self._inner}: each {self._call} may run in all of them"
            self._outside.tell(told)
        self._seen |= found


def bound_to(binding: Binding, kind: BindingKind, outer: str) -> tuple[RequestBinding, ...]:
    """Return what is bound to a full outer name, with full names, in the order of the file."""
    return tuple(
        replace(each, outer=outer, inner=absolute(each.inner))
        for each in binding.requests
        if each.kind == kind and absolute(each.outer) == outer
    )


class MeantCall(NamedTuple):
    """Which request a call is, with its arguments; without a request the rule that refuses it, and why."""

    request: str
    args: dict[str, Any] | None = None
    rule: str = ""
    because: str = ""


class CallReader:
    """Says what the calls of one action or service are; `type_` is that of their arguments."""

    def __init__(self, outside: Outside, bounds: tuple[RequestBinding, ...], type_: str) -> None:
        self._longest = outside.gate.binding.gate.max_line
        self._bounds = bounds
        self._first = bounds[0].request if len(bounds) == 1 else bounds[0].outer
        paths = {field.path for each in bounds for field in each.arguments}
        paths |= {path for each in bounds for path, _ in each.when}
        self._read: Callable[[bytes], Any] = outside.codec.reader(type_, paths) if paths else lambda body: {}

    def __call__(self, body: bytes) -> MeantCall:
        """Return what a call with these arguments is."""
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


def own_values(bound: RequestBinding, args: Args) -> list[tuple[FieldPath, Any]]:
    """Return what a call that the gate makes itself has at paths."""
    said = [(each.path, each.write(value)) for each, value in zip(bound.arguments, args, strict=True)]
    return [*said, *bound.when, *bound.constants]


def ending(
    outside: Outside, bound: RequestBinding, slot: SlotId, well: bool, read: Callable[[], Any]
) -> dict[str, Any]:
    """Return the entries of a report for a result, which `read` reads if it is needed.

    `well` iff the protocol says that all went well.
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
