"""A gate between clients and servers of ROS 2 that are made of lists, with a clock that stands still."""

from collections.abc import Mapping
from functools import cache
from itertools import count
from typing import Any

from exover.gate.gate import Gate
from exover.gate.outer import SlotSaid
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import Stamp
from exover.gate.ros2.checking import mistakes
from exover.gate.ros2.files import finder
from exover.gate.ros2.interfaces import Interfaces
from exover.gate.ros2.names import Port, PortPart
from exover.gate.ros2.proxy import Ros2Proxy
from exover.gate.ros2.strays import AGAIN
from exover.ocrd.machine import Machine
from exover.pipeline import Build, build
from tests.gate.carts import binding_of, kept_in, model_of
from tests.gate.yard import BIND, INTERFACES, SPEC

TYPES = {"/drive": "yard_msgs/action/Drive", "/reach": "yard_msgs/action/Reach", "/halt": "yard_msgs/srv/Halt"}
DRIVE, REACH = "/gated/drive", "/gated/reach"
"""The actions as their servers have them."""
STARTS_IDLE = BIND.replace('spec = "yard"', 'spec = "yard"\nstart = "idle"')
"""A binding that says of each server that its start stops everything."""
HEADERS = count(1)
"""Numbers of requests of clients."""


@cache
def yard() -> Build:
    return build(model_of(SPEC))


@cache
def known() -> Interfaces:
    """Return the types of the yard."""
    return Interfaces(finder([str(INTERFACES)], {}))


def id_of(number: int) -> bytes:
    """Return a goal id."""
    return number.to_bytes(cdr.ID, "big")


