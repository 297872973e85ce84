"""Time limits within one process: what leaves a body that is interrupted, and what is said of it."""

import ctypes
import signal
import sys
from time import monotonic, sleep
from typing import Any, Self

import pytest

from exover.limits import NO_LIMITS, Limits, MemoryUp, TimeUp, interrupted, limits_from
from exover.ocrd.diagram import deep
from tests.support.memory import more_than_now

SOON, MUCH = 0.02, 60.0
needs_linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux alone")
needs_alarms = pytest.mark.skipif(sys.platform == "win32", reason="there are no signals for alarms")


class Converted:
    """An argument that takes long to convert."""

    @classmethod
    def from_param(cls, value: object) -> Self:
        sleep(MUCH)
        return cls()


class HalfMade:
    """An object that takes long to make, and is not ready to go before."""

    def __init__(self, seconds: float) -> None:
        sleep(seconds)
        self.made = True

    def __del__(self) -> None:
        assert self.made


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What Python would print of errors that nothing can catch."""
    found: list[Any] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda error: found.append(error.exc_type))
    return found


@needs_alarms
def test_a_body_is_interrupted() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeUp), interrupted(limits_from(monotonic(), 1, SOON)):
        while True:
            pass
    assert signal.getsignal(signal.SIGALRM) == before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    with interrupted(NO_LIMITS):
        assert signal.getsignal(signal.SIGALRM) == before


@needs_alarms
def test_what_ctypes_makes_of_it_is_that_the_time_is_over() -> None:
    function = ctypes.CFUNCTYPE(None)(lambda: None)
    function.argtypes = [Converted]
    with pytest.raises(TimeUp), interrupted(limits_from(monotonic(), 1, SOON)):
        function(0)


@needs_alarms
def test_what_python_makes_of_it_in_a_class_is_that_the_time_is_over() -> None:
    class Named:
        def __set_name__(self, owner: type, name: str) -> None:
            sleep(MUCH)

    with pytest.raises(TimeUp), interrupted(limits_from(monotonic(), 1, SOON)):
        type("Made", (), {"named": Named()})


@needs_alarms
def test_what_is_half_made_goes_in_silence(told: list[Any]) -> None:
    with pytest.raises(TimeUp), interrupted(limits_from(monotonic(), 1, SOON)):
        HalfMade(MUCH)
    assert told == []


def test_what_fails_in_time_is_told(told: list[Any]) -> None:
    with interrupted(limits_from(monotonic(), 1, MUCH)):
        half = HalfMade(0)
        del half.made, half
    assert told == [AttributeError]


def test_errors_in_time_are_what_they_are() -> None:
    with pytest.raises(ctypes.ArgumentError, match="of its own"), interrupted(limits_from(monotonic(), 1, MUCH)):
        raise ctypes.ArgumentError("of its own")


def deeper(kept: object = None) -> None:
    deeper([kept, bytearray(1 << 20)])


@needs_linux
def test_a_deep_recursion_ends_before_its_memory_does() -> None:
    memory = more_than_now(128)
    for seconds in (None, MUCH):
        limits = limits_from(monotonic(), 1, seconds, memory)
        with (
            pytest.raises(MemoryUp, match=f"^memory limit of {memory} MiB$"),
            deep(),
            interrupted(limits, of_memory=True),
        ):
            deeper()
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@needs_linux
def test_the_time_is_heard_of_where_memory_is_looked_at() -> None:
    limits = limits_from(monotonic(), 1, SOON, 1 << 30)
    with pytest.raises(TimeUp), interrupted(limits, of_memory=True):
        while True:
            pass


@needs_linux
def test_memory_is_looked_at_only_where_that_is_asked() -> None:
    with interrupted(Limits(memory=1)), interrupted(limits_from(monotonic(), 1, MUCH, 1)):
        sleep(0.2)
