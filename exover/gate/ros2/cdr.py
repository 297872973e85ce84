"""The messages of the action protocol that the gate reads and writes itself: XCDR1, in this machine's byte order.

Layouts: action_msgs and unique_identifier_msgs of ROS 2. A service message begins with 4 bytes of encapsulation and a
header of 16 bytes that belongs to the client; the gate reads the header of its own requests only.
"""

import struct
import sys
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from exover.model.event import Ending

ORDER = "<" if sys.byteorder == "little" else ">"
ENCAPSULATION = bytes((0, int(sys.byteorder == "little"), 0, 0))
BODY = 4
"""Offset in bytes of the body of a topic message."""
HEAD = 20
"""Offset in bytes of the body of a service message."""
ID = 16
"""Bytes of a goal id."""
NO_ID = bytes(ID)
"""The goal id of zeros, which means all goals in a cancel request."""

UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)
"""Goal statuses (action_msgs/msg/GoalStatus)."""
ACTIVE = (ACCEPTED, EXECUTING, CANCELING)
OUTCOME_OF: dict[int, Ending] = {SUCCEEDED: "ok", CANCELED: "interrupted", ABORTED: "failed"}
"""The outcomes of the statuses that end a goal."""
CANCEL_OK, CANCEL_REJECTED, CANCEL_UNKNOWN, CANCEL_TERMINATED = range(4)
"""Return codes of `cancel_goal` (action_msgs/srv/CancelGoal)."""

_GOAL_REPLY = struct.Struct(f"{ORDER}?3xiI")
_GOAL_INFO = struct.Struct(f"{ORDER}16siI")
PADDING = 3
_STATUS = struct.Struct(f"{ORDER}16s{PADDING}xiIb")
_COUNT = struct.Struct(f"{ORDER}I")
_CANCEL_REPLY = struct.Struct(f"{ORDER}b3xI")


class Stamp(NamedTuple):
    """A time of ROS 2: seconds since 1970, and nanoseconds."""

    seconds: int
    nanoseconds: int


class GoalReply(NamedTuple):
    """A server's response to `send_goal`: whether it accepts the goal, and when."""

    accepted: bool
    stamp: Stamp


class GoalInfo(NamedTuple):
    """A goal id, and when the goal was accepted (action_msgs/msg/GoalInfo)."""

    id: bytes
    stamp: Stamp


NEVER = Stamp(0, 0)


def plain(data: bytes, least: int) -> bool:
    """Return whether a message is XCDR1 in this machine's byte order and has at least `least` bytes."""
    return data[:2] == ENCAPSULATION[:2] and len(data) >= least


def service(header: bytes, body: bytes) -> bytes:
    """Return a service message with a header of 16 bytes."""
    return ENCAPSULATION + header + body


def topic(body: bytes) -> bytes:
    """Return a topic message."""
    return ENCAPSULATION + body


def text(content: bytes) -> bytes:
    """Return the body of a message that is one string."""
    return _COUNT.pack(len(content) + 1) + content + b"\0"


def goal_reply(accepted: bool, stamp: Stamp) -> bytes:
    """Return the body of a `send_goal` response."""
    return _GOAL_REPLY.pack(accepted, *stamp)


def read_goal_reply(data: bytes) -> GoalReply | None:
    """Return the content of a `send_goal` response; None if it is too short."""
    if len(data) < HEAD + _GOAL_REPLY.size:
        return None
    accepted, *stamp = _GOAL_REPLY.unpack_from(data, HEAD)
    return GoalReply(accepted, Stamp(*stamp))


def cancel_request(goal: bytes) -> bytes:
    """Return the body of a `cancel_goal` request for one goal, or with `NO_ID` for all."""
    return _GOAL_INFO.pack(goal, *NEVER)


def read_cancel(data: bytes) -> GoalInfo | None:
    """Return the goal info in a `cancel_goal` request; None if it is too short."""
    return _info(data, HEAD) if len(data) >= HEAD + _GOAL_INFO.size else None


def cancel_reply(code: int, goals: Iterable[GoalInfo]) -> bytes:
    """Return the body of a `cancel_goal` response."""
    found = [_GOAL_INFO.pack(each.id, *each.stamp) for each in goals]
    return _CANCEL_REPLY.pack(code, len(found)) + b"".join(found)


def read_cancel_reply(data: bytes) -> tuple[int, tuple[bytes, ...]]:
    """Return the return code of a `cancel_goal` response, and the ids of the goals that it cancels.

    A response that is too short is read as rejected; of a list that is cut off, the whole entries are read.
    """
    start = HEAD + _CANCEL_REPLY.size
    code, count = _CANCEL_REPLY.unpack_from(data, HEAD) if len(data) >= start else (CANCEL_REJECTED, 0)
    count = min(count, (len(data) - start) // _GOAL_INFO.size)
    return code, tuple(_info(data, start + each * _GOAL_INFO.size).id for each in range(count))


def status_entry(goal: GoalInfo, status: int) -> bytes:
    """Return a goal's entry in a status array, with the padding that all but the first have behind the id."""
    return _STATUS.pack(goal.id, *goal.stamp, status)


def statuses(entries: Iterable[bytes]) -> bytes:
    """Return the body of a status array."""
    found = b"".join(entries)
    return _COUNT.pack(len(found) // _STATUS.size) + found[:ID] + found[ID + PADDING :]


def read_statuses(data: bytes) -> Iterator[tuple[bytes, int, int, int]]:
    """Yield id, seconds and nanoseconds of the stamp, and status for each whole entry of a status array."""
    start = BODY + _COUNT.size
    (count,) = _COUNT.unpack_from(data, BODY) if len(data) >= start else (0,)
    entries = data[start : start + ID] + bytes(PADDING) + data[start + ID :]
    return _STATUS.iter_unpack(entries[: min(count, len(entries) // _STATUS.size) * _STATUS.size])


def _info(data: bytes, at: int) -> GoalInfo:
    goal, seconds, nanoseconds = _GOAL_INFO.unpack_from(data, at)
    return GoalInfo(goal, Stamp(seconds, nanoseconds))
