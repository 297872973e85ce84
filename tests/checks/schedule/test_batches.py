"""Questions asked at once in one process, with others asked beside it."""

import os
import tempfile
import time
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import pytest

from exover.checks.schedule import agenda, workers
from exover.checks.schedule.agenda import LEAST, Agenda, Lot, Turn
from exover.checks.schedule.workers import GAVE_UP, Lost, alone, spread
from exover.engines.process import BEHIND
from exover.limits import Limits
from tests.checks.schedule.spreading import Progress, Say, await_file, from_now, lost, lots, told
from tests.checks.work import silent
from tests.support.hanging import hang

pytestmark = pytest.mark.usefixtures("nobody_is_left")


@pytest.fixture
def skip(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Return what moves the clock on by which turns are measured; a first slice is 20 s, which no test needs."""
    skipped: list[float] = []
    monkeypatch.setattr(workers, "monotonic", lambda: time.monotonic() + sum(skipped))
    monkeypatch.setattr(agenda, "MOST", 20.0)
    return skipped.append


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
