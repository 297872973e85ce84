"""Requests and tool calls that are not answered yet, between client, gate and server."""

from collections.abc import Iterator
from itertools import count
from typing import Any

from exover.dataclass import dataclass
from exover.gate.binding import Watch
from exover.gate.mcp.lines import is_id, key_of_id
from exover.model.state import SlotId
from exover.model.wire import Json


@dataclass(slots=True)
class Pending:
    """A request that the server has not answered; `client_id`: the client's id of it, if the client has sent it."""

    method: str
    client_id: Any = None
    cancelled: bool = False
    slot: SlotId | None = None
    """The slot that this call carries out, if it does."""
    stops: SlotId | None = None
    """The slot that this call stops, if it does."""
    watch: Watch | None = None


@dataclass(slots=True)
class ToolCall:
    """A client's MCP tool call that the gate decides about, until it is answered."""

    client_id: Any
    params: Json
    answer: Json | None = None
    """The response of the server, which the client gets once the slot has ended."""
    stopped: tuple[str, str | None] | None = None
    """The rule that stopped it, and the reason."""


class Exchange:
    """Maps the JSON-RPC ids of open requests from one side to the numbers that the other side gets as their ids."""

    def __init__(self) -> None:
        self._numbers = count(1)
        self._ids: dict[int, Any] = {}

    def number(self, id: Any) -> int:
        """Note an open request with this id, and return a new number for it."""
        number = next(self._numbers)
        self._ids[number] = id
        return number

    def answered(self, number: Any) -> Iterator[Any]:
        """Yield the id of the open request with this number, if there is one, and close it."""
        if isinstance(number, int) and number in self._ids:
            yield self._ids.pop(number)

    def known(self, id: Any) -> Iterator[int]:
        """Yield the numbers of the open requests with this id."""
        if is_id(id):
            yield from [number for number, each in self._ids.items() if key_of_id(each) == key_of_id(id)]
