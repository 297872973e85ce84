"""What a command reads is not written over by it (docs/commands.md, "Outputs")."""

import argparse
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from exover.audit.sources import missions_in
from exover.cli.named_files import inputs_of, outputs_of
from exover.cli.policy import find_config
from exover.cli.specs import specs_of
from exover.cli.status import CliError
from exover.places import files_of, find_properties, named_after


def refuse_overwriting(arguments: argparse.Namespace, *more: str) -> None:
    """Raise `CliError` if an output of a command, or one of `more`, is a file that it reads, named or found."""
    written = [*outputs_of(arguments), *more]
    if any(os.path.isfile(file) for file in written):
        for path in _read(arguments):
            refuse_over(path, *written)


def refuse_over(path: str, *outputs: str) -> None:
    """Raise `CliError` if one of the outputs is the regular file at this path, which the command reads."""
    for output in outputs:
        if os.path.isfile(path) and os.path.exists(output) and os.path.samefile(path, output):
            raise CliError(f"{output} cannot be written over: the command reads it")


def _read(arguments: argparse.Namespace) -> Iterator[str]:
    """Yield the files that a command reads, and other paths; what cannot be read is left out: it is told of later."""
    named = vars(arguments)
    anew = named.get("baseline") if arguments.verb == "check" else None
    yield from (file for file in inputs_of(arguments) if file != anew)
    with suppress(OSError):
        for path in named.get("missions") or ():
            for mission in missions_in(path):
                yield mission
                yield from (str(each) for each in Path(mission).rglob("*"))
    for spec in _specs(arguments):
        if os.path.isfile(spec):  # a pipe can be read once
            with suppress(OSError):
                yield from _beside(arguments, spec)


def _specs(arguments: argparse.Namespace) -> list[str]:
    named = vars(arguments)
    if "specs" in named:
        return list(specs_of(arguments.specs, arguments.changed).files)
    if arguments.verb == "replay" and arguments.spec is None:
        return list(specs_of([os.curdir]).files)
    return [named[name] for name in ("spec", "old", "new") if isinstance(named.get(name), str)]


def _beside(arguments: argparse.Namespace, spec: str) -> Iterator[str]:
    """Yield a spec with its parts, and the configuration and properties that are found beside it if they are read."""
    yield from files_of(spec)
    if getattr(arguments, "config", "") is None:
        yield find_config(spec) or ""
    if getattr(arguments, "properties", "") is None:
        yield from find_properties(spec, named_after(Path(spec), "spec") or "")
