"""`exover replay`: print what a black box holds, and replay it on the reference interpreter."""

import argparse
import json
import os
from collections.abc import Collection, Iterator, Sequence
from itertools import islice

from exover.cli.files import read_bytes, read_spec, shown, write_one
from exover.cli.simulate import lines_in, open_events
from exover.cli.specs import specs_of
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out
from exover.diagnostics import Diagnostic
from exover.model.model import Model
from exover.model.replayed import Replayed
from exover.model.wire_reading import is_blank
from exover.pipeline import load
from exover.places import read_part
from exover.report.replayed import run_lines
from exover.run.box import Box, NotABox, earlier, read_box
from exover.run.replay import replay
from exover.syntax.decode import decode


def run(arguments: argparse.Namespace) -> int:
    """Print every run of the box, oldest first, with the replay; write the events of the last run if asked for."""
    held = _box(arguments.box)
    model = _model(arguments.spec, held)
    before = _lines(arguments.after)
    runs = list(_replayed(model, held, before))
    for number, steps in enumerate(runs, 1):
        out("".join(f"{line}\n" for line in _run(model, number, steps)))
    if held.damaged:
        unjudged = ": what they held is not compared" if held.lost else ""
        box = shown(arguments.box)
        complain(f"exover: note: {held.damaged} lines of {box} are half written or have changed{unjudged}")
    if arguments.events:
        _write_events(arguments.events, runs[-1], before)
    return _status(runs, held.lost)


def _write_events(path: str, steps: Sequence[Replayed], before: Sequence[bytes]) -> None:
    """Write the events of a run; of what is lost of its beginning those `before`, if they are there, else say so."""
    lost = earlier(steps[0].number)
    given = islice((line for line in before if not is_blank(line)), lost) if steps[0].expected is not None else ()
    if lost and steps[0].expected is None:
        complain(f"exover: note: {path} begins behind step {lost} of its run: give the events before with --after")
    held = (json.dumps(step.event).encode() for step in steps)
    write_one(path, b"".join(line.rstrip(b"\r\n") + b"\n" for line in (*given, *held)), "--events")


def _replayed(model: Model, held: Box, before: Sequence[bytes]) -> Iterator[tuple[Replayed, ...]]:
    """Yield the runs with their replay.

    The event lines `before` are for the oldest run that needs them and for those that go on with its count of steps.
    """
    reached = 0
    for run in held.runs:
        if run[0].number <= reached:
            before = ()
        yield replay(model, run, before)
        if earlier(run[0].number):
            reached = run[-1].number


def _run(model: Model, number: int, steps: tuple[Replayed, ...]) -> list[str]:
    wrong = sum(not step.agrees for step in steps)
    first, last = steps[0].number, steps[-1].number
    if steps[0].expected is None:
        verdict = f"not compared: the {earlier(first)} steps before it are lost; give their events with --after"
    else:
        verdict = f"{wrong} not as the reference answers" if wrong else "all as the reference answers"
    return [f"run {number}: steps {first} to {last}, {verdict}", *run_lines(model, steps)]


def _status(runs: Collection[tuple[Replayed, ...]], lost: int) -> ExitStatus:
    if any(not step.agrees for steps in runs for step in steps):
        return ExitStatus.VIOLATED
    return ExitStatus.UNKNOWN if lost or any(steps[0].expected is None for steps in runs) else ExitStatus.OK


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
        found = _readable(spec)
        if found is not None and digest(found) == held.digest:
            return found
    raise CliError(f"no spec here has the sha256 of the box, {held.digest.hex()}: name the spec behind the box")


def _readable(path: str) -> Model | None:
    """Return the model of a spec, None if it cannot be read or has mistakes."""
    try:
        source = decode(path, read_bytes(path))
    except CliError:
        return None
    return None if isinstance(source, Diagnostic) else load(source, read_part).model


def _lines(path: str | None) -> list[bytes]:
    if path is None:
        return []
    with open_events(path) as events:
        return list(lines_in(path, events))
