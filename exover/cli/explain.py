"""`exover explain`: say why the last event of a run was answered so, or what a check or an error code means."""

import argparse
import json
import os
import re

from exover.cli.files import model_of, read_source
from exover.cli.simulate import lines_in, open_events
from exover.cli.status import Refused, Status
from exover.cli.streams import out
from exover.diagnostics import did_you_mean
from exover.manual import FILES, Page, page, pages
from exover.pipeline import explain
from exover.report import explanation as report


def run(arguments: argparse.Namespace) -> int:
    """Print the page of a check or code, or why the last event was answered so; refuse a stream without events."""
    found_page = page(arguments.spec)
    if found_page:
        out(_told(found_page, arguments.format))
        return Status.OK
    _refuse_unknown(arguments.spec)
    source = read_source(arguments.spec)
    model = model_of(source)
    with open_events(arguments.events) as events:
        found = explain(source, model, lines_in(arguments.events, events))
    if found is None:
        raise Refused(f"{arguments.events} holds no event to explain")
    out(report.render_json(model, found) if arguments.format == "json" else report.render_text(model, found))
    return Status.OK


def _told(page: Page, form: str) -> str:
    """Return a page as Markdown or as a JSON object, with a final newline."""
    if form == "text":
        return page.markdown
    told = {"name": page.name, "title": page.title, "text": page.text, "mend": page.mend}
    return json.dumps(told, ensure_ascii=False, indent=1) + "\n"


def _refuse_unknown(name: str) -> None:
    """Raise `Refused` for a word that is neither a file nor a check nor a code."""
    if re.fullmatch(r"[A-Za-z][\w-]*", name) and not os.path.exists(name):
        near = did_you_mean(name, pages()) or f"checks and codes are those of {', '.join(FILES)} in docs"
        raise Refused(f"there is no spec, check or error code {name}; {near}")
