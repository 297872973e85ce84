"""Where the properties file of a spec is looked for (docs/language.md section 8)."""

import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from exover.diagnostics import Diagnostic
from exover.syntax.decode import MAX_BYTES, decode
from exover.syntax.lex import NAME, tokens

PROPERTIES = "properties"
SUFFIX = ".prop"
SPEC = ".exo"


def find_properties(spec: str, name: str) -> list[str]:
    """Return the files that are called as the spec file is, or whose `for` names the spec, each once, place by place.

    A spec from standard input has no place, and so no file. Raises `OSError` if a place or a file in it cannot be read.
    """
    if spec == "-":
        return []
    found: dict[str, str] = {}
    for file in _files(Path(spec)):
        if file.stem == Path(spec).stem or named_after(file, "for") == name:
            found.setdefault(os.path.realpath(file), str(file))
    return list(found.values())


def find_specs(properties: str) -> list[str]:
    """Return the specs that find a properties file where they look for theirs; `OSError` as for `find_properties`."""
    folder = Path(properties).parent
    above = Path(os.path.normpath(folder / ".."))
    inside = folder.resolve().name == PROPERTIES
    places = [folder, above, *sorted(each for each in above.glob("*/"))] if inside else [folder]
    mine = os.path.realpath(properties)
    specs = sorted({str(each) for place in places for each in place.glob(f"*{SPEC}") if each.is_file()})
    return [spec for spec in specs if mine in map(os.path.realpath, _properties_of(spec))]


def _properties_of(spec: str) -> list[str]:
    return find_properties(spec, named_after(Path(spec), "spec") or "")


def _files(spec: Path) -> Iterator[Path]:
    """Yield the properties files of all specs in the places that are looked at, in order."""
    for place in (spec.parent, spec.parent / PROPERTIES, Path(os.path.normpath(spec.parent / ".." / PROPERTIES))):
        if place.is_dir():
            yield from (file for file in sorted(place.iterdir()) if file.suffix == SUFFIX and file.is_file())


def named_after(file: Path, word: str) -> str | None:
    """Return the name that stands behind the word with which a file begins (`for`, `spec`); None if it does not."""
    with file.open("rb") as stream:
        source = decode(str(file), stream.read(MAX_BYTES))
    if isinstance(source, Diagnostic):
        return None
    first, name = (*islice(tokens(source.text, [], formulas=True), 2), None, None)[:2]
    return name.text if first and name and (first.text, name.kind) == (word, NAME) else None
