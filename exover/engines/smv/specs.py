"""Claims as specifications of SMV."""

from collections.abc import Callable
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.claim import Claim
from exover.model.property import (
    TRUE,
    Atom,
    Broken,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    Properties,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    momentary,
    parts_of,
    until_of,
)

WriteMomentary = Callable[[Formula], str]
"""Writes a formula of one moment."""


@dataclass(frozen=True, slots=True)
class Specification:
    """A named specification: its kind (INVARSPEC, CTLSPEC or LTLSPEC), its text, and the claim that it states."""

    name: str
    kind: str
    body: str
    claim: Claim | None = None
    opposite: bool = False
    """Whether it states the negation of what its name says."""


def invariant(formula: Formula) -> tuple[Formula, bool] | None:
    """Return p, and whether the start counts, iff the formula is `AG p` or `AX AG p` and p is about one moment."""
    match formula:
        case Negation(SomeUntil(left, Negation(part))) if left == TRUE and momentary(part):
            return part, True
        case Negation(SomeNext(SomeUntil(left, Negation(part)))) if left == TRUE and momentary(part):
            return part, False
        case _:
            return None


def is_of(claim: Claim, properties: Properties, fair: bool) -> bool:
    """Return whether a claim belongs to the text of fair runs (`fair`), or to the other one.

    Without assumptions every finite run has a fair continuation, so fairness matters only for claims about infinite
    runs.
    """
    endless = claim.linear or (claim.formula is not None and _is_about_endless_runs(claim.formula))
    return (claim.fair and (bool(properties.assumptions) or endless)) == fair


def _is_about_endless_runs(formula: Formula) -> bool:
    return isinstance(formula, SomeAlways) or any(map(_is_about_endless_runs, parts_of(formula)))


@dataclass(frozen=True)
class Writer:
    """Writes formulas of CTL and LTL in the syntax of SMV, with parentheses where needed.

    `moment` writes formulas of one moment. `live`: the condition of moments on allowed runs, empty if all are.
    """

    moment: WriteMomentary
    live: str = ""

    def write(self, formula: Formula) -> str:
        """Return a formula."""
        if momentary(formula):
            return self.moment(formula)
        match formula:
            case Negation(SomeNext(Negation(part))):
                return f"AX {self._if_live(part)}"
            case Negation(SomeUntil(left, Negation(part))) if left == TRUE:
                return f"AG {self._if_live(part)}"
            case Negation(SomeAlways(Negation(part))):
                return f"AF {self._if_live(part)}"
            case Negation(Until(left, Negation(part))) if left == TRUE:
                return f"G {self.write(part)}"
            case Negation(SomeUntil() | Until() as part):
                return f"!({self.write(part)})"
            case Negation(part):
                return f"!{self.write(part)}"
            case Conjunction(parts):
                until = until_of(formula)
                if until is not None:  # of which NuSMV shows runs, as it does not of a conjunction
                    return f"A [{self.write(until[0])} U {self._if_live(until[1])}]"
                return f"({' & '.join(self.write(part) for part in parts)})"
            case Disjunction((Negation(left), right)):
                return f"({self.write(left)} -> {self.write(right)})"
            case Disjunction(parts):
                return f"({' | '.join(self.write(part) for part in parts)})"
            case SomeNext(part):
                return f"EX {self._and_live(part)}"
            case SomeUntil(left, right) if left == TRUE:
                return f"EF {self._and_live(right)}"
            case SomeUntil(left, right):
                return f"E [{self.write(left)} U {self._and_live(right)}]"
            case SomeAlways(part):
                return f"EG {self._and_live(part)}"
            case Next(part):
                return f"X {self.write(part)}"
            case Until(left, right) if left == TRUE:
                return f"F {self.write(right)}"
            case Until(left, right):
                return f"({self.write(left)} U {self.write(right)})"
            case Atom() | Happened() | Passed() | Broken():
                return self.moment(formula)
            case _:
                assert_never(formula)

    def _and_live(self, part: Formula) -> str:
        """Return `live & part`: the moment is on a run that the assumptions allow."""
        return f"({self.live} & {self.write(part)})" if self.live else self.write(part)

    def _if_live(self, part: Formula) -> str:
        return f"({self.live} -> {self.write(part)})" if self.live else self.write(part)
