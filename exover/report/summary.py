"""The data of a report, and the verdict over all findings (docs/checks.md)."""

from collections.abc import Iterable
from typing import Literal

from exover.checks.finding import Counted, Finding
from exover.dataclass import dataclass
from exover.diagnostics import Severity
from exover.loop.claim import Verdict, worst
from exover.model.model import Model
from exover.model.property import Properties

ERRORS: frozenset[Severity] = frozenset({"error"})
"""The severities that decide the verdict by default."""


@dataclass(frozen=True, slots=True)
class ModelFigures:
    """The size of a spec: numbers of requests and of names of rules (the pairs of a mutex are one), bits of the state.

    `state_bits`: None if unknown. `states`: the number of reachable states, if it was asked for.
    """

    requests: int
    rules: int
    state_bits: int | None
    states: Counted | None = None


@dataclass(frozen=True, slots=True)
class EventFigures:
    """The worst-case bounds of an event, which is in words: tests, answers, passes of settling."""

    event: str
    tests: int
    answers: int
    passes: int


@dataclass(frozen=True, slots=True)
class BoundFigures:
    """The worst-case bounds of events, and of the stack of a call as measured for the compiler `stack_target`."""

    events: tuple[EventFigures, ...]
    method: str
    """How the bounds of events were found."""
    stack_bytes: int
    stack_target: str

    def worst(self, what: Literal["tests", "answers", "passes"]) -> tuple[int, str]:
        """Return the greatest figure of any event, and the first event with it; "none" if there is no event."""
        pairs = [(getattr(event, what), event.event) for event in self.events]
        return max(pairs, key=lambda pair: pair[0], default=(int(what == "answers"), "none"))


@dataclass(frozen=True, slots=True)
class TableFigures:
    """The size of the emitted tables: nodes, tests on the longest path, most tests before a first action, bytes.

    `bounds`: None unless they were asked for.
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
    """The findings of one spec, and what was checked; `file`: the spec's file as the user names it.

    `tables`: None if the command ended before they were made.
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
    """The properties of the spec; None if the report does not tell whether it has a properties file."""
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
    """A spec that could not be checked, its file as the user names it, and the reason."""

    version: str
    file: str
    reason: str

    @property
    def verdict(self) -> Verdict:
        """The verdict `unknown`."""
        return "unknown"


def overall(findings: Iterable[Finding], counted: frozenset[Severity] = ERRORS) -> Verdict:
    """Return the worst verdict of the findings that count."""
    return worst(finding.verdict for finding in findings if counts(finding, counted))


def counts(finding: Finding, counted: frozenset[Severity]) -> bool:
    """Return whether a finding decides the verdict: its severity does, and nothing excuses it."""
    return finding.severity in counted and finding.excuse is None
