"""`exover lsp`: the language server, for editors."""

import argparse
import logging

from exover.cli.status import CliError, ExitStatus

NEEDED = ("pygls", "lsprotocol")


def run(arguments: argparse.Namespace) -> int:
    """Answer an editor on standard input and output until it ends the session or closes the pipe."""
    try:
        from exover.editor.server import make
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in NEEDED:
            raise
        advice = "python -m pip install 'exover[lsp]'"
        raise CliError(f"exover lsp needs {missing.name}, which is not installed: {advice}") from missing
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    server = make()
    server.start_io()
    server.reader.shutdown(wait=False, cancel_futures=True)
    return ExitStatus.OK
