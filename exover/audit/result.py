"""Results of an audit: of each mission, and of all missions together."""

from collections.abc import Sequence
from dataclasses import field

from exover.audit.trail import AuditRow, MissionFigures
from exover.dataclass import dataclass
from exover.model.model import Model

MOST_ROWS = 1000
"""The most divergences of a mission that are kept with their lines; all are counted."""
MOST_MISTAKES = 20


@dataclass(frozen=True, slots=True)
class Mistake:
    """A mistake in a mission, and its line."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class MissionResult:
    """The audit of one mission; `error`: why it was not audited, if so. It can be sent to other processes."""

    name: str
    figures: MissionFigures = field(default_factory=MissionFigures)
    rows: tuple[AuditRow, ...] = ()
    """The first divergences, at most `MOST_ROWS`."""
    mistakes: tuple[Mistake, ...] = ()
    mistake_count: int = 0
    notes: tuple[str, ...] = ()
    error: str = ""
    died: bool = False
    """Whether the process that audited it died, and died again on a second try."""
    table: bytes | str | None = None
    """All rows as Parquet, or the path of the file that holds them; None if they are not wanted."""

    @property
    def divergences(self) -> int:
        """The number of divergences."""
        return self.figures.diverged.total()

    @property
    def first(self) -> AuditRow | None:
        """The first divergence."""
        return self.rows[0] if self.rows else None


@dataclass(frozen=True, slots=True)
class Audit:
    """The audit of all missions, in the order in which they were named."""

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
    def audited(self) -> bool:
        """Whether any mission was audited."""
        return not all(mission.error for mission in self.missions)

    @property
    def diverging(self) -> Sequence[MissionResult]:
        """The missions that diverge."""
        return [mission for mission in self.missions if mission.divergences]


def rules_of(model: Model) -> tuple[str, ...]:
    """Return the names of guards, rules, resources and launch rules, whose use is counted, in the order of the text."""
    from exover.ocrd.reasons import reasons

    return tuple(dict.fromkeys(reason.rule for reason in reasons(model)[1:]))
