"""`exover doctor`: say which optional libraries and programs are there, and what each gains."""

import argparse
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from exover.cli.status import Status
from exover.cli.streams import out
from exover.verify.process import NotRunnable
from exover.verify.process import run as run_program

PATIENCE = 20.0
"""Seconds for a program to say its version."""


@dataclass(frozen=True, slots=True)
class Help:
    """Something that need not be there: its name, what it gains, and a function that says which one is there.

    The function raises `NotRunnable` if none is.
    """

    name: str
    gain: str
    found: Callable[[], str]


def run(arguments: argparse.Namespace) -> Status:
    """Print a line for each of `HELPS`; that something is missing is no error."""
    for help_ in HELPS:
        out(f"{_line(help_)}\n")
    return Status.OK


def _line(help_: Help) -> str:
    try:
        mark, found = "+", help_.found()
    except (NotRunnable, TimeoutError) as reason:
        mark, found = "-", f"not there ({reason})"
    return f"{mark} {help_.name}: {found}; {help_.gain}"


def _cudd() -> str:
    if find_spec("dd.cudd") is None:
        raise NotRunnable("the wheel of dd for this platform has none; its Python diagrams are used")
    return f"in dd {_package('dd')}"


def _package(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError as reason:
        raise NotRunnable(f"{name} is not installed") from reason


def _abc() -> str:
    from exover.engines.aig import abc

    program = abc.find()
    why = abc.unusable(program)
    if why:
        raise NotRunnable(why)
    return f"{_said([program, '-q', 'version'], 'ABC')} at {program}"


def _nusmv() -> str:
    from exover.verify.smv.program import environment, find

    program = find()
    with TemporaryDirectory(prefix="exover-") as folder:
        libraries = environment(Path(folder))
        return f"{_said([program, '-h'], 'This is', libraries)} at {program}"


def _c_compiler() -> str:
    from exover.gateway.native import NativeUnavailable, find_compiler

    try:
        command = find_compiler()
    except NativeUnavailable as reason:
        raise NotRunnable(str(reason)) from reason
    return _said([*command, "--version"])


def _rustc() -> str:
    from exover.gateway.native import NativeUnavailable
    from exover.gateway.rust import find_rustc

    try:
        return _said([*find_rustc(), "--version"])
    except NativeUnavailable as reason:
        raise NotRunnable(str(reason)) from reason


def _cargo() -> str:
    if shutil.which("cargo") is None:
        raise NotRunnable("no cargo was found on PATH")
    return _said(["cargo", "--version"])


def _said(command: list[str], word: str = "", variables: Mapping[str, str] | None = None) -> str:
    """Return the first line with a word that a program prints. Raises `NotRunnable`, `TimeoutError`."""
    with TemporaryDirectory(prefix="exover-") as folder:
        ended = run_program(command, Path(folder), variables, PATIENCE)
    for line in map(str.strip, (ended.printed + ended.complained).splitlines()):
        if line and word in line:
            return line.removeprefix("*** ").removeprefix("This is ")
    raise NotRunnable(f"{command[0]} does not say its version")


HELPS = (
    Help("CUDD", "decision diagrams many times faster, and they may be reordered", _cudd),
    Help(
        "python-sat", "invariants and runs of circuits, where diagrams grow too large", lambda: _package("python-sat")
    ),
    Help("ABC", "the engine aig several times faster on large specs; what it says is checked", _abc),
    Help("NuSMV", "--engine nusmv, and one engine more for --engine all", _nusmv),
    Help("C compiler", "runs are replayed on the emitted C; --engine c", _c_compiler),
    Help("rustc", "--engine rust", _rustc),
    Help("cargo", "builds crates that use the emitted one", _cargo),
)
"""In the order in which they are printed."""
