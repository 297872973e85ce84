"""Files read whole, and files written whole or not at all."""

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from exover.cli.places import the_properties
from exover.cli.status import Refused
from exover.cli.streams import complain
from exover.diagnostics import Diagnostic, render, render_all
from exover.emit.artefact import Artefact
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import load, load_properties
from exover.source import Source
from exover.syntax.decode import MAX_BYTES, decode

T = TypeVar("T")


def read_spec(path: str) -> Model:
    """Return the model of a spec file; what is wrong with it goes to standard error, and `Refused` is raised."""
    return model_of(read_source(path))


def model_of(source: Source) -> Model:
    """Return the model of a text; what is wrong with it goes to standard error, and `Refused` is raised."""
    loaded = load(source)
    return _whole(loaded.model, loaded.diagnostics, source)


def read_properties(spec_path: str, given: str | None, model: Model) -> Properties:
    """Return what the properties file of a spec says: the one given, else the one found, else nothing.

    What is wrong with the file goes to standard error, and `Refused` is raised; so it is if several are found.
    """
    path = given or the_properties(spec_path, model.name)
    if path is None:
        return NO_PROPERTIES
    source = read_source(path)
    loaded = load_properties(source, model)
    return _whole(loaded.properties, loaded.diagnostics, source)


def _whole(content: T | None, diagnostics: tuple[Diagnostic, ...], source: Source) -> T:
    """Return what was read; print what is wrong with it, and raise `Refused` if that left nothing."""
    if diagnostics:
        complain(render_all(diagnostics, source))
    if content is None:
        mistakes = [diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"]
        raise Refused(f"{source.name} has {'a mistake' if len(mistakes) == 1 else 'mistakes'}")
    return content


def read_bytes(path: str, most: int) -> bytes:
    """Return what a file holds, `most` bytes of it at the most; `Refused` is raised if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return file.read(most)
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from error


def read_source(path: str) -> Source:
    """Return the text of a spec or properties file; what is wrong goes to standard error, and `Refused` is raised."""
    source = decode(path, read_bytes(path, MAX_BYTES + 1))
    if isinstance(source, Diagnostic):
        complain(render(source, Source(path, "")))
        raise Refused(f"cannot read {path}")
    return source


def read_text(path: str) -> str:
    """Return what a UTF-8 file holds, or standard input if the path is `-`; `Refused` if it cannot be read."""
    try:
        if path != "-":
            return Path(path).read_text(encoding="utf-8-sig")
        if sys.stdin is None:
            raise Refused("cannot read standard input: it is closed")
        return sys.stdin.buffer.read().decode("utf-8-sig")
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise Refused(f"cannot read {path}: it is not UTF-8") from error


def write_all(folder: str, artefacts: Iterable[Artefact]) -> list[str]:
    """Write every artefact into the folder, which is made if it is not there, and return the paths.

    A name may be that of a file in a folder of its own below.

    All are written under other names and synced before the first gets its own, so that a full disk leaves everything
    as it was. Raises `Refused` if one cannot be written.
    """
    missing = _missing(folder)
    waiting: dict[str, str] = {}
    path = folder
    try:
        os.makedirs(folder, exist_ok=True)
        for artefact in artefacts:
            path = os.path.join(folder, artefact.name)
            if os.path.isdir(path):
                raise Refused(f"cannot write {path}: it is a directory")
            own, name = os.path.split(path)
            missing = [*_missing(own), *missing]
            os.makedirs(own, exist_ok=True)
            waiting[path] = os.path.join(own, f".{name}.{os.getpid()}")
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


def _missing(folder: str) -> list[Path]:
    """Return the folder and those above it that are not there, the deepest first."""
    return [path for path in (Path(folder), *Path(folder).parents) if not path.exists()]


def _write(path: str, content: bytes) -> None:
    with open(path, "xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
