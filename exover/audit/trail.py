"""What an audit finds: rows of asks and divergences, and the counts of a mission."""

from collections import Counter
from dataclasses import field
from typing import Literal, get_args

from exover.dataclass import dataclass

AuditAnswer = Literal["launch", "wait", "reject", "invalid", "none"]
ANSWERS: tuple[AuditAnswer, ...] = get_args(AuditAnswer)
Divergence = Literal["launched", "ran", "kept", "withheld", "stopped", "otherwise"]
DIVERGENCES: tuple[Divergence, ...] = get_args(Divergence)
ERRORS: tuple[Divergence, ...] = ("launched", "ran", "kept")
"""The divergences that SARIF reports as errors; the others are notes."""
RowKind = Literal["ask"] | Divergence
KINDS: tuple[RowKind, ...] = ("ask", *DIVERGENCES)


@dataclass(frozen=True, slots=True)
class AuditRow:
    """An ask or a divergence: its line and time, NaN if unknown, and the answer of the tables with its rule or code."""

    line: int
    time: float
    kind: RowKind
    request: str
    instance: int | None
    answer: AuditAnswer
    rule: str | None


@dataclass(slots=True)
class MissionFigures:
    """Counts over one mission or several."""

    events: int = 0
    told: int = 0
    deeds: int = 0
    passed: int = 0
    """Recorded events and kills that were not put to the tables, as of instances that do not run there."""
    undecided: int = 0
    invalid: int = 0
    lost: int = 0
    followed: int = 0
    """Events of the audit's own, asked to follow the robot."""
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
        """Drop counts of zero, so that equal missions have equal figures, and return self."""
        for counter in (self.asks, self.used, self.diverged):
            for key in [key for key, count in counter.items() if not count]:
                del counter[key]
        return self


COUNTED = ("events", "told", "deeds", "passed", "undecided", "invalid", "lost", "followed")
