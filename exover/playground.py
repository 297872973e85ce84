"""The functions that the playground calls in a browser: the page of a spec, and answers to events.

They use only Python without extension modules, and no engine but the reference interpreter.
"""

import json
from typing import Any

from exover.checks.questions import SEVERITY
from exover.diagnostics import Diagnostic, render_all
from exover.model.wire import escaped
from exover.pipeline import build, load
from exover.rendering import page_of, summarise
from exover.report.summary import ERRORS
from exover.run.simulate import ReferenceEngine, simulate
from exover.source import Source
from exover.syntax.decode import decode

NAME = "spec.exo"
NOT_ASKED = "not asked"


def look(text: str) -> str:
    """Return a JSON object: `mistakes`, as `exover check` prints them, "" if none, and `report`, the page, else null.

    The page has tables, diagrams, rules and graph, and no findings: no check is asked.
    """
    source = _source(text)
    if isinstance(source, Diagnostic):
        return _json({"mistakes": render_all((source,), Source(NAME, "")), "report": None})
    loaded = load(source)
    if loaded.model is None:
        return _json({"mistakes": render_all(loaded.diagnostics, loaded.source), "report": None})
    built = build(loaded.model)
    summary = summarise(NAME, loaded.model, built, None, ERRORS, skipped=tuple(SEVERITY))
    outcome = f"{loaded.model.name}: nothing is proved here, for that takes engines: exover check asks them"
    page = page_of(summary, loaded.source, built)
    return _json({"mistakes": "", "report": page | {"verdict": NOT_ASKED, "outcome": outcome}})


def answer(text: str, events: str) -> str:
    """Return a JSON list of the lines with which the reference interpreter answers `events`, a JSON list of lines.

    The spec must have no mistake.
    """
    source = _source(text)
    assert isinstance(source, Source)
    model = load(source).model
    assert model is not None
    return _json(list(simulate(model, ReferenceEngine(model), json.loads(events))))


def _source(text: str) -> Source | Diagnostic:
    """Return a text as it would be read from a file, or why it would not."""
    return decode(NAME, text.encode("utf-8", "surrogatepass"))


def _json(found: Any) -> str:
    return escaped(json.dumps(found, ensure_ascii=False))
