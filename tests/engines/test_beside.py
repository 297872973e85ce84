"""Work beside ours says the same wherever it is done, and leaves no process behind."""

import os
import signal
import tempfile
from errno import EAGAIN
from pathlib import Path
from select import select
from signal import pause
from threading import Thread

import pytest

from exover.engines import beside
from exover.engines.beside import Beside, Say, hear_all, step_back_if_apart
from exover.engines.process import BEHIND

APART = [False, True]
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="the system forks no process")


def count(say: Say[int]) -> None:
    for number in range(1000):
        say(number)


@pytest.mark.parametrize("apart", APART)
def test_all_that_it_says_is_heard_in_order(apart: bool) -> None:
    heard: list[int] = []
    with Beside(count, apart) as beside:
        assert heard == []
        beside.hear(heard.append)
    assert heard == list(range(1000))


@pytest.mark.parametrize("apart", APART)
def test_a_process_of_its_own_where_there_is_one(apart: bool) -> None:
    heard: list[int] = []
    with Beside[int](lambda say: say(os.getpid()), apart) as beside:
        beside.hear(heard.append)
    assert (heard[0] != os.getpid()) == apart
    assert apart == _is_gone(heard[0])


@pytest.mark.parametrize("apart", APART)
def test_work_steps_back_in_a_process_of_its_own_alone(apart: bool) -> None:
    def work(say: Say[int]) -> None:
        step_back_if_apart()
        say(os.getpriority(os.PRIO_PROCESS, 0))

    ours = os.getpriority(os.PRIO_PROCESS, 0)
    heard: list[int] = []
    with Beside(work, apart) as beside:
        beside.hear(heard.append)
    assert heard == [min(ours + BEHIND, 19) if apart else ours]
    assert os.getpriority(os.PRIO_PROCESS, 0) == ours


def test_much_is_said_before_anybody_hears_it() -> None:
    """The body waits for the work to end: it does, though nobody has heard a message of it."""
    read, write = os.pipe()

    def work(say: Say[bytes]) -> None:
        for _ in range(100):
            say(bytes(10_000))
        os.write(write, b".")

    heard: list[bytes] = []
    with Beside(work, apart=True) as beside:
        assert os.read(read, 1) == b"."
        beside.hear(heard.append)
    assert heard == [bytes(10_000)] * 100
    os.close(read)
    os.close(write)


def test_what_is_said_by_now_is_overheard_and_not_heard_again() -> None:
    read, write = os.pipe()
    heard: list[int] = []

    def work(say: Say[int]) -> None:
        say(1)
        assert os.read(read, 1) == b"."
        say(2)

    with Beside(work, apart=True) as beside:
        while not heard:
            beside.overhear(heard.append)
        os.write(write, b".")
        beside.hear(heard.append)
        beside.overhear(heard.append)
    assert heard == [1, 2]
    os.close(read)
    os.close(write)


def test_nothing_is_overheard_of_what_is_done_later() -> None:
    heard: list[int] = []
    with Beside(count, apart=False) as beside:
        beside.overhear(heard.append)
        assert not heard
        beside.hear(heard.append)
    assert heard == list(range(1000))


def test_several_are_heard_as_they_say_it() -> None:
    """The first waits until something was heard of the others, the last of which goes on when all is heard."""
    read, write = os.pipe()
    said: list[str] = []

    def patient(say: Say[str]) -> None:
        for _ in range(2):
            in_time, _, _ = select([read], [], [], 30)
            say(os.read(read, 1).decode() if in_time else "late")

    def endless(say: Say[str]) -> None:
        say("c")
        pause()

    def take(each: str) -> None:
        said.append(each)
        os.write(write, each.encode())

    with (
        Beside(patient, apart=True) as first,
        Beside[str](lambda say: say("b"), apart=True) as second,
        Beside(endless, apart=True) as third,
    ):
        hear_all([(first, said.append), (second, take)], [(third, take)])
    assert sorted(said) == ["b", "b", "c", "c"]
    os.close(read)
    os.close(write)


def test_what_is_not_apart_is_done_in_turn_and_nothing_of_the_others() -> None:
    said: list[str] = []
    with (
        Beside[str](lambda say: say("a"), apart=False) as first,
        Beside[str](lambda say: say("b"), apart=False) as second,
        Beside[str](lambda say: say("c"), apart=False) as third,
    ):
        hear_all([(first, said.append), (second, said.append)], [(third, said.append)])
    assert said == ["a", "b"]


@pytest.mark.parametrize("ends_well", [True, False])
def test_how_it_ended_is_heard_though_it_was_overheard(ends_well: bool) -> None:
    ours, heard = os.getpid(), list[int]()

    def work(say: Say[int]) -> None:
        say(1)
        if os.getpid() != ours and not ends_well:
            os.kill(os.getpid(), signal.SIGKILL)

    with Beside(work, apart=True) as beside:
        beside._reader.join()
        assert [beside.overhear(heard.append) for _ in range(3)] == [True] * 3
        beside.hear(heard.append)
    assert heard == ([1] if ends_well else [1, 1])


def test_work_whose_process_dies_is_done_again() -> None:
    ours, heard = os.getpid(), list[str]()

    def work(say: Say[str]) -> None:
        say("begun")
        if os.getpid() != ours:
            os.kill(os.getpid(), signal.SIGKILL)
        say("done")

    with Beside(work, apart=True) as beside:
        beside.hear(heard.append)
    assert heard[-2:] == ["begun", "done"] and heard.count("done") == 1


@pytest.mark.parametrize("missing", ["process", "pipe", "thread"])
def test_work_is_done_in_turn_where_no_process_can_be_had(
    missing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise RuntimeError("can't start new thread") if missing == "thread" else BlockingIOError(EAGAIN, "no more")

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    where = {"process": (os, "fork"), "pipe": (beside, "Pipe"), "thread": (Thread, "start")}
    monkeypatch.setattr(*where[missing], refused)
    heard: list[int] = []
    before = _held()
    with Beside[int](lambda say: say(os.getpid()), apart=True) as work:
        assert _held() == before and not list(tmp_path.iterdir())
        assert work.overhear(heard.append) and not heard
        work.hear(heard.append)
    assert heard == [os.getpid()]


def _held() -> tuple[list[str], str]:
    """Return the open files of this process and its children."""
    return sorted(os.listdir("/proc/self/fd")), Path(f"/proc/self/task/{os.getpid()}/children").read_text()


def test_what_is_not_heard_leaves_no_file() -> None:
    def work(say: Say[str]) -> None:
        say(tempfile.mkdtemp())
        signal.pause()

    made: list[Path] = []

    def seen(folder: str) -> None:
        made.append(Path(folder))
        assert made[0].is_dir()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Beside(work, apart=True) as beside:
        beside.hear(seen)
    assert not made[0].exists()


@pytest.mark.parametrize("apart", APART)
def test_what_is_raised_is_raised_here(apart: bool) -> None:
    def work(say: Say[int]) -> None:
        raise MemoryError("none left")

    with pytest.raises(MemoryError, match="none left"), Beside(work, apart) as beside:
        beside.hear(lambda _: None)


def test_the_process_ends_where_nobody_waits_for_it() -> None:
    read, write = os.pipe()

    def work(say: Say[int]) -> None:
        os.write(write, str(os.getpid()).encode())
        signal.pause()

    with pytest.raises(KeyboardInterrupt), Beside(work, apart=True):
        child = int(os.read(read, 20))
        raise KeyboardInterrupt
    assert _is_gone(child)
    os.close(read)
    os.close(write)


def _is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False
