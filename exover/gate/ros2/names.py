"""DDS names of ROS 2 topics, services, actions and types (REP 2002; design.ros2.org, 2015–2019)."""

import re
from typing import Literal, NamedTuple

Side = Literal["outer", "inner"]
PortPart = Literal["send_goal", "cancel_goal", "get_result", "feedback", "status", "call", "message"]
SERVICES: tuple[PortPart, ...] = ("send_goal", "cancel_goal", "get_result")
"""The services of an action."""
_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+\Z")
_TYPE = re.compile(r"[a-z][a-z0-9_]*/(msg|srv|action)/[A-Z][A-Za-z0-9]*\Z")


class Port(NamedTuple):
    """One end point of the gate: a part of an action, a service or a topic, by its outer or its inner name."""

    side: Side
    name: str
    part: PortPart


def absolute(name: str) -> str:
    """Return a name with its `/` at the head."""
    return name if name.startswith("/") else f"/{name}"


def is_name(name: str) -> bool:
    """Return whether this is a full ROS 2 name: with a `/` at the head and without `__`."""
    return _NAME.match(name) is not None and "__" not in name


def is_type(text: str, kind: str) -> bool:
    """Return whether this is the name of a type of this kind: `msg`, `srv` or `action`."""
    found = _TYPE.match(text)
    return found is not None and found[1] == kind


def service_of(port: Port) -> str:
    """Return the ROS 2 service name of a port of a service or an action."""
    return port.name if port.part == "call" else f"{port.name}/_action/{port.part}"


def request_topic(port: Port) -> str:
    """Return the DDS topic of a service's requests."""
    return f"rq{service_of(port)}Request"


def reply_topic(port: Port) -> str:
    """Return the DDS topic of a service's replies."""
    return f"rr{service_of(port)}Reply"


def message_topic(port: Port) -> str:
    """Return the DDS topic of a ROS 2 topic, or of an action's feedback or status."""
    return f"rt{port.name if port.part == 'message' else f'{port.name}/_action/{port.part}'}"


def dds_type(name: str) -> str:
    """Return the DDS name of a type `package/kind/Name`, its modules joined by dots."""
    package, kind, last = name.split("/")
    return f"{package}.{kind}.dds_.{last}_"
