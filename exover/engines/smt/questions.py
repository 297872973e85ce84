"""The decomposition of a claim into questions that a solver answers separately."""

from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.loop.claim import NO_FORMULA, Claim
from exover.loop.formula_classes import (
    AtStart,
    ExistsUntil,
    Joined,
    Lingering,
    Opposite,
    Path,
    QuestionClass,
    Stuck,
    Unclassed,
    lingering_of,
    question_of,
)
from exover.model.property import TRUE, Formula, Negation


@dataclass(frozen=True, slots=True)
class Goal:
    """Some run (`wanted`), or none, reaches a moment with the formula after `least` steps or more; -1: at the start."""

    formula: Formula
    least: int
    wanted: bool


@dataclass(frozen=True, slots=True)
class StuckQuestion:
    """Some run (`wanted`), or none, reaches a moment from which there is no way."""

    stuck: Stuck
    wanted: bool


@dataclass(frozen=True, slots=True)
class Course:
    """A formula of LTL is true of some run (`wanted`) or of none; if `fair`, of fair runs.

    `exact`: that it is true of no run decides the claim, too. `lingering`: the formula as F (since and G stays), if it
    is of that form.
    """

    formula: Formula
    fair: bool
    wanted: bool
    exact: bool
    lingering: Lingering | None


Asked = Goal | StuckQuestion | Course


@dataclass(frozen=True, slots=True)
class ClaimQuestions:
    """The claim holds iff `every` part, or else at least one part, is as `wanted`."""

    parts: tuple[Asked, ...]
    every: bool = True


def questions(claim: Claim) -> ClaimQuestions | str:
    """Return the questions of a claim, or why there are none."""
    if claim.formula is None:
        return NO_FORMULA
    if claim.linear:
        refuting = Negation(claim.formula)
        return ClaimQuestions((Course(refuting, claim.fair, False, True, lingering_of(refuting)),))
    found = _asked(question_of(claim.formula), True, claim.fair)
    return found or "no single run shows it or its opposite, and it does not ask for ways from everywhere"


def _asked(question: QuestionClass, wanted: bool, fair: bool) -> ClaimQuestions | None:
    """Return the questions that decide whether a formula of this class is true or, if not `wanted`, false."""
    match question:
        case AtStart(formula):
            return ClaimQuestions((Goal(formula, -1, wanted),))
        case Opposite(part):
            return _asked(part, not wanted, fair)
        case Joined(parts, every):
            return _joined(parts, every == wanted, wanted, fair)
        case Stuck():
            return ClaimQuestions((StuckQuestion(question, wanted),))
        case ExistsUntil():
            return ClaimQuestions((_goal(question, wanted) or _course(question.path, fair, wanted, True),))
        case Path(formula, exact):
            return ClaimQuestions((_course(formula, fair, wanted, exact),))
        case Unclassed():
            return None
        case _:
            assert_never(question)


def _joined(parts: tuple[QuestionClass, ...], every: bool, wanted: bool, fair: bool) -> ClaimQuestions | None:
    found = [_asked(part, wanted, fair) for part in parts]
    kept = [each for each in found if each is not None]
    if len(kept) < len(found) or any(len(each.parts) > 1 and each.every != every for each in kept):
        return None
    return ClaimQuestions(tuple(asked for each in kept for asked in each.parts), every)


def _goal(way: ExistsUntil, wanted: bool) -> Goal | None:
    """Return E [true U goal] as a reachability question; None if the way restricts the steps before the goal."""
    return Goal(way.goal, int(way.strict), wanted) if way.allowed == TRUE else None


def _course(path: Formula, fair: bool, wanted: bool, exact: bool) -> Course:
    return Course(path, fair, wanted, exact, lingering_of(path))


Answer = Literal["sat", "unsat"]


def meaning(asked: Asked, answer: Answer, which: str, alone: bool, every: bool) -> str:
    """Return, in words, what the answer to one question says of the claim.

    `which`: the name of the part of the claim, if the question is not `alone`.
    """
    good = (answer == "sat") == asked.wanted
    if alone or good != every:
        return "it holds" if good else "it is violated"
    return f"{which} {'holds' if good else 'does not hold'}"
