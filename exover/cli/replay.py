"""`exover replay`: print what a black box holds, and replay it on the reference interpreter."""

import argparse
import json
import os

from exover.cli.files import load_file, read_bytes, read_spec, refuse_twice, shown, write_one
from exover.cli.simulate import lines_in, open_events
from exover.cli.specs import specs_of
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out
from exover.model.model import Model
from exover.model.replayed import Replayed
from exover.report.replayed import run_lines
from exover.run.box import Box, NotABox, earlier, read_box
from exover.run.replay import replay


def run(arguments: argparse.Namespace) -> int:
    """Print every run of the box, oldest first, with the replay; write the events of the last run if asked for."""
    refuse_twice(arguments.box, arguments.spec, arguments.after)
    held = _box(arguments.box)
    model = _model(arguments.spec, held)
    before = _lines(arguments.after)
    runs = [replay(model, steps, before if number == 1 else ()) for number, steps in enumerate(held.runs, 1)]
    for number, steps in enumerate(runs, 1):
        out("".join(f"{line}\n" for line in _run(model, number, steps)))
    if held.damaged:
        complain(f"exover: note: {held.damaged} lines of {shown(arguments.box)} are half written or have changed")
    if arguments.events:
        events = "".join(f"{json.dumps(step.event)}\n" for step in runs[-1])
        write_one(arguments.events, events.encode(), "--events")
    return _status(runs)


def _run(model: Model, number: int, steps: tuple[Replayed, ...]) -> list[str]:
    wrong = sum(not step.agrees for step in steps)
    first, last = steps[0].number, steps[-1].number
    if steps[0].expected is None:
        verdict = f"not compared: the {earlier(first)} steps before it are lost; give their events with --after"
    else:
        verdict = f"{wrong} not as the reference answers" if wrong else "all as the reference answers"
    return [f"run {number}: steps {first} to {last}, {verdict}", *run_lines(model, steps)]


def _status(runs: list[tuple[Replayed, ...]]) -> ExitStatus:
    if any(not step.agrees for steps in runs for step in steps):
        return ExitStatus.VIOLATED
    return ExitStatus.UNKNOWN if any(steps[0].expected is None for steps in runs) else ExitStatus.OK


def _box(path: str) -> Box:
    try:
        found = read_box(read_bytes(path))
    except NotABox as reason:
        raise CliError(f"{shown(path)} is no black box: {reason}") from reason
    if not found.runs:
        raise CliError(f"{shown(path)} holds no event")
    return found


def _model(path: str | None, held: Box) -> Model:
    """Return the model whose digest the box has: of the spec that is named, else of one below this folder."""
    from exover.model.canonical import digest

    if path is not None:
        model = read_spec(path)
        if digest(model) != held.digest:
            raise CliError(
                f"the box was written for another spec than {shown(path)}: its sha256 is {held.digest.hex()}"
            )
        return model
    for spec in specs_of([os.curdir]).files:
        loaded = load_file(spec)
        if loaded.model is not None and digest(loaded.model) == held.digest:
            return loaded.model
    raise CliError(f"no spec here has the sha256 of the box, {held.digest.hex()}: name the spec behind the box")


def _lines(path: str | None) -> list[bytes]:
    if path is None:
        return []
    with open_events(path) as events:
        return list(lines_in(path, events))
