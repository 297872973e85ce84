"""Runs the C preprocessor on a description, with an empty file for each that it includes and that is missing."""

import os
import re
import shutil
import subprocess
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from exover.dataclass import dataclass

SECONDS = 60
MAX_MISSING = 200
"""The most missing files that are replaced by empty ones."""
_MARKER = re.compile(r'^#(?:line)?[ \t]+([0-9]+)[ \t]+"((?:[^"\\]|\\.)*)"', re.MULTILINE)
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]*)[>"]', re.MULTILINE)
_MISSING = re.compile(r"fatal error: '?([^'\n]+?)'?(?:: No such file or directory| file not found)")


class NotPreprocessed(Exception):
    """The C preprocessor refuses a file; the text says why."""


@dataclass(frozen=True)
class Preprocessed:
    """A preprocessed file; `missing`: a text for each file not read; `starts`: (line, file, line in it), ascending."""

    name: str
    text: str
    missing: tuple[str, ...]
    starts: tuple[tuple[int, str, int], ...]

    @property
    def files(self) -> frozenset[str]:
        """The names of the file and of those that it includes."""
        return frozenset(file for _, file, _ in self.starts)

    def origin(self, line: int) -> tuple[str, int]:
        """Return the file and the line in it from which a line of the text comes."""
        at = bisect_right(self.starts, line, key=lambda each: each[0]) - 1
        first, file, number = self.starts[max(at, 0)]
        return file, number + line - first

    def place(self, line: int) -> str:
        """Return `FILE:LINE` of a line of the text."""
        file, number = self.origin(line)
        return f"{file}:{number}"

    def is_own(self, line: int) -> bool:
        """Return whether a line comes from the file itself, and not from one that it includes."""
        return self.origin(line)[0] == self.name


def preprocess(name: str, text: str, folders: Sequence[str] = ()) -> Preprocessed:
    """Return a preprocessed file, or the file as it is if there is no preprocessor; `folders`: searched for includes.

    Raises `NotPreprocessed` if the preprocessor fails.
    """
    command = _command()
    if command is None:
        missing = tuple(f"`{each}` is not read: there is no C preprocessor" for each in _INCLUDE.findall(text))
        return Preprocessed(name, text, missing, ((1, name, 1),))
    if "#" not in text:
        return Preprocessed(name, text, (), ((1, name, 1),))
    with TemporaryDirectory(prefix="exover-") as empty:
        looked = [part for folder in (*folders, empty) for part in ("-I", folder)]
        given = [*command, "-nostdinc", "-undef", "-D__GENOM__", *looked, _operand(name)]
        found_missing: list[str] = []
        while True:
            done = _run(given)
            found = _MISSING.search(done.stderr)
            if done.returncode == 0:
                remarks = tuple(f"`{each}` is not found: what it declares is not known" for each in found_missing)
                return Preprocessed(name, done.stdout, remarks, tuple(_starts(name, done.stdout)))
            if (
                found is None
                or found[1] in found_missing
                or len(found_missing) == MAX_MISSING
                or not _make(Path(empty), found[1])
            ):
                raise NotPreprocessed(_first(done.stderr) or f"{command[0]} ends with status {done.returncode}")
            found_missing.append(found[1])


def _command() -> list[str] | None:
    for program, options in (("cpp", []), ("gcc", ["-E", "-xc"]), ("clang", ["-E", "-xc"])):
        path = shutil.which(program)
        if path:
            return [path, *options]
    return None


def _run(command: list[str]) -> "subprocess.CompletedProcess[str]":
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        return subprocess.run(
            command, capture_output=True, text=True, errors="replace", check=False, timeout=SECONDS, env=environment
        )
    except subprocess.TimeoutExpired as reason:
        raise NotPreprocessed(f"{command[0]} takes longer than {SECONDS} s") from reason


def _make(folder: Path, name: str) -> bool:
    """Make an empty file in the folder; return False if the name is not relative, leads outside, or is there."""
    if os.path.isabs(name) or ".." in Path(name).parts or (folder / name).exists():
        return False
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).touch()
    return True


def _operand(name: str) -> str:
    """Return a file as an operand that is no option."""
    return os.path.join(".", name) if name.startswith("-") else name


def _first(printed: str) -> str:
    errors: Iterable[str] = (line for line in printed.splitlines() if "error" in line)
    return next(iter(errors), "")


def _starts(name: str, text: str) -> Iterator[tuple[int, str, int]]:
    """Yield the starts of a preprocessed text; its first marker says how the preprocessor writes `name`."""
    yield 1, name, 1
    own = ""
    for match in _MARKER.finditer(text):
        own = own or match[2]
        line = text.count("\n", 0, match.start()) + 2
        yield line, name if match[2] == own else re.sub(r"\\(.)", r"\1", match[2]), int(match[1])
