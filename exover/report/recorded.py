"""Reads findings with traces from a JSON report, replays the traces, and writes them as text or JSON."""

import json
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from exover.dataclass import dataclass
from exover.escaping import visible_lines
from exover.manual import pages
from exover.model.event import Event, Invalid
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.trace import run
from exover.model.wire import action_json, indented
from exover.model.wire_reading import read_event
from exover.model.wording import action_text
from exover.report.json import UnreadableReport, loaded, steps_json
from exover.report.story import Story, story_lines, story_of


@dataclass(frozen=True, slots=True)
class Recorded:
    """A finding with a trace, as a report has it; `file`: the spec's file in the report, empty if it has none.

    `moments`: for each step the event and its actions, as JSON objects.
    """

    file: str
    check: str
    subject: str
    verdict: str
    message: str
    moments: tuple[tuple[object, object], ...]
    loop_start: int | None

    @property
    def title(self) -> str:
        """The check, the subject and the verdict or severity, in one line."""
        known = pages().get(self.check)
        lesser = self.verdict == "violated" and known is not None and known.severity in ("warning", "note")
        return f"{self.check} {self.subject} {known.severity if known and lesser else self.verdict}"


# ---- reading ----


def read(text: str) -> tuple[Recorded, ...]:
    """Return the findings with a trace in a report of `exover check --format json`, of one spec or several; or the one
    finding of a report that the text is.

    Raises `UnreadableReport` for any other text.
    """
    report = loaded(text)
    if isinstance(report, dict) and isinstance(report.get("specs"), list):
        return tuple(found for each in report["specs"] if not _unchecked(each) for found in _findings(each))
    return _findings(report)


def _unchecked(report: Any) -> bool:
    return isinstance(report, dict) and "error" in report


def _findings(report: Any) -> tuple[Recorded, ...]:
    if not isinstance(report, dict) or not ("findings" in report or "trace" in report):
        raise UnreadableReport("it is neither a report of `exover check --format json` nor a finding of one")
    findings = report.get("findings", [report])
    if not isinstance(findings, list):
        raise UnreadableReport("its `findings` are no list")
    return tuple(
        _finding(found, report) for found in findings if not isinstance(found, dict) or found.get("trace") is not None
    )


def _finding(found: object, report: dict[str, Any]) -> Recorded:
    if not isinstance(found, dict):
        raise UnreadableReport("one of its findings is no object")
    location = found.get("location")
    file = report.get("file", location.get("file") if isinstance(location, dict) else None)
    check, subject, verdict, message = (found.get(key, "") for key in ("check", "subject", "verdict", "message"))
    trace, loop_start = found["trace"], found.get("loop_start")
    if not all(isinstance(text, str) for text in (check, subject, verdict, message)) or not isinstance(trace, list):
        raise UnreadableReport("one of its findings has a check, a subject or a trace of the wrong type")
    if loop_start is not None and not (type(loop_start) is int and 0 <= loop_start < len(trace)):
        raise UnreadableReport(f"the `loop_start` of its {check} {subject} is no step of the trace")
    if not all(isinstance(moment, dict) and {"event", "actions"} <= moment.keys() for moment in trace):
        raise UnreadableReport(f"a step in the trace of its {check} {subject} lacks `event` or `actions`")
    moments = tuple((moment["event"], moment["actions"]) for moment in trace)
    return Recorded(file if isinstance(file, str) else "", check, subject, verdict, message, moments, loop_start)


def choose(found: Iterable[Recorded], check: str | None, subject: str | None) -> tuple[Recorded, ...]:
    """Return the violated findings of this check and subject, where given; if there are none, the others of them."""
    named = [each for each in found if check in (None, each.check) and subject in (None, each.subject)]
    return tuple(each for each in named if each.verdict == "violated") or tuple(named)


# ---- telling again ----


def retell(model: Model, recorded: Recorded) -> Story:
    """Return the story of a recorded trace; raises `UnreadableReport` unless the reference answers as recorded.

    Also raises it if the trace is a lasso that does not return to the state in which its loop starts.
    """
    events: list[Event] = []
    for step, (entry, _) in enumerate(recorded.moments, 1):
        event = read_event(model, json.dumps(entry))
        if isinstance(event, Invalid):
            raise UnreadableReport(_otherwise(step, f"{event.code}, {event.detail}"))
        events.append(event)
    trace = run(Reference(model), tuple(events))
    for step, (moment, (_, actions)) in enumerate(zip(trace.moments, recorded.moments, strict=True), 1):
        if [action_json(model, action) for action in moment.actions] != actions:
            answer = "; ".join(action_text(model, action) for action in moment.actions) or "no action"
            raise UnreadableReport(_otherwise(step, answer))
    story = story_of(model, replace(trace, loop_start=recorded.loop_start))
    begin = recorded.loop_start
    if begin is not None and story.scenes[begin].before.key() != story.scenes[-1].after.key():
        raise UnreadableReport(
            f"the run of its {recorded.check} {recorded.subject} does not come back to where it was after {begin} "
            "steps, as its `loop_start` says"
        )
    return story


def _otherwise(step: int, answer: str) -> str:
    return f"the spec answers step {step} otherwise than the trace says ({answer}): it has changed since, or is another"


# ---- writing ----


def render_text(recorded: Recorded, story: Story) -> str:
    """Return the finding and its run as text with a final newline."""
    head = f"{recorded.title}: {recorded.message}" if recorded.message else recorded.title
    return visible_lines((head, *story_lines(story)))


def render_json(recorded: Recorded, story: Story) -> str:
    """Return the finding with its trace as one JSON object (docs/checks.md), which `read` takes for a finding."""
    finding = {
        "file": recorded.file,
        "check": recorded.check,
        "subject": recorded.subject,
        "verdict": recorded.verdict,
        "message": recorded.message,
        "trace": steps_json(story.model, [(scene.event, scene.actions) for scene in story.scenes]),
        "loop_start": story.loop_start,
    }
    return indented(finding)
