"""The MCP server as the proxy writes to it: requests that it has not answered, and the `_meta` of its session."""

from collections.abc import Callable, Iterator
from dataclasses import field

from exover.dataclass import dataclass
from exover.gate.mcp import lines
from exover.gate.mcp.calls import Pending
from exover.gate.mcp.lines import PreparedCall
from exover.gate.mcp.results import envelope
from exover.model.wire import Json


@dataclass(slots=True)
class McpServer:
    """The server, to which nothing is written once it has gone; `write` takes whole lines."""

    write: Callable[[bytes], None]
    numbers: Iterator[int]
    """The ids of requests to the server."""
    alive: bool = True
    envelope: Json = field(default_factory=dict)
    """The `_meta` entries of a stateless session; empty if it is none, or not known to be one yet."""
    _meta: str = ""
    """`envelope` as JSON text, for prepared calls."""
    _pending: dict[int, Pending] = field(default_factory=dict)

    @property
    def stateless(self) -> bool:
        """Whether the session is known to be stateless."""
        return bool(self.envelope)

    def remember(self, params: Json) -> None:
        """Note the `_meta` entries of a stateless session, if a request with these parameters carries them."""
        found = envelope(params)
        if found and found != self.envelope:
            self._meta = lines.text_of(found)
            self.envelope = found

    def own(self, params: Json) -> Json:
        """Return the parameters of a call of the gate itself, in a stateless session with `_meta`."""
        return {**params, "_meta": self.envelope} if self.stateless else params

    def send(self, body: Json) -> None:
        """Write a message."""
        if self.alive:
            self.write(lines.write(body))

    def request(self, body: Json, pending: Pending) -> int:
        """Write a request under a new number, and return the number."""
        number = next(self.numbers)
        self._pending[number] = pending
        self.send({**body, "id": number})
        return number

    def call(self, call: PreparedCall, pending: Pending) -> None:
        """Write a prepared call under a new number."""
        number = next(self.numbers)
        self._pending[number] = pending
        if self.alive:
            self.write(call.line(number, self._meta))

    def pending(self, number: int) -> Pending | None:
        """Return the open request of this number; None if there is none."""
        return self._pending.get(number)

    def close(self, number: int) -> Pending | None:
        """Return the open request of this number, which is answered or given up now; None if there is none."""
        return self._pending.pop(number, None)

    def forget(self, about: Callable[[Pending], bool]) -> None:
        """Await no answer any more to the requests about which this is true."""
        self._pending = {number: pending for number, pending in self._pending.items() if not about(pending)}

    def gone(self) -> tuple[Pending, ...]:
        """Return the open requests, which nobody answers any more: the server has gone."""
        self.alive = False
        left = tuple(self._pending.values())
        self._pending.clear()
        return left
