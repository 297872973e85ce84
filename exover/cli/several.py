"""Several specs in one command: one after the other, or in parallel, each in a process of its own."""

import argparse
import io
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic
from typing import Any

from exover import __version__
from exover.checks.schedule.workers import GRACE, ended, process_of
from exover.cli.files import shown
from exover.cli.main import ExitGuard
from exover.cli.status import ExitStatus
from exover.cli.streams import ProgressLine, complain
from exover.dataclass import dataclass
from exover.ending import ENDING, leave_ending_to_parent
from exover.engines.process import die_with, uninterrupted
from exover.engines.scratch import Scratch, files_in
from exover.limits import INTERRUPTED
from exover.loop.claim import Verdict
from exover.pipeline import Build
from exover.report.several import ReportFormat, part
from exover.report.summary import Summary, Unchecked
from exover.source import Source

STOP = getattr(signal, "SIGUSR1", signal.SIGTERM)
"""The signal that has a process end with what it knows."""


@dataclass(frozen=True, slots=True)
class Examined:
    """The findings of one spec with their exit status, and its text and tables if it came so far."""

    found: Summary | Unchecked
    status: int
    source: Source | None = None
    built: Build | None = None
    recalled: int = 0
    """The number of answers from the cache."""


Examine = Callable[[argparse.Namespace], Examined]
"""Checks one spec; raises whatever ends a command."""


@dataclass(frozen=True, slots=True)
class Checked:
    """The outcome of one spec: its part of each report, and its text for standard error."""

    verdict: Verdict
    status: int
    parts: dict[ReportFormat, Any]
    complaints: str = ""


def examine_all(examine: Examine, arguments: argparse.Namespace, specs: Sequence[str]) -> list[Checked]:
    """Return the outcome of each spec, in order. They share the processes of `--jobs` and the time of `--timeout`.

    After Ctrl-C the outcomes say `interrupted` where nothing is known.
    """
    if arguments.jobs <= 1:
        return _in_turn(examine, arguments, specs)
    with _Pool(examine, arguments, specs) as pool:
        found = pool.work()
    for each in found:
        if each.complaints:
            complain(each.complaints.rstrip("\n"))
    return found


def _in_turn(examine: Examine, arguments: argparse.Namespace, specs: Sequence[str]) -> list[Checked]:
    found: list[Checked] = []
    for number, spec in enumerate(specs):
        if found and found[-1].status == ExitStatus.INTERRUPTED:
            found.append(_without(arguments, spec, INTERRUPTED, ExitStatus.INTERRUPTED))
        else:
            found.append(_one(examine, _alone(arguments, spec, 1, len(specs) - number)))
            if found[-1].status == ExitStatus.TERMINATED:
                sys.exit(ExitStatus.TERMINATED)
    return found


def _alone(arguments: argparse.Namespace, spec: str, places: int, left: int) -> argparse.Namespace:
    """Return the arguments for one spec, if `left` specs are left and `places` of them are checked in parallel."""
    share = None
    if arguments.timeout is not None:
        share = (arguments.timeout - (monotonic() - arguments.started)) * min(places, left) / left
    own = {"spec": spec, "share": share, "jobs": arguments.jobs // places}
    return argparse.Namespace(**{**vars(arguments), **own})


def _one(examine: Examine, arguments: argparse.Namespace) -> Checked:
    """Return the outcome of a spec, also if an exception ends it."""
    outcome = ExitGuard()
    with outcome:
        examined = examine(arguments)
        outcome.status = examined.status
        return Checked(examined.found.verdict, outcome.status, _parts(arguments, examined.found))
    return _without(arguments, arguments.spec, outcome.reason, outcome.status)


def _without(arguments: argparse.Namespace, spec: str, reason: str, status: int) -> Checked:
    unchecked = Unchecked(__version__, shown(spec), reason)
    return Checked(unchecked.verdict, status, _parts(arguments, unchecked))


def _parts(arguments: argparse.Namespace, found: Summary | Unchecked) -> dict[ReportFormat, Any]:
    forms = (arguments.format, *(form for form, _ in arguments.output))
    return {form: part(found, form, arguments.timings) for form in forms}


# ---- processes ----


def _serve(
    channel: "Connection[Checked, Any]", parent: int, examine: Examine, arguments: argparse.Namespace, scratch: str
) -> None:
    """Check a spec and send its outcome to the parent. Ctrl-C is ignored: the parent, which gets it too, sends `STOP`.

    `scratch`: the folder of its temporary files.
    """
    leave_ending_to_parent()
    signal.signal(STOP, signal.default_int_handler)
    if die_with(parent):
        files_in(scratch)
        sys.stderr = said = io.StringIO()
        found = _one(examine, arguments)
        channel.send(replace(found, complaints=said.getvalue()))


class _Pool:
    """The processes that check specs; a context at whose end all of them are killed."""

    def __init__(self, examine: Examine, arguments: argparse.Namespace, specs: Sequence[str]) -> None:
        self._examine, self._arguments, self._specs = examine, arguments, specs
        self._places = min(arguments.jobs, len(specs))
        self._waiting = deque(range(len(specs)))
        self._running: dict[Connection[object, Checked], tuple[int, BaseProcess]] = {}
        self._found: dict[int, Checked] = {}
        self._stopped = False
        self._scratch = Scratch()

    def __enter__(self) -> "_Pool":
        self._scratch.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        with uninterrupted(*ENDING):
            for _, process in self._running.values():
                process.kill()
                process.join()
            self._scratch.__exit__(*error)

    def work(self) -> list[Checked]:
        """Return the outcome of each spec, in order."""
        with ProgressLine() as progress:
            try:
                self._work(progress)
            except KeyboardInterrupt:
                self._interrupt()
                self._work(progress)
        return [self._found[number] for number in range(len(self._specs))]

    def _work(self, progress: ProgressLine) -> None:
        while self._waiting or self._running:
            while self._waiting and len(self._running) < self._places:
                self._start(self._waiting.popleft())
            progress.show(f"{len(self._found)} of {len(self._specs)} specs checked")
            for channel in wait(list(self._running)):
                if channel in self._running:
                    self._hear(channel)

    def _interrupt(self) -> None:
        """Start no more specs, and have the running processes end with what they know."""
        for number in self._waiting:
            self._found[number] = _without(self._arguments, self._specs[number], INTERRUPTED, ExitStatus.INTERRUPTED)
        self._waiting.clear()
        self._stopped = True
        for _, process in self._running.values():
            os.kill(process.pid or 0, STOP)

    def _start(self, number: int) -> None:
        ours, theirs = Pipe(duplex=False)
        own = _alone(self._arguments, self._specs[number], self._places, len(self._waiting) + 1)
        process = process_of(_serve, (theirs, os.getpid(), self._examine, own, self._scratch.folder), daemon=False)
        with uninterrupted(signal.SIGINT):
            process.start()
            self._running[ours] = number, process
        theirs.close()

    def _hear(self, channel: "Connection[object, Checked]") -> None:
        number, process = self._running[channel]
        try:
            found = channel.recv()
        except (EOFError, OSError):
            process.join(GRACE)
            reason, status = ended(process.exitcode), ExitStatus.UNKNOWN
            if self._stopped:
                reason, status = INTERRUPTED, ExitStatus.INTERRUPTED
            found = _without(self._arguments, self._specs[number], reason, status)
        process.join()
        del self._running[channel]
        channel.close()
        self._found[number] = found
