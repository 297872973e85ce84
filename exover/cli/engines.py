"""The engines that a command asks, by its options `--engine`, `--nusmv` and `--abc`."""

import argparse
from dataclasses import replace
from typing import Literal, assert_never

from exover.checks.schedule.engines import DIAGRAMS, PORTFOLIO, Engines
from exover.cli.status import CliError
from exover.cli.streams import complain
from exover.engines.process import NotRunnable

Choice = Literal["auto", "aig", "bdd", "z3", "nusmv", "all"]
EMBEDDED = "none"
"""The value of `--abc` with which ABC is not asked."""


def engines_of(arguments: argparse.Namespace) -> Engines:
    """Return the engines; raises `CliError` if options contradict each other, or an engine asked for is missing."""
    choice: Choice = arguments.engine
    if arguments.nusmv is not None and choice not in ("nusmv", "all"):
        raise CliError("--nusmv is for --engine nusmv and --engine all")
    if arguments.abc is not None and choice not in ("auto", "aig", "all"):
        raise CliError("--abc is for --engine auto, aig and all")
    match choice:
        case "auto":
            return portfolio(arguments.abc)
        case "aig":
            return Engines(("aig",), abc=abc_of(arguments.abc))
        case "bdd":
            return DIAGRAMS
        case "z3":
            return Engines(("z3",))
        case "nusmv" | "all":
            return _with_nusmv(choice, arguments.nusmv, arguments.abc)
        case _:
            assert_never(choice)


def portfolio(abc: str | None = None) -> Engines:
    """Return the engines that are asked by default."""
    return replace(PORTFOLIO, abc=abc_of(abc))


def abc_of(given: str | None) -> str:
    """Return the program of Berkeley ABC; "" if it is not to be asked or, with a warning if it was named, unusable."""
    from exover.engines.aig.abc import prover

    if given == EMBEDDED:
        return ""
    try:
        program = prover.find(given)
    except NotRunnable as reason:
        if given is not None:
            complain(f"exover: warning: ABC is not asked: {reason}")
        return ""
    why = "" if given is None else prover.unusable(program)  # one that was found is tried when it is needed
    if why:
        complain(f"exover: warning: ABC is not asked: {why}")
    return "" if why else program


def _with_nusmv(choice: Literal["nusmv", "all"], path: str | None, abc: str | None) -> Engines:
    from exover.engines.smv.program import find

    try:
        program = find(path)
    except NotRunnable as reason:
        if choice == "nusmv" or path is not None:
            raise CliError(str(reason)) from reason
        complain(f"exover: warning: NuSMV is not asked: {reason}")
        return Engines(("aig", "bdd", "z3"), compared=True, abc=abc_of(abc))
    if choice == "nusmv":
        return Engines(("nusmv",), nusmv=program)
    return Engines(("aig", "bdd", "z3", "nusmv"), compared=True, nusmv=program, abc=abc_of(abc))
