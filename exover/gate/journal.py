"""What a gate has decided, as JSON lines in a file; a file that cannot be written stops nobody."""

import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from time import time
from typing import Any

from exover.gate.gate import Journal
from exover.model.wire import escaped

Complaint = Callable[[str], None]


def no_journal(entry: Mapping[str, Any]) -> None:
    """Take an entry that nobody wants."""


class WrittenEntry(dict[str, Any]):
    """An entry with its time that was written as a line before."""

    line: str = ""


class JournalFile:
    """Appends each entry with its time, whole or not at all, before it returns; raises `OSError` only when it is made.

    What cannot be written is counted, told once, and noted before the next line that can be written.
    """

    def __init__(self, path: str, complain: Complaint, clock: Callable[[], float] = time) -> None:
        self._path = path
        self._complain = complain
        self._clock = clock
        self._file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o644)
        self._lost = 0

    def __call__(self, entry: Mapping[str, Any]) -> None:
        """Write an entry."""
        now = round(self._clock(), 6)
        notes = [{"time": now, "lost": self._lost}] if self._lost else []
        try:
            written = entry.line if isinstance(entry, WrittenEntry) else _line({"time": now, **entry})
            self._write("".join((*map(_line, notes), written)).encode())
        except OSError as error:
            if not self._lost:
                self._complain(f"cannot write {self._path}: {error.strerror}; decisions go on, and are not in it")
            self._lost += 1
        else:
            self._lost = 0

    def _write(self, data: bytes) -> None:
        written = os.write(self._file, data)
        if written == len(data):
            return
        with suppress(OSError):  # it is a pipe or a device
            os.ftruncate(self._file, os.fstat(self._file).st_size - written)
        raise OSError(28, "no space is left on the device")

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


def published(journal: Journal, publish: Callable[[str], None], clock: Callable[[], float] = time) -> Journal:
    """Return a journal that gives each entry, as its line with its time, to `publish`, and then to another journal."""

    def take(entry: Mapping[str, Any]) -> None:
        stamped = WrittenEntry(time=round(clock(), 6), **entry)
        stamped.line = _line(stamped)
        publish(stamped.line[:-1])
        journal(stamped)

    return take


def _line(entry: Mapping[str, Any]) -> str:
    return escaped(_ENCODER.encode(entry)) + "\n"


_ENCODER = json.JSONEncoder(ensure_ascii=False)
