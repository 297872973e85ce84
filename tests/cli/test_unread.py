"""Messages that nobody reads: whoever writes them does not wait, and what does not fit is counted."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from exover.cli import unread
from exover.cli.unread import MessageWriter

PATIENCE = 20.0
BIG = 1 << 20


@contextmanager
def pipe(waits: bool = True) -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    os.set_blocking(writing, waits)
    try:
        yield reading, writing
    finally:
        os.close(reading)
        os.close(writing)


def lost(number: int) -> str:
    return f"lost {number}\n"


def read(file: int, end: str) -> str:
    said = b""
    while not said.decode().endswith(end):
        said += os.read(file, BIG)
    return said.decode()


def test_all_is_written_in_order() -> None:
    with pipe() as (reading, writing):
        writer = MessageWriter(writing, "utf-8", lost)
        for number in range(100):
            writer(f"é {number}\n")
        assert writer.close(PATIENCE)
        assert read(reading, "99\n") == "".join(f"é {number}\n" for number in range(100))


@pytest.mark.parametrize("waits", (True, False))
def test_what_does_not_fit_is_dropped_and_counted_where_it_would_stand(
    monkeypatch: pytest.MonkeyPatch, waits: bool
) -> None:
    monkeypatch.setattr(unread, "MOST", 2 * BIG)
    with pipe(waits) as (reading, writing):
        writer = MessageWriter(writing, "ascii", lost)
        for text in ("a" * BIG, "b" * BIG, "c", "d"):
            writer(f"{text}\n")
        assert not writer.close(0.01)
        assert read(reading, "lost 3\n") == "a" * BIG + "\nlost 3\n"
        assert writer.close(PATIENCE)


def test_a_text_that_is_too_long_is_written_if_nothing_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unread, "MOST", 2)
    with pipe() as (reading, writing):
        writer = MessageWriter(writing, "ascii", lost)
        writer("very long é\n")
        assert writer.close(PATIENCE)
        assert read(reading, "\n") == "very long \\xe9\n"


def test_a_stream_that_is_closed_is_no_fault() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    writer = MessageWriter(writing, "utf-8", lost)
    writer("a\n")
    assert writer.close(PATIENCE)
    os.close(writing)
