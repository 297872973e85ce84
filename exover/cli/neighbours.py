"""The files that are in an output folder already: tables of other specs, and files that exover has not written."""

from collections.abc import Sequence
from pathlib import Path

from exover.bounds.sizes import word_bytes
from exover.cli.files import read_text
from exover.cli.status import CliError
from exover.cli.streams import complain
from exover.emit.artefact import Artefact
from exover.emit.buildfiles import CMAKE, MARK
from exover.emit.config import FILE, Needs, read
from exover.emit.rust import MANIFEST, MARKS, ROOT
from exover.ocrd.tables import Tables

TABLES = "_tables.c"
DEFINED = b"const exover_tables "
"""A text that is in every source of tables, by any version of exover."""


def neighbours(folder: str, tables: Tables, name: str) -> tuple[Needs, ...]:
    """Return the needs of the tables of other specs in the folder; `name`: of these `tables`.

    Raises `CliError` if the needs are not recorded, or no one configuration can serve all the tables.
    """
    others = _others(Path(folder), name)
    known = {each.name: each for each in read(_configuration(Path(folder)))} if others else {}
    width = word_bytes(tables)
    for other in others:
        if other not in known:
            raise CliError(
                f"{folder} holds tables of {other}, and its {FILE} does not tell what they need; "
                f"emit {other} there anew first, or {name} into a folder of its own"
            )
        if known[other].width != width:
            raise CliError(
                f"the tables of {name} have numbers of {width} bytes, those of {other} in {folder} of "
                f"{known[other].width}, and one runtime serves one width; emit {name} into a folder of its own, for a "
                "program of its own"
            )
    return tuple(known[other] for other in others)


def _others(folder: Path, name: str) -> list[str]:
    """Return the names of the other specs whose tables are in the folder."""
    sources = [path for path in sorted(folder.glob(f"*{TABLES}")) if path.is_file() and DEFINED in path.read_bytes()]
    names = [path.name.removesuffix(TABLES) for path in sources]
    return [other for other in names if other != name]


def _configuration(folder: Path) -> str:
    path = folder / FILE
    return read_text(str(path)) if path.is_file() else ""


def spared(folder: str, artefacts: Sequence[Artefact]) -> Sequence[Artefact]:
    """Return the artefacts, but for CMakeLists.txt, with a note, if the folder has one that exover did not write."""
    path = Path(folder) / CMAKE
    if not path.is_file() or _begins(path, MARK):
        return artefacts
    kept = [artefact for artefact in artefacts if artefact.name != CMAKE]
    if len(kept) < len(artefacts):
        complain(f"exover: note: {path} is not one of exover's and stays as it is")
    return kept


def refuse_foreign_crate(folder: str, artefacts: Sequence[Artefact]) -> None:
    """Raise `CliError` if a file of the crate would replace one that exover has not written.

    exover has written a manifest or root iff it begins with its mark, and another source iff it has the root beside it.
    """
    root = Path(folder) / ROOT
    ours = root.is_file() and _begins(root, MARKS[ROOT])
    for name in [each.name for each in artefacts if each.name == MANIFEST or each.name.startswith("src/")]:
        path = Path(folder) / name
        if path.is_file() and not (_begins(path, MARKS[MANIFEST]) if name == MANIFEST else ours):
            raise CliError(
                f"{path} is not one of exover's, and the crate would replace it: nothing is written; emit the crate "
                "into a folder of its own"
            )


def _begins(path: Path, mark: str) -> bool:
    with path.open("rb") as file:
        return file.read(len(mark.encode())) == mark.encode()
