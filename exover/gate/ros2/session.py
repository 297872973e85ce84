"""Runs a ROS 2 gate on DDS: opens a reader or writer for each port, and runs the loop; needs `cyclonedds`."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from functools import partial
from time import monotonic
from typing import Any, TypeVar
from uuid import uuid4

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant

from exover.dataclass import dataclass
from exover.gate.binding import Binding, BindingKind
from exover.gate.gate import Tell
from exover.gate.ros2 import cdr
from exover.gate.ros2 import endpoints as dds
from exover.gate.ros2.endpoints import KEPT, TopicReader, TopicWriter, Waiting, key_of
from exover.gate.ros2.idl import SampleTypes
from exover.gate.ros2.interfaces import CANCEL, Interfaces
from exover.gate.ros2.names import SERVICES, Port, PortPart, Side, absolute, message_topic, reply_topic, request_topic
from exover.gate.ros2.proxy import Ros2Proxy
from exover.gate.ros2.signals import DeferredSignals

TURN = 0.2
"""The longest wait of the loop in seconds, so that signals are noticed."""
PATIENCE = 1.0
"""Seconds that a reply waits until the client's reader is discovered."""
T = TypeVar("T")
STATUSES = "action_msgs/msg/GoalStatusArray"
TEXT = "std_msgs/msg/String"


@dataclass(slots=True)
class Served:
    """A service that the gate offers; `ready`: clients whose reader of replies was discovered; clients are handles."""

    requests: TopicReader
    replies: TopicWriter
    ready: set[int] = field(default_factory=set)
    clients: set[int] = field(default_factory=set)
    late: deque[tuple[float, int, bytes]] = field(default_factory=lambda: deque(maxlen=KEPT))
    """The last replies whose reader is not discovered yet: until when they wait, the client, the message."""

    def answer(self, data: bytes, peer: int) -> None:
        """Send a client a reply, now or as soon as its reader is discovered. Raises `DDSException`."""
        if peer in self.ready or self._known(peer):
            self.replies.write(data)
        else:
            self.late.append((monotonic() + PATIENCE, peer, data))

    def _known(self, peer: int) -> bool:
        found = self.requests.entity.get_matched_publication_data(peer)
        if found is None or key_of(found) not in map(key_of, self.replies.readers()):
            return False
        self.ready.add(peer)
        return True

    def catch_up(self) -> None:
        """Send waiting replies whose reader was discovered; drop those that waited too long, or for a gone client."""
        for _ in range(len(self.late)):
            until, peer, data = self.late.popleft()
            if peer in self.ready or self._known(peer):
                self.replies.write(data)
            elif until > monotonic() and peer in self.requests.handles():
                self.late.append((until, peer, data))

    def gone(self) -> set[int]:
        """Return the clients that have gone since the last call."""
        now = self.requests.handles()
        gone, self.clients = self.clients - now, now
        self.ready &= now
        return gone


@dataclass(frozen=True, slots=True)
class Asked:
    """A service that the gate calls."""

    requests: TopicWriter
    replies: TopicReader

    def servers(self) -> frozenset[str]:
        """Return the participant keys of the processes that read its requests and write its replies."""
        reading = {str(each.participant_key) for each in self.requests.readers()}
        return frozenset(reading & {str(each.participant_key) for each in self.replies.writers()})


