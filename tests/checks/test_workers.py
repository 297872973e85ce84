"""Questions asked in processes: the same answers for any number, kept limits, and nobody left behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from exover.checks import run as runner
from exover.checks import safety
from exover.checks.agenda import LEAST, Agenda
from exover.checks.finding import Finding
from exover.checks.limits import Limits, TimeUp, interrupted, limits_from
from exover.checks.question import Check, Context, Question, requests
from exover.checks.run import check_all
from exover.checks.workers import Lost, WorkerFault, spread
from exover.pipeline import Build, build, load
from exover.source import Source

ROOT = Path(__file__).resolve().parents[2]
SPEC = """spec demo;
module m { request a(); request b(); request c(); }
mutex m.a, m.b by wait;
"""
Answer = Callable[[int, Callable[[str], None]], int]


def built(text: str) -> Build:
    model = load(Source("demo.exo", text)).model
    assert model is not None
    return build(model)


def from_now(jobs: int, seconds: float | None) -> Limits:
    return limits_from(time.monotonic(), jobs, seconds)


def silent(text: str) -> None:
    """Tell nobody."""


def children() -> list[int]:
    """Return the processes whose parent we are."""
    found = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return [int(number) for number in found]


@pytest.fixture(autouse=True)
def _nobody_is_left() -> Iterator[None]:
    before = children()
    yield
    assert children() == before


def hang() -> None:
    """Stay in one call of C code for minutes; no signal handler of Python runs meanwhile."""
    pow(7, 10**8)


# ---- answers ----


@pytest.mark.parametrize("name", ["diligent", "violations/deadlock", "violations/completeness"])
def test_answers_are_the_same_for_any_number_of_processes(name: str) -> None:
    work = built((ROOT / f"specs/{name}.exo").read_text(encoding="utf-8"))

    def outcome(jobs: int, seconds: float | None = None) -> runner.Outcome:
        found = check_all(work.compiled, silent, limits=from_now(jobs, seconds))
        return replace(found, findings=tuple(replace(finding, seconds=0.0) for finding in found.findings))

    alone = outcome(1)
    assert alone.findings
    assert alone.state_bits
    assert outcome(2) == alone
    assert outcome(3) == alone
    assert outcome(1, 100.0) == alone


def test_what_one_answer_has_cost_the_next_need_not_pay() -> None:
    learnt: list[int] = []

    def work(number: int, progress: Callable[[str], None]) -> list[int]:
        learnt.append(number)
        return list(learnt)

    assert spread(work, Agenda(["a"] * 3), from_now(1, 60), silent) == [[0], [0, 1], [0, 1, 2]]
    assert learnt == []


def test_progress_comes_through() -> None:
    told: list[str] = []

    def work(number: int, progress: Callable[[str], None]) -> int:
        progress(f"looking at {number}")
        return number

    assert spread(work, Agenda(["a", "b"]), Limits(2), told.append) == [0, 1]
    assert sorted(told) == ["looking at 0", "looking at 1"]


# ---- limits ----


def test_the_time_limit_is_kept_inside_a_long_call() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        if number % 2:
            hang()
        return number

    started = time.monotonic()
    limits = from_now(2, 1.5)
    answers = spread(work, Agenda(["a", "slow", "b", "slow", "c", "slow"], 1.5), limits, silent)
    assert 1.4 < time.monotonic() - started < 2.0
    late = Lost("time limit of 1.5 s")
    assert answers == [0, late, 2, late, 4, late]


def test_an_endless_check_is_unknown_and_the_others_are_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    def decide(context: Context, question: Question) -> Finding:
        hang()
        raise AssertionError

    endless = Check("endless", "error", requests, decide, safety.claim)
    monkeypatch.setattr(runner, "CHECKS", (endless, *runner.CHECKS))
    found = check_all(built(SPEC).compiled, silent, limits=from_now(1, 4)).findings
    assert {f.verdict for f in found if f.check != "endless"} == {"holds"}
    assert [(f.subject, f.verdict, f.message) for f in found if f.check == "endless"] == [
        (subject, "unknown", "time limit of 4 s") for subject in ("m.a", "m.b", "m.c")
    ]


def test_a_process_that_dies_leaves_its_question_open() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        if number == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        if number == 2:
            os._exit(7)
        if number == 3:
            raise MemoryError
        return number

    assert spread(work, Agenda(["a"] * 6), Limits(2), silent) == [
        0,
        Lost("its process was ended by SIGKILL, perhaps for want of memory"),
        Lost("its process ended with status 7"),
        Lost("not enough memory"),
        4,
        5,
    ]


def test_a_fault_is_a_fault_of_the_whole() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        return [5][number]

    with pytest.raises(WorkerFault, match="IndexError: list index out of range") as caught:
        spread(work, Agenda(["a", "a"]), Limits(2), silent)
    assert "in work" in caught.value.__notes__[0]


def test_nobody_is_left_when_the_parent_is_interrupted() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        progress("here")
        hang()
        return number

    def interrupt(text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        spread(work, Agenda(["a", "a"]), Limits(2), interrupt)


ORPHANS = """
import os, sys
from exover.checks.agenda import Agenda
from exover.checks.limits import Limits
from exover.checks.workers import spread

