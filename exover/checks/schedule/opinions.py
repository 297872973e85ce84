"""Opinions of engines as findings, and the combination of the findings of several engines."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from exover.checks.finding import Finding
from exover.checks.questions.property import VACUOUS, is_contradiction
from exover.checks.questions.question import Check, Question
from exover.loop.claim import CONTRADICTORY, NO_FORMULA, Opinion
from exover.model.trace import Disagreement

OTHERS = "; "
"""The separator of the reasons of several engines."""


def finding_of(opinion: Opinion, engine: str, check: Check, question: Question) -> Finding:
    """Return the opinion of an engine as the finding of the check that makes the claim."""
    if opinion.verdict == "unknown":
        return question.unknown(opinion.message, engine)
    said = check.holds if opinion.verdict == "holds" else check.violated
    message = OTHERS.join(filter(None, (said, opinion.message)))
    return question.answer(opinion.verdict, message, opinion.method, opinion.trace, engine)


def first(answers: Sequence[Finding]) -> Finding:
    """Return the first finding that is not `unknown`; if all are, `unknown` with the reasons of all engines."""
    for answer in answers:
        if answer.verdict != "unknown":
            return answer
    return replace(answers[0], message=OTHERS.join([answers[0].message, *_reasons(answers[0], answers[1:])]))


def together(answers: Sequence[Finding]) -> Finding:
    """Return the first finding that is not `unknown`, with all engines of its verdict, and why others have none."""
    chosen = first(answers)
    if chosen.verdict == "unknown":
        return chosen
    named = "+".join(answer.engine for answer in answers if answer.verdict == chosen.verdict)
    return replace(chosen, engine=named, message=OTHERS.join([chosen.message, *_reasons(chosen, answers)]))


def _reasons(chosen: Finding, answers: Iterable[Finding]) -> Iterator[str]:
    """Yield the reasons of `unknown` findings, except of engines that have no such formula, and repeated reasons."""
    for answer in answers:
        if answer.verdict == "unknown" and answer.message not in (NO_FORMULA, chosen.message):
            yield f"{answer.engine}: {answer.message}"


def compare(answers: Iterable[Sequence[Finding]], assumed: bool) -> None:
    """Raise `Disagreement` if for some row of findings one engine says `holds` and another `violated`.

    `assumed`: there are assumptions. Unless some engine has found that they do not contradict each other, only
    properties are compared: any other claim may be about no run at all.
    """
    rows = list(answers)
    coherent = not assumed or any(_coherent(answer) for row in rows for answer in row)
    found = [row for row in rows if (coherent or row[0].check == "property") and _contrary(row)]
    if found:
        said = ", ".join(f"{answer.engine} says {answer.verdict}" for answer in found[0])
        more = f"; and on {len(found) - 1} more" if found[1:] else ""
        raise Disagreement(f"engines disagree on {found[0][0].check} of `{found[0][0].subject}`: {said}{more}")


def _contrary(row: Sequence[Finding]) -> bool:
    return {"holds", "violated"} <= {answer.verdict for answer in row}


def _coherent(answer: Finding) -> bool:
    """Return whether a finding implies that the assumptions do not contradict each other."""
    if answer.check != "property" or answer.verdict == "unknown":
        return False
    return answer.verdict == "holds" or (answer.engine == "bdd" and not is_contradiction(answer.message))


def contradicted(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the findings; if one says that the assumptions contradict each other, all properties become violated."""
    shown = [each for each in findings if (each.check, each.verdict) == ("property", "violated")]
    for found in shown:
        _, contradictory, how = found.message.partition(CONTRADICTORY)
        if contradictory:
            told = replace(found, message=contradictory + how)
            return tuple(
                replace(told, subject=each.subject, location=each.location, seconds=each.seconds)
                if each.check == "property"
                else each
                for each in findings
            )
    return tuple(findings)


def vacuous(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the findings, with the message `VACUOUS` for properties that hold and whose premise is never true."""
    never = {each.subject for each in findings if (each.check, each.verdict) == ("vacuity", "violated")}
    return tuple(
        replace(each, message=VACUOUS)
        if each.check == "property" and each.verdict == "holds" and each.subject in never
        else each
        for each in findings
    )
