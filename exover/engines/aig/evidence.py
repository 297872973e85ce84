"""The answers known to questions about runs, and the opinions on claims that follow."""

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE
from exover.engines.aig.encoding.concretize import Spurious
from exover.engines.aig.encoding.questions import (
    Beyond,
    CutOff,
    Either,
    KnownAtStart,
    LassoQuestion,
    Leaf,
    OppositeQuestion,
    Reach,
    RunQuestion,
    questions_in,
)
from exover.loop.claim import CONTRADICTION, NO_FORMULA, Claim, Opinion, Verdict
from exover.model.trace import Trace

NOT_PROVED = "it is not proved that the passes of the graph are enough"
STRANDED = "it is not known whether the assumptions let every run go on"
WITNESS, PROVED, INDUCTION = "witness", "pdr", "k-induction k=1"
WAYS, INITIAL = "weakest preconditions", "initial state"
TOLD = ("reachability", "redundancy", "property")
"""Checks whose run is part of the finding even where they hold."""


@dataclass(frozen=True, slots=True)
class Found:
    """What is known of one question: the answer, how it was found, and the run that shows it, if one does."""

    truth: bool | None
    method: str = ""
    trace: Trace | None = None
    reason: str = ""


Answered = tuple[Leaf, Found]


@dataclass
class Evidence:
    """The answers known to elementary questions, and what follows for the questions that are made of them."""

    goes_on: Callable[[bool], bool]
    """Returns whether it is proved that every run can go on for ever under the assumptions; given True, fairly."""
    some_run_is_fair: Callable[[], bool]
    """Returns whether a run from the start is known that goes on for ever, fairly, under the assumptions."""
    settled: bool | None = None
    """Whether it is proved that the passes are enough; None before that is looked into."""
    found: dict[Leaf, Found] = field(default_factory=lambda: {Reach(FALSE): Found(False, PROVED)})
    fairly: dict[Leaf, Found] = field(default_factory=dict)
    """Whether a fair run comes to a moment to which some run comes, where not every run can go on fairly."""
    stranded: Trace | None = None
    """A run to a state from which the assumptions allow no step, if one is known; looked for if `goes_on` is false."""

    def is_complete(self, question: RunQuestion) -> bool:
        """Return whether the passes, and all elementary questions that a question is made of, have been looked into."""
        return self.settled is not None and all(leaf in self.found for leaf in questions_in(question))

    def opinion(self, question: RunQuestion, claim: Claim) -> Opinion:
        """Return the opinion on a claim, from the answer to its question and whether the assumptions let runs go on."""
        answer = self.answer(question, claim.fair)
        of_all_runs = answer.truth is not None and (answer.truth or answer.method != WITNESS)
        goes_on = not (claim.coherent and of_all_runs) or self._are_coherent(claim.fair)
        if claim.coherent and self.stranded is not None:
            return Opinion("violated", WITNESS, CONTRADICTION, self.stranded)
        if answer.truth is None:
            return Opinion("unknown", "", answer.reason or NO_FORMULA)
        if answer.truth and not goes_on:
            return Opinion("unknown", "", STRANDED)
        verdict: Verdict = "holds" if answer.truth else "violated"
        told = verdict == "violated" or claim.check in TOLD
        return Opinion(verdict, answer.method, trace=answer.trace if told else None)

    def _are_coherent(self, fair: bool) -> bool:
        """Return whether it is proved that the assumptions do not contradict each other, if `fair` with fair reports.

        Then there need be but one fair run: others may come to where no run is fair.
        """
        return self.goes_on(fair) or (fair and self.goes_on(False) and self.some_run_is_fair())

    def answer(self, question: RunQuestion, fair: bool) -> Found:
        """Return the answer to a question, from those to its parts; `fair`: about fair runs alone."""
        match question:
            case Reach() | LassoQuestion() | CutOff():
                return self._certain(question, fair)
            case KnownAtStart(truth):
                return Found(truth, INITIAL, Trace(()))
            case OppositeQuestion(part):
                inner = self.answer(part, fair)
                return inner if inner.truth is None else replace(inner, truth=not inner.truth)
            case Either(parts):
                return _either([self.answer(part, fair) for part in parts])
            case Beyond():
                return Found(None)
            case _:
                assert_never(question)

    def _certain(self, leaf: Leaf, fair: bool) -> Found:
        """Return the answer to an elementary question, as far as it counts.

        A run to a moment, and a lasso, count in any case; all other answers only if the passes are proved enough. If
        `fair`, a finite run, and any answer about ways, count only if every run can go on fairly; else a moment may be
        asked of fair runs alone. That no run comes to it is true of fair runs, too.
        """
        found = self.found.get(leaf, Found(None))
        if found.truth is None:
            return found
        is_run = found.truth and not isinstance(leaf, CutOff)
        if not is_run and not self.settled:
            return Found(None, reason=NOT_PROVED)
        finite = isinstance(leaf, CutOff) or (found.truth and isinstance(leaf, Reach))
        if fair and finite and not self.goes_on(True):
            return self.fairly.get(leaf, Found(None, reason=STRANDED))
        return found


def unproved(opinion: Opinion) -> Opinion:
    """Return what is left of an opinion where it is not proved that the passes of the graph are enough."""
    sure = opinion.verdict == "unknown" or opinion.method == WITNESS
    return opinion if sure else Opinion("unknown", "", NOT_PROVED)


def shown(trace: Trace | Spurious) -> Found:
    """Return the answer that a run shows: yes if it is concrete, unknown if it is spurious."""
    return Found(None, reason=str(trace)) if isinstance(trace, Spurious) else Found(True, WITNESS, trace)


def _either(answers: Sequence[Found]) -> Found:
    """Return the disjunction of answers: the first that is yes, else unknown if one is unknown, else a proof of no."""
    for answer in answers:
        if answer.truth:
            return answer
    unknown = [answer for answer in answers if answer.truth is None]
    if unknown:
        return Found(None, reason="; ".join(dict.fromkeys(answer.reason for answer in unknown if answer.reason)))
    proved = [answer for answer in answers if answer.method != INITIAL]
    return proved[0] if proved else Found(False, INITIAL, Trace(()))