def work(number, progress):
    progress(str(os.getpid()))
    pow(7, 10**8)

spread(work, Agenda(["a", "a"]), Limits(2), lambda text: print(text, flush=True))
"""


BEGINNING = """
import ctypes, os, time
library = ctypes.CDLL

def slow(name):
    os.write(1, b"%d\\n" % os.getpid())
    time.sleep(0.5)
    return library(name)

ctypes.CDLL = slow
"""
"""The workers are slow to ask that they be told of the end of their parent; their question is sent meanwhile."""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a process that its parent has ended")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.parametrize("script", [ORPHANS, BEGINNING + ORPHANS])
def test_nobody_is_left_when_the_parent_is_killed(script: str, number: signal.Signals) -> None:
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        assert all(map(alive, workers))
        parent.send_signal(number)
        parent.wait(timeout=10)
    until = time.monotonic() + 5
    while any(map(alive, workers)) and time.monotonic() < until:
        time.sleep(0.02)
    assert not any(map(alive, workers))


def alive(process: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_a_body_is_interrupted() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeUp), interrupted(from_now(1, 0.1)):
        while True:
            pass
    assert signal.getsignal(signal.SIGALRM) == before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    with interrupted(Limits()):
        assert signal.getsignal(signal.SIGALRM) == before


# ---- agenda ----


def test_without_a_limit_all_are_asked_in_order() -> None:
    agenda = Agenda(["a", "b", "a"])
    assert [agenda.next(float("inf")) for _ in range(4)] == [(n, float("inf")) for n in range(3)] + [None]


def test_a_slow_check_is_put_off_and_comes_back() -> None:
    agenda = Agenda(["slow", "slow", "slow", "quick", "dull", "dull"], 120.0)
    assert agenda.next(120.0) == (0, 10.0)
    agenda.late(0)
    assert agenda.next(110.0) == (3, 10.0)
    assert agenda.next(109.0) == (4, 10.0)
    agenda.late(4)
    # Now what was put off: check by check, the questions that were never asked first.
    assert agenda.next(100.0) == (1, 50.0)
    assert agenda.next(99.0) == (2, 49.5)
    agenda.late(2)
    assert agenda.next(40.0) == (5, 20.0)
    assert agenda.next(30.0) == (4, 15.0)
    agenda.late(4)
    assert agenda.next(10.0) == (0, 10.0)
    agenda.late(0)
    assert agenda.next(1.0) is None


def test_every_question_gets_the_time_that_a_process_needs_to_begin() -> None:
    assert Agenda(["a", "b"], 0.5).next(0.5) == (0, LEAST)
    assert Agenda(["a", "b"], 0.5).next(0.1) == (0, 0.1)
