"""`exover lsp`: the language server, for editors."""

import argparse
import logging
import os
import re
import signal
import sys
from contextlib import suppress
from io import BufferedReader, RawIOBase
from select import select
from types import FrameType
from typing import TYPE_CHECKING, Any, BinaryIO, cast

from exover.cli.files import standard_input
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain
from exover.ending import heeded

if TYPE_CHECKING:
    from exover.editor.server import SpecServer

NEEDED = ("pygls", "lsprotocol")
_LENGTH = re.compile(rb"Content-Length: [0-9]{1,9}\r\n\Z")


def run(arguments: argparse.Namespace) -> int:
    """Answer an editor on standard input and output until it ends the session or closes the pipe, or a signal comes."""
    server, questions = _server(), EditorInput()
    heard: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        questions.end()

    for number in heeded():
        signal.signal(number, end)
    questions.hear_signals()
    if sys.stdin is not None and sys.stdin.isatty():
        complain("exover: note: an editor is expected on standard input, which is a terminal; Ctrl-C ends this")
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    server.start_io(Messages(questions), cast(BinaryIO, Answers()))
    server.reader.shutdown(wait=False, cancel_futures=True)
    if not heard:
        return ExitStatus.OK
    return ExitStatus.INTERRUPTED if heard[0] == signal.SIGINT else ExitStatus.TERMINATED


def _server() -> "SpecServer":
    try:
        from exover.editor.server import make
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in NEEDED:
            raise
        advice = "python -m pip install 'exover[lsp]'"
        raise CliError(f"exover lsp needs {missing.name}, which is not installed: {advice}") from missing
    return make()


class Messages(BufferedReader):
    """The messages of an editor, of which the headers that cannot be read, or tell of absurd sizes, say nothing."""

    def readline(self, size: int | None = -1, /) -> bytes:
        """Return the next line of a header.

        Before the length of a message may stand the content of one whose own length could not be read.
        """
        line = super().readline(size)
        found = _LENGTH.search(line)
        return found[0] if found else (line if not line.strip() else b"-\r\n")


class EditorInput(RawIOBase):
    """Standard input, up to its end or up to a call of `end`, which wakes a thread that waits for input.

    On Windows, which cannot wait for both, the call takes effect at the next message.
    """

    def __init__(self) -> None:
        self._source = standard_input().fileno()
        self._woken, self._wake = os.pipe()

    def hear_signals(self) -> None:
        """Let a signal wake the waiting thread at once.

        The handler in Python runs only when the main thread runs, which may be about to wait.
        """
        if sys.platform != "win32":
            os.set_blocking(self._wake, False)
            signal.set_wakeup_fd(self._wake, warn_on_full_buffer=False)

    def readable(self) -> bool:
        """Return true."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Wait for input, read what is available, and return the number of bytes; 0 at the end."""
        if sys.platform != "win32":
            ready, _, _ = select([self._source, self._woken], [], [])
            if self._woken in ready:
                return 0
        found = os.read(self._source, len(buffer))
        buffer[: len(found)] = found
        return len(found)

    def end(self) -> None:
        """End the input: wake the thread that waits for it."""
        os.write(self._wake, b"\0")


class Answers(RawIOBase):
    """Standard output, on which a broken pipe is no error."""

    def __init__(self) -> None:
        if sys.stdout is None:
            raise CliError("cannot write to standard output: it is closed")
        self._out = sys.stdout.buffer

    def writable(self) -> bool:
        """Return true."""
        return True

    def write(self, data: Any) -> int:
        """Write a whole message and flush it."""
        with suppress(BrokenPipeError):
            self._out.write(data)
            self._out.flush()
        return len(data)