class RosMiddle:
    """The gate of the yard; what was sent on each port is taken from its list when it is asked for."""

    def __init__(self, bind: str = BIND) -> None:
        self.now = 0.0
        self.journal: list[Mapping[str, Any]] = []
        self.told: list[str] = []
        self.sent: list[tuple[Port, bytes, int]] = []
        self.types = known()
        model, tables = yard().model, yard().tables
        binding = binding_of(bind, model)
        assert not list(mistakes(binding, self.types, apart=False))
        self.gate = Gate(model, binding, Machine(model, tables), lambda: self.now, kept_in(self.journal))
        ids = (id_of(number) for number in count(1_000_000))
        self.proxy = Ros2Proxy(
            self.gate,
            self.types,
            lambda *message: self.sent.append(message),
            self.told.append,
            lambda: Stamp(7, 8),
            lambda: next(ids),
            b"the gate",
        )
        self.proxy.start()
        self.starts_idle = all(each.starts_idle for each in binding.requests if each.kind == "action")

    def ready(self) -> "RosMiddle":
        """Let all servers come, where nothing runs."""
        for name in (DRIVE, REACH):
            self.come(name)
            self.show(name)
            self.meet(name)
        self.proxy.servers("service", "/gated/halt", frozenset({"server"}))
        assert self.gate.state.started
        return self

    def come(self, name: str, *keys: str) -> None:
        """Let the server of an action be these processes."""
        self.proxy.servers("action", name, frozenset(keys or {"server"}))

    def meet(self, name: str) -> None:
        """Let a server that runs nothing answer the only question of the gate: to cancel all goals, or, if it starts
        idle, one that nobody has.
        """
        ((data, _),) = self.got("inner", name, "cancel_goal")
        assert (data[20:36] == cdr.NO_ID) is not self.starts_idle
        self.serve(name, "cancel_goal", data, cdr.cancel_reply(cdr.CANCEL_UNKNOWN if self.starts_idle else 0, ()))

    def meet_again(self, name: str) -> None:
        """Let a server that has shown no status array since it came, and runs nothing, answer a second time."""
        self.now += AGAIN
        self.proxy.tick()
        self.meet(name)

    def leave(self, name: str) -> None:
        self.proxy.servers("action", name, frozenset())

    # ---- clients ----

    def client(self, name: str, part: PortPart, body: bytes, peer: int = 1) -> bytes:
        """Let a client ask, and return its header."""
        header = peer.to_bytes(8, "little") + next(HEADERS).to_bytes(8, "little")
        self.proxy.take(Port("outer", name, part), cdr.service(header, body), peer)
        return header

    def goal(self, name: str, number: int, peer: int = 1, **values: Any) -> bytes:
        """Let a client send a goal."""
        body = self.types.write(f"{TYPES[name]}_Goal", [((key,), value) for key, value in values.items()])
        return self.client(name, "send_goal", id_of(number) + body, peer)

    def drive(self, number: int, x: float = 1.0, peer: int = 1) -> bytes:
        return self.goal("/drive", number, peer, x=x)

    def reach(self, number: int, side: str = "l", peer: int = 1) -> bytes:
        return self.goal("/reach", number, peer, side=side)

    def cancel(self, name: str, number: int, stamp: Stamp = cdr.NEVER, peer: int = 1) -> int:
        """Let a client cancel a goal, and return the code that it is answered."""
        body = cdr.cancel_request(id_of(number))[: cdr.ID]
        body += stamp.seconds.to_bytes(4, "little") + stamp.nanoseconds.to_bytes(4, "little")
        header = self.client(name, "cancel_goal", body, peer)
        ((data, _),) = self.got("outer", name, "cancel_goal")
        assert data[4:20] == header
        return cdr.read_cancel_reply(data)[0]

    # ---- servers ----

    def serve(self, name: str, part: PortPart, asked: bytes, body: bytes) -> None:
        """Let the server answer a request of the gate."""
        self.proxy.take(Port("inner", name, part), cdr.service(asked[4:20], body), 99)

    def take_goal(self, name: str, accepted: bool = True) -> bytes:
        """Let the server answer the goal that it was sent; return that without its header."""
        ((data, _),) = self.got("inner", name, "send_goal")
        self.serve(name, "send_goal", data, cdr.goal_reply(accepted, Stamp(5, 6)))
        return data[20:]

    def end(self, name: str, status: int, **values: Any) -> None:
        """Let the server tell the result that it was asked for last."""
        type_ = TYPES[name.removeprefix("/gated")]
        body = self.types.write(
            f"{type_}_GetResult_Response", [(("result", key), each) for key, each in values.items()]
        )
        data, _ = self.got("inner", name, "get_result")[-1]
        self.serve(name, "get_result", data, bytes((status,)) + body[1:])

    def show(self, name: str, *goals: tuple[int, int]) -> None:
        """Let the server publish a status array."""
        body = cdr.statuses(
            cdr.status_entry(cdr.GoalInfo(id_of(number), Stamp(5, 6)), status) for number, status in goals
        )
        self.proxy.take(Port("inner", name, "status"), cdr.topic(body))

    # ---- what was sent ----

    def got(self, side: str, name: str, part: PortPart) -> list[tuple[bytes, int]]:
        """Return what was sent on a port since it was asked for last, and to whom."""
        port = Port(side, name, part)  # type: ignore[arg-type]
        found = [(data, peer) for each, data, peer in self.sent if each == port]
        self.sent = [each for each in self.sent if each[0] != port]
        return found

    def accepted(self, name: str, header: bytes) -> bool | None:
        """Return how a goal was answered, None if it was not."""
        for data, _ in self.got("outer", name, "send_goal"):
            assert data[4:20] == header
            answer = cdr.read_goal_reply(data)
            return answer and answer.accepted
        return None

    def result(self, name: str, number: int, peer: int = 1) -> tuple[int, Any] | None:
        """Ask for the result of a goal, and return its status and what it is, None if there is none yet."""
        self.client(name, "get_result", id_of(number), peer)
        return self.told_result(name)

    def told_result(self, name: str) -> tuple[int, Any] | None:
        found = self.got("outer", name, "get_result")
        if not found:
            return None
        message = self.types.read(f"{TYPES[name]}_GetResult_Response", found[-1][0][20:])
        return message["status"], dict(message["result"])

    def statuses(self, name: str) -> dict[int, int]:
        """Return the status array that was published last."""
        data, _ = self.got("outer", name, "status")[-1]
        return {int.from_bytes(id, "big"): status for id, *_, status in cdr.read_statuses(data)}

    def alarms(self) -> list[str]:
        return [str(entry["alarm"]) for entry in self.journal if "alarm" in entry]

    def rules(self) -> list[str]:
        """Return the rules of the refusals so far, of the gate and of the tables."""
        said = [action for entry in self.journal for action in (entry, *entry.get("actions", ()))]
        return [str(each["rule"]) for each in said if "refused" in each or "reject" in each]

    def say(self, slot: tuple[str, int], active: bool) -> None:
        self.gate.tell(SlotSaid(slot, active))
