"""The specs that a command is about: files, those in a folder, those to which another file belongs."""

import os
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import NoReturn

from exover.cli.policy import find_config
from exover.cli.repository import CONFIG, real_place
from exover.cli.status import CliError
from exover.dataclass import dataclass
from exover.places import SPEC, SUFFIX, below, find_including, find_specs, is_part


@dataclass(frozen=True, slots=True)
class SpecFiles:
    """The files, each once; `several`: not just one spec file is named, so that reports are of a list of specs."""

    files: tuple[str, ...]
    several: bool


def specs_of(paths: Iterable[str], changed: bool = False) -> SpecFiles:
    """Return the specs that the arguments of a command stand for; `CliError` if one stands for none.

    A folder stands for all specs in it and below, hidden folders left out; a properties file for the specs that read
    it; `exover.toml` for those that it configures; of files that have `changed`, a part for the specs that include it.
    """
    given = list(paths)
    found: dict[str, str] = {}
    for path in given:
        for spec in _including(path) if changed and _is_part(path) else _meant(path):
            found.setdefault(real_place(spec), spec)
    return SpecFiles(tuple(found.values()), len(given) > 1 or given != list(found.values()))


def _meant(path: str) -> list[str]:
    """Return the specs that one argument stands for."""
    if path != "-" and os.path.isdir(path):
        return _in_folder(path)
    if path.endswith(SUFFIX):
        return _some(_readers(path), f"{path} is read by no spec: it is called as none, and is for none, in its places")
    if os.path.basename(path) == CONFIG:
        return _some(_configured(path), f"{path} configures no spec")
    return [path]


def _some(specs: Iterable[str], otherwise: str) -> list[str]:
    found = list(specs)
    if not found:
        raise CliError(otherwise)
    return found


def _in_folder(folder: str) -> list[str]:
    """Return the specs in a folder and below; `CliError` says where to go if there are only parts, or nothing."""
    files = list(_below(folder))
    specs = [file for file in files if not _is_part(file)]
    if specs:
        return specs
    if not files:
        raise CliError(f"{folder} holds no {SPEC} file")
    only_parts = f"{folder} holds parts and no spec"
    outside = _some(
        _asked(find_including, *files), f"{only_parts}; no spec beside it includes one: write one that does"
    )
    raise CliError(f"{only_parts}; name what includes them: {', '.join(outside)}")


def _below(folder: str) -> Iterator[str]:
    """Yield the specs and parts in a folder and below."""
    for file in sorted(map(Path, below(folder, (SPEC,), _refuse))):
        if file.is_file() and not file.name.startswith("."):
            yield str(file)


def _refuse(error: OSError) -> NoReturn:
    raise CliError(f"cannot read {error.filename}: {error.strerror}") from error


def _is_part(path: str) -> bool:
    """Return whether a path is that of a part; False if it cannot be read."""
    try:
        return os.path.isfile(path) and is_part(path)
    except OSError:
        return False


def _including(part: str) -> list[str]:
    return _some(
        _asked(partial(find_including, unclear=True), part), f"{part} is a part that no spec beside it includes"
    )


def _readers(properties: str) -> list[str]:
    return _asked(find_specs, properties)


def _asked(look: Callable[..., list[str]], *files: str) -> list[str]:
    try:
        return look(*files)
    except OSError as error:
        _refuse(error)


def _configured(config: str) -> Iterator[str]:
    """Yield the specs whose nearest configuration is this file."""
    mine = os.path.realpath(config)
    for file in _below(str(Path(config).parent)):
        nearest = None if _is_part(file) else find_config(file)
        if nearest is not None and os.path.realpath(nearest) == mine:
            yield file
