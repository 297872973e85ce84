"""The files that a command is told to read and to write."""

import argparse

from exover.cli.status import CliError

INPUTS = (
    *("spec", "specs", "old", "new", "file", "table", "files", "box", "finding", "missions"),
    *("properties", "old_properties", "events", "audit", "bind", "after", "config", "baseline"),
)
"""The arguments and options that name one or several files to read."""


def inputs_of(arguments: argparse.Namespace) -> list[str]:
    """Return the files and folders that a command is told to read; `-` is standard input."""
    named = vars(arguments)
    files: list[str] = []
    for name in INPUTS:
        if (arguments.verb, name) != ("replay", "events"):  # it is an output
            given = named.get(name)
            files += given if isinstance(given, list) else [given] if isinstance(given, str) else []
    return files


def refuse_twice(*inputs: str | None) -> None:
    """Raise `CliError` if more than one of the inputs is standard input, which can be read once."""
    if inputs.count("-") > 1:
        raise CliError("only one thing can be read from standard input, and - stands for it twice")


def outputs_of(arguments: argparse.Namespace) -> list[str]:
    """Return the files that a command is told to write."""
    named = vars(arguments)
    options = ("out", "log", "certificate", "events" if arguments.verb == "replay" else "")
    files = [named[each] for each in options if named.get(each)]
    return files + [file for _, file in named.get("output") or ()]
