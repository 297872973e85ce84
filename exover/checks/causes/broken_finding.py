"""A violated finding with the context of its message, and wordings that several messages share."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import islice

from exover.checks.causes.blocking import Obstacles
from exover.checks.causes.shadowing import Shadows
from exover.checks.finding import Finding, FindingKey
from exover.dataclass import dataclass
from exover.loop.claim import Verdict
from exover.model.model import Model
from exover.model.property import Assumption, Properties
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import end_of, visited

SHADOWS = 3
"""The greatest number of rules that are named as deciding before another."""


@dataclass(frozen=True)
class BrokenFinding:
    """A violated finding with the context of its message."""

    reference: Reference
    properties: Properties
    finding: Finding
    obstacles: Obstacles
    near: Shadows | None
    """Finds rules that decide first, in steps near runs; None if they are not to be looked for."""
    verdicts: Mapping[FindingKey, Verdict]
    """The verdicts of all findings."""
    unlaunched: frozenset[str]
    """Requests of which a finding says that no run launches them."""

    @property
    def model(self) -> Model:
        """The model."""
        return self.reference.model

    @cached_property
    def end(self) -> State | None:
        """The state at the end of the run, if there is one."""
        trace = self.finding.trace
        return None if trace is None else end_of(self.reference, trace.events)

    @cached_property
    def loop(self) -> Sequence[State]:
        """The states after the steps that a lasso repeats; none if the run is no lasso."""
        trace = self.finding.trace
        if trace is None or trace.loop_start is None:
            return ()
        return tuple(islice(visited(self.reference, trace.events), trace.loop_start + 1, None))


def never_launched(broken: BrokenFinding, names: Iterable[str]) -> list[str]:
    """Return for each of these requests that no run launches a part of a sentence that says so."""
    found = (name for name in dict.fromkeys(names) if name in broken.unlaunched)
    return [f"no run launches `{name}`: see reachability" for name in found]


def forbid_text(assumptions: Sequence[Assumption]) -> str:
    """Return the words that these assumptions forbid something; if there are none, that "the assumptions" do."""
    match assumptions:
        case []:
            return "the assumptions forbid"
        case [one]:
            return f"the assumption at {one.location} forbids"
        case _:
            places = " and at ".join(str(each.location) for each in assumptions)
            return f"the assumptions at {places} forbid"


def decide_text(rules: Sequence[str]) -> str:
    """Return the words that these rules decide."""
    return f"{listed(rules)} decide{'s' * (len(rules) == 1)}"


def listed(rules: Sequence[str]) -> str:
    """Return the names of up to `SHADOWS` rules, and how many more there are."""
    first, others = ", ".join(f"`{each}`" for each in rules[:SHADOWS]), len(rules) - SHADOWS
    return f"{first} and {others} more" if others > 0 else first
