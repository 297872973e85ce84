"""Clients and servers of ROS 2 on DDS, with types that were written by hand; nothing of the gate is used here."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LOOPBACK = """<CycloneDDS><Domain>
<General><Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers><LeaseDuration>2s</LeaseDuration></Discovery>
</Domain></CycloneDDS>"""
"""What keeps DDS on this machine, without multicast, which the loopback need not have."""
PATIENCE = 30.0
"""Seconds for what has to come."""
RELIABLE = (
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepAll,
    Policy.DataRepresentation(use_cdrv0_representation=True),
)
PLAIN = Qos(*RELIABLE, Policy.Durability.Volatile)
LATCHED = Qos(*RELIABLE[::2], Policy.History.KeepLast(1), Policy.Durability.TransientLocal)
ANY = SampleState.Any | ViewState.Any | InstanceState.Any
EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)


@dataclass
class Uuid(IdlStruct, typename="unique_identifier_msgs.msg.dds_.UUID_"):
    uuid: idl.array[idl.uint8, 16]


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: idl.int32
    nanosec: idl.uint32


@dataclass
class GoalInfo(IdlStruct, typename="action_msgs.msg.dds_.GoalInfo_"):
    goal_id: Uuid
    stamp: Time


@dataclass
class GoalStatus(IdlStruct, typename="action_msgs.msg.dds_.GoalStatus_"):
    goal_info: GoalInfo
    status: idl.int8


@dataclass
class StatusArray(IdlStruct, typename="action_msgs.msg.dds_.GoalStatusArray_"):
    status_list: idl.sequence[GoalStatus]


@dataclass
class CancelRequest(IdlStruct, typename="action_msgs.srv.dds_.CancelGoal_Request_"):
    client_: idl.uint64
    number_: idl.int64
    goal_info: GoalInfo


@dataclass
class CancelReply(IdlStruct, typename="action_msgs.srv.dds_.CancelGoal_Response_"):
    client_: idl.uint64
    number_: idl.int64
    return_code: idl.int8
    goals_canceling: idl.sequence[GoalInfo]


def action_types(name: str, goal: dict[str, Any], result: dict[str, Any], feedback: dict[str, Any]) -> dict[str, Any]:
    """Return the types of an action of the yard, given the fields of its messages."""
    from cyclonedds.idl import make_idl_struct

    def struct(last: str, fields: dict[str, Any]) -> Any:
        return make_idl_struct(last, f"yard_msgs.action.dds_.{last}_", fields)

    head = {"client_": idl.uint64, "number_": idl.int64}
    body, done, told = (
        struct(f"{name}_{part}", each) for part, each in (("Goal", goal), ("Result", result), ("Feedback", feedback))
    )
    return {
        "Goal": body, "Result": done, "Feedback": told,
        "goal": (struct(f"{name}_SendGoal_Request", {**head, "goal_id": Uuid, "goal": body}),
                 struct(f"{name}_SendGoal_Response", {**head, "accepted": bool, "stamp": Time})),
        "cancel": (CancelRequest, CancelReply),
        "result": (struct(f"{name}_GetResult_Request", {**head, "goal_id": Uuid}),
                   struct(f"{name}_GetResult_Response", {**head, "status": idl.int8, "result": done})),
        "feedback": struct(f"{name}_FeedbackMessage", {"goal_id": Uuid, "feedback": told}),
    }  # fmt: skip


DRIVE = action_types(
    "Drive", {"x": idl.float64}, {"metres": idl.float64, "error_code": idl.uint16}, {"left": idl.float64}
)
REACH = action_types("Reach", {"side": str}, {"touched": bool}, {"percent": idl.uint8})


@dataclass
class HaltRequest(IdlStruct, typename="yard_msgs.srv.dds_.Halt_Request_"):
    client_: idl.uint64
    number_: idl.int64
    reason: idl.uint8


@dataclass
class HaltReply(IdlStruct, typename="yard_msgs.srv.dds_.Halt_Response_"):
    client_: idl.uint64
    number_: idl.int64
    success: bool
    message: str


@dataclass
class Battery(IdlStruct, typename="yard_msgs.msg.dds_.Battery_"):
    level: idl.float32


@dataclass
class Text(IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str


class Node:
    """A participant, and a way to wait for whatever comes to its readers."""

    def __init__(self, domain: int) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("CYCLONEDDS_URI", LOOPBACK)
            self.participant = DomainParticipant(domain)
        self._waiting = WaitSet(self.participant)
        self._polled: list[Callable[[], None]] = []
        self._conditions: list[Any] = []

    def close(self) -> None:
        """Be gone, with all readers and writers, as a process that ends."""
        self._polled.clear()
        self.participant._delete(self.participant._ref)  # type: ignore[attr-defined]

    def reader(self, topic: str, type_: Any, qos: Qos = PLAIN) -> DataReader[Any]:
        found: DataReader[Any] = DataReader(self.participant, Topic(self.participant, topic, type_), qos)
        self._conditions.append(ReadCondition(found, ANY))
        self._waiting.attach(self._conditions[-1])
        return found

    def writer(self, topic: str, type_: Any, qos: Qos = PLAIN) -> DataWriter[Any]:
        return DataWriter(self.participant, Topic(self.participant, topic, type_), qos)

    def forget(self, poll: Callable[[], None]) -> None:
        self._polled.remove(poll)

    def poll_with(self, poll: Callable[[], None]) -> None:
        self._polled.append(poll)

    def until(self, condition: Callable[[], Any], what: str = "") -> Any:
        """Take what comes until a condition holds, and return what it gives."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for poll in self._polled:
                poll()
            found = condition()
            if found:
                return found
            self._waiting.wait(duration(milliseconds=20))
        raise AssertionError(f"it did not come: {what}")


