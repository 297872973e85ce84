"""Goals of one action, as a gate knows them: open ones, and the last that have ended."""

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
"""Goals that have ended and whose results can still be asked for."""
KEPT_BYTES = 64 << 20
"""Bytes of their results."""
SHOWN = 10
"""Goals that have ended and are still in the status array."""
MAX_WAITING = 1000
"""Who may ask for the result of one goal at once."""


@dataclass(slots=True)
class ActionGoal:
    """A goal; `body` is its request without the header. `header`: that of the client, until it has its answer."""

    id: bytes
    body: bytes
    call: CallId | None = None
    peer: int = 0
    header: bytes | None = None
    stamp: Stamp = NEVER
    status: int = cdr.UNKNOWN
    slot: SlotId | None = None
    phase: Literal["new", "held", "sent", "running", "refused", "ended"] = "new"
    """At the server; `refused`: by the server."""
    stop: bool = False
    again: float = math.inf
    """When the server is asked for the result again: it shows the goal to have ended, and has not told it."""
    result: bytes | None = None
    """What the server has answered to `get_result`: its body."""
    waiting: list[tuple[int, bytes]] = field(default_factory=list)
    """Who has asked for the result: peers and their headers."""

    @property
    def info(self) -> GoalInfo:
        """Return its id, and when it was accepted."""
        return GoalInfo(self.id, self.stamp)


class ActionGoals:
    """The goals of an action by id."""

    def __init__(self) -> None:
        self._open: dict[bytes, ActionGoal] = {}
        self._ended: dict[bytes, ActionGoal] = {}
        self._shown = deque[bytes](maxlen=SHOWN)
        """What the status array says of the last that have ended."""
        self._bytes = 0

    def __iter__(self) -> Iterator[ActionGoal]:
        return iter(tuple(self._open.values()))

    def open(self, id: bytes) -> ActionGoal | None:
        """Return an open goal."""
        return self._open.get(id)

    def ended(self, id: bytes) -> ActionGoal | None:
        """Return a goal that has ended not long ago."""
        return self._ended.get(id)

    def known(self, id: bytes) -> bool:
        """Return whether a goal is open, or has ended not long ago."""
        return id in self._open or id in self._ended

    def add(self, goal: ActionGoal) -> None:
        """Know a goal."""
        self._open[goal.id] = goal

    def drop(self, goal: ActionGoal) -> None:
        """Forget a goal that never began."""
        if self._open.get(goal.id) is goal:
            del self._open[goal.id]

    def end(self, goal: ActionGoal, status: int, result: bytes) -> None:
        """Let an open goal have ended."""
        self.drop(goal)
        goal.phase, goal.status, goal.result, goal.body = "ended", status, result, b""
        self._ended[goal.id] = goal
        self._shown.append(cdr.status_entry(goal.info, status))
        self._bytes += len(result)
        while len(self._ended) > KEPT or (self._bytes > KEPT_BYTES and len(self._ended) > 1):
            oldest = self._ended.pop(next(iter(self._ended)))
            self._bytes -= len(oldest.result or b"")

    def statuses(self) -> bytes:
        """Return the body of the status array: what has been accepted, and the last that ended."""
        open_ = (each for each in self._open.values() if each.status != cdr.UNKNOWN)
        return cdr.statuses([*self._shown, *(cdr.status_entry(each.info, each.status) for each in open_)])

    def meant_by(self, info: GoalInfo) -> list[ActionGoal]:
        """Return the goals of clients that a cancel is about (action_msgs/srv/CancelGoal)."""
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
