"""Claims as questions to a transition system: whether some run comes to a moment, which stays, or is cut off.

A formula of CTL is a condition of such questions, each about one run, or about the way from everywhere to a goal.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import assert_never

from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import Literal
from exover.loop.claim import Claim
from exover.loop.formula_classes import Stuck, path_of, stuck_of
from exover.model.property import Conjunction, Disjunction, Formula, Negation, SomeNext, SomeUntil, momentary


@dataclass(frozen=True, slots=True)
class Reach:
    """Some run makes this literal true."""

    bad: Literal


@dataclass(frozen=True, slots=True)
class Known:
    """It is true, or not, of the start."""

    truth: bool


@dataclass(frozen=True, slots=True)
class LassoQuestion:
    """Some run, if `fair` a fair one, satisfies a formula of LTL."""

    path: Formula
    fair: bool


@dataclass(frozen=True, slots=True)
class CutOff:
    """Some run comes to a moment from which there is no way to a goal."""

    stuck: Stuck


@dataclass(frozen=True, slots=True)
class Denied:
    """The question is answered with no."""

    part: "Question"


@dataclass(frozen=True, slots=True)
class Either:
    """One of the questions is answered with yes."""

    parts: tuple["Question", ...]


@dataclass(frozen=True, slots=True)
class Beyond:
    """None of these kinds: the engine cannot say."""


Leaf = Reach | LassoQuestion | CutOff
"""What is asked of runs."""
Question = Reach | Known | LassoQuestion | CutOff | Denied | Either | Beyond


@dataclass
class Questions:
    """Makes questions about one encoding; latches for what a run must have kept are added to its graph."""

    encoding: Encoding
    _begun: Literal | None = None
    _kept: dict[tuple[Formula, bool], Literal] = field(default_factory=dict)

    def of_claim(self, claim: Claim) -> Question:
        """Return the question that the formula of a claim is: the claim holds iff it is answered with yes."""
        if claim.formula is None:
            return Beyond()
        if claim.linear:
            return Denied(LassoQuestion(Negation(claim.formula), claim.fair))
        return self.of(claim.formula, claim.fair)

    def of(self, formula: Formula, fair: bool = False) -> Question:
        """Return the question that a formula of CTL is: true at the start iff it is answered with yes."""
        if momentary(formula):
            return Known(self.encoding.at_start(formula))
        match formula:
            case Negation(part):
                return Denied(self.of(part, fair))
            case Disjunction(parts):
                return Either(tuple(self.of(part, fair) for part in parts))
            case Conjunction(parts):
                return Denied(Either(tuple(Denied(self.of(part, fair)) for part in parts)))
            case SomeNext(SomeUntil(left, right)) if momentary(left) and momentary(right):
                return Reach(self._until(left, right, strict=True))
            case SomeNext(part) if momentary(part):
                return Reach(self.encoding.graph.conjunction(self._first, self.encoding.step_is(part)))
            case SomeUntil(left, right) if momentary(left) and momentary(right):
                if self.encoding.at_start(right):
                    return Known(True)
                return Reach(self._until(left, right, strict=False))
        stuck = stuck_of(formula)
        if stuck is not None:
            return CutOff(stuck)
        path = path_of(formula)
        return LassoQuestion(path.formula, fair) if path is not None and path.exact else Beyond()

    def _until(self, left: Formula, right: Formula, strict: bool) -> Literal:
        """Return where a step comes to `right`, `left` having been true of every moment before (of the start too,
        unless `strict`)."""
        here = self.encoding.step_is(right)
        if left == Conjunction(()):
            return here
        key = (left, strict)
        if key not in self._kept:
            start = strict or self.encoding.at_start(left)
            kept = self.encoding.graph.latch(start)
            still = self.encoding.graph.conjunction(kept, self.encoding.truth(left))
            self.encoding.follow(kept, still)
            self._kept[key] = kept
        return self.encoding.graph.conjunction(self._kept[key], here)

    @property
    def _first(self) -> Literal:
        """Where no step has been taken yet."""
        if self._begun is None:
            self._begun = self.encoding.graph.latch(False)
            graph, legal = self.encoding.graph, self.encoding.legal
            self.encoding.following[self._begun] = graph.any((self._begun, legal))
        return self._begun ^ 1


def questions_in(question: Question) -> Iterator[Leaf]:
    """Yield the questions that an answer depends on, in order."""
    match question:
        case Reach() | LassoQuestion() | CutOff():
            yield question
        case Denied(part):
            yield from questions_in(part)
        case Either(parts):
            for part in parts:
                yield from questions_in(part)
        case Known() | Beyond():
            pass
        case _:
            assert_never(question)