def taken(reader: DataReader[Any]) -> Iterator[Any]:
    for sample in reader.take(1000):
        if sample.sample_info.valid_data:
            yield sample


class Server:
    """An action server that accepts everything and does nothing until it is told."""

    def __init__(self, node: Node, name: str, types: dict[str, Any]) -> None:
        self.types = types
        self.node = node
        self.goals: dict[bytes, Any] = {}
        self.cancelled: list[bytes] = []
        self.active: dict[bytes, int] = {}
        self.accepts = True
        self.cancels = True
        self._results: dict[bytes, Any] = {}
        self._wanted: dict[bytes, list[Any]] = {}
        self.ends = [
            (node.reader(f"rq{name}/_action/{part}Request", types[key][0]),
             node.writer(f"rr{name}/_action/{part}Reply", types[key][1]), key)
            for part, key in (("send_goal", "goal"), ("cancel_goal", "cancel"), ("get_result", "result"))
        ]  # fmt: skip
        self.feedback = node.writer(f"rt{name}/_action/feedback", types["feedback"])
        self.status = node.writer(f"rt{name}/_action/status", StatusArray, LATCHED)
        node.poll_with(self.poll)

    def poll(self) -> None:
        for reader, writer, key in self.ends:
            for request in taken(reader):
                getattr(self, f"_{key}")(request, writer)

    def _goal(self, request: Any, writer: Any) -> None:
        id = bytes(request.goal_id.uuid)
        assert id not in self.goals, "a goal came twice"
        self.goals[id] = request.goal
        if self.accepts:
            self.active[id] = EXECUTING
        writer.write(self.types["goal"][1](request.client_, request.number_, self.accepts, Time(1, 2)))
        self.show()

    def _cancel(self, request: Any, writer: Any) -> None:
        id = bytes(request.goal_info.goal_id.uuid)
        chosen = list(self.active) if id == bytes(16) else [each for each in self.active if each == id]
        chosen = chosen if self.cancels else []
        self.cancelled += chosen
        infos = [GoalInfo(Uuid(list(each)), Time(1, 2)) for each in chosen]
        code = 0 if infos or (id == bytes(16) and not self.active) else 1
        writer.write(CancelReply(request.client_, request.number_, code, infos))

    def _result(self, request: Any, writer: Any) -> None:
        id = bytes(request.goal_id.uuid)
        self._wanted.setdefault(id, []).append((request, writer))
        self._tell(id)

    def _tell(self, id: bytes) -> None:
        if id in self._results:
            for request, writer in self._wanted.pop(id, ()):
                status, result = self._results[id]
                writer.write(self.types["result"][1](request.client_, request.number_, status, result))

    def end(self, id: bytes, status: int, *result: Any) -> None:
        """Let a goal end."""
        self.active.pop(id, None)
        self._results[id] = status, self.types["Result"](*result)
        self._tell(id)
        self.show()

    def show(self) -> None:
        """Publish the status array."""
        found = [GoalStatus(GoalInfo(Uuid(list(id)), Time(1, 2)), each) for id, each in self.active.items()]
        self.status.write(StatusArray(found))


