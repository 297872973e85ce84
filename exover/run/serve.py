"""A checker at a socket: several clients, one state, one event after the other (docs/serve.md)."""

import errno
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
from exover.model.wire_reading import MAX_LINE, read_entries, read_object
from exover.run.records import LISTEN, RecordCodec
from exover.run.simulate import Engine

MAGIC = b"EXO1"
"""What a client sends first that speaks binary records."""
MAX_WAITING = 16 << 20
"""Bytes of answers that may wait for a client; one that leaves more unread is let go."""
ENOUGH = 1 << 20
"""Bytes of answers that wait for a client above which nothing more is read from it."""
SHORT = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)
"""Why the system accepts no client although one waits."""
PAUSE = 1.0
"""Seconds after which it is tried again then, if no client goes before."""
_READ = 1 << 16
_LENGTH = struct.Struct("<I")


@dataclass(eq=False, slots=True)
class Client:
    """A connection: what came and was not understood yet, what is to be sent, and how it speaks."""

    socket: socket.socket
    number: int
    coming: bytearray = field(default_factory=bytearray)
    going: bytearray = field(default_factory=bytearray)
    binary: bool | None = None
    """None until its first bytes have told."""
    listens: bool = False
    ended: bool = False
    """It sends no more."""
    overlong: bool = False
    """The rest of the line that comes is passed over: it is too long, and answered."""
    stalled: bool = False
    """Nothing more is read from it until it has read what waits for it."""


@dataclass(slots=True)
class CheckerServer:
    """Answers the clients of a listening socket, which does not block, by one engine. `tell` hears of odd clients."""

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
    """The system accepts no client, and that has been told."""

    def __post_init__(self) -> None:
        """Wait for clients from now on."""
        self._codec = RecordCodec(self.model)
        self._listen()

    def serve(self) -> NoReturn:
        """Answer until the process is told to end."""
        while True:
            self.turn(None)

    def turn(self, seconds: float | None) -> None:
        """Wait until something can be read or written, at most so long, and do it."""
        deaf = self.listener not in self._selector.get_map()
        if deaf:
            seconds = PAUSE if seconds is None else min(seconds, PAUSE)
        for key, mask in self._selector.select(seconds):
            if key.fileobj is self.listener:
                self._accept()
                continue
            client: Client = key.data
            if mask & selectors.EVENT_READ and client.number in self.clients:
                self._read(client)
            if client.number in self.clients:
                self._write(client)
        if deaf:
            self._listen()

    def close(self) -> None:
        """Let all clients go."""
        for client in list(self.clients.values()):
            self._drop(client)
        self._selector.close()

    # ---- connections ----

    def _listen(self) -> None:
        """Wait for clients, too."""
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
        self._known += 1
        client = self.clients[self._known] = Client(connected, self._known)
        self._selector.register(connected, selectors.EVENT_READ, client)

    def _not_accepted(self, error: OSError) -> None:
        """Go on without the client; if it still waits, without listening, for it would be heard of again at once."""
        if error.errno not in SHORT:  # it is gone again
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
        self._selector.unregister(client.socket)
        client.socket.close()
        self._listen()

    def _read(self, client: Client) -> None:
        try:
            data = client.socket.recv(_READ)
        except BlockingIOError:
            return
        except OSError:
            self._drop(client)
            return
        client.coming += data
        client.ended = not data
        for event in self._events(client):
            self._answer(client, event)
            if client.number not in self.clients:
                return

    def _write(self, client: Client) -> None:
        """Send what is to be sent, as far as it is taken."""
        try:
            if client.going:
                del client.going[: client.socket.send(client.going[:_READ])]
        except BlockingIOError:
            pass
        except OSError:
            self._drop(client)
            return
        if client.ended and not client.going:
            self._drop(client)
            return
        self._watch(client)

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
        """Yield the events that have come whole."""
        if client.binary is None:
            self._begin(client)
        if client.binary is None:
            return
        yield from self._records(client) if client.binary else self._lines(client)

    def _begin(self, client: Client) -> None:
        """Find out how a client speaks."""
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
                self._drop(client, f"a record of {length} bytes, and at most {MAX_LINE} are read")
                return
            end = _LENGTH.size + length
            if len(client.coming) < end:
                return
            record = bytes(client.coming[_LENGTH.size : end])
            del client.coming[:end]
            if record[:1] != bytes([LISTEN]):
                yield self._codec.event(record)
            elif record[1:2] in (b"\0", b"\1"):
                client.listens = record[1:2] == b"\1"
            else:
                yield Invalid("bad-event", "1 is to listen, 0 is not to")

    def _lines(self, client: Client) -> Iterator[Event | Invalid]:
        while (end := client.coming.find(b"\n")) >= 0 or client.ended or len(client.coming) > MAX_LINE:
            whole = end >= 0
            line = bytes(client.coming[: end if whole else len(client.coming)])
            del client.coming[: end + 1 if whole else len(client.coming)]
            passed, client.overlong = client.overlong, not whole and not client.ended
            if line.strip() and not passed and (event := self._event(client, line)) is not None:
                yield event
            if not whole:
                return

    def _event(self, client: Client, line: bytes) -> Event | Invalid | None:
        """Return the event of a line; None if it asks to listen."""
        entries = read_object(line)
        if isinstance(entries, Invalid):
            return entries
        if entries.keys() != {"listen"}:
            return read_entries(self.model, entries)
        if not isinstance(entries["listen"], bool):
            return Invalid("bad-event", "`listen` is true or false")
        client.listens = entries["listen"]
        return None

    def _answer(self, asker: Client, event: Event | Invalid) -> None:
        """Take an event, and tell its answer to whoever raised it and to those that listen."""
        actions: tuple[Action, ...] = (event,) if isinstance(event, Invalid) else self.engine.step(event)
        self.steps += 1
        for client in list(self.clients.values()):
            if client is asker or client.listens:
                self._send(client, actions)

    def _send(self, client: Client, actions: tuple[Action, ...]) -> None:
        if client.binary:
            self._send_record(client, self._codec.answer(self.steps, actions))
        else:
            client.going += answer_line(self.model, self.steps, actions).encode() + b"\n"
        if len(client.going) > MAX_WAITING:
            self._drop(client, f"more than {MAX_WAITING >> 20} MiB of answers wait for it")
        else:
            self._watch(client)

    def _send_record(self, client: Client, record: bytes) -> None:
        client.going += _LENGTH.pack(len(record)) + record
