"""`exover lsp`: the language server, for editors."""

import argparse
import logging
import os
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
from exover.engines.process import ENDING

if TYPE_CHECKING:
    from exover.editor.server import SpecServer

NEEDED = ("pygls", "lsprotocol")


def run(arguments: argparse.Namespace) -> int:
    """Answer an editor on standard input and output until it ends the session or closes the pipe, or a signal comes."""
    server, questions = _server(), EditorInput()
    heard: list[int] = []

    def end(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        questions.end()

    for number in ENDING:
        signal.signal(number, end)
    questions.hear_signals()
    if sys.stdin is not None and sys.stdin.isatty():
        complain("exover: note: an editor is expected on standard input, which is a terminal; Ctrl-C ends this")
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    server.start_io(BufferedReader(questions), cast(BinaryIO, Answers()))
    server.reader.shutdown(wait=False, cancel_futures=True)
    return 128 + heard[0] if heard else ExitStatus.OK


def _server() -> "SpecServer":
    try:
        from exover.editor.server import make
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in NEEDED:
            raise
        advice = "python -m pip install 'exover[lsp]'"
        raise CliError(f"exover lsp needs {missing.name}, which is not installed: {advice}") from missing
    return make()


class EditorInput(RawIOBase):
    """Standard input, until that ends or this is to `end`, which a thread hears that waits for more.

    Where the system cannot wait for both (Windows) it is heard at the next question.
    """

    def hear_signals(self) -> None:
        """Let a signal be an end as soon as it comes.

        What Python calls for it is called only once the main thread does something, which may be about to wait.
        """
        if sys.platform != "win32":
            os.set_blocking(self._wake, False)
            signal.set_wakeup_fd(self._wake, warn_on_full_buffer=False)

    def __init__(self) -> None:
        self._source = standard_input().fileno()
        self._woken, self._wake = os.pipe()

    def readable(self) -> bool:
        """Return true."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read what there is, once there is something; return how many bytes that are, 0 at the end."""
        if sys.platform != "win32":
            ready, _, _ = select([self._source, self._woken], [], [])
            if self._woken in ready:
                return 0
        found = os.read(self._source, len(buffer))
        buffer[: len(found)] = found
        return len(found)

    def end(self) -> None:
        """Let no more be read."""
        os.write(self._wake, b"\0")


class Answers(RawIOBase):
    """Standard output, as long as somebody reads there; what is written then goes nowhere."""

    def __init__(self) -> None:
        if sys.stdout is None:
            raise CliError("cannot write to standard output: it is closed")
        self._out = sys.stdout.buffer

    def writable(self) -> bool:
        """Return true."""
        return True

    def write(self, data: Any) -> int:
        """Write a message whole, at once."""
        with suppress(BrokenPipeError):
            self._out.write(data)
            self._out.flush()
        return len(data)
