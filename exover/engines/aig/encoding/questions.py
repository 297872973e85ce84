"""Claims as questions about runs: does one reach a bad state, is one a lasso of a formula, is one cut off from a goal?

A formula of CTL is a Boolean combination of such elementary questions.
"""

from collections.abc import Iterator
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.loop.claim import Claim
from exover.loop.formula_classes import (
    AtStart,
    ExistsUntil,
    Joined,
    Opposite,
    Path,
    QuestionClass,
    Stuck,
    Unclassed,
    question_of,
)
from exover.model.property import FALSE, TRUE, Formula, Negation


@dataclass(frozen=True, slots=True)
class Reach:
    """Some run makes this literal true."""

    bad: Literal


@dataclass(frozen=True, slots=True)
class KnownAtStart:
    """The answer is known: it depends on the start alone."""

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
class OppositeQuestion:
    """The negation of a question."""

    part: "RunQuestion"


@dataclass(frozen=True, slots=True)
class Either:
    """The disjunction of questions."""

    parts: tuple["RunQuestion", ...]


@dataclass(frozen=True, slots=True)
class Beyond:
    """A question of none of these kinds, which the engine cannot answer."""


Leaf = Reach | LassoQuestion | CutOff
"""The elementary questions about runs."""
RunQuestion = Reach | KnownAtStart | LassoQuestion | CutOff | OppositeQuestion | Either | Beyond


@dataclass
class Questions:
    """Makes questions about one encoding; latches for what a run must have kept are added to its graph.

    `shown`: by question whether some run comes to a moment, what that run shows.
    """

    encoding: Encoding
    shown: dict[Reach, ExistsUntil] = field(default_factory=dict)
    _begun: Literal | None = None
    _kept: dict[tuple[Formula, bool], Literal] = field(default_factory=dict)

    def of_claim(self, claim: Claim) -> RunQuestion:
        """Return the question of a claim: the claim holds iff its answer is yes."""
        if claim.formula is None:
            return Beyond()
        if claim.linear:
            return OppositeQuestion(LassoQuestion(Negation(claim.formula), claim.fair))
        return self.of(claim.formula, claim.fair)

    def of(self, formula: Formula, fair: bool = False) -> RunQuestion:
        """Return the question of a formula of CTL: the formula is true at the start iff its answer is yes."""
        return self._of(question_of(formula), fair)

    def _of(self, question: QuestionClass, fair: bool) -> RunQuestion:
        match question:
            case AtStart(formula):
                return KnownAtStart(self.encoding.moments.at_start(formula))
            case Opposite(part):
                return OppositeQuestion(self._of(part, fair))
            case Joined(parts, every):
                asked = tuple(self._of(part, fair) for part in parts)
                return OppositeQuestion(Either(tuple(map(OppositeQuestion, asked)))) if every else Either(asked)
            case ExistsUntil():
                return self._reach(question)
            case Stuck():
                return CutOff(question)
            case Path(formula, exact):
                return LassoQuestion(formula, fair) if exact else Beyond()
            case Unclassed():
                return Beyond()
            case _:
                assert_never(question)

    def _reach(self, way: ExistsUntil) -> RunQuestion:
        if not way.strict and self.encoding.moments.at_start(way.goal):
            return KnownAtStart(True)
        if way.strict and way.allowed == FALSE:
            bad = self.encoding.graph.conjunction(self._first, self.encoding.step_is(way.goal))
        else:
            bad = self._until(way.allowed, way.goal, way.strict)
        self.shown.setdefault(Reach(bad), way)
        return Reach(bad)

    def _until(self, left: Formula, right: Formula, strict: bool) -> Literal:
        """Return where a step comes to `right`, `left` having been true of every moment before (of the start too,
        unless `strict`)."""
        here = self.encoding.step_is(right)
        if left == TRUE:
            return here
        key = (left, strict)
        if key not in self._kept:
            start = strict or self.encoding.moments.at_start(left)
            kept = self.encoding.graph.latch(start)
            still = self.encoding.graph.conjunction(kept, self.encoding.moments.truth(left))
            self.encoding.follow(kept, still)
            self._kept[key] = kept
        return self.encoding.graph.conjunction(self._kept[key], here)

    @property
    def _first(self) -> Literal:
        """A literal over the state: no step has been taken yet."""
        if self._begun is None:
            self._begun = self.encoding.graph.latch(False)
            graph, legal = self.encoding.graph, self.encoding.legal
            self.encoding.following[self._begun] = graph.any((self._begun, legal))
        return self._begun ^ 1


def questions_in(question: RunQuestion) -> Iterator[Leaf]:
    """Yield the elementary questions that a question is made of, in order."""
    match question:
        case Reach() | LassoQuestion() | CutOff():
            yield question
        case OppositeQuestion(part):
            yield from questions_in(part)
        case Either(parts):
            for part in parts:
                yield from questions_in(part)
        case KnownAtStart() | Beyond():
            pass
        case _:
            assert_never(question)
