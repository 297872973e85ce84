"""Finds the files that belong to a spec: its properties file (docs/language.md section 8) and its parts (10)."""

import errno
import os
import stat
from codecs import BOM_UTF8
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path

from exover.diagnostics import Diagnostic, quote
from exover.source import Source
from exover.syntax.decode import MAX_BYTES, decode
from exover.syntax.includes import joined
from exover.syntax.lex import NAME, STRING, Token, string_value, tokens

PROPERTIES = "properties"
SUFFIX = ".prop"
SPEC = ".exo"
INCLUDE = "include"


def find_properties(spec: str, name: str) -> list[str]:
    """Return the properties files that have the name of the spec file, or whose `for` names the spec, folder by folder.

    A properties file without a readable `for` is returned alone: it may be for this spec, and must be mended first.
    A spec from standard input has no folder, and so no file. Raises `OSError` if a folder or a properties file in it
    cannot be read, for example because it is a folder or a pipe.
    """
    if spec == "-":
        return []
    found: dict[str, str] = {}
    for file in _files(Path(spec)):
        meant = _meant(file)
        if meant is None:
            return [str(file)]
        if file.stem == Path(spec).stem or meant == name:
            found.setdefault(os.path.realpath(file), str(file))
    return list(found.values())


def below(folder: str, suffixes: tuple[str, ...], unread: Callable[[OSError], object]) -> Iterator[str]:
    """Yield the paths in a folder and below, hidden folders left out, whose names end so.

    `unread` takes the error of each folder that cannot be read.
    """
    for place, folders, names in os.walk(folder, onerror=unread):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (os.path.normpath(os.path.join(place, name)) for name in sorted(names) if name.endswith(suffixes))


def find_specs(properties: str) -> list[str]:
    """Return the specs for which `find_properties` looks at this file and takes it; raises `OSError` as that does.

    If the file has no readable `for`, or a spec no readable name, they are taken to belong together.
    """
    folder = Path(properties).parent
    above = Path(os.path.normpath(folder / ".."))
    inside = folder.resolve().name == PROPERTIES
    places = [folder, above, *sorted(each for each in above.glob("*/"))] if inside else [folder]
    meant = _meant(Path(properties))
    specs = sorted({str(each) for place in places for each in place.glob(f"*{SPEC}") if each.is_file()})
    return [spec for spec in specs if not is_part(spec) and _belong(properties, meant, spec)]


def _belong(properties: str, meant: str | None, spec: str) -> bool:
    """Return whether a spec looks for properties where this file is, and takes it; `meant`: the name after `for`."""
    if os.path.realpath(properties) not in map(os.path.realpath, _files(Path(spec))):
        return False
    return Path(properties).stem == Path(spec).stem or meant is None or named_after(Path(spec), "spec") in (meant, None)


def _files(spec: Path) -> Iterator[Path]:
    """Yield all properties files in the folders where those of a spec are looked for, in order.

    Files whose names begin with a dot, as editors and systems make them, are skipped unless they begin with `for NAME`.
    """
    for place in (spec.parent, spec.parent / PROPERTIES, Path(os.path.normpath(spec.parent / ".." / PROPERTIES))):
        for file in sorted(place.iterdir()) if place.is_dir() else ():
            hidden = file.name.startswith(".")
            if file.suffix == SUFFIX and (not hidden or (file.is_file() and named_after(file, "for"))):
                yield file


def _meant(properties: Path) -> str | None:
    """Return the name after `for` in a properties file, None without one; raises `OSError` if it cannot be read."""
    refuse_irregular(str(properties))
    return named_after(properties, "for")


def refuse_irregular(path: str) -> None:
    """Raise `OSError` if a path does not lead to a regular file."""
    mode = os.stat(path).st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), path)
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "it is no regular file", path)


def named_after(file: Path, word: str) -> str | None:
    """Return the name after `word` (`for`, `spec`, `part`) if a file begins with the two; else None."""
    first, name = (*islice(_tokens(file), 2), None, None)[:2]
    return name.text if first and name and (first.text, name.kind) == (word, NAME) else None


