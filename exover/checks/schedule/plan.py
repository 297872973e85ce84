"""What is asked of a spec, and who answers."""

from collections.abc import Collection, Iterator

from exover.checks.questions import CHECKS, SEVERITY
from exover.checks.questions.property import CHECK as PROPERTY
from exover.checks.questions.property import coherence
from exover.checks.questions.question import Check, Question
from exover.checks.schedule.engines import PORTFOLIO, Engines
from exover.dataclass import dataclass
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties


@dataclass(frozen=True, slots=True)
class CheckPlan:
    """The names of the checks that are asked (None: all), in runs that satisfy the assumptions of `properties`.

    With `count`, the reachable states are counted as well.
    """

    checks: Collection[str] | None = None
    properties: Properties = NO_PROPERTIES
    engines: Engines = PORTFOLIO
    count: bool = False

    @property
    def skipped(self) -> tuple[str, ...]:
        """The checks that are not asked."""
        return () if self.checks is None else tuple(name for name in SEVERITY if name not in self.checks)

    def questions(self, model: Model) -> Iterator[tuple[Check, Question]]:
        """Yield the questions of the checks about a model, in the order of docs/checks.md.

        Whether the assumptions contradict each other is asked in any case: if they do, all other answers are about no
        run. Raises `ValueError` if a name is that of no check.
        """
        if self.checks is not None and (others := set(self.checks) - SEVERITY.keys()):
            raise ValueError(f"there is no check {', '.join(sorted(others))}")
        for check in CHECKS:
            chosen = self.checks is None or check.name in self.checks
            subjects = check.subjects if chosen else coherence if check is PROPERTY else None
            for subject, location in subjects(model, self.properties) if subjects else ():
                yield check, Question(check.name, check.severity, subject, location)
