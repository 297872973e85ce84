"""The goals of one action that the gate knows: the open ones, and the last ones that ended."""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import field
from typing import Literal

from exover.dataclass import dataclass
from exover.gate.outer import CallId
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import NEVER, GoalInfo, Stamp
from exover.model.state import SlotId

KEPT = 1000
"""The most ended goals whose results are kept."""
KEPT_BYTES = 64 << 20
"""The most bytes of their results in sum; the last result is kept at any size."""
SHOWN = 10
"""The most ended goals in the status array."""
MAX_WAITING = 1000
"""The most open requests for the result of one goal."""


@dataclass(slots=True)
class ActionGoal:
    """A goal; `body`: its `send_goal` request without the header; `header`: the client's, until it is answered."""

    id: bytes
    body: bytes
    call: CallId | None = None
    peer: int = 0
    header: bytes | None = None
    stamp: Stamp = NEVER
    status: int = cdr.UNKNOWN
    slot: SlotId | None = None
    phase: Literal["new", "held", "sent", "running", "refused", "ended"] = "new"
    """Where the goal is; `sent`: the server has not answered yet; `refused`: by the server."""
    stop: bool = False
    again: float = math.inf
    """When to ask for the result again, since the status array shows the end and no result has come; else infinite."""
    result: bytes | None = None
    """The body of the server's `get_result` response."""
    waiting: list[tuple[int, bytes]] = field(default_factory=list)
    """Open requests for the result: peers and their headers."""

    @property
    def info(self) -> GoalInfo:
        """The goal id, and when the goal was accepted."""
        return GoalInfo(self.id, self.stamp)


class ActionGoals:
    """The goals of an action, by id."""

    def __init__(self) -> None:
        self._open: dict[bytes, ActionGoal] = {}
        self._ended: dict[bytes, ActionGoal] = {}
        self._shown = deque[bytes](maxlen=SHOWN)
        """Status array entries of the last goals that ended."""
        self._bytes = 0

    def __iter__(self) -> Iterator[ActionGoal]:
        return iter(tuple(self._open.values()))

    def open(self, id: bytes) -> ActionGoal | None:
        """Return the open goal with this id; None if there is none."""
        return self._open.get(id)

    def ended(self, id: bytes) -> ActionGoal | None:
        """Return the ended goal with this id; None if there is none, or it is not kept any more."""
        return self._ended.get(id)

    def known(self, id: bytes) -> bool:
        """Return whether a goal with this id is open, or ended and still kept."""
        return id in self._open or id in self._ended

    def launched(self, id: bytes) -> bool:
        """Return whether a goal with this id, open or ended and still kept, was sent to the server."""
        goal = self._open.get(id) or self._ended.get(id)
        return goal is not None and goal.slot is not None

    def add(self, goal: ActionGoal) -> None:
        """Add an open goal."""
        self._open[goal.id] = goal

    def drop(self, goal: ActionGoal) -> None:
        """Remove a goal from the open ones."""
        if self._open.get(goal.id) is goal:
            del self._open[goal.id]

    def end(self, goal: ActionGoal, status: int, result: bytes) -> None:
        """Move an open goal to the ended ones; forget the oldest of these beyond `KEPT` and `KEPT_BYTES`."""
        self.drop(goal)
        goal.phase, goal.status, goal.result, goal.body = "ended", status, result, b""
        self._ended[goal.id] = goal
        self._shown.append(cdr.status_entry(goal.info, status))
        self._bytes += len(result)
        while len(self._ended) > KEPT or (self._bytes > KEPT_BYTES and len(self._ended) > 1):
            oldest = self._ended.pop(next(iter(self._ended)))
            self._bytes -= len(oldest.result or b"")

    def statuses(self) -> bytes:
        """Return the body of the status array: the last goals that ended, then the open ones that were accepted."""
        open_ = (each for each in self._open.values() if each.status != cdr.UNKNOWN)
        return cdr.statuses([*self._shown, *(cdr.status_entry(each.info, each.status) for each in open_)])

    def meant_by(self, info: GoalInfo) -> list[ActionGoal]:
        """Return the open goals of clients that a cancel request means (action_msgs/srv/CancelGoal)."""
        whole = info.id == cdr.NO_ID
        early = info.stamp if info.stamp != NEVER else None
        return [
            goal
            for goal in self
            if goal.call is not None
            and (
                goal.id == info.id
                or (whole and early is None)
                or (early is not None and goal.status != cdr.UNKNOWN and goal.stamp <= early)
            )
        ]
