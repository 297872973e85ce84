"""A checker on a socket: several clients share one state, and events are taken one by one (docs/serve.md)."""

import errno
import select
import selectors
import socket
import struct
from collections.abc import Callable, Iterator
from dataclasses import field
from typing import NoReturn

from exover.dataclass import dataclass
from exover.model.event import Action, Event, Invalid
from exover.model.model import Model
from exover.model.wire import answer_line
from exover.model.wire_reading import LONG_LINE, MAX_LINE, TOO_LONG, is_blank, read_entries, read_object
from exover.run.records import LISTEN, MOST_ACTIONS, RecordCodec, says_listen
from exover.run.simulate import Engine

MAGIC = b"EXO1"
"""The first bytes of a client that speaks binary records."""
MAX_WAITING = 16 << 20
"""The most bytes of answers that may wait for a client; with more, its connection is closed."""
ENOUGH = 1 << 20
"""The bytes of answers that wait for a client above which nothing is read from it (back-pressure)."""
SHORT = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)
"""Errors by which the system accepts no client although one waits."""
PAUSE = 1.0
"""Seconds after which accepting is tried again after such an error, if no client goes before."""
_READ = 1 << 10
"""The most bytes that are read from a client at once: all others wait until the events in them are answered."""
_SENT = 1 << 16
"""The most bytes that are sent to a client at once."""
_LENGTH = struct.Struct("<I")


@dataclass(eq=False, slots=True)
class Client:
    """A connection: bytes that are not read as events yet, bytes to be sent, and its protocol."""

    socket: socket.socket
    number: int
    coming: bytearray = field(default_factory=bytearray)
    going: bytearray = field(default_factory=bytearray)
    binary: bool | None = None
    """Whether it speaks binary records; None until its first bytes tell."""
    listens: bool = False
    ended: bool = False
    """Whether it has closed its sending side."""
    deaf: bool = False
    """Whether it has closed its receiving side, so that nothing more is sent to it."""
    overlong: bool = False
    """Whether the rest of the incoming line is skipped, since it is too long and was answered."""
    stalled: bool = False
    """Whether nothing is read from it until it has read its answers."""


