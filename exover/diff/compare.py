"""The changes of answers between two versions, each shown by a run that both reference interpreters replay."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress

from exover.checks.finding import Finding
from exover.diff.deeds import changes_of, done
from exover.engines.aig.circuit.answer import Open
from exover.engines.aig.comparison import CommonRun, compare
from exover.engines.aig.encoding.pair_concretize import Both
from exover.engines.aig.encoding.versions import ComparedLoops
from exover.limits import NO_LIMITS, Limits
from exover.loop.plain_runs import PlainRuns, plain_pair
from exover.model.difference import AnswerChange, CommonStep, Difference, PropertyChange, Undecided
from exover.model.event import Action
from exover.model.semantics import Reference
from exover.model.trace import Disagreement
from exover.model.versions import Versions


def differences(
    loops: ComparedLoops,
    abc: str,
    progress: Callable[[str], None],
    limits: Limits = NO_LIMITS,
) -> tuple[tuple[Difference, ...], tuple[Undecided, ...]]:
    """Return the changes that some run shows, each with such a run, and the changes that are undecided.

    `abc`: the program of Berkeley ABC, empty if it is not to be used. Raises `Disagreement` if the reference
    interpreters do not answer a run as the engine says. When the time is over what is known is returned, and such a run
    counts as undecided: it was not proved yet that the circuit has enough passes.
    """
    shown, undecided = [], []
    versions = loops.versions
    sides = PlainRuns(versions.old, loops.properties[0]), PlainRuns(versions.new, loops.properties[1])
    answers = compare(loops, abc, progress, limits)
    late = any(isinstance(found, Open) and found.reason == limits.reason for found in answers.values())
    for change, found in answers.items():
        match found:
            case CommonRun(events, shortest):
                try:
                    shown.append(Difference(change, _plainly(versions, sides, change, events), shortest))
                except Disagreement:
                    if not late:
                        raise
                    undecided.append(Undecided(change, limits.reason))
            case Open(reason):
                undecided.append(Undecided(change, reason))
            case None:
                pass
    return tuple(shown), tuple(undecided)


def _plainly(
    versions: Versions, sides: tuple[PlainRuns, PlainRuns], change: AnswerChange, events: Sequence[Both]
) -> tuple[CommonStep, ...]:
    """Return a run as both versions answer it, with plain numbers in place of others if it still shows the change."""
    given = replayed(versions, change, events)
    with suppress(Disagreement):
        return replayed(versions, change, [plain_pair(sides, both) for both in events])
    return given


def replayed(versions: Versions, change: AnswerChange, events: Iterable[Both]) -> tuple[CommonStep, ...]:
    """Return a run as both versions answer it; raises `Disagreement` unless its last step is the first in which they
    differ, and differs by `change`."""
    references = Reference(versions.old), Reference(versions.new)
    states = [reference.start() for reference in references]
    steps: list[CommonStep] = []
    seen: set[AnswerChange] = set()
    for both in events:
        if seen:
            raise Disagreement(f"a run that shows {change.subject} {change.word} differs before its last step")
        old, new = (
            done(reference, state, event) for reference, state, event in zip(references, states, both, strict=True)
        )
        seen = set(changes_of(versions, old, new))
        answers: list[tuple[Action, ...]] = []
        for side, event in enumerate(both):
            actions: tuple[Action, ...] = ()
            if event is not None:
                states[side], actions = references[side].step(states[side], event)
            answers.append(actions)
        steps.append(CommonStep(both, (answers[0], answers[1])))
    if change not in seen:
        raise Disagreement(f"the reference interpreters do not answer a run as {change.subject} {change.word}")
    return tuple(steps)


def judged(old: Iterable[Finding], new: Iterable[Finding]) -> tuple[PropertyChange, ...]:
    """Return the properties whose verdicts differ, or of which one is unknown; `none` if a version lacks it."""
    mine, its = ({each.subject: each for each in found} for found in (old, new))
    found = []
    for name in dict.fromkeys((*its, *mine)):
        verdicts = [each[name].verdict if name in each else "none" for each in (mine, its)]
        location = (its.get(name) or mine[name]).location
        if verdicts[0] != verdicts[1] or "unknown" in verdicts:
            found.append(PropertyChange(name, verdicts[0], verdicts[1], location))
    return tuple(found)
