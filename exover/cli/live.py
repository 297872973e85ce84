"""The display of progress and findings on a terminal during a check."""

from collections import Counter
from time import monotonic

from exover.checks.finding import SEVERITIES, Finding
from exover.cli.streams import ProgressLine
from exover.diagnostics import Severity


class Live(ProgressLine):
    """The line with the number of answered questions, and above it a line for each finding that does not hold.

    Errors come first: a finding of lower severity is held back until no question of a higher one is open.
    """

    def __init__(self) -> None:
        """Begin to count the seconds."""
        self._started = monotonic()
        self._open: Counter[Severity] = Counter()
        self._asked = self._answered = 0
        self._held: list[Finding] = []

    def __call__(self, text: str) -> None:
        """Show this text instead of the last one, or while questions are open, how many are answered."""
        self.show(self._count() if self._answered < self._asked else text)

    def asks(self, questions: Counter[Severity]) -> None:
        """Begin to show how many of these questions, counted by severity, are answered."""
        self._open, self._asked = Counter(questions), questions.total()
        self.waits()

    def finds(self, finding: Finding) -> None:
        """Count one more answer, and show the finding unless it holds."""
        self._answered += 1
        self._open[finding.severity] -= 1
        if finding.verdict != "holds":
            self._held.append(finding)
        self._release()
        self.waits()

    def waits(self) -> None:
        """Show how many questions are answered."""
        self.show(self._count())

    def finish(self) -> None:
        """Show the findings held back: no more will come."""
        self._open.clear()
        self._release()

    def _release(self) -> None:
        """Show the findings held back of which no question of a higher severity is open."""
        for severity in SEVERITIES:
            for finding in [finding for finding in self._held if finding.severity == severity]:
                self._held.remove(finding)
                self.show("", above=f"{finding.word}: {finding.check} {finding.subject}")
            if self._open[severity]:
                return

    def _count(self) -> str:
        return f"{self._answered} of {self._asked} answered, {monotonic() - self._started:.0f} s"
