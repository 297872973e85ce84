"""`exover init`: start a project, with a spec that holds and the files around it."""

import argparse
import os
import re
import shlex
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from unicodedata import normalize

from exover import __version__
from exover.cli.files import write_all
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import out
from exover.emit.artefact import Artefact
from exover.syntax.lex import RESERVED

USUAL = "robot"
"""The name of the spec if the name of the folder can be none."""
FILES = {
    "spec.exo": "@NAME@.exo",
    "properties.prop": "@NAME@.prop",
    "events.jsonl": "@NAME@.events.jsonl",
    "exover.toml": "exover.toml",
    "workflow.yml": ".github/workflows/exover.yml",
}
"""The files in `starter`, each with its path in a project."""


def run(arguments: argparse.Namespace) -> ExitStatus:
    """Write the files and print their paths and what to do next; nothing is written if one of them is there."""
    name = spec_name(Path(arguments.folder))
    artefacts = list(_artefacts(name))
    paths = [os.path.join(arguments.folder, artefact.name) for artefact in artefacts]
    there = [path for path in paths if os.path.lexists(path)]
    if there:
        raise CliError(f"nothing is written, for there is already {', '.join(there)}; give another folder")
    out("".join(f"{path}\n" for path in write_all(arguments.folder, artefacts)))
    spec = f"./{paths[0]}" if paths[0].startswith("-") else paths[0]
    out(f"\nnext: exover check {shlex.quote(spec)}\n")
    return ExitStatus.OK


def spec_name(folder: Path) -> str:
    """Return the name for the spec of a project in this folder: that of the folder, with `_` for other characters."""
    letters = normalize("NFKD", Path(os.path.realpath(folder)).name).encode("ascii", "ignore").decode()
    name = re.sub(r"\W+", "_", letters).strip("_")
    return USUAL if not name or name[0].isdigit() or name in RESERVED else name


def _artefacts(name: str) -> Iterator[Artefact]:
    starter = files("exover.cli").joinpath("starter")
    for file, path in FILES.items():
        text = starter.joinpath(file).read_text(encoding="utf-8")
        filled = text.replace("@NAME@", name).replace("@VERSION@", __version__)
        yield Artefact(path.replace("@NAME@", name), filled.encode())
