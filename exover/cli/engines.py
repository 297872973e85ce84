"""Which engines a command asks: its options `--engine` and `--nusmv`."""

import argparse
from typing import Literal, assert_never

from exover.checks.engines import DIAGRAMS, PORTFOLIO, Engines
from exover.cli.status import Refused
from exover.cli.streams import complain
from exover.verify.process import NotRunnable

Choice = Literal["auto", "bdd", "z3", "nusmv", "all"]


def engines_of(arguments: argparse.Namespace) -> Engines:
    """Return the engines; raises `Refused` if one that was asked for by name is not there."""
    choice: Choice = arguments.engine
    if arguments.nusmv is not None and choice not in ("nusmv", "all"):
        raise Refused("--nusmv is for --engine nusmv and --engine all")
    match choice:
        case "auto":
            return PORTFOLIO
        case "bdd":
            return DIAGRAMS
        case "z3":
            return Engines(("z3",))
        case "nusmv" | "all":
            return _with_nusmv(choice, arguments.nusmv)
        case _:
            assert_never(choice)


def _with_nusmv(choice: Literal["nusmv", "all"], path: str | None) -> Engines:
    from exover.verify.smv.program import find

    try:
        program = find(path)
    except NotRunnable as reason:
        if choice == "nusmv" or path is not None:
            raise Refused(str(reason)) from reason
        complain(f"exover: warning: NuSMV is not asked: {reason}")
        return Engines(("bdd", "z3"), compared=True)
    if choice == "nusmv":
        return Engines(("nusmv",), nusmv=program)
    return Engines(("bdd", "z3", "nusmv"), compared=True, nusmv=program)
