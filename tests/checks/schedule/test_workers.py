"""Questions asked in processes: the same answers for any number, kept limits, and nobody left behind."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import pytest

from exover.checks.finding import Finding
from exover.checks.questions import safety
from exover.checks.questions.question import Check, Context, Question, requests
from exover.checks.run import CheckOutcome
from exover.checks.schedule import agenda, plan, workers
from exover.checks.schedule.agenda import GROWTH, LEAST, LONGEST, MOST, Agenda, Lot, Turn
from exover.checks.schedule.workers import GAVE_UP, HALTED, Lost, WorkerFault, alone, spread
from exover.engines.process import BEHIND
from exover.limits import Limits, limits_from
from tests.checks.work import built, silent
from tests.support.diagrams import check_by_diagrams
from tests.support.hanging import HANG, hang

ROOT = Path(__file__).resolve().parents[3]
SPEC = """spec demo;
module m { request a(); request b(); request c(); }
mutex m.a, m.b by wait;
"""
Progress = Callable[[str], None]
Say = Callable[[int, object], None]


def from_now(jobs: int, seconds: float | None) -> Limits:
    return limits_from(time.monotonic(), jobs, seconds)


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


# ---- turns ----


@pytest.fixture
def skip(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Return what moves the clock on by which turns are measured; a first slice is 20 s, which no test needs."""
    skipped: list[float] = []
    monkeypatch.setattr(workers, "monotonic", lambda: time.monotonic() + sum(skipped))
    monkeypatch.setattr(agenda, "MOST", 20.0)
    return skipped.append


def await_file(file: Path) -> None:
    """Wait until another process has made a file."""
    while not file.exists():
        time.sleep(0.01)


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


# ---- batches ----


def batch(turn: Turn, say: Say, progress: Progress) -> None:
    """Answer 0, 2, 4, … of what is asked at once, give up the rest; of one question, give its number."""
    if len(turn.numbers) == 1:
        say(turn.numbers[0], turn.numbers[0])
        return
    for number in reversed(turn.numbers):
        progress(f"batch {number}")
        say(number, number if number % 2 == 0 else Lost("no idea"))


@pytest.mark.parametrize(("jobs", "seconds"), [(1, None), (2, None), (2, 600.0)])
def test_what_a_batch_leaves_unknown_another_is_asked(jobs: int, seconds: float | None) -> None:
    limits = from_now(jobs, seconds)
    agenda = Agenda([Lot(range(4), together=True), Lot(range(4, 8))], limits.seconds, {n: n + 4 for n in range(4)})
    found = told(batch, agenda, limits)
    assert found == {0: 0, 1: Lost("no idea"), 2: 2, 3: Lost("no idea"), 5: 5, 7: 7}
    assert next(iter(found)) == 3


def test_answers_of_a_batch_are_taken_as_they_fall(tmp_path: Path) -> None:
    """Each is said when that before it has been taken, and tells whether it has."""

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        before = True
        for number in turn.numbers:
            say(number, before)
            until = time.monotonic() + 20
            while not (tmp_path / str(number)).exists() and time.monotonic() < until:
                time.sleep(0.01)
            before = (tmp_path / str(number)).exists()

    heard: dict[int, object] = {}

    def take(number: int, answer: object) -> bool:
        heard[number] = answer
        (tmp_path / str(number)).touch()
        return False

    spread(work, Agenda([Lot(range(3), together=True)]), Limits(2), silent, take)
    assert heard == {0: True, 1: True, 2: True}


def test_what_a_batch_has_said_stays_when_it_falls_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exover.checks.schedule.agenda.LONGEST", LEAST)

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        if turn.numbers[0] >= 4:
            say(turn.numbers[0], "another")
            return
        for number in turn.numbers[:2]:
            say(number, "batch")
        hang()

    agenda = Agenda([Lot(range(4), together=True), Lot(range(4, 8))], 100.0, {n: n + 4 for n in range(4)})
    assert told(work, agenda, from_now(1, 100)) == {0: "batch", 1: "batch", 6: "another", 7: "another"}


