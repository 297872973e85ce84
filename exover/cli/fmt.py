"""`exover fmt`: format specs and properties files in the canonical layout."""

import argparse
import os
import stat
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Literal

from exover.cli.files import mistaken, read_language, shown, source_of, write_all
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out
from exover.diagnostics import render_all
from exover.emit.artefact import Artefact
from exover.model.wording import counted
from exover.places import SPEC, SUFFIX, below
from exover.syntax.layout import formatted

Result = Literal["reformatted", "would be reformatted", "left unchanged"]
SUFFIXES = (SPEC, SUFFIX)
UNREAD = "that cannot be read or written"


class _Mistaken(CliError):
    """The text of a file has a mistake."""


def run(arguments: argparse.Namespace) -> int:
    """Format the files, print which changed or would, and return the status; a mistake in one stops no other."""
    results: Counter[Result] = Counter()
    wrong: Counter[str] = Counter()

    def unread(error: OSError) -> None:
        complain(f"exover: error: cannot read {error.filename}: {error.strerror}")
        wrong[UNREAD] += 1

    for path in dict.fromkeys(_files(arguments.files, unread)):
        try:
            result, content = _format(path, arguments.check)
        except CliError as refusal:
            complain(f"exover: error: {refusal}")
            wrong["with mistakes" if isinstance(refusal, _Mistaken) else UNREAD] += 1
            continue
        results[result] += 1
        if path == "-" and not arguments.check:
            out(content.decode("utf-8"))
        elif path != "-" and result != "left unchanged":
            out(f"{path} {result}\n")
    counts = [f"{counted(count, 'file')} {result}" for result, count in sorted(results.items())]
    counts += [f"{count} {what}" for what, count in sorted(wrong.items())]
    complain(", ".join(counts) or "no .exo or .prop file found")
    if wrong:
        return ExitStatus.WRONG
    return ExitStatus.VIOLATED if results["would be reformatted"] else ExitStatus.OK


def _files(paths: Iterable[str], unread: Callable[[OSError], None]) -> Iterator[str]:
    """Yield the files; for a folder, the regular files of the language `below` it, as `unread` is for that."""
    for path in paths:
        if path == "-" or not os.path.isdir(path):
            yield path
            continue
        for file in below(path, SUFFIXES, unread):
            if os.path.isfile(file):
                yield file
            else:  # opening a pipe would wait
                complain(f"exover: note: {file} is passed over: it is no regular file")


def _format(path: str, check: bool) -> tuple[Result, bytes]:
    """Format a file, with `check` without writing; return the result and the formatted bytes. Raises `CliError`."""
    if path != "-" and os.path.exists(path) and not os.path.isfile(path):
        raise CliError(f"{path} is no regular file; - formats standard input")
    given = read_language(path)
    content = _formatted(path, given)
    if content == given:
        return "left unchanged", content
    if check:
        return "would be reformatted", content
    if path != "-":
        _replace(path, content)
    return "reformatted", content


def _formatted(path: str, given: bytes) -> bytes:
    """Return a text in the canonical layout; mistakes go to standard error, and `CliError` is raised."""
    source = source_of(shown(path), given)
    text, mistakes = formatted(source)
    if text is None:
        complain(render_all(mistakes, source))
        left = "" if path == "-" else " and is left as it is"
        raise _Mistaken(f"{mistaken(mistakes, source)}{left}")
    return text.encode("utf-8")


def _replace(path: str, content: bytes) -> None:
    """Write a file whole or not at all, following links, and keep its permissions."""
    folder, name = os.path.split(os.path.realpath(path))
    mode = stat.S_IMODE(os.stat(path).st_mode)
    write_all(folder, [Artefact(name, content)])
    os.chmod(os.path.join(folder, name), mode)
