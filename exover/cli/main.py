"""The command `exover`: dispatch to the verbs, and exit statuses for all exceptions.

Only the module of the verb that is called is imported, so that `exover --help` starts fast.
"""

import argparse
import gc
import os
import signal
import sys
from collections.abc import Sequence
from importlib import import_module
from time import monotonic
from types import FrameType, TracebackType

from exover.cli.arguments import parser
from exover.cli.named_files import inputs_of, outputs_of, refuse_twice
from exover.cli.signals import persistent_signals
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, settle
from exover.ending import heeded
from exover.limits import memory_reason
from exover.raised import TablesTooLarge, is_raised, out_of_memory

OBJECTS = 100_000
"""The threshold of the garbage collector, in objects: trees and models are many objects without cycles."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with these arguments (default: those of the process) and return its exit status."""
    outcome = ExitGuard()
    with outcome, persistent_signals():
        started = monotonic()
        gc.set_threshold(OBJECTS)
        _end_by_signals()
        arguments = parser().parse_args(argv, argparse.Namespace(started=started))
        _refuse_odd_files(arguments)
        outcome.status = import_module(f"exover.cli.{getattr(arguments, 'module', arguments.verb)}").run(arguments)
    return settle(outcome.status)


def _refuse_odd_files(arguments: argparse.Namespace) -> None:
    """Raise `CliError` if standard input is named twice or as an output, or an output is a file that is read."""
    refuse_twice(*inputs_of(arguments))
    if "-" in outputs_of(arguments):
        raise CliError("- is standard input, and no file to write; ./- is a file of that name")
    if outputs_of(arguments):  # what looks for files is loaded for these alone
        import_module("exover.cli.overwriting").refuse_overwriting(arguments)


class ExitGuard:
    """A context that swallows every exception, and has the exit status and the reason of it afterwards."""

    status: int = ExitStatus.OK
    reason: str = ""

    def __enter__(self) -> None:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        """Set the status and the reason from the exception, if there is one, complain of it, and swallow it."""
        match error:
            case None:
                pass
            case CliError() | TablesTooLarge():
                self.status, self.reason = ExitStatus.WRONG, str(error)
                complain(f"exover: error: {self.reason}")
            case OSError():  # a temporary folder that is full, say
                self.status = ExitStatus.WRONG
                self.reason = f"{error.strerror}" + (f": {error.filename}" if error.filename else "")
                complain(f"exover: error: {self.reason}")
            case _ if out_of_memory(error):
                self.status, self.reason = ExitStatus.UNKNOWN, memory_reason(error)
                complain(f"exover: error: {self.reason}: nothing more is known")
            case SystemExit():
                self.status = error.code if isinstance(error.code, int) else ExitStatus.OK
            case _ if is_raised(SystemExit, error):
                self.status = ExitStatus.TERMINATED
            case _ if is_raised(KeyboardInterrupt, error):
                self.status, self.reason = ExitStatus.INTERRUPTED, "interrupted"
            case _:
                self.status, self.reason = ExitStatus.FAULT, "internal fault"
                _explain(error)
        return True


def _explain(error: BaseException) -> None:
    if os.environ.get("EXOVER_DEBUG") == "1":
        import traceback

        complain("".join(traceback.format_exception(error)).rstrip())
    what = f"{type(error).__name__}: {error}".rstrip(": ").replace("\n", " ")
    complain(f"exover: internal fault: {what}; please report it (EXOVER_DEBUG=1 shows where it happened)")


def _end_by_signals() -> None:
    """Let Ctrl-C, SIGTERM and, unless it is ignored, a closed terminal end the command in order."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (heeded() | {signal.SIGTERM}) - {signal.SIGINT}:
        signal.signal(number, _terminated)


def _terminated(number: int, frame: FrameType | None) -> None:
    sys.exit(ExitStatus.TERMINATED)
