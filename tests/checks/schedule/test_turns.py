"""Questions asked in processes that take turns: they are halted, and go on where they were."""

import os
import signal
import time
from pathlib import Path

import pytest

from exover.checks.schedule.agenda import Agenda
from exover.checks.schedule.workers import HALTED
from tests.checks.schedule.spreading import Progress, asked, children, from_now, lots

pytestmark = pytest.mark.usefixtures("nobody_is_left")


def test_a_process_is_halted_and_goes_on_where_it_was() -> None:
    def work(number: int, progress: Progress) -> tuple[int, int]:
        rounds = 0
        until = time.process_time() + (0.6 if number == 0 else 0.0)
        while time.process_time() < until:
            rounds += 1
        return os.getpid(), rounds

    began: list[str] = []

    def counted(number: int, progress: Progress) -> tuple[int, int]:
        progress(f"{number}")
        return work(number, progress)

    found = asked(counted, Agenda(lots("slow", "b", "c"), 1.0), from_now(1, 60), began.append)
    assert sorted(found) == [0, 1, 2]
    assert began.count("0") == 1  # so it was not begun anew
    assert list(found) != [0, 1, 2]  # though others came between


def test_only_so_many_are_halted(tmp_path: Path) -> None:
    """Nine wait for the last one to be asked, however long that takes here."""
    most, quick, others = 0, tmp_path / "quick", set(children())

    def work(number: int, progress: Progress) -> int:
        progress("here")
        if number == 9:
            quick.touch()
        while not quick.exists():
            time.sleep(0.01)
        return number

    def count(text: str) -> None:
        nonlocal most
        if not quick.exists():  # from then on one may end while the next begins
            most = max(most, len(set(children()) - others))

    names = [f"slow {number}" for number in range(9)] + ["quick"]
    assert asked(work, Agenda(lots(*names), 4.0), from_now(1, 300), count)[9] == 9
    assert most == HALTED + 1


def test_nobody_is_ended_while_nobody_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(signal, "SIGSTOP")  # where nobody can be halted

    def work(number: int, progress: Progress) -> int:
        progress("here")
        time.sleep(1)
        return number

    began: list[str] = []
    assert asked(work, Agenda(lots("slow"), 0.4), from_now(1, 60), began.append) == {0: 0}
    assert began == ["here"]
