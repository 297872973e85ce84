"""The MCP client as the proxy writes to it: its requests that are not answered yet, and the answers to them."""

from collections.abc import Callable, Iterator
from dataclasses import field
from typing import Any

from exover.dataclass import dataclass
from exover.gate.mcp import lines
from exover.gate.mcp.calls import Exchange, ToolCall
from exover.gate.mcp.lines import Message, key_of_id
from exover.gate.mcp.results import refusal
from exover.gate.outer import CallId, reason_text
from exover.model.wire import Json

MAX_OPEN = 1000
"""The most requests of the client that may be open at once."""


@dataclass(slots=True)
class McpClient:
    """The client; `write` takes whole lines."""

    write: Callable[[bytes], None]
    _open: dict[tuple[bool, Any], int | CallId] = field(default_factory=dict)
    """Open requests by id: the number by which one was passed on, or the call that the gate decides."""
    _calls: dict[CallId, ToolCall] = field(default_factory=dict)
    _asked: Exchange = field(default_factory=Exchange)
    """Open requests of the server to the client."""

    def send(self, body: Json) -> None:
        """Write a message."""
        self.write(lines.write(body))

    def error(self, id: Any, code: int, text: str) -> None:
        """Write the response with a JSON-RPC error."""
        self.send(lines.error(id, code, text))

    # ---- its requests ----

    def admits(self, id: Any) -> bool:
        """Return whether a request with this id may be opened; if not, it is answered with an error."""
        if key_of_id(id) in self._open:
            text = f"the id {id!r:.60} is that of a request which is not answered yet"
            self.error(None, lines.INVALID_REQUEST, text)
        elif len(self._open) >= MAX_OPEN:
            self.error(id, lines.INVALID_REQUEST, f"{MAX_OPEN} requests are not answered yet")
        else:
            return True
        return False

    def passed(self, id: Any, number: int) -> None:
        """Open a request that was passed on to the server under this number."""
        self._open[key_of_id(id)] = number

    def called(self, call: CallId, message: Message) -> None:
        """Open a tool call that the gate decides about."""
        self._calls[call] = ToolCall(message.id, message.params)
        self._open[key_of_id(message.id)] = call

    def known(self, id: Any) -> int | CallId | None:
        """Return the number or the call of the open request with this id; None if there is none."""
        return self._open.get(key_of_id(id)) if lines.is_id(id) else None

    def call(self, call: CallId | None) -> ToolCall | None:
        """Return an open tool call; None if it is not open."""
        return self._calls.get(call) if call else None

    def close(self, id: Any) -> None:
        """Close the request with this id, since it is answered now or was cancelled."""
        self._open.pop(key_of_id(id), None)

    def forget(self, call: CallId) -> ToolCall | None:
        """Close and return a tool call, since it is answered now or was cancelled; None if it is not open."""
        found = self._calls.pop(call, None)
        if found:
            self.close(found.client_id)
        return found

    # ---- answers to them ----

    def answer(self, id: Any, body: Json) -> None:
        """Answer the request with this id by a response of the server."""
        self.close(id)
        self.send({**body, "jsonrpc": "2.0", "id": id})

    def hold(self, call: CallId, rule: str, because: str | None) -> None:
        """Tell the progress of a call that waits, if the client has asked for that."""
        found = self._calls.get(call)
        meta = found.params.get("_meta") if found else None
        token = meta.get("progressToken") if isinstance(meta, dict) else None
        if token is not None:
            params = {"progressToken": token, "progress": 0, "message": f"waits for {reason_text(rule, because)}"}
            self.send(lines.notification("notifications/progress", params))

    def refuse(self, call: CallId, rule: str, because: str | None, stateless: bool) -> None:
        """Answer a tool call by a tool error."""
        found = self.forget(call)
        if found:
            self._deny(found.client_id, refusal(rule, because), stateless)

    def finish(self, call: CallId, stateless: bool) -> None:
        """Answer a tool call by the response of the server; without one, by a tool error that says why it stopped."""
        found = self.forget(call)
        if found is None:
            return
        if found.answer is not None:
            self.send({**found.answer, "id": found.client_id})
        else:
            self._deny(found.client_id, refusal(*(found.stopped or ("interrupted", None)), "stopped"), stateless)

    def _deny(self, id: Any, error: Json, stateless: bool) -> None:
        """Write a tool error; in a stateless session with `resultType`, which is needed there."""
        self.send(lines.result(id, {**error, **({"resultType": "complete"} if stateless else {})}))

    # ---- requests of the server ----

    def request(self, message: Message) -> None:
        """Write a request of the server, under a new number."""
        self.send({**message.body, "id": self._asked.number(message.id)})

    def withdraw(self, message: Message) -> None:
        """Write a cancellation by the server, with the number of the request that it cancels."""
        for number in self._asked.known(message.params.get("requestId")):
            self.send({**message.body, "params": {**message.params, "requestId": number}})

    def answered(self, number: Any) -> Iterator[Any]:
        """Yield the server's id of the open request with this number, if there is one, and close it."""
        yield from self._asked.answered(number)
