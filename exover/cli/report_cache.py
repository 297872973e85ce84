"""The cache of `exover check` beside a project (docs/checks.md, "The cache"): its folder, and the reports in it.

The key of a report is a digest of the bytes that it depends on, so that nothing is parsed to find it. Only modules that
load fast are imported.
"""

import argparse
import errno
import json
import os
import re
import shutil
import sys
import sysconfig
import time
from collections.abc import Iterator
from contextlib import suppress
from datetime import date
from pathlib import Path

import exover
from exover.cli.replacing import replacing
from exover.cli.repository import CONFIG, folders_up, real_place
from exover.dataclass import dataclass
from exover.digest import digest_of

FOLDER, OFF = ".exover_cache", "EXOVER_NO_CACHE"
BESIDE = ("certificate", "count", "bounds", "timings", "timeout", "memory", "max_tests", "max_rom", "max_ram", "output")
"""The options with which no report is kept: they write, measure or limit something."""
INDIFFERENT = ("jobs", "started", "module", "watch", "watched", "no_cache", "specs")
"""The arguments that a report does not depend on, or whose files are digested in their place."""
PROGRAMS = ("berkeley-abc", "abc", "NuSMV", "nuXmv", "nusmv", "nuxmv", "cc", "gcc", "clang")
INCLUDE = re.compile(rb'\binclude\s*"([^"\\\n]*)"\s*;')
TAG = "Signature: 8a477f597d28d172789f06886806bc55\n# What `exover check` keeps: safe to delete.\n"
MOST_FILES, MOST_BYTES = 200, 32 << 20
"""The most files and bytes of the folder; the oldest files are dropped."""
DAY = 86_400


@dataclass(frozen=True, slots=True)
class ReportEntry:
    """The file for the report of a command, and the digest of all that the report depends on."""

    file: Path
    key: str


@dataclass(frozen=True, slots=True)
class Kept:
    """A report and the status with which it was printed."""

    text: str
    status: int


def entry(arguments: argparse.Namespace) -> ReportEntry | None:
    """Return the entry for the report of a command; None if it is not to be cached, or something cannot be read."""
    if is_off(arguments) or any(getattr(arguments, name) for name in BESIDE):
        return None
    if len(arguments.specs) != 1 or "-" in (*arguments.specs, arguments.properties, arguments.baseline):
        return None
    spec = Path(arguments.specs[0])
    if not spec.is_file() or spec.suffix in (".prop", ".toml"):
        return None
    return _entry(arguments, spec)


def is_off(arguments: argparse.Namespace) -> bool:
    """Return whether the cache is switched off."""
    return arguments.no_cache or bool(os.environ.get(OFF))


def state(arguments: argparse.Namespace, spec: str) -> str:
    """Return a digest of the files that the report of a spec depends on, or the error if one cannot be read."""
    try:
        return digest_of(*_contents(arguments, Path(spec)))
    except OSError as error:
        return f"{error.filename}: {error.strerror}"


def _entry(arguments: argparse.Namespace, spec: Path) -> ReportEntry | None:
    words = repr(sorted((name, str(value)) for name, value in vars(arguments).items() if name not in INDIFFERENT))
    try:
        parts = [words, os.getcwd(), arguments.specs[0], *program(), *_contents(arguments, spec)]
    except OSError:
        return None
    name = digest_of(words, os.path.realpath(spec))[:32]
    return ReportEntry(folder_of(spec) / f"{name}.json", digest_of(*parts))


