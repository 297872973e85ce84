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
from exover.cli.signals import persistent_signals
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, settle
from exover.raised import is_raised

READ = (
    *("spec", "old", "new", "files", "box", "finding", "missions"),
    *("properties", "old_properties", "events", "audit", "bind", "after"),
)
"""The arguments and options that name one or several files to read."""
OBJECTS = 100_000
"""The threshold of the garbage collector, in objects: trees and models are many objects without cycles."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with these arguments (default: those of the process) and return its exit status."""
    outcome = ExitGuard()
    with outcome, persistent_signals():
        started = monotonic()
        gc.set_threshold(OBJECTS)
        signal.signal(signal.SIGTERM, _terminated)
        arguments = parser().parse_args(argv, argparse.Namespace(started=started))
        _refuse_overwriting(arguments)
        outcome.status = import_module(f"exover.cli.{getattr(arguments, 'module', arguments.verb)}").run(arguments)
    return settle(outcome.status)


def _refuse_overwriting(arguments: argparse.Namespace) -> None:
    """Raise `CliError` if an output of the command is a file that it reads."""
    named = vars(arguments)
    written = [each for each in ("out", "log", "events" if arguments.verb == "replay" else "") if named.get(each)]
    for output in written:
        for name in (each for each in READ if each != output):
            for path in named[name] if isinstance(named.get(name), list) else [named.get(name)]:
                if isinstance(path, str) and os.path.isfile(path) and _is_same(path, named[output]):
                    raise CliError(f"{named[output]} cannot be written over: the command reads it")


def _is_same(path: str, other: str) -> bool:
    """Return whether two paths lead to one file."""
    return os.path.exists(other) and os.path.samefile(path, other)


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
            case CliError():
                self.status, self.reason = ExitStatus.WRONG, str(error)
                complain(f"exover: error: {self.reason}")
            case OSError():  # a temporary folder that is full, say
                self.status = ExitStatus.WRONG
                self.reason = f"{error.strerror}" + (f": {error.filename}" if error.filename else "")
                complain(f"exover: error: {self.reason}")
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


def _terminated(number: int, frame: FrameType | None) -> None:
    sys.exit(ExitStatus.TERMINATED)
