"""Files read whole, and files written whole or not at all."""

import errno
import os
import stat
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, TypeVar

from exover.cli.replacing import replacing
from exover.cli.status import CliError
from exover.cli.streams import complain, out
from exover.diagnostics import Diagnostic, render_all
from exover.emit.artefact import Artefact
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import Loaded, load, load_properties
from exover.places import advised, find_properties, read_part
from exover.source import STDIN, Source
from exover.syntax.decode import MAX_BYTES, decode, unread

T = TypeVar("T")
MOST_BYTES = 1 << 28
"""The most bytes of tables, a certificate, a black box or a report; a larger file is refused."""


def read_spec(path: str) -> Model:
    """Return the model of a spec file; what is wrong with it goes to standard error, and `CliError` is raised."""
    return load_spec(path)[1]


def load_spec(path: str) -> tuple[Source, Model]:
    """Return the text of a spec with its parts, and its model; errors as of `read_spec`."""
    loaded = load_file(path)
    return loaded.source, model_of(replace(loaded, diagnostics=advised(loaded.diagnostics, path)))


def model_of(loaded: Loaded) -> Model:
    """Return the model of a loaded spec; mistakes go to standard error, and `CliError` is raised."""
    return whole(loaded.model, loaded.diagnostics, loaded.source)


def load_file(path: str) -> Loaded:
    """Return a loaded spec file with its diagnostics; `CliError` is raised if it cannot be read, not for mistakes.

    A spec from standard input has no folder, and so cannot include files.
    """
    return load(read_source(path), None if path == "-" else read_part)


def read_properties(spec_path: str, given: str | None, model: Model) -> Properties:
    """Return the properties of a spec: of the file given, else of the one found, else none.

    Mistakes in the file go to standard error, and `CliError` is raised, also if several files are found.
    """
    path = given or the_properties(spec_path, model.name)
    if path is None:
        return NO_PROPERTIES
    return properties_of(read_source(path), model)


def properties_of(source: Source, model: Model) -> Properties:
    """Return the properties in a file; mistakes go to standard error, and `CliError` is raised."""
    loaded = load_properties(source, model)
    return whole(loaded.properties, loaded.diagnostics, source)


def the_properties(spec: str, name: str, option: str = "--properties") -> str | None:
    """Return the properties file of a spec that has this name, if there is one; `CliError` if there are several.

    `option`: the option by which the user can name one.
    """
    found = properties_files(spec, name)
    if len(found) > 1:
        listed = ", ".join(found)
        raise CliError(f"{spec} has {len(found)} properties files, {listed}: keep one, or name one with {option}")
    return found[0] if found else None


def properties_files(spec: str, name: str) -> list[str]:
    """Return the properties files of a spec that has this name; `CliError` if a place or file cannot be read."""
    try:
        return find_properties(spec, name)
    except OSError as error:
        raise CliError(f"cannot read {error.filename}: {error.strerror}") from error


def whole(content: T | None, diagnostics: tuple[Diagnostic, ...], source: Source) -> T:
    """Return the content of a file; print its diagnostics, and raise `CliError` if it is None."""
    if diagnostics:
        complain(render_all(diagnostics, source))
    if content is None:
        raise CliError(mistaken(diagnostics, source))
    return content


def mistaken(diagnostics: Sequence[Diagnostic], source: Source) -> str:
    """Return that a file has a mistake, or several."""
    errors = sum(each.severity == "error" for each in diagnostics)
    return f"{source.name} has {'a mistake' if errors == 1 else 'mistakes'}"


def shown(path: str) -> str:
    """Return the name of a file in messages and reports."""
    return STDIN if path == "-" else path


def read_bytes(path: str) -> bytes:
    """Return the bytes of a file that is no text of the language, or of standard input if the path is `-`.

    `CliError` is raised if it cannot be read, or is larger than `MOST_BYTES`.
    """
    try:
        content = _content(path, MOST_BYTES + 1)
    except OSError as error:
        raise CliError(f"cannot read {shown(path)}: {error.strerror}") from error
    if len(content) > MOST_BYTES:
        raise CliError(f"cannot read {shown(path)}: it is larger than {MOST_BYTES} bytes")
    return content


def _content(path: str, most: int) -> bytes:
    if path == "-":
        return standard_input().read(most)
    with open(path, "rb") as file:
        return file.read(most)


def standard_input() -> BinaryIO:
    """Return the stream of standard input; `CliError` if it is closed."""
    if sys.stdin is None:
        raise CliError("cannot read standard input: it is closed")
    return sys.stdin.buffer


def read_source(path: str) -> Source:
    """Return the text of a spec or properties file; errors go to standard error, and `CliError` is raised."""
    return source_of(shown(path), read_language(path))


