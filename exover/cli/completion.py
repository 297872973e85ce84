"""`exover completion`: print the script that completes commands in a shell."""

import argparse
from collections.abc import Iterator

import shtab

from exover.cli.arguments import parser
from exover.cli.status import ExitStatus
from exover.cli.streams import out

PATHS = {
    "DIR": shtab.DIRECTORY,
    **dict.fromkeys(("FILE", "SPEC", "PATH", "TABLE", "FINDING", "REPORT", "BOX"), shtab.FILE),
}
"""What an argument is completed with, by the name that the help gives it."""


def run(arguments: argparse.Namespace) -> int:
    """Print the script for a shell, made from the very parser that reads the arguments."""
    described = parser()
    for action in _actions(described):
        if action.metavar in PATHS:
            action.complete = PATHS[action.metavar]  # type: ignore[attr-defined]  # where shtab looks for it
    out(f"{shtab.complete(described, shell=arguments.shell).rstrip()}\n")
    return ExitStatus.OK


def _actions(described: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser, and those of its verbs."""
    for action in described._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                yield from _actions(verb)
