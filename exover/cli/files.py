"""Files read whole, and files written whole or not at all."""

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from exover.cli.status import Refused
from exover.cli.streams import complain
from exover.diagnostics import Diagnostic, render, render_all
from exover.emit.artefact import Artefact
from exover.model.model import Model
from exover.pipeline import load
from exover.source import Source
from exover.syntax.decode import MAX_BYTES, decode


def read_spec(path: str) -> Model:
    """Return the model of a spec file; what is wrong with it goes to standard error, and `Refused` is raised."""
    source = _source(path)
    loaded = load(source)
    if loaded.diagnostics:
        complain(render_all(loaded.diagnostics, source))
    if loaded.model is None:
        mistakes = [diagnostic for diagnostic in loaded.diagnostics if diagnostic.severity == "error"]
        raise Refused(f"{path} has {'a mistake' if len(mistakes) == 1 else 'mistakes'}")
    return loaded.model


def _source(path: str) -> Source:
    try:
        with open(path, "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from error
    source = decode(path, content)
    if isinstance(source, Diagnostic):
        complain(render(source, Source(path, "")))
        raise Refused(f"cannot read {path}")
    return source


def write_all(folder: str, artefacts: Iterable[Artefact]) -> list[str]:
    """Write every artefact into the folder, which is made if it is not there, and return the paths.

    All are written under other names and synced before the first gets its own, so that a full disk leaves everything
    as it was. Raises `Refused` if one cannot be written.
    """
    missing = [path for path in (Path(folder), *Path(folder).parents) if not path.exists()]
    waiting: dict[str, str] = {}
    path = folder
    try:
        os.makedirs(folder, exist_ok=True)
        for artefact in artefacts:
            path = os.path.join(folder, artefact.name)
            if os.path.isdir(path):
                raise Refused(f"cannot write {path}: it is a directory")
            waiting[path] = os.path.join(folder, f".{artefact.name}.{os.getpid()}")
            _write(waiting[path], artefact.content)
        for path, temporary in waiting.items():
            os.replace(temporary, path)
    except OSError as error:
        raise Refused(f"cannot write {path}: {error.strerror}") from error
    finally:
        for temporary in waiting.values():
            with suppress(OSError):  # it has got its own name, or was never made
                os.unlink(temporary)
        for made in missing:
            with suppress(OSError):  # it is not empty: everything is written
                made.rmdir()
    return list(waiting)


def _write(path: str, content: bytes) -> None:
    with open(path, "xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
