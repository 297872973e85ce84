"""A gate between a client and a server that are made of lists, with a clock that stands still."""

import json
from collections.abc import Mapping
from functools import cache
from typing import Any

from exover.gate.gate import Gate
from exover.gate.mcp.proxy import McpProxy
from exover.model.model import Model
from exover.ocrd.machine import Machine
from exover.pipeline import Build, build
from tests.gate.carts import BIND, SPEC, binding_of, kept_in, model_of

IDLE = {"base": {"phase": "halted", "metres": 0, "speed_mm": 0}, "paint": 5}


@cache
def cart() -> Build:
    return build(model_of(SPEC))


class Middle:
    """The gate of a cart; what each side was sent, as objects, is taken from its list when it is asked for."""

    def __init__(self, bind: str = BIND, model: Model | None = None) -> None:
        self.now = 0.0
        self.journal: list[Mapping[str, Any]] = []
        self.complaints: list[str] = []
        self._to_client: list[bytes] = []
        self._to_server: list[bytes] = []
        found = build(model) if model else cart()
        machine = Machine(found.model, found.tables)
        self.gate = Gate(found.model, binding_of(bind, found.model), machine, lambda: self.now, kept_in(self.journal))
        sent = self._to_client.append, self._to_server.append
        self.proxy = McpProxy(self.gate, *sent, self.complaints.append)
        self.proxy.start()

    def ready(self, state: Mapping[str, Any] = IDLE) -> "Middle":
        """Begin the session, and let the watch say what runs."""
        self.client({"method": "notifications/initialized"})
        self.server_got()
        self.watched(state)
        return self

    def watched(self, state: Mapping[str, Any]) -> None:
        """Let the watch be called, and answered."""
        self.shown(self.polled(), state)

    def polled(self, after: float = 0.1) -> dict[str, Any]:
        """Let the watch be called after so many seconds, and return its call."""
        self.now += after
        self.proxy.tick()
        (poll,) = [each for each in self.server_got() if each.get("params", {}).get("name") == "get_state"]
        return poll

    def shown(self, poll: Mapping[str, Any], state: Mapping[str, Any]) -> None:
        """Answer a call of the watch."""
        self.answer(poll, {"content": [{"type": "text", "text": json.dumps(state)}]})

    def client(self, body: Mapping[str, Any]) -> None:
        self.proxy.from_client(json.dumps({"jsonrpc": "2.0", **body}).encode())

    def server(self, body: Mapping[str, Any]) -> None:
        self.proxy.from_server(json.dumps({"jsonrpc": "2.0", **body}).encode())

    def answer(self, request: Mapping[str, Any], result: Any) -> None:
        """Let the server answer a request."""
        self.server({"id": request["id"], "result": result})

    def call(self, id: object, name: str, arguments: object = None, **params: object) -> None:
        self.client(
            {"id": id, "method": "tools/call", "params": {"name": name, "arguments": arguments or {}, **params}}
        )

    def client_got(self) -> list[dict[str, Any]]:
        """Return what the client was sent since it was asked for last."""
        found = [json.loads(line) for line in self._to_client]
        self._to_client.clear()
        return found

    def server_got(self) -> list[dict[str, Any]]:
        """Return what the server was sent since it was asked for last."""
        found = [json.loads(line) for line in self._to_server]
        self._to_server.clear()
        return found

    def alarms(self) -> list[str]:
        return [str(entry["alarm"]) for entry in self.journal if "alarm" in entry]
