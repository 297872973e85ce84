"""What a finding says of the closed loop, as formulas: the same for every engine, and for who wants another opinion."""

from dataclasses import dataclass

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


def after_every_step(formula: Formula) -> Formula:
    """Return `AX AG formula`: it is true in the moment after each reachable step."""
    return Negation(SomeNext(SomeUntil(TRUE, Negation(formula))))


def always_possible(since: Formula, goal: Formula, allowed: Formula) -> Formula:
    """Return AG (since -> EX E [allowed U (allowed and goal)]): `allowed` steps can lead from there to a goal."""
    reaching = Conjunction((allowed, goal))
    return all_always(implies(since, SomeNext(SomeUntil(allowed, reaching))))
