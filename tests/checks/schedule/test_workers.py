"""Questions asked in processes: the same answers for any number, kept limits, and nobody left behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from exover.checks.finding import Finding
from exover.checks.questions import safety
from exover.checks.questions.question import Check, Context, Question, requests
from exover.checks.run import CheckOutcome
from exover.checks.schedule import plan
from exover.checks.schedule.agenda import Agenda
from exover.checks.schedule.workers import Lost, WorkerFault
from exover.limits import Limits
from tests.checks.schedule.spreading import asked, from_now, lots
from tests.checks.work import built
from tests.support.diagrams import check_by_diagrams
from tests.support.hanging import HANG, hang

ROOT = Path(__file__).resolve().parents[3]
SPEC = """spec demo;
module m { request a(); request b(); request c(); }
mutex m.a, m.b by wait;
"""
pytestmark = pytest.mark.usefixtures("nobody_is_left")


# ---- answers ----


@pytest.mark.parametrize(
    ("name", "jobs", "seconds"),
    [("diligent", 2, None), ("violations/deadlock", 3, None), ("violations/completeness", 1, 100.0)],
)
def test_answers_are_the_same_for_any_number_of_processes(name: str, jobs: int, seconds: float | None) -> None:
    work = built((ROOT / f"specs/{name}.exo").read_text(encoding="utf-8"))

    def outcome(jobs: int, seconds: float | None = None) -> CheckOutcome:
        found = check_by_diagrams(work.compiled, limits=from_now(jobs, seconds))
        return replace(found, findings=tuple(replace(finding, seconds=0.0) for finding in found.findings))

    alone = outcome(1)
    assert alone.findings
    assert alone.state_bits
    assert outcome(jobs, seconds) == alone


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


LOUD = """
import ctypes, os, sys
from exover.checks.schedule.agenda import Agenda, Lot
from exover.limits import Limits
from exover.checks.schedule.workers import alone, spread

def work(turn, say, progress):
    print("a library prints", flush=True)
    if os.getpid() != parent and sys.stdout is not None:
        ctypes.CDLL(None).puts(b"so does one in C")
        ctypes.CDLL(None).fflush(None)
    for number in turn.numbers:
        say(number, number)
    print("and leaves the rest to the end")

def take(number, answer):
    sys.stderr.write(f"{answer} ")

parent = os.getpid()
print("the report", end=" ")
alone(work, Agenda([Lot((0,))]), print, take)
spread(work, Agenda([Lot((1, 2))]), Limits(1, memory=4000), print, take)
print("is whole")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the library of C is looked up as in Linux")
@pytest.mark.parametrize(
    ("redirected", "printed"), [("", "the report is whole\n"), (">&-", "")], ids=["open", "closed"]
)
def test_what_a_library_prints_is_no_part_of_the_report(redirected: str, printed: str) -> None:
    command = ["sh", "-c", f'exec "$0" -c "$1" {redirected}', sys.executable, LOUD]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == (printed, "0 1 2 ", 0)


THREADS = """
import threading, time
from exover.checks.schedule.agenda import Agenda, Lot
from exover.checks.schedule.workers import alone

def work(turn, say, progress):
    global running
    running += 1
    print("a library prints", flush=True)
    begun.set()
    time.sleep(0.1)
    assert running == 1
    running -= 1
    say(0, 0)

running, begun = 0, threading.Event()
threads = [threading.Thread(target=alone, args=(work, Agenda([Lot((0,))]), print, print)) for _ in range(2)]
for thread in threads:
    thread.start()
begun.wait()
print("the host", end=" ", flush=True)
for thread in threads:
    thread.join()
print("prints")
"""


def test_threads_that_ask_in_one_process_come_in_turn_and_leave_standard_output_to_the_host() -> None:
    done = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == ("the host prints\n", "", 0)


# ---- limits ----


def test_the_time_limit_is_kept_inside_a_long_call() -> None:
    def work(number: int, progress: Callable[[str], None]) -> int:
        if number % 2:
            hang()
        return number

    started = time.monotonic()
    limits = from_now(2, 3.0)
    answers = asked(work, Agenda(lots("a", "slow", "b", "slow", "c", "slow"), 3.0), limits)
    assert 2.9 < time.monotonic() - started < 60  # where nobody ended them they would hang for minutes
    assert answers == {0: 0, 2: 2, 4: 4}


def test_an_endless_check_is_unknown_and_the_others_are_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    def decide(context: Context, question: Question) -> Finding:
        hang()
        raise AssertionError

    endless = Check("endless", "error", "it ends", requests, decide, safety.claim)
    monkeypatch.setattr(plan, "CHECKS", (endless, *plan.CHECKS))
    found = check_by_diagrams(built(SPEC).compiled, limits=from_now(1, 4)).findings
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


ORPHANS = f"""
{HANG}
import os, sys
from exover.checks.schedule.agenda import Agenda, Lot
from exover.limits import Limits
from exover.checks.schedule.workers import spread

def work(turn, say, progress):
    progress(str(os.getpid()))
    hang()

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
        parent.wait(timeout=60)
    until = time.monotonic() + 60
    while any(map(alive, workers)) and time.monotonic() < until:
        time.sleep(0.02)
    assert not any(map(alive, workers))


def alive(process: int) -> bool:
    """Return whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
