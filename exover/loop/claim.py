"""Claims: what a finding says of the closed loop, as a formula that all engines judge."""

from collections.abc import Callable, Iterable
from typing import Literal, Protocol

from exover.dataclass import dataclass
from exover.model.property import (
    TRUE,
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    SomeAlways,
    SomeNext,
    SomeUntil,
    all_always,
    implies,
    parts_of,
)
from exover.model.trace import Trace

Progress = Callable[[str], None]
"""Receives a text that says what is being done."""
Verdict = Literal["holds", "violated", "unknown"]
VERDICTS: tuple[Verdict, ...] = ("violated", "unknown", "holds")
"""The verdicts, the worst first."""
NO_FORMULA = "what it asks is not said by a formula about runs"
"""The reason of `unknown` of an engine that can only judge formulas."""
CONTRADICTORY = "the assumptions contradict each other"
"""Why a claim with `coherent` is violated, whatever its formula."""
CONTRADICTION = f"{CONTRADICTORY}: from here on they forbid every step"
"""The same, for a run that leads to a moment without an allowed step."""
UNFAIR = f"{CONTRADICTORY}: on no run that they leave are reports fair"
"""The same, where the start already lies on no fair run."""
APPROXIMATE = "it rests on runs through compared reals, which may have no concrete one"
"""The reason of `unknown` where a loop that may have too many runs does not decide a claim (`believed`)."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim: the check holds for the subject iff the formula is true at the start.

    It is a formula of CTL or, if `linear`, of LTL. Paths are infinite and made of steps that the assumptions allow; if
    `fair`, only those with fair reports count. `coherent`: the claim also says that the assumptions do not contradict
    each other; if they do, a claim without it is about no run. None: the check is not about the runs of one loop.
    """

    check: str
    subject: str
    formula: Formula | None
    linear: bool = False
    fair: bool = False
    coherent: bool = False


@dataclass(frozen=True, slots=True)
class Opinion:
    """The answer of an engine to a claim.

    `method`: how a `holds` or `violated` was found; `message`: why it is `unknown`, or what else a reader should know.
    `trace`: a run of the reference interpreter that shows it, if a run can and the engine has found one.
    """

    verdict: Verdict
    method: str
    message: str = ""
    trace: Trace | None = None


SayOpinion = Callable[[int, Opinion], None]
"""Receives the index of a claim and the opinion of an engine."""


class Judge(Protocol):
    """An engine for claims about one closed loop.

    A claim that it cannot express, or gives up, is `unknown` with the reason. It raises only for faults of exover. It
    may be killed at any time, and all processes that it has started end with it (`exover.engines.process`).
    """

    @property
    def name(self) -> str:
        """The engine, as findings name it."""
        ...

    def judge(self, claim: Claim) -> Opinion:
        """Return the opinion whether the claim is true of the runs that the assumptions allow."""
        ...


def after_every_step(formula: Formula) -> Formula:
    """Return `AX AG formula`: it is true in the moment after each reachable step."""
    return Negation(SomeNext(SomeUntil(TRUE, Negation(formula))))


def always_possible(since: Formula, goal: Formula, allowed: Formula) -> Formula:
    """Return AG (since -> EX E [allowed U (allowed and goal)]): `allowed` steps can lead from there to a goal."""
    reaching = Conjunction((allowed, goal))
    return all_always(implies(since, SomeNext(SomeUntil(allowed, reaching))))


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; `holds` if there is none."""
    return min(verdicts, key=VERDICTS.index, default="holds")


def believed(claim: Claim, verdict: Verdict, shown: bool) -> bool:
    """Return whether a loop that may have too many runs decides a claim; `shown`: a concrete run shows the verdict.

    What is true of all its runs is true of all runs. That there is a run has to be shown.
    """
    if claim.formula is None:
        return shown or verdict == "violated" or claim.check == "tables"
    if verdict == "holds" and claim.coherent:
        return False
    said = claim.formula if verdict == "holds" else Negation(claim.formula)
    return not existential(said) or (shown and _shown_by_one(said))


def _shown_by_one(formula: Formula, positive: bool = True) -> bool:
    """Return whether one run shows all runs that a formula (or, unless `positive`, its negation) says there are."""
    if not existential(formula, positive):
        return True
    match formula:
        case Negation(part):
            return _shown_by_one(part, not positive)
        case SomeNext(part):
            return positive and _shown_by_one(part)
        case SomeUntil(left, right):
            return positive and not existential(left) and _shown_by_one(right)
        case SomeAlways(part):
            return positive and not existential(part)
        case Conjunction(parts) | Disjunction(parts):
            both = positive is isinstance(formula, Conjunction)
            several = both and sum(existential(part, positive) for part in parts) > 1
            return not several and all(_shown_by_one(part, positive) for part in parts)
        case _:
            return False


def existential(formula: Formula, positive: bool = True) -> bool:
    """Return whether a formula of CTL (or, unless `positive`, its negation) says anywhere that there is a run.

    Of any other formula, as those of ACTL, one run shows that it is false.
    """
    match formula:
        case Negation(part):
            return existential(part, not positive)
        case SomeNext() | SomeUntil() | SomeAlways() if positive:
            return True
        case _:
            return any(existential(part, positive) for part in parts_of(formula))
