"""What tests of questions in processes share."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from exover.checks.schedule.agenda import Agenda, Lot, Turn
from exover.checks.schedule.workers import Lost, spread
from exover.limits import Limits, limits_from
from tests.checks.work import silent

Progress = Callable[[str], None]
Say = Callable[[int, object], None]


def from_now(jobs: int, seconds: float | None) -> Limits:
    return limits_from(time.monotonic(), jobs, seconds)


def children() -> list[int]:
    """Return the processes whose parent we are."""
    found = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return [int(number) for number in found]


def lots(*names: str) -> tuple[Lot, ...]:
    """Return lots of questions that have the same name."""
    return tuple(Lot([n for n, each in enumerate(names) if each == name]) for name in dict.fromkeys(names))


def lost(answer: object) -> bool:
    return isinstance(answer, Lost)


def asked(
    work: Callable[[int, Progress], object],
    agenda: Agenda,
    limits: Limits,
    progress: Progress = silent,
    vain: Callable[[object], bool] = lost,
) -> dict[int, object]:
    """Return what a function that answers one question after the other says in processes."""

    def each(turn: Turn, say: Say, progress: Progress) -> None:
        for number in turn.numbers:
            say(number, work(number, progress))

    return told(each, agenda, limits, progress, vain)


def told(
    work: Callable[[Turn, Say, Progress], None],
    agenda: Agenda,
    limits: Limits,
    progress: Progress = silent,
    vain: Callable[[object], bool] = lost,
) -> dict[int, object]:
    """Return what a function that answers turns says in processes, in the order in which it does."""
    found: dict[int, object] = {}

    def take(number: int, answer: object) -> bool:
        assert number not in found
        found[number] = answer
        return vain(answer)

    spread(work, agenda, limits, progress, take)
    return found


def await_file(file: Path) -> None:
    """Wait until another process has made a file."""
    while not file.exists():
        time.sleep(0.01)
