"""The log of a gate's decisions, as JSON lines in a file; a file that cannot be written does not stop the gate."""

import errno
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from time import time

from exover.gate.gate import Journal, Tell

Take = Callable[[bytes], None]
"""Takes a line, with its line end."""
UNREAD = {errno.EAGAIN: "what it holds is not read", errno.ENXIO: "nobody reads it"}
"""Why a pipe cannot be written, by error number."""


def no_journal(entry: str) -> None:
    """Discard an entry."""


def stamped(*takers: Take, clock: Callable[[], float] = time) -> Journal:
    """Return a journal that gives each entry, as a line with its time, to the takers in order."""

    def journal(entry: str) -> None:
        line = _stamped(entry, clock())
        for take in takers:
            take(line)

    return journal


class JournalFile:
    """Appends each line, whole or not at all, before the call returns; raises `OSError` only when it is made.

    It waits for no reader of a pipe. Part of a line stays, and is ended by a line end, if another process has written
    behind it or if it is in a pipe. Lines that cannot be written are counted, the first of them is told, and
    their number is written before the next line that can be.
    """

    def __init__(self, path: str, tell: Tell) -> None:
        self._path = path
        self._tell = tell
        self._file = _opened(path)
        self._lost = 0
        self._begun = b"" if _ends_whole(path) else b"\n"
        """What ends the half of a line that was in the file before."""

    def __call__(self, line: bytes) -> None:
        """Write a line."""
        note = _stamped(f'{{"lost": {self._lost}}}', time()) if self._lost else b""
        try:
            self._write(self._begun + note + line)
        except OSError as error:
            if not self._lost:
                reason = UNREAD.get(error.errno or 0, error.strerror)
                self._tell(f"cannot write {self._path}: {reason}; decisions go on, and are not in it")
            self._lost += 1
        else:
            self._lost, self._begun = 0, b""

    def _write(self, data: bytes) -> None:
        written = os.write(self._file, data)
        if written == len(data):
            return
        if not stat.S_ISREG(os.fstat(self._file).st_mode):  # nothing is taken back: the next line ends this one
            self._begun = b"\n"
            raise OSError(errno.EAGAIN, UNREAD[errno.EAGAIN])
        with suppress(OSError):
            end = os.lseek(self._file, 0, os.SEEK_CUR)
            if os.fstat(self._file).st_size == end:  # else another process has written behind it
                os.ftruncate(self._file, end - written)
        raise OSError(errno.ENOSPC, "no space is left on the device")

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


def _opened(path: str) -> int:
    """Return the descriptor of a file, to append to it without waiting for the reader of a pipe.

    Raises `OSError`, also if it is a pipe that nobody reads.
    """
    without_waiting = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
    try:
        return os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | without_waiting, 0o644)
    except OSError as error:
        raise OSError(error.errno, UNREAD.get(error.errno or 0, error.strerror), path) from error


def _ends_whole(path: str) -> bool:
    """Return whether a file ends with a line end or is empty; True if that cannot be found out, as of a pipe."""
    if os.path.isfile(path):
        with suppress(OSError), open(path, "rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - 1))
            return file.read(1) in (b"", b"\n")
    return True


def _stamped(entry: str, now: float) -> bytes:
    """Return an entry with its time as a line; a lone surrogate in a string is written as `\\udxxx`."""
    return f'{{"time": {round(now, 6)!r}, {entry[1:]}\n'.encode("utf-8", "backslashreplace")
