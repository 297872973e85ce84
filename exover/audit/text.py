"""Renders an audit as text."""

import math
from collections.abc import Iterator
from datetime import UTC, datetime

from exover.audit.result import Audit, MissionResult, rules_of
from exover.audit.trail import ANSWERS, DIVERGENCES, AuditRow, MissionFigures
from exover.escaping import visible_lines
from exover.model.model import Model
from exover.model.wording import counted, slot_text

SHOWN = 10
"""The most divergences of a mission that are listed."""
SAYS = {
    "launched": "the robot launched {subject}, and the tables {answer}",
    "ran": "{subject} has ended, and the tables had not launched it{answer}",
    "kept": "the tables stop {subject}, and the robot did not",
    "withheld": "the tables launch {subject}, and the robot did not",
    "stopped": "the robot stopped {subject}, and the tables do not",
    "otherwise": "{subject}: the robot answered otherwise, and the tables {answer}",
}
ANSWERED = {"wait": "let it wait", "reject": "reject it", "invalid": "take it for invalid", "none": "", "launch": ""}


def render(audit: Audit) -> str:
    """Return an audit as lines with a final newline."""
    lines = [line for mission in audit.missions for line in _mission(audit.model, mission)]
    total = audit.total
    rules = _rules(audit.model, total) if audit.audited else ()
    return visible_lines((*lines, *_asks(total), *rules, last_line(audit)))


def last_line(audit: Audit) -> str:
    """Return the summary of all missions."""
    total = audit.total
    if not audit.audited:
        verdict = "nothing is known"
    elif not total.diverged:
        verdict = "nothing diverges"
    else:
        kinds = [f"{total.diverged[kind]} {kind}" for kind in DIVERGENCES if total.diverged[kind]]
        verdict = (
            f"{len(audit.diverging)} of them diverge{'s' if len(audit.diverging) == 1 else ''}: {', '.join(kinds)}"
        )
    missions, events = counted(len(audit.missions), "mission"), counted(total.events, "event")
    return "; ".join((f"{audit.model.name}: {missions}, {events}", verdict, *_unknown(audit)))


def _unknown(audit: Audit) -> Iterator[str]:
    """Yield what keeps a verdict from being about all that was recorded."""
    if undecided := audit.total.undecided:
        yield f"{counted(undecided, 'launch', 'launches')} undecided"
    if mistakes := sum(mission.mistake_count for mission in audit.missions):
        yield counted(mistakes, "mistake")
    if missed := sum(bool(mission.error) for mission in audit.missions):
        yield f"{missed} not audited"


def _mission(model: Model, mission: MissionResult) -> Iterator[str]:
    if mission.error:
        yield f"{mission.name}: not audited: {mission.error}"
        return
    first = mission.first
    where = f", the first in line {first.line}" if first else ""
    count = mission.divergences
    diverges = f"{counted(count, 'divergence')}{where}" if count else "no divergence"
    yield f"{mission.name}: {counted(mission.figures.events, 'event')}, {diverges}"
    for row in mission.rows[:SHOWN]:
        yield f"  {mission.name}:{row.line}: {row_text(model, row)}"
    if count > SHOWN:
        yield f"  … {count - SHOWN} more"
    for note in mission.notes:
        yield f"  note: {note}"


def row_text(model: Model, row: AuditRow) -> str:
    """Return a divergence as text without its place."""
    subject = row.request if row.instance is None else slot_text(model, row.request, row.instance)
    answer = ANSWERED[row.answer]
    if row.kind == "ran" and answer:
        answer = f": they {answer}"
    when = "" if math.isnan(row.time) else f" at {_clock(row.time)}"
    why = f" [{row.rule}]" if row.rule else ""
    return f"{row.kind}{when}: {SAYS[row.kind].format(subject=subject, answer=answer)}{why}"


def _clock(seconds: float) -> str:
    try:
        return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    except (OverflowError, ValueError, OSError):
        return f"{seconds:g} s"


def _asks(total: MissionFigures) -> Iterator[str]:
    requests = sorted({name for name, _ in total.asks})
    if requests:
        yield "asks:"
    for name in requests:
        counts = [f"{answer} {total.asks[name, answer]}" for answer in ANSWERS if total.asks[name, answer]]
        yield f"  {name}: {', '.join(counts)}"


def _rules(model: Model, total: MissionFigures) -> Iterator[str]:
    rules = rules_of(model)
    if rules:
        yield "rules:"
    for rule in rules:
        yield f"  {rule}: {total.used[rule] or 'never used'}"
