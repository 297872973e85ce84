"""`exover lsp`: the language server, for editors."""

import argparse
import logging
import sys
from contextlib import suppress
from io import RawIOBase
from typing import TYPE_CHECKING, Any, BinaryIO, cast

from exover.cli.files import standard_input
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain

if TYPE_CHECKING:
    from exover.editor.server import SpecServer

NEEDED = ("pygls", "lsprotocol")


def run(arguments: argparse.Namespace) -> int:
    """Answer an editor on standard input and output until it ends the session or closes the pipe."""
    server = _server()
    if sys.stdin is not None and sys.stdin.isatty():
        complain("exover: note: an editor is expected on standard input, which is a terminal; Ctrl-C ends this")
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    server.start_io(standard_input(), cast(BinaryIO, Answers()))
    server.reader.shutdown(wait=False, cancel_futures=True)
    return ExitStatus.OK


def _server() -> "SpecServer":
    try:
        from exover.editor.server import make
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in NEEDED:
            raise
        advice = "python -m pip install 'exover[lsp]'"
        raise CliError(f"exover lsp needs {missing.name}, which is not installed: {advice}") from missing
    return make()


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
