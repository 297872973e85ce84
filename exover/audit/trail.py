"""What an audit finds: rows, and figures of a whole mission."""

from collections import Counter
from dataclasses import field
from typing import Literal, get_args

from exover.dataclass import dataclass

AuditAnswer = Literal["launch", "wait", "reject", "invalid", "none"]
ANSWERS: tuple[AuditAnswer, ...] = get_args(AuditAnswer)
Divergence = Literal["launched", "ran", "kept", "withheld", "stopped", "otherwise"]
DIVERGENCES: tuple[Divergence, ...] = get_args(Divergence)
REFUSED: tuple[Divergence, ...] = ("launched", "ran", "kept")
"""What the robot did against the tables; the others are things that it did not do, or did on its own."""
KINDS = ("ask", *DIVERGENCES)


@dataclass(frozen=True, slots=True)
class AuditRow:
    """An ask, or a divergence: where it is in the mission, and what the tables said, with the rule or the code."""

    line: int
    time: float
    kind: str
    request: str
    instance: int | None
    answer: AuditAnswer
    rule: str | None


@dataclass(slots=True)
class MissionFigures:
    """Counts over a mission."""

    events: int = 0
    told: int = 0
    deeds: int = 0
    passed: int = 0
    """Reports, aborts and stops of what the tables had not let run, or whose launch is undecided."""
    undecided: int = 0
    invalid: int = 0
    lost: int = 0
    followed: int = 0
    """Events that the audit has raised to follow the robot."""
    asks: Counter[tuple[str, AuditAnswer]] = field(default_factory=Counter)
    used: Counter[str] = field(default_factory=Counter)
    diverged: Counter[str] = field(default_factory=Counter)

    def add(self, other: "MissionFigures") -> None:
        """Add the counts of another mission."""
        for name in COUNTED:
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.asks.update(other.asks)
        self.used.update(other.used)
        self.diverged.update(other.diverged)

    def plain(self) -> "MissionFigures":
        """Return the same without counts of nought, so that equal missions have equal figures."""
        for counter in (self.asks, self.used, self.diverged):
            for key in [key for key, count in counter.items() if not count]:
                del counter[key]
        return self


COUNTED = ("events", "told", "deeds", "passed", "undecided", "invalid", "lost", "followed")
