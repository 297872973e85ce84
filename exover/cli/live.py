"""What is seen of findings on a terminal while the rest is still looked for."""

from collections import Counter
from time import monotonic

from exover.checks.finding import SEVERITIES, Finding
from exover.cli.streams import ProgressLine
from exover.diagnostics import Severity


class Live(ProgressLine):
    """The line that tells how many questions are answered, and above it, a line each, what does not hold.

    Errors come first: what weighs less waits until no error is open.
    """

    def __init__(self, started: float | None = None) -> None:
        """Begin to count the seconds at this time of `monotonic` (default: now)."""
        self._started = monotonic() if started is None else started
        self._open: Counter[Severity] = Counter()
        self._asked = self._answered = 0
        self._held: list[Finding] = []

    def __enter__(self) -> "Live":
        super().__enter__()
        return self

    def __call__(self, text: str) -> None:
        """Show this text instead of the last one; while questions are open, how many are answered."""
        self.show(self._count() if self._answered < self._asked else text)

    def asks(self, questions: Counter[Severity]) -> None:
        """Show from now on how many of so many questions are answered."""
        self._open, self._asked = Counter(questions), questions.total()
        self.waits()

    def finds(self, finding: Finding) -> None:
        """Show that one more is answered, and the finding unless it holds."""
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
        """Show what is held: nothing will be found any more."""
        self._open.clear()
        self._release()

    def _release(self) -> None:
        """Show what is held as far as nothing is open that weighs more."""
        for severity in SEVERITIES:
            for finding in [finding for finding in self._held if finding.severity == severity]:
                self._held.remove(finding)
                self.show("", above=f"{finding.word}: {finding.check} {finding.subject}")
            if self._open[severity]:
                return

    def _count(self) -> str:
        return f"{self._answered} of {self._asked} answered, {monotonic() - self._started:.0f} s"
