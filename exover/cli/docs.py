"""`exover docs`: print or open the pages of the documentation that are installed with the command."""

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
    """Print the page, or open it with the default program of the system."""
    path = _path(arguments.page)
    if not arguments.open:
        out(read_text(str(path)))
    elif not webbrowser.open(path.as_uri()):
        raise CliError(f"no program was found that opens {path}; `exover docs {path.stem}` prints it")
    return ExitStatus.OK


def pages() -> dict[str, Path]:
    """Return the paths of the pages by name, sorted."""
    return {path.stem: path for path in sorted(FOLDER.glob(f"*{SUFFIX}"))}


def _path(page: str) -> Path:
    """Return the path of a page, by its name with or without the suffix; `CliError` if there is none."""
    found = pages()
    if FIRST not in found:
        raise CliError(f"the pages are not installed: {FOLDER} holds none")
    name = page.removesuffix(SUFFIX)
    if name not in found:
        advice = did_you_mean(name, found) or f"there are {', '.join(found)}"
        raise CliError(f"there is no page {quote(page)}; {advice}")
    return found[name]
