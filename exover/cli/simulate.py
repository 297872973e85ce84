"""`exover simulate`: answer a stream of events."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, nullcontext
from typing import BinaryIO

from exover.cli.files import read_spec
from exover.cli.status import Refused, Status
from exover.cli.streams import out
from exover.gateway.simulate import Engine, lines_of, simulate
from exover.model.model import Model
from exover.pipeline import EngineName, engine


def run(arguments: argparse.Namespace) -> int:
    """Answer each event before the next is read, so that this works as a coprocess, too."""
    model = read_spec(arguments.spec)
    with open_events(arguments.events) as events, ExitStack() as stack:
        chosen = _start(stack, arguments.engine, model)
        for answer in simulate(model, chosen, lines_in(arguments.events, events)):
            if not out(f"{answer}\n"):
                break
    return Status.OK


def open_events(path: str) -> AbstractContextManager[BinaryIO]:
    """Return the stream of a file, or of standard input if the path is `-`; `Refused` if there is none."""
    if path != "-":
        try:
            return open(path, "rb")
        except OSError as error:
            raise Refused(f"cannot read {path}: {error.strerror}") from error
    if sys.stdin is None:
        raise Refused("cannot read standard input: it is closed")
    return nullcontext(sys.stdin.buffer)


def lines_in(path: str, stream: BinaryIO) -> Iterator[bytes]:
    """Yield the lines of the stream of a path; `Refused` if it cannot be read to its end."""
    try:
        yield from lines_of(stream)
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from error


def _start(stack: ExitStack, name: EngineName, model: Model) -> Engine:
    """Return an engine that runs until the stack is left."""
    if name not in ("c", "rust"):
        return stack.enter_context(engine(name, model))
    from exover.gateway.native import NativeUnavailable

    try:
        return stack.enter_context(engine(name, model))
    except NativeUnavailable as reason:
        raise Refused(str(reason)) from reason