class Ros2Session:
    """The DDS end points of a binding, and the loop; `inner`: the domain of the inner ports."""

    def __init__(self, binding: Binding, interfaces: Interfaces, domain: int, inner: int, tell: Tell) -> None:
        """Open the ports. Raises `DDSException`."""
        self._tell = tell
        self._types = SampleTypes(interfaces)
        outer = DomainParticipant(domain)
        self._participants = {"outer": outer, "inner": outer if inner == domain else DomainParticipant(inner)}
        self._waiting = Waiting()
        self._served: dict[Port, Served] = {}
        self._asked: dict[Port, Asked] = {}
        self._writers: dict[Port, TopicWriter] = {}
        self._read: dict[int, tuple[Port, TopicReader]] = {}
        self._matched: dict[int, Callable[[Ros2Proxy], None]] = {}
        for kind, name, type_ in _interfaces(binding, "outer"):
            self._serve(kind, name, type_)
        for kind, name, type_ in _interfaces(binding, "inner"):
            self._call(kind, name, type_)
        for watch in binding.watches:
            qos = dds.LATCHED if watch.latched else dds.WATCHED
            self._reader(Port("inner", absolute(watch.source), "message"), str(watch.type), qos)
        self._decisions: TopicWriter | None = None

    # ---- ports ----

    def _serve(self, kind: BindingKind, name: str, type_: str) -> None:
        for part, types in _services(kind, type_):
            port, user = Port("outer", name, part), f"serviceid={uuid4().hex};"
            found = Served(*self._pair(port, types, user))
            self._served[port] = found
            self._listen(port, found.requests)
            self._on_match(found.requests, partial(_clients, found, part in ("send_goal", "call")))
            self._on_match(found.replies, partial(_catch_up, found))
        if kind == "action":
            for part, of, qos in (
                ("feedback", f"{type_}_FeedbackMessage", dds.FEEDBACK),
                ("status", STATUSES, dds.LATCHED),
            ):
                port = Port("outer", name, part)
                self._writers[port] = TopicWriter(
                    self._participants["outer"], message_topic(port), self._types.message(of), qos
                )

    def _call(self, kind: BindingKind, name: str, type_: str) -> None:
        for part, types in _services(kind, type_):
            port, user = Port("inner", name, part), f"clientid={uuid4().hex};"
            replies, requests = self._pair(port, types, user)
            self._asked[port] = Asked(requests, replies)
            self._listen(port, replies)
            for end in (replies, requests):
                self._on_match(end, lambda proxy: self._servers(proxy, kind, name))
        if kind == "action":
            self._reader(Port("inner", name, "feedback"), f"{type_}_FeedbackMessage", dds.FEEDBACK)
            self._reader(Port("inner", name, "status"), STATUSES, dds.LATCHED)

    def _pair(self, port: Port, types: tuple[str, str], user: str) -> tuple[TopicReader, TopicWriter]:
        """Return reader and writer of a service port: as a server does on the outer side, as a client on the inner."""
        request, reply = (
            (topic, self._types.service(type_))
            for topic, type_ in zip((request_topic(port), reply_topic(port)), types, strict=True)
        )
        come, go = (request, reply) if port.side == "outer" else (reply, request)
        participant = self._participants[port.side]
        return TopicReader(participant, *come, dds.REQUESTS, user), TopicWriter(participant, *go, dds.REPLIES, user)

    def _reader(self, port: Port, type_: str, qos: Any) -> None:
        self._listen(
            port, TopicReader(self._participants[port.side], message_topic(port), self._types.message(type_), qos)
        )

    def _listen(self, port: Port, reader: TopicReader) -> None:
        number = self._number()
        self._read[number] = port, reader
        self._waiting.watch(reader.condition, number)

    def _on_match(self, end: TopicReader | TopicWriter, then: Callable[[Ros2Proxy], None]) -> None:
        def changed(proxy: Ros2Proxy) -> None:
            end.changed()
            then(proxy)

        number = self._number()
        self._matched[number] = changed
        self._waiting.watch(end.entity, number)

    def _number(self) -> int:
        return len(self._waiting.attached) + 1

    def publish_decisions(self, name: str) -> Callable[[bytes], None]:
        """Return a function that publishes lines, without line ends, on a topic. Raises `DDSException`."""
        topic = message_topic(Port("outer", absolute(name), "message"))
        writer = TopicWriter(self._participants["outer"], topic, self._types.message(TEXT), dds.DECISIONS)
        self._decisions = writer

        def publish(line: bytes) -> None:
            self._write(name, lambda: writer.write(cdr.topic(cdr.text(line[:-1]))))

        return publish

    # ---- what goes out ----

    def send(self, port: Port, data: bytes, peer: int) -> None:
        """Send a message; complain if it cannot be sent."""
        if port in self._served:
            self._write(port.name, lambda: self._served[port].answer(data, peer))
        elif port in self._asked:
            self._write(port.name, lambda: self._asked[port].requests.write(data))
        else:
            self._write(port.name, lambda: self._writers[port].write(data))

    def _write(self, name: str, write: Callable[[], None]) -> None:
        try:
            write()
        except DDSException as error:
            self._tell(f"a message of {name} was not sent: {error.msg}")

    # ---- the loop ----

    def run(self, proxy: Ros2Proxy) -> None:
        """Serve until a signal comes; then stop what runs, as if all clients had gone, and raise the signal again."""
        with DeferredSignals() as signals:
            try:
                proxy.start()
                while not signals.heard:
                    self.turn(proxy, TURN)
            finally:
                self._finish(proxy)

    def turn(self, proxy: Ros2Proxy, most: float) -> None:
        """Wait for messages at most `most` seconds or until the next deadline; take them, and do what is due."""
        late = min((until for each in self._served.values() for until, _, _ in each.late), default=float("inf"))
        due = min(late, proxy.due)
        ready = self._waiting.ready(min(most, max(0.0, due - monotonic())))
        for port, reader in topics_first(self._read[number] for number in ready if number in self._read):
            for data, peer in reader.take():
                proxy.take(port, data, peer)
        for number in ready:
            if number in self._matched:
                self._matched[number](proxy)
        if due <= monotonic():
            proxy.tick()
            for each in self._served.values():
                each.catch_up()

    def _servers(self, proxy: Ros2Proxy, kind: BindingKind, name: str) -> None:
        parts = SERVICES if kind == "action" else ("call",)
        found = [self._asked[Port("inner", name, part)].servers() for part in parts]
        proxy.servers(kind, name, frozenset.intersection(*found))

    def _finish(self, proxy: Ros2Proxy) -> None:
        """Tell the proxy that all clients have gone, and wait for what stops, at most the longest stop deadline."""
        for peer in {peer for each in self._served.values() for peer in each.clients}:
            proxy.client_gone(peer)
        until = monotonic() + proxy.gate.binding.longest_stop
        while proxy.stopping and monotonic() < until:
            self.turn(proxy, 0.05)


