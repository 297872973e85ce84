"""`exover explain`: explain the answer to an event, or print the page of a check or an error code."""

import argparse
import json
import os
import re
from collections.abc import Iterable

from exover.cli.files import load_spec, shown
from exover.cli.findings import chosen
from exover.cli.named_files import refuse_twice
from exover.cli.simulate import lines_in, no_event, open_events
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import out
from exover.diagnostics import did_you_mean
from exover.escaping import visible
from exover.manual import FILES, Page, page, pages
from exover.model.explanation import Explanation
from exover.model.model import Model
from exover.pipeline import explain
from exover.report import explanation as report
from exover.report.json import UnreadableReport
from exover.report.recorded import Recorded, retell
from exover.source import Source


def run(arguments: argparse.Namespace) -> int:
    """Print the page of a check or code, or the explanation of the answer to the last event or to a step."""
    found = page(arguments.spec or "")
    if found:
        _refuse_run(arguments)
        out(_told(found, arguments.format))
        return ExitStatus.OK
    return _finding(arguments) if arguments.finding else _events(arguments)


def _refuse_run(arguments: argparse.Namespace) -> None:
    """Raise `CliError` if an option for a run is given with a page: `--check` is meant."""
    for option in ("finding", "events", "check", "subject", "step"):
        if getattr(arguments, option) is not None:
            name = arguments.spec
            raise CliError(
                f"{name} names a page, to which --{option} says nothing: in a report, --check {name} chooses"
            )


def _events(arguments: argparse.Namespace) -> ExitStatus:
    if not arguments.spec:
        raise CliError("say which spec the events are for, or with --finding which report has the run")
    _refuse_unknown(arguments.spec)
    for option in ("check", "subject", "step"):
        if getattr(arguments, option) is not None:
            raise CliError(f"--{option} chooses in a report: say with --finding in which")
    path = arguments.events or "-"
    refuse_twice(arguments.spec, path)
    source, model = load_spec(arguments.spec)
    with open_events(path) as events:
        found = _print(arguments, source, model, lines_in(path, events), shown(path))
    if not found.events:
        raise no_event(path)
    return ExitStatus.OK


def _finding(arguments: argparse.Namespace) -> ExitStatus:
    if arguments.events:
        raise CliError("--finding has the events of its run: leave out --events")
    recorded, spec = chosen(arguments)
    source, model = load_spec(spec)
    try:
        retell(model, recorded)
    except UnreadableReport as reason:
        raise CliError(f"cannot use {shown(arguments.finding)}: {reason}") from reason
    step = _step(arguments, recorded)
    if arguments.format == "text":
        out(visible(f"{recorded.title}: {recorded.message}") + "\n")
    lines = [json.dumps(event).encode() for event, _ in recorded.moments[:step]]
    _print(arguments, source, model, lines, recorded.title)
    return ExitStatus.OK


def _step(arguments: argparse.Namespace, recorded: Recorded) -> int:
    """Return the number of the step to explain: the one given, else the last; `CliError` if there is none such."""
    steps = len(recorded.moments)
    if not steps:
        raise CliError(f"{recorded.title} shows the start, where nothing has happened yet: there is no step to explain")
    if arguments.step is not None and not 1 <= arguments.step <= steps:
        raise CliError(f"there is no step {arguments.step}: the run of {recorded.title} has steps 1 to {steps}")
    return arguments.step or steps


def _print(
    arguments: argparse.Namespace, source: Source, model: Model, lines: Iterable[bytes], what: str
) -> Explanation:
    found = explain(source, model, lines)
    if found is None:
        raise CliError(f"{what} holds no event to explain")
    out(report.render_json(model, found) if arguments.format == "json" else report.render_text(model, found))
    return found


def _told(page: Page, form: str) -> str:
    """Return a page as Markdown or as a JSON object, with a final newline."""
    if form == "text":
        return page.markdown
    told = {"name": page.name, "title": page.title, "text": page.text, "mend": page.mend}
    return json.dumps(told, ensure_ascii=False, indent=1) + "\n"


def _refuse_unknown(name: str) -> None:
    """Raise `CliError` for a word that is neither a file nor a check nor an error code."""
    if re.fullmatch(r"[A-Za-z][\w-]*", name) and not os.path.exists(name):
        near = did_you_mean(name, pages()) or f"checks and codes are those of {', '.join(FILES)} in docs"
        raise CliError(f"there is no spec, check or error code {name}; {near}")
