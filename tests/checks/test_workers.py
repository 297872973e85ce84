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
from exover.checks.agenda import LEAST, MOST, Agenda, Lot, Turn
from exover.checks.finding import Finding
from exover.checks.limits import Limits, TimeUp, interrupted, limits_from
from exover.checks.question import Check, Context, Question, requests
from exover.checks.run import check_all
from exover.checks.workers import GAVE_UP, HALTED, Lost, WorkerFault, alone, spread
from exover.pipeline import Build, build, load
from exover.source import Source

ROOT = Path(__file__).resolve().parents[2]
SPEC = """spec demo;
module m { request a(); request b(); request c(); }
mutex m.a, m.b by wait;
"""
Progress = Callable[[str], None]
Say = Callable[[int, object], None]


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
    assert alone.state_bits > 0
    assert outcome(2) == alone
    assert outcome(3) == alone
    assert outcome(1, 100.0) == alone


def test_what_one_answer_has_cost_the_next_need_not_pay() -> None:
    learnt: list[int] = []

    def work(number: int, progress: Callable[[str], None]) -> list[int]:
        learnt.append(number)
        return list(learnt)

    found = asked(work, Agenda(lots("a", "a", "a")), from_now(1, 60))
    assert found == {0: [0], 1: [0, 1], 2: [0, 1, 2]}
    assert learnt == []


def test_progress_comes_through() -> None:
    said: list[str] = []

    def work(number: int, progress: Callable[[str], None]) -> int:
        progress(f"looking at {number}")
        return number

    assert asked(work, Agenda(lots("a", "b")), Limits(2), said.append) == {0: 0, 1: 1}
    assert sorted(said) == ["looking at 0", "looking at 1"]


# ---- limits ----


def test_the_time_limit_is_kept_inside_a_long_call() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        if number % 2:
            hang()
        return number

    started = time.monotonic()
    limits = from_now(2, 1.5)
    answers = asked(work, Agenda(lots("a", "slow", "b", "slow", "c", "slow"), 1.5), limits)
    assert 1.4 < time.monotonic() - started < 2.0
    assert answers == {0: 0, 2: 2, 4: 4}


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

    assert asked(work, Agenda(lots(*"aaaaaa")), Limits(2)) == {
        0: 0,
        1: Lost("its process was ended by SIGKILL, perhaps for want of memory"),
        2: Lost("its process ended with status 7"),
        3: Lost("not enough memory"),
        4: 4,
        5: 5,
    }


def test_a_fault_is_a_fault_of_the_whole() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        return [5][number]

    with pytest.raises(WorkerFault, match="IndexError: list index out of range") as caught:
        asked(work, Agenda(lots("a", "a")), Limits(2))
    assert "in work" in caught.value.__notes__[0]


def test_nobody_is_left_when_the_parent_is_interrupted() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        progress("here")
        hang()
        return number

    def interrupt(text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        asked(work, Agenda(lots("a", "a")), Limits(2), interrupt)


ORPHANS = """
import os, sys
from exover.checks.agenda import Agenda, Lot
from exover.checks.limits import Limits
from exover.checks.workers import spread

def work(turn, say, progress):
    progress(str(os.getpid()))
    pow(7, 10**8)

spread(work, Agenda([Lot((0, 1))]), Limits(2), lambda text: print(text, flush=True), lambda number, answer: False)
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


