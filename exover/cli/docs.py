"""`exover docs`: print or open the pages that are installed with the command."""

import argparse
import webbrowser
from pathlib import Path

import exover
from exover.cli.files import read_text
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import out
from exover.diagnostics import did_you_mean, quote

FOLDER = Path(exover.__file__).with_name("docs")
SUFFIX = ".md"
FIRST = "index"


def run(arguments: argparse.Namespace) -> int:
    """Print the page, or open it with the program that the system has for it."""
    path = _path(arguments.page)
    if not arguments.open:
        out(read_text(str(path)))
    elif not webbrowser.open(path.as_uri()):
        raise CliError(f"no program was found that opens {path}; `exover docs {path.stem}` prints it")
    return ExitStatus.OK


def _path(page: str) -> Path:
    """Return where a page is, by its name with or without the suffix; `CliError` if there is none."""
    pages = {path.stem: path for path in FOLDER.glob(f"*{SUFFIX}")}
    if FIRST not in pages:
        raise CliError(f"the pages are not installed: {FOLDER} holds none")
    name = page.removesuffix(SUFFIX)
    if name not in pages:
        advice = did_you_mean(name, pages) or f"there are {', '.join(sorted(pages))}"
        raise CliError(f"there is no page {quote(page)}; {advice}")
    return pages[name]
