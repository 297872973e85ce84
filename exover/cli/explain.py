"""`exover explain`: say why the last event of a run was answered so."""

import argparse

from exover.cli.files import model_of, read_source, refuse_twice, shown
from exover.cli.simulate import lines_in, open_events
from exover.cli.status import Refused, Status
from exover.cli.streams import out
from exover.pipeline import explain
from exover.report import explanation as report


def run(arguments: argparse.Namespace) -> int:
    """Print why the last event was answered so; refuse a stream without events."""
    refuse_twice(arguments.spec, arguments.events)
    source = read_source(arguments.spec)
    model = model_of(source)
    with open_events(arguments.events) as events:
        found = explain(source, model, lines_in(arguments.events, events))
    if found is None:
        raise Refused(f"{shown(arguments.events)} holds no event to explain")
    out(report.render_json(model, found) if arguments.format == "json" else report.render_text(model, found))
    return Status.OK
