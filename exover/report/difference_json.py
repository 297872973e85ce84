"""The differences between two versions of a spec as JSON (docs/diff.md)."""

from typing import Any

from exover.model.difference import CommonStep, Compared, Difference
from exover.model.event import Action, Event
from exover.model.wire import action_json, event_json, indented


def render(compared: Compared) -> str:
    """Return the differences as one JSON object, with a final newline."""
    versions, files, asked = compared.versions, compared.files, compared.properties
    told = {
        "tool": "exover",
        "version": compared.version,
        **{
            side: {"spec": model.name, "file": file, "properties": props.file}
            for side, model, file, props in zip(("old", "new"), versions.models, files, asked, strict=True)
        },
        "verdict": compared.verdict,
        "weaker": compared.weaker,
        "changes": [_difference(compared, each) for each in compared.differences],
        "unknown": [
            {"request": each.change.request, "change": each.change.word, "reason": each.reason}
            for each in compared.undecided
        ],
        "properties": [{"property": each.name, "old": each.old, "new": each.new} for each in compared.judged],
        "only_old": list(versions.alone(0)),
        "only_new": list(versions.alone(1)),
        "renamed": dict(versions.renamed),
        "notes": list(compared.notes),
    }
    return indented(told)


def _difference(compared: Compared, each: Difference) -> dict[str, Any]:
    return {
        "request": each.change.request,
        "change": each.change.word,
        "weaker": each.change.weaker,
        "shortest": each.shortest,
        "trace": [_step(compared, step) for step in each.steps],
    }


def _step(compared: Compared, step: CommonStep) -> dict[str, Any]:
    models = compared.versions.models
    events: list[Event | None] = list(step.events)
    shown = [None if event is None else event_json(model, event) for model, event in zip(models, events, strict=True)]
    answers = [_actions(compared, side, step.answers[side]) for side in (0, 1)]
    told: dict[str, Any] = {"event": shown[1] if shown[1] is not None else shown[0]}
    for side, name in enumerate(("old", "new")):
        told[name] = None if shown[side] is None else answers[side]
    return told


def _actions(compared: Compared, side: int, actions: tuple[Action, ...]) -> list[Any]:
    model = compared.versions.models[side]
    return [action_json(model, action) for action in actions]