def read_language(path: str) -> bytes:
    """Return the bytes of a file of the language or of a configuration; errors as of `read_source`."""
    name = shown(path)
    try:
        return _content(path, MAX_BYTES + 1)
    except OSError as error:
        complain(render_all([unread(error)], Source(name, "")))
        raise CliError(f"cannot read {name}: {error.strerror}") from error


def source_of(name: str, content: bytes) -> Source:
    """Return the text in the bytes of a file of this name; errors go to standard error, and `CliError` is raised."""
    source = decode(name, content)
    if isinstance(source, Diagnostic):
        complain(render_all([source], Source(name, "")))
        raise CliError(f"cannot read {name}")
    return source


def read_text(path: str) -> str:
    """Return the text of a UTF-8 file; errors as of `read_bytes`."""
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CliError(f"cannot read {shown(path)}: it is not UTF-8") from error


def write_all(folder: str, artefacts: Iterable[Artefact]) -> list[str]:
    """Write every artefact into the folder, which is made if it is missing, and return the paths.

    The name of an artefact may have folders, which are made too.

    All are written under temporary names and synced before the first is renamed, so that a full disk leaves everything
    as it was. Links are followed; an existing device or pipe is written into. Raises `CliError` if one cannot be
    written.
    """
    missing = _missing(folder)
    streams: dict[str, bytes] = {}
    targets: dict[str, str] = {}
    paths: list[str] = []
    path = folder
    try:
        with ExitStack() as waiting:
            os.makedirs(folder, exist_ok=True)
            for artefact in artefacts:
                path = os.path.join(folder, artefact.name)
                paths.append(path)
                missing = [*_missing(os.path.dirname(path)), *missing]
                os.makedirs(os.path.dirname(path), exist_ok=True)
                if _is_stream(path):
                    streams[path] = artefact.content
                    continue
                target = os.path.realpath(path)
                if target in targets:
                    raise CliError(f"cannot write {path}: it is the same file as {targets[target]}")
                targets[target] = path
                _write(waiting.enter_context(replacing(target)), artefact.content)
            for path, content in streams.items():
                _write_into(path, content)
    except OSError as error:
        why = os.strerror(errno.ENOTDIR) if isinstance(error, FileExistsError) else error.strerror
        raise CliError(f"cannot write {error.filename2 or path}: {why}") from error
    finally:
        for made in missing:
            with suppress(OSError):  # not empty: everything is written
                made.rmdir()
    return paths


def print_or_write(path: str | None, text: str) -> None:
    """Print a text, or write it to the file that `--out` names."""
    if path is None:
        out(text)
    else:
        write_one(path, text.encode("utf-8", "backslashreplace"))


def write_one(path: str, content: bytes, option: str = "--out") -> list[str]:
    """Write one file as `write_all` does, and return its path; `option`: the option that names it, for `CliError`."""
    folder, name = os.path.split(path)
    if not name:
        raise CliError(f"{path} is a folder: {option} names the file to write")
    return write_all(folder or os.curdir, [Artefact(name, content)])


def refuse_unwritable(path: str, option: str = "--out") -> None:
    """Raise the `CliError` of `write_one` as far as it can be known before any work is done."""
    _, name = os.path.split(path)
    if not name:
        raise CliError(f"{path} is a folder: {option} names the file to write")
    try:
        if _is_stream(path):
            return
    except OSError as error:
        raise CliError(f"cannot write {path}: {error.strerror}") from error
    refuse_closed(os.path.dirname(os.path.realpath(path)), path)


def refuse_closed(folder: str, path: str) -> None:
    """Raise `CliError` if a folder takes no files, and neither can be made; `path`: what was to be written."""
    nearest = next(each for each in (Path(folder), *Path(folder).absolute().parents) if each.exists())
    if not nearest.is_dir():
        raise CliError(f"cannot write {path}: {os.strerror(errno.ENOTDIR)}")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise CliError(f"cannot write {path}: {os.strerror(errno.EACCES)}")


def _missing(folder: str) -> list[Path]:
    """Return the folder and those above it that do not exist, the deepest first."""
    return [path for path in (Path(folder), *Path(folder).parents) if not path.exists()]


def _write(path: str, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _is_stream(path: str) -> bool:
    """Return whether a path is a device, a pipe or a standard stream, to be written into; `CliError` if a directory."""
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        return False
    if stat.S_ISDIR(mode):
        raise CliError(f"cannot write {path}: it is a directory")
    return not stat.S_ISREG(mode) or _standard(path) is not None


def _standard(path: str) -> int | None:
    """Return the descriptor of standard output or standard error if the path is the same file; else None."""
    for number in (1, 2):
        with suppress(OSError):  # it is closed
            if os.path.samestat(os.stat(path), os.fstat(number)):
                return number
    return None


def _write_into(path: str, content: bytes) -> None:
    """Write into a device, a pipe or a standard stream, this at its present position; a broken pipe is no error."""
    number = _standard(path)
    with suppress(BrokenPipeError), open(path if number is None else os.dup(number), "wb") as file:
        file.write(content)