class Client:
    """An action client."""

    def __init__(self, node: Node, name: str, types: dict[str, Any]) -> None:
        self.node, self.types = node, types
        self.mark = uuid4().int & (2**63 - 1)
        self._numbers = count(1)
        self._ends = {
            key: (node.writer(f"rq{name}/_action/{part}Request", types[key][0]),
                  node.reader(f"rr{name}/_action/{part}Reply", types[key][1]))
            for part, key in (("send_goal", "goal"), ("cancel_goal", "cancel"), ("get_result", "result"))
        }  # fmt: skip
        self._answers: dict[int, Any] = {}
        self.statuses: dict[bytes, int] = {}
        self.feedback: list[tuple[bytes, Any]] = []
        self._feedback = node.reader(f"rt{name}/_action/feedback", types["feedback"])
        self._status = node.reader(f"rt{name}/_action/status", StatusArray, LATCHED)
        node.poll_with(self.poll)
        node.until(self.there, f"the server of {name}")

    def there(self) -> bool:
        return all(writer.get_matched_subscriptions() and reader.get_matched_publications()
                   for writer, reader in self._ends.values())  # fmt: skip

    def poll(self) -> None:
        for _, reader in self._ends.values():
            for reply in taken(reader):
                if reply.client_ == self.mark:
                    assert reply.number_ not in self._answers, "an answer came twice"
                    self._answers[reply.number_] = reply
        self.feedback += [(bytes(each.goal_id.uuid), each.feedback) for each in taken(self._feedback)]
        for array in taken(self._status):
            self.statuses = {bytes(each.goal_info.goal_id.uuid): each.status for each in array.status_list}

    def ask(self, key: str, *body: Any) -> int:
        """Send a request, and return its number."""
        number = next(self._numbers)
        self._ends[key][0].write(self.types[key][0](self.mark, number, *body))
        return number

    def answer(self, number: int) -> Any:
        """Return the answer to a request."""
        return self.node.until(lambda: self._answers.pop(number, None), f"the answer to request {number}")

    def answered(self, number: int) -> bool:
        self.poll()
        return number in self._answers

    def send(self, *goal: Any, id: bytes = b"") -> tuple[bytes, int]:
        """Send a goal, and return its id and the number of the request."""
        id = id or uuid4().bytes
        return id, self.ask("goal", Uuid(list(id)), self.types["Goal"](*goal))

    def accepted(self, *goal: Any) -> bytes:
        """Return the id of a goal once it is accepted."""
        id, number = self.send(*goal)
        assert self.answer(number).accepted
        return id

    def result(self, id: bytes) -> int:
        """Ask for the result of a goal, and return the number of the request."""
        return self.ask("result", Uuid(list(id)))

    def cancel(self, id: bytes) -> int:
        """Cancel a goal, and return the code of the answer."""
        code: int = self.answer(self.ask("cancel", GoalInfo(Uuid(list(id)), Time(0, 0)))).return_code
        return code


@contextmanager
def gate(folder: Path, spec: str, bind: str, domain: int, *options: str) -> Iterator[Path]:
    """Run the gate of the yard; yield where its decisions are logged."""
    (folder / "yard.exo").write_text(spec, "utf-8")
    (folder / "yard.bind.toml").write_text(bind, "utf-8")
    log = folder / "log.jsonl"
    command = [sys.executable, "-m", "exover", "gate", "ros2", "yard.exo", "--bind", "yard.bind.toml", "--unchecked"]
    command += ["--domain", str(domain), "--log", str(log), *options]
    with (
        (folder / "stderr").open("w") as errors,
        subprocess.Popen(command, cwd=folder, stderr=errors, env=os.environ | {"CYCLONEDDS_URI": LOOPBACK}) as process,
    ):
        try:
            yield log
        finally:
            process.terminate()
            assert process.wait(PATIENCE) == 143, (folder / "stderr").read_text()
