"""The differences between two versions of a spec as text, and in words that other formats share (docs/diff.md)."""

from collections.abc import Iterator

from exover.escaping import visible_lines
from exover.model.difference import AnswerChange, CommonStep, Compared, Difference, PropertyChange
from exover.model.event import Waits
from exover.model.wording import action_text, counted, event_text

WEAKER = "OLD refuses it or lets it wait"
PERHAPS_SHORTER = "it is not proved that no shorter run shows it"


def render(compared: Compared) -> str:
    """Return the differences as text with a final newline."""
    return visible_lines(_lines(compared))


def _lines(compared: Compared) -> Iterator[str]:
    old, new = compared.files
    yield f"OLD: {old}"
    yield f"NEW: {new}"
    yield from (f"note: {note}" for note in compared.notes)
    yield ""
    for each in compared.differences:
        yield title(each)
        yield from (f"  {line}" for line in run_lines(compared, each))
    for prop in in_both(compared):
        yield property_title(prop)
    for reason, unknown in unknown_by_reason(compared).items():
        yield f"unknown, {reason}:"
        yield from (f"  {change_text(change)}" for change in unknown)
    if compared.differences or in_both(compared) or compared.undecided:
        yield ""
    yield last_line(compared)


def title(difference: Difference) -> str:
    """Return a change in words, with the length of the run that shows it."""
    length = counted(len(difference.steps), "step")
    return f"{change_text(difference.change)} ({length}{'' if difference.shortest else f'; {PERHAPS_SHORTER}'})"


def change_text(change: AnswerChange) -> str:
    """Return a change in words."""
    return f"{change.subject} {change.word}{f', where {WEAKER}' if change.weaker else ''}"


def unknown_by_reason(compared: Compared) -> dict[str, list[AnswerChange]]:
    """Return by reason the changes that are undecided."""
    found: dict[str, list[AnswerChange]] = {}
    for each in compared.undecided:
        found.setdefault(each.reason, []).append(each.change)
    return found


def property_title(change: PropertyChange) -> str:
    """Return the verdicts on a property in words."""
    return f"property {change.name}: {change.old} in OLD, {change.new} in NEW"


def in_both(compared: Compared) -> list[PropertyChange]:
    """Return the changes of properties that both versions have."""
    return [each for each in compared.judged if "none" not in (each.old, each.new)]


def run_lines(compared: Compared, difference: Difference) -> Iterator[str]:
    """Yield a numbered line for each event, and indented below it the answers, of both versions if they differ."""
    steps = difference.steps
    width = len(str(len(steps)))
    for number, step in enumerate(steps, 1):
        yield f"{number:>{width}}. {_event(compared, step)}"
        old, new = (_answers(compared, step, side) for side in (0, 1))
        if number == len(steps):
            (old if difference.change.gone else new).extend(_standing(compared, step, difference.change))
        if old == new:
            yield from (f"{'':{width}}    {line}" for line in new)
        else:
            yield from (f"{'':{width}}    OLD: {line}" for line in old or ["no answer"])
            yield from (f"{'':{width}}    NEW: {line}" for line in new or ["no answer"])


def _event(compared: Compared, step: CommonStep) -> str:
    old, new = step.events
    if new is not None:
        return event_text(compared.versions.new, new) + ("" if old is not None else ", of which OLD knows nothing")
    assert old is not None, "something comes to one of them"
    return f"{event_text(compared.versions.old, old)}, of which NEW knows nothing"


def _answers(compared: Compared, step: CommonStep, side: int) -> list[str]:
    model = compared.versions.models[side]
    return [action_text(model, action) for action in step.answers[side]]


def _standing(compared: Compared, step: CommonStep, change: AnswerChange) -> list[str]:
    """Return a line that the request goes on waiting, if that is the change and no answer tells it; else nothing."""
    names = {change.subject, compared.versions.was_called.get(change.subject)}
    told = any(isinstance(each, Waits) and each.request in names for each in step.answers[not change.gone])
    return [] if told or change.deed != "waiting" else [f"{change.subject} goes on waiting"]


def last_line(compared: Compared) -> str:
    """Return the verdict with counts, in one line."""
    match compared.verdict:
        case "same":
            within = " within what is compared" if compared.left_out else ""
            return f"no change of behaviour{within}: proved for every run"
        case "unknown":
            open_ = len(compared.undecided) + sum(each.unknown for each in compared.judged)
            return f"unknown: {counted(open_, 'question has', 'questions have')} no answer, and no change is known"
        case _:
            parts = [counted(len(compared.differences), "change of answers", "changes of answers")]
            decided = sum(each.decided for each in compared.judged)
            parts += [counted(decided, "property", "properties")] if decided else []
            parts += [f"{len(compared.undecided)} unknown"] if compared.undecided else []
            return f"changed: {', '.join(parts)}; {_weaker(compared)}"


def _weaker(compared: Compared) -> str:
    within = ", within what is compared" if compared.left_out else ""
    return {
        True: "NEW launches what OLD refuses or lets wait",
        False: f"NEW launches nothing that OLD refuses or lets wait{within}",
        None: "whether NEW launches what OLD refuses or lets wait is not known",
    }[compared.weaker]
