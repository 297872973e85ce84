"""Bags for the tests of audits: written by `rosbags`, with types of their own."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

EVENT = """service_msgs/ServiceEventInfo info
{package}/{name}_Request[<=1] request
{package}/{name}_Response[<=1] response
"""
TYPES = {
    "yard/action/Lift_Goal": "float32 load\nstring mode\n",
    "yard/action/Lift_SendGoal_Request": "unique_identifier_msgs/UUID goal_id\nyard/action/Lift_Goal goal\n",
    "yard/action/Lift_SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp\n",
    "yard/action/Lift_SendGoal_Event": EVENT.format(package="yard/action", name="Lift_SendGoal"),
    "yard/action/Turn_Result": "float32 degrees\nuint16 error_code\n",
    "yard/action/Turn_GetResult_Request": "unique_identifier_msgs/UUID goal_id\n",
    "yard/action/Turn_GetResult_Response": "int8 status\nyard/action/Turn_Result result\n",
    "yard/action/Turn_GetResult_Event": EVENT.format(package="yard/action", name="Turn_GetResult"),
    "yard/srv/Park_Request": "bool quick\n",
    "yard/srv/Park_Response": "bool success\n",
    "yard/srv/Park_Event": EVENT.format(package="yard/srv", name="Park"),
    "yard/msg/Wind": "float64 metres_per_second\n",
}
RULER = "=" * 80
HASH = "RIHS01_" + "0" * 64


def known(kind: str) -> str:
    """Return what `rosbags` calls a type of a service."""
    return kind.replace("/srv/", "/srv/msg/")


def definition(kind: str) -> str:
    """Return the definition of a type as a recorder writes it: with those that it names."""
    if kind not in TYPES:
        store = get_typestore(Stores.LATEST)
        return store.generate_msgdef(kind, ros_version=2)[0]
    named = [name for name in TYPES if name != kind and kind.endswith("_Event")]
    foreign = ["builtin_interfaces/msg/Time", "unique_identifier_msgs/msg/UUID", "service_msgs/msg/ServiceEventInfo"]
    texts = {name: TYPES[name] for name in named}
    if named:
        texts |= {
            name: get_typestore(Stores.LATEST).generate_msgdef(name, ros_version=2)[0].split(RULER)[0]
            for name in foreign
        }
    return TYPES[kind] + "".join(f"{RULER}\nMSG: {name}\n{text}" for name, text in texts.items())


class BagWriter:
    """Writes a bag; times are seconds. `define` gives the definitions of types that the bag holds."""

    def __init__(self, path: Path, plugin: str = "mcap", define: Callable[[str], str] = definition) -> None:
        self.define = define
        self.store = get_typestore(Stores.LATEST)
        for name, text in TYPES.items():
            self.store.register(get_types_from_msg(text, name))
        self.writer = Writer(path, version=9, storage_plugin=StoragePlugin[plugin.upper()])
        self.connections: dict[str, Any] = {}
        self.now = 0

    def __enter__(self) -> "BagWriter":
        self.writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.writer.close()

    def make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[known(kind)](**fields)

    def write(self, topic: str, kind: str, message: Any) -> None:
        """Write a message a second after the one before."""
        self.now += 1_000_000_000
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, msgdef=self.define(kind), rihs01=HASH)
        self.writer.write(self.connections[topic], self.now, self.store.serialize_cdr(message, known(kind)))

    # ---- messages ----

    def uuid(self, goal: int) -> Any:
        return self.make("unique_identifier_msgs/msg/UUID", uuid=np.full(16, goal, np.uint8))

    def stamp(self) -> Any:
        return self.make("builtin_interfaces/msg/Time", sec=0, nanosec=0)

    def status(self, action: str, **goals: int) -> None:
        """Write what statuses goals have, which are called g1, g2 and so on."""
        listed = []
        for name, status in goals.items():
            info = self.make("action_msgs/msg/GoalInfo", goal_id=self.uuid(int(name[1:])), stamp=self.stamp())
            listed.append(self.make("action_msgs/msg/GoalStatus", goal_info=info, status=status))
        message = self.make("action_msgs/msg/GoalStatusArray", status_list=listed)
        self.write(f"{action}/_action/status", "action_msgs/msg/GoalStatusArray", message)

    def info(self, event: int, number: int) -> Any:
        gid = np.full(16, 7, np.uint8)
        return self.make(
            "service_msgs/msg/ServiceEventInfo",
            event_type=event,
            stamp=self.stamp(),
            client_gid=gid,
            sequence_number=number,
        )

    def goal(self, goal: int, load: float, mode: str = "") -> None:
        inner = self.make("yard/action/Lift_Goal", load=load, mode=mode)
        sent = self.make("yard/action/Lift_SendGoal_Request", goal_id=self.uuid(goal), goal=inner)
        self.event("/lift/_action/send_goal/_service_event", "yard/action/Lift_SendGoal_Event", 1, goal, [sent], [])

    def accept(self, goal: int, accepted: bool = True) -> None:
        answer = self.make("yard/action/Lift_SendGoal_Response", accepted=accepted, stamp=self.stamp())
        self.event("/lift/_action/send_goal/_service_event", "yard/action/Lift_SendGoal_Event", 2, goal, [], [answer])

    def turned(self, goal: int, status: int, degrees: float, error_code: int = 0) -> None:
        """Write a question for the result of a turn, and its answer."""
        topic, kind = "/turn/_action/get_result/_service_event", "yard/action/Turn_GetResult"
        asked = self.make(f"{kind}_Request", goal_id=self.uuid(goal))
        self.event(topic, f"{kind}_Event", 1, goal, [asked], [])
        result = self.make("yard/action/Turn_Result", degrees=degrees, error_code=error_code)
        answer = self.make(f"{kind}_Response", status=status, result=result)
        self.event(topic, f"{kind}_Event", 2, goal, [], [answer])

    def park(self, number: int) -> None:
        for event in (0, 1):  # recorded at the client and at the server
            sent = self.make("yard/srv/Park_Request", quick=True)
            self.event("/park/_service_event", "yard/srv/Park_Event", event, number, [sent], [])

    def parked(self, number: int, success: bool) -> None:
        answer = self.make("yard/srv/Park_Response", success=success)
        self.event("/park/_service_event", "yard/srv/Park_Event", 2, number, [], [answer])

    def event(self, topic: str, kind: str, event: int, number: int, request: list[Any], response: list[Any]) -> None:
        self.write(topic, kind, self.make(kind, info=self.info(event, number), request=request, response=response))

    def wind(self, speed: float) -> None:
        self.write("/wind", "yard/msg/Wind", self.make("yard/msg/Wind", metres_per_second=speed))
