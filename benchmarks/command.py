"""`exover check` as a user runs it, in a process of its own: what it took, what it says, when the first error shows.

Times are those of processors, of the process and all that it started, so that what else runs does not count; only the
time to the first error is that of a clock. It is the time at which the line appears on a terminal.
"""

import json
import os
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import Popen
from threading import Thread, Timer

from benchmarks.measure import ROOT

ERROR = re.compile(rb"violated: \S+ [^\r\n]*\r?\n")
GRACE = 20.0
"""Seconds after its time limit in which the command must have ended: it still replays runs, and reports."""


@dataclass(frozen=True, slots=True)
class Checked:
    """A run of the command: processor seconds, those of the clock until the first error, memory, verdicts by check."""

    seconds: float
    first: float | None
    megabytes: float
    state_bits: int | None = None
    verdicts: Counter[tuple[str, str]] = field(default_factory=Counter)
    failure: str = ""
    """Why there is no report."""

    @property
    def questions(self) -> int:
        """How many were asked."""
        return self.verdicts.total()

    @property
    def unknown(self) -> Counter[str]:
        """How many of each check are not answered."""
        return Counter({check: n for (check, verdict), n in self.verdicts.items() if verdict == "unknown"})

    @property
    def whole(self) -> bool:
        """Whether everything is answered."""
        return not self.failure and not self.unknown

    @property
    def said(self) -> str:
        """What came of it, in one line."""
        if self.failure:
            return self.failure
        violated = sum(n for (_, verdict), n in self.verdicts.items() if verdict == "violated")
        left = ", ".join(f"{n} {check}" for check, n in self.unknown.most_common())
        return f"{self.unknown.total()} of {self.questions} unknown{f' ({left})' * bool(left)}, {violated} violated"


def check(spec: Path, seconds: float, *options: str) -> Checked:
    """Return what became of `exover check` of a spec, its properties beside it, within so many seconds."""
    arguments = [sys.executable, "-m", "exover", "check", str(spec), "--format", "json", f"--timeout={seconds:g}"]
    return _run([*arguments, *options], seconds + GRACE)


def _run(arguments: Sequence[str], limit: float) -> Checked:
    with tempfile.TemporaryFile() as output:
        terminal, inside = os.openpty()
        begin = time.perf_counter()
        process = Popen(arguments, cwd=ROOT, stdout=output, stderr=inside)
        os.close(inside)
        listener = _Listener(terminal, begin)
        listener.start()
        timer = Timer(limit, process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
        late = time.perf_counter() - begin >= limit
        process.returncode = os.waitstatus_to_exitcode(status)
        listener.join(GRACE)
        os.close(terminal)
        output.seek(0)
        text = output.read()
    took = usage.ru_utime + usage.ru_stime
    verdicts: Counter[tuple[str, str]] = Counter()
    bits, failure = None, ""
    try:
        report = json.loads(text)
    except json.JSONDecodeError:
        failure = "given up" if late else f"exit status {process.returncode}: {listener.last}"
    else:
        verdicts.update((finding["check"], finding["verdict"]) for finding in report["findings"])
        bits = report["model"]["state_bits"]
    return Checked(took, listener.first, usage.ru_maxrss / 1024, bits, verdicts, failure)


class _Listener(Thread):
    """Reads what the command writes to its terminal, and notes when the first error stands there."""

    def __init__(self, terminal: int, begin: float) -> None:
        super().__init__(daemon=True)
        self.first: float | None = None
        self._terminal, self._begin, self._heard = terminal, begin, b""

    def run(self) -> None:
        with suppress(OSError):  # nobody holds the other end any more
            while read := os.read(self._terminal, 65536):
                self._heard = (self._heard + read)[-65536:]
                if self.first is None and ERROR.search(self._heard):
                    self.first = time.perf_counter() - self._begin

    @property
    def last(self) -> str:
        """The last line that was written."""
        lines = re.sub(rb"\x1b\[K", b"", self._heard).decode(errors="replace").replace("\r", "\n").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")
