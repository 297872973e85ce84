"""`exover simulate`: answer a stream of events."""

import argparse
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, nullcontext
from typing import BinaryIO

from exover.cli.files import read_spec, shown, standard_input
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import out
from exover.model.model import Model
from exover.pipeline import CheckerName, engine
from exover.run.simulate import Engine, lines_of, simulate

EXAMPLE = '{"ask": "MODULE.REQUEST", "args": {}}'


def run(arguments: argparse.Namespace) -> int:
    """Print the answer to each event before the next is read, so that the command works as a coprocess too."""
    model = read_spec(arguments.spec)
    with open_events(arguments.events) as events, ExitStack() as stack:
        chosen = start(stack, arguments.engine, model)
        for answer in _answers(model, chosen, arguments.events, events):
            if not out(f"{answer}\n"):
                break
    return ExitStatus.OK


def _answers(model: Model, chosen: Engine, path: str, stream: BinaryIO) -> Iterator[str]:
    """Yield the answers to the lines of a stream; `CliError` at its end if none of them was an event."""
    events = yield from simulate(model, chosen, lines_in(path, stream))
    if not events:
        raise no_event(path)


def no_event(path: str) -> CliError:
    """Return the error for a file in which no line is an event."""
    return CliError(f"no line of {shown(path)} is an event: write one JSON object a line, as {EXAMPLE}")


def open_events(path: str) -> AbstractContextManager[BinaryIO]:
    """Return the stream of a file, or of standard input if the path is `-`; `CliError` if there is none."""
    if path != "-":
        try:
            return open(path, "rb")
        except OSError as error:
            raise CliError(f"cannot read {path}: {error.strerror}") from error
    return nullcontext(standard_input())


def lines_in(path: str, stream: BinaryIO) -> Iterator[bytes]:
    """Yield the lines of the stream of a path; `CliError` if it cannot be read to its end."""
    try:
        yield from lines_of(stream)
    except OSError as error:
        raise CliError(f"cannot read {path}: {error.strerror}") from error


def start(stack: ExitStack, name: CheckerName, model: Model) -> Engine:
    """Return an engine that runs until the stack is left; `CliError` if what it needs is not installed."""
    if name not in ("c", "rust"):
        return stack.enter_context(engine(name, model))
    from exover.engines.compiler import NativeUnavailable

    try:
        return stack.enter_context(engine(name, model))
    except NativeUnavailable as reason:
        raise CliError(str(reason)) from reason
