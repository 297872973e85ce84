"""What is open between client, gate and server."""

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
    """A request that the server has not answered; `client_id` is that of the client's own request, if it has one."""

    method: str
    client_id: Any = None
    cancelled: bool = False
    slot: SlotId | None = None
    """Of a call that carries out a request."""
    stops: SlotId | None = None
    """Of a call that stops one."""
    watch: Watch | None = None


@dataclass(slots=True)
class ToolCall:
    """A call of a tool by the client that the gate decides, until it is answered."""

    client_id: Any
    params: Json
    answer: Json | None = None
    """What the server has answered, to be given to the client once the slot has ended."""
    stopped: tuple[str, str | None] | None = None
    """The rule for which it was stopped, and why."""


class Exchange:
    """Ids of requests that one side has asked, and the numbers by which the other side knows them."""

    def __init__(self) -> None:
        self._numbers = count(1)
        self._ids: dict[int, Any] = {}

    def number(self, id: Any) -> int:
        """Return a new number for an id."""
        number = next(self._numbers)
        self._ids[number] = id
        return number

    def answered(self, number: Any) -> Iterator[Any]:
        """Yield the id of a number that is answered now, if there is such a request."""
        if isinstance(number, int) and number in self._ids:
            yield self._ids.pop(number)

    def known(self, id: Any) -> Iterator[int]:
        """Yield the numbers of what was asked by this id and is not answered."""
        if is_id(id):
            yield from [number for number, each in self._ids.items() if key_of_id(each) == key_of_id(id)]
