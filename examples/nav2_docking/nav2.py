"""Stand-ins for the servers of Nav2, and a client of actions: small, on DDS, with the types of `interfaces/`."""

import os
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

from cyclonedds.domain import DomainParticipant

from exover.gate.ros2 import cdr, endpoints
from exover.gate.ros2.endpoints import TopicReader, TopicWriter
from exover.gate.ros2.files import finder
from exover.gate.ros2.idl import SampleTypes
from exover.gate.ros2.interfaces import CANCEL, Interfaces
from exover.gate.ros2.names import Port, PortPart, Side, message_topic, reply_topic, request_topic

HERE = Path(__file__).resolve().parent
PATIENCE = 60.0
"""Seconds for what has to come."""
SERVICES: tuple[tuple[PortPart, str], ...] = (
    ("send_goal", "SendGoal"),
    ("cancel_goal", ""),
    ("get_result", "GetResult"),
)


class World:
    """A participant of DDS, and everybody who lives in it and takes what comes."""

    def __init__(self, domain: int) -> None:
        self.participant = DomainParticipant(domain)
        self.types = Interfaces(finder([str(HERE / "interfaces")], os.environ))
        self.samples = SampleTypes(self.types)
        self.live: list[Callable[[], None]] = []

    def service(self, port: Port, type_: str, asks: bool) -> tuple[TopicReader, TopicWriter]:
        """Return what reads answers and writes requests if it asks, else what reads requests and writes answers."""
        request = request_topic(port), self.samples.service(f"{type_}_Request")
        reply = reply_topic(port), self.samples.service(f"{type_}_Response")
        come, go = (reply, request) if asks else (request, reply)
        return TopicReader(self.participant, *come, endpoints.REQUESTS), TopicWriter(
            self.participant, *go, endpoints.REPLIES
        )

    def action(self, name: str, type_: str, asks: bool) -> dict[PortPart, tuple[TopicReader, TopicWriter]]:
        """Return the services of an action."""
        self.types.load(type_)
        port: Callable[[PortPart], Port] = lambda part: Port("outer", name, part)  # noqa: E731
        return {part: self.service(port(part), f"{type_}_{of}" if of else CANCEL, asks) for part, of in SERVICES}

    def writer(self, side: Side, name: str, part: PortPart, type_: str, qos: Any) -> TopicWriter:
        """Return what publishes a topic."""
        self.types.load(type_)
        return TopicWriter(self.participant, message_topic(Port(side, name, part)), self.samples.message(type_), qos)

    def until(self, condition: Callable[[], Any], what: str) -> Any:
        """Let everybody live until a condition holds, and return what it gives."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for each in self.live:
                each()
            found = condition()
            if found:
                return found
            time.sleep(0.002)
        raise SystemExit(f"it did not come: {what}")


class Server:
    """An action server: each goal runs until it is told how it ends, or is cancelled."""

    def __init__(self, world: World, name: str, type_: str) -> None:
        self.type, self._types = type_, world.types
        self._ends = world.action(name, type_, asks=False)
        self.running: list[bytes] = []
        self._results: dict[bytes, bytes] = {}
        self._wanted: dict[bytes, bytes] = {}
        world.live.append(self.live)

    def live(self) -> None:
        """Answer what has come."""
        for part, (reader, writer) in self._ends.items():
            for data, _ in reader.take():
                header, id = data[4:20], data[20:36]
                if part == "get_result":
                    self._wanted[id] = header
                else:
                    body = self._begin(id) if part == "send_goal" else self._cancel(id)
                    writer.write(cdr.service(header, body))
        for id in [each for each in self._wanted if each in self._results]:
            self._ends["get_result"][1].write(cdr.service(self._wanted.pop(id), self._results.pop(id)))

    def _begin(self, id: bytes) -> bytes:
        self.running.append(id)
        return cdr.goal_reply(True, cdr.Stamp(1, 0))

    def _cancel(self, id: bytes) -> bytes:
        chosen = [each for each in self.running if id in (each, cdr.NO_ID)]
        for each in chosen:
            self.end(cdr.CANCELED, each)
        return cdr.cancel_reply(cdr.CANCEL_OK, [cdr.GoalInfo(each, cdr.Stamp(1, 0)) for each in chosen])

    def end(self, status: int, id: bytes = b"", **result: Any) -> None:
        """Let a goal end, the one that runs if none is named."""
        id = id or self.running[-1]
        self.running.remove(id)
        values = [(("status",), status)] + [(("result", key), value) for key, value in result.items()]
        self._results[id] = self._types.write(f"{self.type}_GetResult_Response", values)


class Client:
    """An action client."""

    def __init__(self, world: World, name: str, type_: str) -> None:
        self.type, self._world = type_, world
        self._ends = world.action(name, type_, asks=True)
        self._mark, self._number = uuid4().bytes[:8], 0
        world.until(self._there, f"the server of {name}")

    def _there(self) -> bool:
        return all(list(writer.readers()) and list(reader.writers()) for reader, writer in self._ends.values())

    def ask(self, part: PortPart, body: bytes) -> Callable[[], bytes | None]:
        """Ask a service; return what gives the body of the answer once it is there."""
        self._number += 1
        header = self._mark + struct.pack("<q", self._number)
        reader, writer = self._ends[part]
        writer.write(cdr.service(header, body))

        def answer() -> bytes | None:
            return next((data[20:] for data in _taken(reader) if data[4:20] == header), None)

        return answer

    def send(self, **goal: Any) -> bytes | None:
        """Send a goal, its fields by name with `__` for dots, and return its id if it is accepted."""
        id = uuid4().bytes
        values = [(tuple(key.split("__")), value) for key, value in goal.items()]
        answer = self.ask("send_goal", id + self._world.types.write(f"{self.type}_Goal", values))
        return id if self._world.until(answer, "the answer to a goal")[0] else None

    def result(self, id: bytes) -> Callable[[], bytes | None]:
        """Ask for the result of a goal; its first byte is the status."""
        return self.ask("get_result", id)


def _taken(reader: TopicReader) -> Iterator[bytes]:
    for data, _ in reader.take():
        yield data