def topics_first(found: Iterable[tuple[Port, T]]) -> list[tuple[Port, T]]:
    """Return ports in the order in which they are read, topics of watches first, then status arrays.

    What a topic holds beside a reply may have been said before it, and must not be taken for the end of what the reply
    says has begun. A status array shows goals that the reply to a cancel of all goals leaves out.
    """
    order = {"message": 0, "status": 1}
    return sorted(found, key=lambda each: order.get(each[0].part, len(order)))


def _clients(served: Served, first: bool, proxy: Ros2Proxy) -> None:
    """Tell the proxy which clients have gone, if `first`: this service is the one by which clients are counted."""
    for peer in served.gone():
        if first:
            proxy.client_gone(peer)


def _catch_up(served: Served, _: Ros2Proxy) -> None:
    served.catch_up()


def _interfaces(binding: Binding, side: Side) -> Iterator[tuple[BindingKind, str, str]]:
    """Yield kind, name and type of each action and service of a side, once each."""
    names = ((each.kind, each.outer if side == "outer" else each.inner, each.type) for each in binding.requests)
    yield from dict.fromkeys((kind, absolute(name), str(type_)) for kind, name, type_ in names)


def _services(kind: BindingKind, type_: str) -> Iterator[tuple[PortPart, tuple[str, str]]]:
    """Yield the services that an interface consists of, with their request and reply types.

    The gate asks the last one first. Discovery announces endpoints in the order of their creation, so a server that
    knows the reader of its replies knows all readers.
    """
    if kind == "service":
        yield "call", (f"{type_}_Request", f"{type_}_Response")
        return
    yield "send_goal", (f"{type_}_SendGoal_Request", f"{type_}_SendGoal_Response")
    yield "get_result", (f"{type_}_GetResult_Request", f"{type_}_GetResult_Response")
    yield "cancel_goal", (f"{CANCEL}_Request", f"{CANCEL}_Response")
