"""Output to standard output and standard error, which may be closed, full, or a broken pipe."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from exover.cli.status import CliError, ExitStatus
from exover.cli.unread import MessageWriter
from exover.escaping import visible_lines

PATIENCE = 1.0
"""Seconds that messages get to be written when a service ends."""


def out(text: str) -> bool:
    """Write text to standard output at once; return False if the pipe is broken.

    Raises `CliError` if it cannot be written. The bytes are UTF-8 with plain newlines, whatever the locale says.
    """
    if sys.stdout is None:
        raise CliError("cannot write to standard output: it is closed")
    try:
        rest = memoryview(text.encode("utf-8", "backslashreplace"))
        while rest:  # an unbuffered stream may take a part only
            rest = rest[sys.stdout.buffer.write(rest) :]
        sys.stdout.buffer.flush()
    except OSError as error:
        _give_up_output()
        if isinstance(error, BrokenPipeError):
            return False
        raise CliError(f"cannot write to standard output: {error.strerror}") from error
    return True


class Complaints:
    """The number of calls of `complain` so far, and what writes them where they must not wait."""

    count = 0
    writer: MessageWriter | None = None


@contextmanager
def unwaited_complaints() -> Iterator[None]:
    """Let `complain` not wait until its messages are read: in the body, and after it if nobody reads them.

    This is for services, which nobody may hold up who does not read their standard error. What does not fit is
    counted and dropped.
    """
    try:
        file = sys.stderr.fileno()
    except (AttributeError, OSError):  # it is closed or no file, and so nobody is waited for
        yield
        return
    writer = Complaints.writer = MessageWriter(file, sys.stderr.encoding, _lost)
    try:
        yield
    finally:
        if writer.close(PATIENCE):
            Complaints.writer = None


def _lost(number: int) -> str:
    return f"exover: warning: messages lost here, since standard error was not read: {number}\n"


def complain(text: str) -> None:
    """Write text and a newline to standard error; failures are ignored.

    Further lines of an `exover: ` message are indented, so that no file name with a newline can forge a message.
    """
    Complaints.count += 1
    if text.startswith("exover: "):
        text = text.replace("\n", "\n  ")
    _to_stderr(visible_lines(text.split("\n")))


def settle(status: int) -> int:
    """Flush standard output and return the exit status: `status`, or WRONG if the output could not be written."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        _give_up_output()
    except OSError as error:
        _give_up_output()
        complain(f"exover: error: cannot write to standard output: {error.strerror}")
        return ExitStatus.WRONG
    return status


def _give_up_output() -> None:
    # What is in the buffer would fail again, with a message, when the interpreter flushes it at its end.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def _to_stderr(text: str) -> None:
    if Complaints.writer is not None:
        Complaints.writer(text)
        return
    if sys.stderr is None:
        return
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stderr.fileno())
        os.close(nowhere)


class ProgressLine:
    """A line of progress on standard error, if that is a terminal; it is erased at the end."""

    WIDTH = 79
    ERASE = "\r\x1b[K"

    def __enter__(self) -> Self:
        self._shown = sys.stderr is not None and sys.stderr.isatty()
        self._text = ""
        return self

    def __call__(self, text: str) -> None:
        """Show this text instead of the last one."""
        self.show(text)

    def show(self, text: str, above: str = "") -> None:
        """Show this text instead of the last one, and print `above`, if there is any, as a lasting line above it."""
        if self._shown and (above or text != self._text):
            self._text = text
            _to_stderr(self.ERASE)
            if above:
                complain(above)
            _to_stderr(text[: self.WIDTH])

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.show("")