@pytest.mark.skipif(not hasattr(os, "getpriority"), reason="the system has no priorities")
def test_who_is_asked_beside_a_batch_comes_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exover.checks.schedule.agenda.LONGEST", LEAST)

    def priority() -> int:
        return os.getpriority(os.PRIO_PROCESS, 0)

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        if turn.together:
            say(turn.numbers[0], priority())
            hang()
        say(turn.numbers[0], priority())

    agenda = Agenda([Lot(range(3), together=True), Lot(range(3, 6))], 100.0, {n: n + 3 for n in range(3)})
    ours, later = priority(), min(priority() + BEHIND, 19)
    assert told(work, agenda, from_now(2, 100)) == {0: ours, 4: later, 5: later}


def test_a_batch_may_take_its_time_for_each_answer(
    tmp_path: Path, skip: Callable[[float], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """For all of them it needs more than half of the time, and keeps nobody from a place."""
    found: dict[int, object] = {}
    fresh: list[int] = []
    heard: list[int] = []
    """What was answered before the parent looked last who is too slow; `fresh`: what was answered since."""

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        for number in turn.numbers:
            say(number, "batch" if turn.together else "another")
            if turn.together:
                await_file(tmp_path / str(number))

    def take(number: int, answer: object) -> bool:
        found[number] = answer
        skip(12.0)
        fresh.append(number)
        return False

    def looked() -> None:
        for number in heard:
            (tmp_path / str(number)).touch()
        heard[:], fresh[:] = fresh, ()

    monkeypatch.setattr(workers, "PULSE", 0.01)
    agenda = Agenda([Lot(range(12), together=True), Lot(range(12, 24))], 240.0, {n: n + 12 for n in range(12)})
    spread(work, agenda, from_now(2, 240), silent, take, looked)
    assert found == dict.fromkeys(range(12), "batch")


def test_what_a_process_wrote_that_is_ended_is_gone() -> None:
    def work(turn: Turn, say: Say, progress: Progress) -> None:
        say(0, tempfile.mkdtemp(prefix="exover-"))
        hang()

    found = told(work, Agenda([Lot(range(2), together=True)], 1.0), from_now(1, 1.0))
    folder = Path(str(found[0]))
    assert folder.name.startswith("exover-") and not folder.parent.exists()
    assert str(folder.parent) != tempfile.gettempdir()


def test_a_batch_keeps_its_place_while_another_serves_those_who_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ends when one of them has been answered, and another has been halted, since it was too slow as well."""
    found: dict[int, object] = {}
    halted: set[bool] = set()
    put_off = workers._Pool._put_off

    def noted(pool: Any, worker: Any) -> None:
        halted.add(worker.turn.together)
        put_off(pool, worker)
        end()

    def take(number: int, answer: object) -> bool:
        found[number] = answer
        end()
        return False

    def end() -> None:
        if halted and 4 in found:
            (tmp_path / "end").touch()

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        if turn.numbers == (4,):
            say(4, "another")
        elif turn.numbers[0] > 4:
            hang()
        else:
            await_file(tmp_path / "end")
            for number in turn.numbers:
                say(number, "batch")

    monkeypatch.setattr(workers._Pool, "_put_off", noted)
    monkeypatch.setattr("exover.checks.schedule.agenda.LONGEST", LEAST)
    others = [Lot((number,)) for number in range(4, 8)]
    agenda = Agenda([Lot(range(4), together=True), *others], 100.0, {n: n + 4 for n in range(4)})
    spread(work, agenda, from_now(2, 100), silent, take)
    assert found == {4: "another", 1: "batch", 2: "batch", 3: "batch"}
    assert halted == {False}


def test_two_may_say_the_same_in_the_same_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    met: list[object] = []

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        say(turn.numbers[0], "said")

    def together(channels: list[Connection], seconds: float) -> list[object]:
        """Hear nobody before both have said it."""
        found = list(wait(channels, 0.01))
        if len(found) == 2:
            met.extend(found)
        return found if met else []

    monkeypatch.setattr(workers, "wait", together)
    monkeypatch.setattr("exover.checks.schedule.agenda.LONGEST", LEAST)
    agenda = Agenda([Lot((0,), together=True), Lot((1,))], 100.0, {0: 1})
    found = told(work, agenda, from_now(2, 100))
    assert met and list(found.values()) == ["said"]


def test_a_batch_gets_half_of_the_time_of_one_process() -> None:
    agenda = Agenda([Lot((0,), together=True), *(Lot((number,)) for number in range(1, 9))], 60.0)
    spent, left = {True: 0.0, False: 0.0}, 60.0
    while left > 0:
        turn = agenda.next(left)
        assert turn is not None
        agenda.late(turn.numbers)
        spent[turn.together] += turn.seconds
        left -= turn.seconds
    assert spent[True] >= 24
    assert spent[False] >= 24


def test_a_batch_that_takes_turns_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It ends when it has been halted twice."""
    halts: list[bool] = []
    put_off = workers._Pool._put_off

    def noted(pool: Any, worker: Any) -> None:
        put_off(pool, worker)
        halts.append(worker.turn.together)
        if halts.count(True) == 2:
            (tmp_path / "end").touch()

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        if turn.numbers[0] and not (tmp_path / "end").exists():
            hang()
        if not turn.numbers[0]:
            progress("batch")
            await_file(tmp_path / "end")
        say(turn.numbers[0], "said")

    monkeypatch.setattr(workers._Pool, "_put_off", noted)
    monkeypatch.setattr(agenda, "MOST", LEAST)
    monkeypatch.setattr(agenda, "LONGEST", LEAST)
    began: list[str] = []
    lots = [Lot((0,), together=True), *(Lot((number,)) for number in range(1, 9))]
    found: dict[int, object] = {}

    def take(number: int, answer: object) -> bool:
        found[number] = answer
        if number == 0:
            raise KeyboardInterrupt  # the others need not be waited for
        return False

    with pytest.raises(KeyboardInterrupt):
        spread(work, Agenda(lots, 100.0), from_now(1, 100), began.append, take)
    assert found[0] == "said"
    assert began == ["batch"]


@pytest.mark.parametrize("seconds", [None, 60.0])
def test_what_a_batch_leaves_unknown_another_is_asked_at_once(tmp_path: Path, seconds: float | None) -> None:
    asked = tmp_path / "asked"

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        if turn.numbers == (2,):
            asked.touch()
            say(2, "another")
            return
        say(0, Lost("no idea"))
        until = time.monotonic() + 10
        while not asked.exists() and time.monotonic() < until:
            time.sleep(0.01)
        say(1, asked.exists())

    agenda = Agenda([Lot(range(2), together=True), Lot(range(2, 4))], seconds, {0: 2, 1: 3})
    found = told(work, agenda, from_now(2, seconds))
    assert found == {0: Lost("no idea"), 2: "another", 1: True}


def test_a_batch_that_dies_is_asked_again_only_if_it_had_answers() -> None:
    def work(turn: Turn, say: Say, progress: Progress) -> None:
        for number in turn.numbers:
            if number in (2, 4):
                os._exit(7)
            say(number, number)

    ended = Lost("its process ended with status 7")
    found = told(work, Agenda([Lot(range(7), together=True)]), Limits(2))
    assert found == {0: 0, 1: 1, 2: ended, 3: 3, 4: ended, 5: 5, 6: 6}
    found = told(work, Agenda([Lot(range(2, 5), together=True)]), Limits(2))
    assert found == {2: ended, 3: ended, 4: ended}


def test_what_is_left_unsaid_needs_more_time_or_is_given_up(skip: Callable[[float], None]) -> None:
    """At first the question 0 takes 16 of the 20 s of its slice, and 1 next to nothing."""

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        (number,) = turn.numbers
        progress(f"{number}")
        if number == 2 or turn.seconds > 20:
            say(number, number)

    began: list[str] = []

    def note(text: str) -> None:
        began.append(text)
        if began == ["0"]:
            skip(16.0)

    found = told(work, Agenda(lots("a", "b", "c"), 240.0), from_now(1, 240), note)
    assert found == {0: 0, 1: Lost(GAVE_UP), 2: 2}
    assert began == ["0", "1", "2", "0"]


def test_one_after_the_other_in_this_process() -> None:
    process = os.getpid()
    found: dict[int, object] = {}

    def work(turn: Turn, say: Say, progress: Progress) -> None:
        assert os.getpid() == process
        if 5 in turn.numbers:
            raise MemoryError
        batch(turn, say, progress)

    def take(number: int, answer: object) -> bool:
        found[number] = answer
        return lost(answer)

    agenda = Agenda([Lot(range(4), together=True), Lot(range(4, 8))], None, {n: n + 4 for n in range(4)})
    alone(work, agenda, silent, take)
    assert found == {0: 0, 1: Lost("no idea"), 2: 2, 3: Lost("no idea"), 5: Lost("not enough memory"), 7: 7}


# ---- agenda ----


def one(number: int, seconds: float) -> Turn:
    return Turn((number,), seconds, seconds)


def test_without_a_limit_all_are_asked_in_order() -> None:
    agenda = Agenda(lots("a", "b", "a"))
    assert [agenda.next(float("inf")) for _ in range(4)] == [*(one(n, float("inf")) for n in (0, 2, 1)), None]


def test_what_weighs_more_is_asked_first() -> None:
    agenda = Agenda([Lot((0, 1), 1), Lot((2,), 2), Lot((3,), 0)])
    assert [turn.numbers for _ in range(4) if (turn := agenda.next(9.0))] == [(3,), (0,), (1,), (2,)]


def test_every_question_gets_a_slice_before_any_gets_a_second() -> None:
    agenda = Agenda(lots("slow", "slow", "quick", "dull"), 120.0)
    assert agenda.next(120.0) == one(0, MOST)
    agenda.late((0,))
    assert agenda.next(119.0) == one(2, MOST)
    agenda.answered(2, in_vain=False)
    assert agenda.next(119.0) == one(3, MOST)
    agenda.late((3,))
    # The next round: what was never asked, then what was.
    assert agenda.next(100.0) == one(1, 4 * MOST)
    agenda.answered(1, in_vain=False)
    assert agenda.next(99.0) == one(0, 4 * MOST)
    agenda.late((0,))
    assert agenda.next(90.0) == one(3, 4 * MOST)
    agenda.late((3,))
    assert agenda.next(80.0) == one(0, 16 * MOST)
    agenda.late((0,))
    assert agenda.next(5.0) == one(3, 5.0)
    agenda.answered(3, in_vain=False)
    agenda.answered(0, in_vain=True)
    assert not agenda.waits
    assert agenda.next(1.0) is None


def test_what_was_never_asked_comes_before_what_was() -> None:
    agenda = Agenda(lots("slow", "dull", "dull"), 120.0)
    assert agenda.next(120.0) == one(0, MOST)
    agenda.late((0,))
    assert agenda.next(119.0) == one(1, MOST)
    agenda.late((1,))
    assert agenda.next(118.0) == one(2, 4 * MOST)
    assert agenda.next(118.0) == one(0, 4 * MOST)


def test_every_question_gets_the_time_that_a_process_needs_to_begin() -> None:
    assert Agenda(lots("a", "b"), 0.5).next(0.5) == one(0, LEAST)
    assert Agenda(lots("a", "b"), 0.5).next(0.1) == one(0, 0.1)


def test_a_question_that_is_asked_instead_waits_for_its_turn() -> None:
    agenda = Agenda(lots("a", "b", "z a", "z b"), instead={0: 2, 1: 3})
    assert agenda.next(9.0) == one(0, 9.0)
    assert agenda.answered(0, in_vain=True) == (0,)
    assert agenda.next(7.0) == one(1, 7.0)
    assert agenda.answered(1, in_vain=False) == (1, 3)
    assert agenda.next(7.0) == one(2, 7.0)
    assert agenda.answered(2, in_vain=True) == (2,)
    assert agenda.next(6.0) is None
    assert agenda.over == {0, 1, 2, 3}


def test_any_answer_ends_the_question_for_all() -> None:
    for who in (0, 1, 2):
        agenda = Agenda(lots("a", "y", "z"), 80.0, {0: 1, 1: 2})
        assert agenda.next(80.0) == one(0, MOST)
        agenda.late((0,))
        assert agenda.next(79.0) == one(1, MOST)
        agenda.late((1,))
        assert agenda.next(78.0) == one(2, MOST)
        assert agenda.answered(who, in_vain=False) == (0, 1, 2)
        assert agenda.next(70.0) is None


def test_what_is_asked_at_once_waits_for_all_of_it() -> None:
    agenda = Agenda([Lot((0, 1)), Lot((2, 3), together=True)], instead={0: 2, 1: 3})
    assert agenda.next(9.0) == one(0, 9.0)
    agenda.answered(0, in_vain=True)
    assert agenda.next(9.0) == one(1, 9.0)
    assert agenda.next(9.0) is None
    agenda.answered(1, in_vain=True)
    assert agenda.next(9.0) == Turn((2, 3), 9.0, 9.0, together=True)


def test_what_is_asked_at_once_takes_turns_with_all_the_others() -> None:
    agenda = Agenda([Lot((0, 1), together=True), *(Lot((number,)) for number in range(2, 9))], 600.0)
    assert agenda.next(600.0) == Turn((0, 1), LONGEST, 300.0, together=True)
    agenda.late((0, 1))
    assert agenda.next(570.0) == one(2, MOST)
    agenda.answered(2, in_vain=False)
    assert agenda.next(560.0) == one(3, MOST)
    agenda.late((3,))
    assert agenda.next(540.0) == Turn((0, 1), GROWTH * LONGEST, 270.0, together=True)
    agenda.answered(0, in_vain=False)
    agenda.late((1,))
    assert agenda.next(450.0) == one(4, MOST)
    agenda.late((4,))
    assert agenda.next(300.0) == Turn((1,), 150.0, 150.0, together=True)
    agenda.late((1,))
    assert agenda.next(150.0) == one(5, MOST)
    agenda.late((5,))
    assert agenda.next(100.0) == one(6, MOST)
    agenda.late((6,))
    assert agenda.next(50.0) == Turn((1,), LONGEST, LONGEST, together=True)


def test_what_is_asked_at_once_first_gets_a_quarter_of_the_time() -> None:
    """So that in a time limit of seconds others are asked, too, and none does again what is all but done."""
    for seconds, stretch in ((1.0, 0.25), (20.0, 5.0), (60.0, 15.0)):
        turn = Agenda([Lot((0,), together=True), Lot((1,))], seconds, {0: 1}).next(seconds)
        assert turn == Turn((0,), stretch, seconds / 2, together=True)


def test_others_try_errors_first_of_what_takes_long_at_once() -> None:
    lots = [Lot(range(3), together=True), Lot((3,), 1), Lot((4, 5), 0)]
    agenda = Agenda(lots, 60.0, {n: n + 3 for n in range(3)})
    assert agenda.next(60.0) == Turn((0, 1, 2), 15.0, 30.0, together=True)
    assert agenda.next(60.0) is None
    agenda.answered(2, in_vain=True)
    assert agenda.next(60.0) == one(5, MOST)
    agenda.call((0, 1))
    assert agenda.next(59.0) == one(4, MOST)
    assert agenda.next(59.0) == one(3, MOST)


FULL = """
import resource
from exover.checks.schedule.serving import is_memory
strange = AttributeError("what a library that is loaded in part raises")
assert not is_memory(strange, limited=True)
resource.setrlimit(resource.RLIMIT_AS, (1 << 20, resource.RLIM_INFINITY))
assert is_memory(strange, limited=True)
assert not is_memory(strange)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux alone")
def test_whatever_is_raised_where_no_memory_is_left_is_for_want_of_it() -> None:
    done = subprocess.run([sys.executable, "-c", FULL], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
