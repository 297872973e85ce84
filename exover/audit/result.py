"""What became of missions: each of them, and all together."""

from collections.abc import Sequence
from dataclasses import field

from exover.audit.trail import AuditRow, MissionFigures
from exover.dataclass import dataclass
from exover.model.model import Model

MOST_ROWS = 1000
"""Divergences of a mission that are kept with their places; all are counted."""
MOST_MISTAKES = 20


@dataclass(frozen=True, slots=True)
class Mistake:
    """What cannot be read in a mission, and in which line."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class MissionResult:
    """What an audit says of one mission; `error` if it was not audited, and why. It can be sent to other processes."""

    name: str
    figures: MissionFigures = field(default_factory=MissionFigures)
    rows: tuple[AuditRow, ...] = ()
    """The divergences, the first ones."""
    mistakes: tuple[Mistake, ...] = ()
    mistake_count: int = 0
    notes: tuple[str, ...] = ()
    error: str = ""
    died: bool = False
    """The process that audited it died, twice."""
    table: bytes | str | None = None
    """All rows as Parquet, or the file that holds them."""

    @property
    def divergences(self) -> int:
        """How often it diverges."""
        return self.figures.diverged.total()

    @property
    def first(self) -> AuditRow | None:
        """The first divergence."""
        return self.rows[0] if self.rows else None


@dataclass(frozen=True, slots=True)
class Audit:
    """What an audit says of missions, in the order in which they were named."""

    version: str
    model: Model
    file: str
    missions: tuple[MissionResult, ...]

    @property
    def total(self) -> MissionFigures:
        """The counts of all missions."""
        figures = MissionFigures()
        for mission in self.missions:
            figures.add(mission.figures)
        return figures

    @property
    def diverging(self) -> Sequence[MissionResult]:
        """The missions that diverge."""
        return [mission for mission in self.missions if mission.divergences]


def rules_of(model: Model) -> tuple[str, ...]:
    """Return the names of all that can be used: guards, rules, resources, launch rules, in the order of the text."""
    from exover.ocrd.reasons import reasons

    return tuple(dict.fromkeys(reason.rule for reason in reasons(model)[1:]))
