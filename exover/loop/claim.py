"""What a finding says of the closed loop, as a formula: one for all engines."""

from collections.abc import Callable
from typing import Literal, Protocol

from exover.dataclass import dataclass
from exover.model.property import (
    TRUE,
    Conjunction,
    Formula,
    Negation,
    SomeNext,
    SomeUntil,
    all_always,
    implies,
)
from exover.model.trace import Trace

Progress = Callable[[str], None]
"""Is told what is being looked at."""
Verdict = Literal["holds", "violated", "unknown"]
NO_FORMULA = "what it asks is not said by a formula about runs"
"""Why an engine has no answer that knows formulas alone."""
CONTRADICTORY = "the assumptions contradict each other"
"""Why a claim about them is violated whatever else it says."""
CONTRADICTION = f"{CONTRADICTORY}: from here on they forbid every step"
"""The same, of a run that leads there."""


@dataclass(frozen=True, slots=True)
class Claim:
    """What holds iff the check holds for the subject: the formula is true at the start.

    It is of CTL, or if `linear` of LTL. Paths are infinite, made of the steps that the assumptions allow, and if `fair`
    those of fair reports. `coherent`: and the assumptions do not contradict each other; where they do, a claim without
    that is about nothing. No formula: what the check asks cannot be said of the moments of the loop's runs.
    """

    check: str
    subject: str
    formula: Formula | None
    linear: bool = False
    fair: bool = False
    coherent: bool = False


@dataclass(frozen=True, slots=True)
class Opinion:
    """What an engine says of a claim.

    `method` says how a `holds` or `violated` was found, `message` why it is `unknown`, and what else a reader should
    know. `trace`: the run of the reference interpreter that shows it, if a run can and the engine has found one.
    """

    verdict: Verdict
    method: str
    message: str = ""
    trace: Trace | None = None


SayOpinion = Callable[[int, Opinion], None]
"""Takes the index of a claim, and what an engine says of it."""


class Judge(Protocol):
    """An engine for claims about one closed loop.

    What it cannot express, and what it gives up, is `unknown` with the reason. It raises nothing but for faults of
    exover's own. It may be killed at any moment, and whatever processes it has started end with it
    (`exover.engines.process`).
    """

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        ...

    def judge(self, claim: Claim) -> Opinion:
        """Return whether the claim is true of every run that the assumptions leave."""
        ...


def after_every_step(formula: Formula) -> Formula:
    """Return `AX AG formula`: it is true in the moment after each reachable step."""
    return Negation(SomeNext(SomeUntil(TRUE, Negation(formula))))


def always_possible(since: Formula, goal: Formula, allowed: Formula) -> Formula:
    """Return AG (since -> EX E [allowed U (allowed and goal)]): `allowed` steps can lead from there to a goal."""
    reaching = Conjunction((allowed, goal))
    return all_always(implies(since, SomeNext(SomeUntil(allowed, reaching))))
