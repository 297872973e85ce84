"""What a benchmark says, and how time is taken."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Timer

ROOT = Path(__file__).parent.parent


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: what was measured, the limit it is held against, the paper's figure, and the value.

    `whole`: all was done that was to be done in this time.
    """

    what: str
    value: float
    unit: str = ""
    limit: float | None = None
    paper: str = ""
    note: str = ""
    whole: bool = True

    @property
    def verdict(self) -> str:
        """`ok` iff the value is within the limit and is that of the whole, else `MISSED`; nothing without a limit."""
        if self.limit is None:
            return ""
        return "ok" if self.whole and self.value <= self.limit else "MISSED"


def median_seconds(action: Callable[[], object], rounds: int) -> float:
    """Return the median of the wall-clock times that `action` took."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def command(arguments: Sequence[str], rounds: int) -> tuple[float, int]:
    """Return the median wall-clock seconds of the whole process `exover ARGUMENTS`, and its exit status."""
    statuses = []

    def run() -> None:
        done = subprocess.run([sys.executable, "-m", "exover", *arguments], cwd=ROOT, capture_output=True, check=False)
        statuses.append(done.returncode)

    return median_seconds(run, rounds), max(statuses)


@dataclass(frozen=True, slots=True)
class Run:
    """A process that was waited for: wall-clock seconds, the most memory it held, its status and what it printed."""

    seconds: float
    megabytes: float
    status: int
    output: str
    late: bool

    @property
    def whole(self) -> bool:
        """Whether it did all that it was there for."""
        return not self.late and self.status == 0

    @property
    def said(self) -> str:
        """What became of it, in one line."""
        if self.late:
            return "given up"
        return "; ".join(self.output.split("\n")[:-1]) if self.output else f"exit status {self.status}"


def watched(arguments: Sequence[str], limit: float, folder: Path, environment: dict[str, str] | None = None) -> Run:
    """Return what became of a process, which is killed after `limit` seconds."""
    with tempfile.TemporaryFile() as output:
        begin = time.perf_counter()
        process = subprocess.Popen(arguments, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT)
        timer = Timer(limit, process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read().decode(errors="replace")
    return Run(seconds, usage.ru_maxrss / 1024, process.returncode, text, seconds >= limit)


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def load() -> float:
    """Return how many processes wanted a core during the last minute: times are to be believed if it is small."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