def _tokens(file: Path) -> Iterator[Token]:
    """Yield the tokens of a file. Raises `OSError` if it cannot be read."""
    yield from tokens(_text(file), [], formulas=True)


def _text(file: Path) -> str:
    """Return the text of a file; bytes that are no UTF-8 become surrogates. Raises `OSError` if it cannot be read."""
    with file.open("rb") as stream:
        return stream.read(MAX_BYTES).removeprefix(BOM_UTF8).decode(errors="surrogateescape")


# ---- parts ----


def read_part(path: str, most: int) -> bytes:
    """Return at most so many bytes of an included file; raises `OSError` if no regular file has exactly this name."""
    refuse_irregular(path)
    folder, name = os.path.split(path)
    if name not in os.listdir(folder or os.curdir):
        raise OSError(errno.ENOENT, "the file is spelt otherwise, in capital or small letters")
    with open(path, "rb") as file:
        return file.read(most)


def find_including(*parts: str, unclear: bool = False) -> list[str]:
    """Return the specs that include one of the parts, directly or not.

    They are looked for in the folder of a part, the one above, and the folders in that. `unclear`: also those of which
    this is unknown, because they or a part of theirs cannot be decoded as text. Raises `OSError` if a folder or a file
    in it cannot be read.
    """
    places: dict[str, None] = {}
    for folder in dict.fromkeys(Path(part).parent for part in parts):
        above = Path(os.path.normpath(folder / ".."))
        places.update(dict.fromkeys(os.path.realpath(each) for each in (folder, above, *sorted(above.glob("*/")))))
    mine = set(map(os.path.realpath, parts))
    files = [file for place in places for file in sorted(Path(place).glob(f"*{SPEC}")) if file.is_file()]
    specs = {file: files_of(str(file)) for file in files if not is_part(str(file))}
    return [
        _near(spec)
        for spec, read in specs.items()
        if not mine.isdisjoint(read) or (unclear and not all(map(_is_text, read)))
    ]


def _is_text(file: str) -> bool:
    with open(file, "rb") as stream:
        return isinstance(decode(file, stream.read(MAX_BYTES + 1)), Source)


def _near(file: Path) -> str:
    """Return a path for messages: relative to the working folder if it is inside."""
    here = Path.cwd()
    return str(file.relative_to(here) if file.is_relative_to(here) else file)


def files_of(spec: str) -> set[str]:
    """Return the real paths of a spec and of the existing files that it includes, directly or not."""
    found = {os.path.realpath(spec)}
    open_ends = [spec]
    while open_ends:
        here = open_ends.pop()
        paths = [joined(here, path) for path in _included(Path(here))]
        new = [path for path in paths if os.path.isfile(path) and os.path.realpath(path) not in found]
        found.update(map(os.path.realpath, new))
        open_ends += new
    return found


def _included(file: Path) -> Iterator[str]:
    if INCLUDE not in _text(file):  # most files, which need not be tokenized for that
        return
    for word, path in pairwise(_tokens(file)):
        if word.text == INCLUDE and path.kind == STRING:
            yield string_value(path.text)


def is_part(file: str) -> bool:
    """Return whether a file begins with `part NAME`; raises `OSError` if it cannot be read."""
    return named_after(Path(file), "part") is not None


def advised(diagnostics: Iterable[Diagnostic], file: str) -> tuple[Diagnostic, ...]:
    """Return the diagnostics, with the specs that include the file as advice if it is a part (E009)."""
    return tuple(replace(each, help=_includers(file)) if each.code == "E009" else each for each in diagnostics)


def _includers(part: str) -> str:
    with suppress(OSError):  # a place cannot be read
        found = find_including(part)
        if found:
            return f"check {' or '.join(map(quote, found))}, which include{'s' if len(found) == 1 else ''} it"
    return "no spec beside it includes it: write one that does"