def recall(kept: ReportEntry) -> Kept | None:
    """Return the report; None if there is none, if it depends on something that has changed, or if it is damaged."""
    try:
        found = json.loads(kept.file.read_bytes())
        if found["key"] == kept.key and found["sha256"] == digest_of(kept.key, found["text"], str(found["status"])):
            return Kept(str(found["text"]), int(found["status"]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    return None


def remember(kept: ReportEntry, text: str, status: int) -> None:
    """Keep a report; failures to write are ignored. Other processes may do the same at the same time."""
    known = {"key": kept.key, "status": status, "sha256": digest_of(kept.key, text, str(status)), "text": text}
    write(kept.file, json.dumps(known))


# ---- the folder ----


def folder_of(spec: Path) -> Path:
    """Return the cache folder of a spec: at the root of its repository, else beside it."""
    return folders_up(Path(os.path.realpath(spec)))[-1] / FOLDER


def write(file: Path, text: str) -> None:
    """Write a file of the cache folder, and drop the oldest ones if there are too many; errors are ignored."""
    with suppress(OSError):
        folder = file.parent
        if not folder.is_dir():
            folder.mkdir()
            _written(folder / ".gitignore", "*\n")
            _written(folder / "CACHEDIR.TAG", TAG)
        _written(file, text)
        _tidy(folder)


def _tidy(folder: Path) -> None:
    """Drop the oldest files above the limits, and temporary files that are older than a day."""
    found: list[tuple[int, int, str]] = []
    for entry in os.scandir(folder):
        with suppress(FileNotFoundError):  # another process tidies too
            known = entry.stat()
            if entry.name.endswith(".json"):
                found.append((known.st_mtime_ns, known.st_size, entry.path))
            elif entry.name.endswith(".tmp") and known.st_mtime < time.time() - DAY:
                os.unlink(entry.path)
    size = sum(each for _, each, _ in found)
    for number, (_, each, path) in enumerate(sorted(found)):
        if len(found) - number <= MOST_FILES and size <= MOST_BYTES:
            return
        with suppress(FileNotFoundError):
            os.unlink(path)
        size -= each


def _written(file: Path, text: str) -> None:
    """Write a file whole or not at all."""
    with (
        replacing(str(file), private=True) as temporary,
        open(temporary, "w", encoding="utf-8", errors="surrogatepass") as stream,
    ):
        stream.write(text)


# ---- what a report depends on ----


def program() -> Iterator[str]:
    """Yield texts that identify the version of this program, of Python, and of the libraries and programs it uses."""
    yield exover.__version__
    yield sys.version
    yield str(os.stat(sysconfig.get_path("purelib")).st_mtime_ns)
    package = os.path.dirname(os.path.abspath(exover.__file__))
    for place, folders, files in os.walk(package, followlinks=True):
        folders[:] = sorted(name for name in folders if name != "__pycache__")
        for file in (os.path.join(place, name) for name in sorted(files)):
            yield f"{file[len(package) + 1 :]} {_stamp(file)}"
    compiler = os.environ.get("CC", "")
    yield compiler
    for name in (*PROGRAMS, *compiler.split()[:1]):
        found = shutil.which(name)
        yield f"{name} {found} {_stamp(found) if found else ''}"


def _stamp(path: str) -> str:
    known = os.stat(path)
    return f"{known.st_size} {known.st_mtime_ns}"


def _contents(arguments: argparse.Namespace, spec: Path) -> Iterator[str | bytes]:
    """Yield names and contents of all files that may be read, and if there is any beside the spec, today's date.

    Raises `OSError` if one cannot be read, is no regular file, or has more than `MOST_BYTES`.
    """
    configs = [folder / CONFIG for folder in folders_up(spec)]
    found = [*_parts(spec), *_properties(spec), *(file for file in configs if os.path.lexists(file))]
    found += [Path(file) for file in (arguments.properties, arguments.config, arguments.baseline) if file]
    for file in found:
        yield str(file)
        yield _bytes(file)
    yield from helpers(arguments)
    if len(found) > 1:
        yield date.today().isoformat()


def _bytes(file: Path) -> bytes:
    """Return the bytes of a file; `OSError` if it cannot be read, is no regular file, or has more than `MOST_BYTES`."""
    if not file.is_file() or file.stat().st_size > MOST_BYTES:
        raise OSError(errno.EINVAL, "it is no regular file, or a large one", str(file))
    return file.read_bytes()


def helpers(arguments: argparse.Namespace) -> Iterator[str]:
    """Yield size and time stamp of the programs that options name."""
    for path in (arguments.abc, arguments.nusmv):
        yield _stamp(path) if path and os.path.exists(path) else ""


def _parts(spec: Path) -> list[Path]:
    """Return a spec and all files that it includes, at any depth.

    Raises `OSError` if an `include` is not in plain form, and as `_contents` does.

    A file that is included by several names is returned for each folder: what it includes itself is looked for there.
    """
    found, known = [spec], {real_place(spec)}
    for file in found:
        text = _bytes(file)
        named = INCLUDE.findall(text)
        if len(named) != len(re.findall(rb"\binclude\b", text)):
            raise OSError(errno.EINVAL, "what it includes is not plain to see", str(file))
        for part in (file.parent / os.fsdecode(name) for name in named):
            if (place := real_place(part)) not in known:
                known.add(place)
                found.append(part)
    return found


def _properties(spec: Path) -> list[Path]:
    """Return all properties files in the places where those of a spec are searched (`exover.places`)."""
    beside = Path(os.path.normpath(spec.parent / ".." / "properties"))
    places = (spec.parent, spec.parent / "properties", beside)
    return [file for place in places if place.is_dir() for file in sorted(place.glob("*.prop"))]
