"""What a bag has shown of action goals and service calls so far."""

from dataclasses import field
from typing import Any

from exover.dataclass import dataclass
from exover.gate.binding import RequestBinding
from exover.model.wire import Json


@dataclass(slots=True)
class SeenGoal:
    """An action goal or a service call, with its request, arguments and instance as far as they are known."""

    bound: RequestBinding | None
    args: Json | None = None
    instance: int | None = None
    asked: bool = False
    status: int = 0
    fault: str = ""
    seen: bool = False
    """Whether its watch has shown it as running."""
    rounds: int | None = None
    """How many messages its watch has shown since the response that it has started; None before that response."""

    def ends(self, meaning: str | None) -> bool:
        """Take the status that its watch shows; return whether it tells the end, and not that of an earlier run."""
        self.seen = self.seen or meaning == "running"
        if self.rounds is not None:
            self.rounds += 1
        return meaning not in (None, "running") and (self.seen or (self.rounds or 0) > 1)


@dataclass(slots=True)
class SeenGoals:
    """The goals of an action, or the open calls of a service, and which of its topics were recorded."""

    bounds: tuple[RequestBinding, ...]
    goals: dict[Any, SeenGoal] = field(default_factory=dict)
    sent: dict[tuple[int, ...], SeenGoal] = field(default_factory=dict)
    """The goals of an action with arguments, by id, read before all else: a status may stand before its goal."""
    has_goals: bool = False
    has_status: bool = False

    def goal(self, key: tuple[int, ...]) -> SeenGoal:
        """Return the goal of an id."""
        return self.goals.setdefault(key, self.sent.get(key) or SeenGoal(None))