@dataclass(slots=True)
class CheckerServer:
    """Answers the clients of a non-blocking listening socket by one engine. `tell` gets messages about clients."""

    model: Model
    engine: Engine
    listener: socket.socket
    tell: Callable[[str], None]
    steps: int = 0
    clients: dict[int, Client] = field(default_factory=dict)
    _codec: RecordCodec = field(init=False)
    _selector: selectors.BaseSelector = field(init=False, default_factory=selectors.DefaultSelector)
    _known: int = 0
    _short: bool = False
    """Whether `tell` has got that the system accepts no client."""

    def __post_init__(self) -> None:
        """Begin to listen."""
        self._codec = RecordCodec(self.model)
        self._listen()

    def serve(self) -> NoReturn:
        """Answer clients until the process ends."""
        while True:
            self.turn(None)

    def turn(self, seconds: float | None) -> None:
        """Wait, at most so many seconds, until a socket can be read or written, and do it; None waits without limit."""
        deaf = self.listener not in self._selector.get_map()
        if deaf:
            seconds = PAUSE if seconds is None else min(seconds, PAUSE)
        for key, mask in self._selector.select(seconds):
            if key.fileobj is self.listener:
                if not self._any_gone():
                    self._accept()
                continue
            client: Client = key.data
            if client.number in self.clients:
                self._exchange(client, bool(mask & selectors.EVENT_READ))
        if deaf:
            self._listen()

    def close(self) -> None:
        """Close all connections."""
        for client in list(self.clients.values()):
            self._drop(client)
        self._selector.close()

    # ---- connections ----

    def _listen(self) -> None:
        """Watch the listening socket, unless it is watched already."""
        if self.listener not in self._selector.get_map():
            self._selector.register(self.listener, selectors.EVENT_READ)

    def _accept(self) -> None:
        try:
            connected, _ = self.listener.accept()
        except OSError as error:
            self._not_accepted(error)
            return
        self._short = False
        connected.setblocking(False)
        client = Client(connected, self._known + 1)
        try:
            self._selector.register(connected, selectors.EVENT_READ, client)
        except OSError as error:
            connected.close()
            self.tell(f"a client cannot be served: {error.strerror}")
            return
        self._known += 1
        self.clients[self._known] = client

    def _any_gone(self) -> bool:
        """Return whether a client has closed its connection and something that it has sent is not taken yet.

        Clients that have come since then wait, so that no reading of a sensor replaces one of the process that took
        its place.
        """
        found = select.poll()
        for client in self.clients.values():
            found.register(client.socket, 0)
        return any(what & select.POLLHUP for _, what in found.poll(0))

    def _not_accepted(self, error: OSError) -> None:
        """Go on without the client; if it still waits, stop listening, lest the selector report it again at once."""
        if error.errno not in SHORT:  # the client is gone again
            self.tell(f"a client cannot be served: {error.strerror}")
            return
        self._selector.unregister(self.listener)
        if not self._short:
            self.tell(f"clients wait until others go: {error.strerror}")
        self._short = True

    def _drop(self, client: Client, why: str = "") -> None:
        if why:
            self.tell(f"client {client.number} is let go: {why}")
        self.clients.pop(client.number, None)
        client.going.clear()
        self._selector.unregister(client.socket)
        client.socket.close()
        self._listen()

    def _exchange(self, client: Client, readable: bool) -> None:
        """Answer what has arrived and send answers, until the client has to send or to read something.

        Its connection is closed once it has ended and has all answers.
        """
        if readable:
            self._read(client)
        self._write(client)
        all_taken = False
        while client.number in self.clients and not all_taken and len(client.going) <= ENOUGH:
            all_taken = self._take(client)
            self._write(client)
        if client.number not in self.clients:
            return
        if client.ended and not client.going:
            self._drop(client)
        else:
            self._watch(client)

    def _read(self, client: Client) -> None:
        """Read some of what a client has sent."""
        try:
            data = client.socket.recv(_READ)
        except BlockingIOError:
            return
        except ConnectionError:  # it has left answers unread, and all that it has sent is read
            data = b""
        except OSError as error:
            self._drop(client, error.strerror or str(error))
            return
        client.coming += data
        client.ended = not data

    def _take(self, client: Client) -> bool:
        """Answer events that have arrived, until too many answers wait for the client; return whether none is left."""
        for event in self._events(client):
            self._answer(client, event)
            if client.number not in self.clients:
                return True
            if len(client.going) > ENOUGH:
                return False
        return True

    def _write(self, client: Client) -> None:
        """Send as much as the socket takes; nothing any more if the client has gone or reads no more."""
        try:
            if client.going:
                del client.going[: client.socket.send(client.going[:_SENT])]
        except BlockingIOError:
            pass
        except ConnectionError:
            client.deaf = True
            client.going.clear()
        except OSError as error:
            self._drop(client, error.strerror or str(error))

    def _watch(self, client: Client) -> None:
        stalled = len(client.going) > ENOUGH
        if stalled and not client.stalled:
            self.tell(
                f"nothing more is read from client {client.number}: more than {ENOUGH >> 20} MiB of answers wait for it"
            )
        client.stalled = stalled
        reads = 0 if client.ended or stalled else selectors.EVENT_READ
        wanted = reads | (selectors.EVENT_WRITE if client.going else 0)
        self._selector.modify(client.socket, wanted or selectors.EVENT_READ, client)

    # ---- messages ----

    def _events(self, client: Client) -> Iterator[Event | Invalid]:
        """Yield the events that have arrived whole, or their faults."""
        if client.binary is None:
            self._begin(client)
        if client.binary is None:
            return
        yield from self._records(client) if client.binary else self._lines(client)

    def _begin(self, client: Client) -> None:
        """Find out from its first bytes whether a client speaks binary records, and send it the description if so."""
        start = bytes(client.coming[: len(MAGIC)])
        if start == MAGIC:
            del client.coming[: len(MAGIC)]
            client.binary = True
            self._send_record(client, self._codec.description())
        elif client.ended or not MAGIC.startswith(start):
            client.binary = False

    def _records(self, client: Client) -> Iterator[Event | Invalid]:
        while len(client.coming) >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(client.coming)
            if length > MAX_LINE:
                self.tell(
                    f"client {client.number} is let go: a record of {length} bytes, and at most {MAX_LINE} are read"
                )
                client.coming.clear()
                client.ended = True  # so that it gets the answers to what it sent before
                return
            end = _LENGTH.size + length
            if len(client.coming) < end:
                return
            record = bytes(client.coming[_LENGTH.size : end])
            del client.coming[:end]
            listens = says_listen(record)
            if listens is not None:
                client.listens = listens
            elif record[:1] == bytes([LISTEN]):
                yield Invalid("bad-event", "1 is to listen, 0 is not to")
            else:
                yield self._codec.event(record)

    def _lines(self, client: Client) -> Iterator[Event | Invalid]:
        while (end := client.coming.find(b"\n")) >= 0 or client.ended or len(client.coming) >= TOO_LONG:
            whole = end >= 0
            line = bytes(client.coming[: end if whole else len(client.coming)])
            del client.coming[: end + 1 if whole else len(client.coming)]
            passed, client.overlong = client.overlong, not whole and not client.ended
            if not passed and client.overlong:
                yield LONG_LINE
            elif not passed and not is_blank(line) and (event := self._event(client, line)) is not None:
                yield event
            if not whole:
                return

    def _event(self, client: Client, line: bytes) -> Event | Invalid | None:
        """Return the event of a line, or its fault; None if it turns listening on or off."""
        entries = read_object(line)
        if isinstance(entries, Invalid):
            return entries
        if "listen" not in entries:
            return read_entries(self.model, entries)
        if len(entries) > 1:
            return Invalid("bad-event", "`listen` has something beside it")
        if not isinstance(entries["listen"], bool):
            return Invalid("bad-event", "`listen` is true or false")
        client.listens = entries["listen"]
        return None

    def _answer(self, asker: Client, event: Event | Invalid) -> None:
        """Take an event, and give its answer to the client that asked and to those that listen."""
        actions: tuple[Action, ...] = (event,) if isinstance(event, Invalid) else self.engine.step(event)
        self.steps += 1
        for client in list(self.clients.values()):
            if client is asker or client.listens:
                self._send(client, actions)
                if client is not asker and client.number in self.clients:
                    self._watch(client)

    def _send(self, client: Client, actions: tuple[Action, ...]) -> None:
        """Let an answer wait to be sent to a client; let one go that listens and does not read."""
        if client.deaf:
            return
        if client.binary and len(actions) > MOST_ACTIONS:
            self._drop(client, f"an answer of {len(actions)} actions, and a record has at most {MOST_ACTIONS}")
            return
        if client.binary:
            self._send_record(client, self._codec.answer(self.steps, actions))
        else:
            client.going += answer_line(self.model, self.steps, actions).encode() + b"\n"
        if client.listens and len(client.going) > MAX_WAITING:
            self._drop(client, f"more than {MAX_WAITING >> 20} MiB of answers wait for it")

    def _send_record(self, client: Client, record: bytes) -> None:
        client.going += _LENGTH.pack(len(record)) + record
