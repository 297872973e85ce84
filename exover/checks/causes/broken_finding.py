"""A finding that is violated, with what its message can be made of, and words that several messages have."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import islice

from exover.checks.causes.blocking import Obstacles
from exover.checks.causes.shadowing import Shadows
from exover.checks.finding import Finding
from exover.dataclass import dataclass
from exover.loop.claim import Verdict
from exover.model.model import Model
from exover.model.property import Assumption, Properties
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import end_of, visited

SHADOWS = 3
"""So many rules are named that decide before another."""


@dataclass(frozen=True)
class BrokenFinding:
    """A finding that is violated, with what its message can be made of."""

    reference: Reference
    properties: Properties
    finding: Finding
    obstacles: Obstacles
    near: Shadows | None
    """Looks for what decides first in steps near runs, if it is to be looked for."""
    verdicts: Mapping[tuple[str, str], Verdict]
    """Of all findings, by check and subject."""
    unlaunched: frozenset[str]
    """Requests that no run launches, as far as that is found."""

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
        """The states after the moments that a lasso repeats; none of another run."""
        trace = self.finding.trace
        if trace is None or trace.loop_start is None:
            return ()
        return tuple(islice(visited(self.reference, trace.events), trace.loop_start + 1, None))


def never_launched(broken: BrokenFinding, names: Iterable[str]) -> list[str]:
    """Return of which requests it is known that no run launches them, as parts of a sentence."""
    found = (name for name in dict.fromkeys(names) if name in broken.unlaunched)
    return [f"no run launches `{name}`: see reachability" for name in found]


def forbid_text(assumptions: Sequence[Assumption]) -> str:
    """Return that these assumptions forbid something; if there are none, that the assumptions do."""
    match assumptions:
        case []:
            return "the assumptions forbid"
        case [one]:
            return f"the assumption at {one.location} forbids"
        case _:
            places = " and at ".join(str(each.location) for each in assumptions)
            return f"the assumptions at {places} forbid"


def decide_text(rules: Sequence[str]) -> str:
    """Return that these rules decide."""
    return f"{listed(rules)} decide{'s' * (len(rules) == 1)}"


def listed(rules: Sequence[str]) -> str:
    first, others = ", ".join(f"`{each}`" for each in rules[:SHADOWS]), len(rules) - SHADOWS
    return f"{first} and {others} more" if others > 0 else first
