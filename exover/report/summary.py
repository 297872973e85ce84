"""Everything that a report tells, and the verdict over all findings (docs/checks.md)."""

from collections.abc import Iterable
from typing import Literal

from exover.checks.finding import Counted, Finding
from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.loop.claim import Verdict
from exover.model.model import Model
from exover.model.property import Properties

ERRORS: frozenset[Severity] = frozenset({"error"})
"""The severities that decide the verdict, unless more are asked for."""


@dataclass(frozen=True, slots=True)
class ModelFigures:
    """How large a spec is: requests, rules by name (the pairs of a mutex are one), bits of the checker's state.

    `state_bits`: None if that is not known. `states`: how many of these are reachable, if that was asked for.
    """

    requests: int
    rules: int
    state_bits: int | None
    states: Counted | None = None


@dataclass(frozen=True, slots=True)
class EventFigures:
    """What an event, in words, costs at most: tests, answers, passes of settling."""

    event: str
    tests: int
    answers: int
    passes: int


@dataclass(frozen=True, slots=True)
class BoundFigures:
    """What no event and no call exceeds; `stack_target` is the compiler for which the bytes of stack are known."""

    events: tuple[EventFigures, ...]
    method: str
    """How those of events were found."""
    stack_bytes: int
    stack_target: str

    def worst(self, what: Literal["tests", "answers", "passes"]) -> tuple[int, str]:
        """Return the greatest figure of any event, and the first event that has it; an event has an answer at least."""
        pairs = [(getattr(event, what), event.event) for event in self.events]
        return max(pairs, key=lambda pair: pair[0], default=(int(what == "answers"), "none"))


@dataclass(frozen=True, slots=True)
class TableFigures:
    """How large the emitted tables are: nodes, tests on the longest path, tests before a first action, bytes.

    `bounds` are there if they were asked for.
    """

    nodes: int
    depth: int
    tests: int
    bytes: int
    ram_bytes: int
    sha256: str
    bounds: BoundFigures | None = None


@dataclass(frozen=True, slots=True)
class Summary:
    """The findings of one spec, and what was checked; `file` is the name under which the user knows it.

    `tables` are there unless the command ended before they were made.
    """

    version: str
    file: str
    model: Model
    findings: tuple[Finding, ...]
    figures: ModelFigures
    tables: TableFigures | None
    counted: frozenset[Severity] = ERRORS
    """The severities that decide the verdict."""
    properties: Properties | None = None
    """What the properties file says, if it is told whether there is one."""
    skipped: tuple[str, ...] = ()
    """The checks that were not asked."""

    @property
    def verdict(self) -> Verdict:
        """The verdict over all findings that count."""
        return overall(self.findings, self.counted)

    def counts(self, finding: Finding) -> bool:
        """Return whether a finding decides the verdict."""
        return counts(finding, self.counted)


@dataclass(frozen=True, slots=True)
class Unchecked:
    """A spec that could not be checked, by the name under which the user knows it, and why."""

    version: str
    file: str
    reason: str

    @property
    def verdict(self) -> Verdict:
        """Nothing is known of it."""
        return "unknown"


def overall(findings: Iterable[Finding], counted: frozenset[Severity] = ERRORS) -> Verdict:
    """Return violated iff a finding that counts is; else unknown iff one is; else holds."""
    verdicts = {finding.verdict for finding in findings if counts(finding, counted)}
    if "violated" in verdicts:
        return "violated"
    return "unknown" if "unknown" in verdicts else "holds"


def counts(finding: Finding, counted: frozenset[Severity]) -> bool:
    """Return whether a finding decides the verdict: its severity does, and nothing excuses it."""
    return finding.severity in counted and finding.excuse is None
