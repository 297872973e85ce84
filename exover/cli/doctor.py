"""`exover doctor`: print which libraries and programs are installed, which slow fall-backs work, and remedies."""

import argparse
import platform
import shutil
from collections.abc import Callable, Mapping
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from exover import __version__
from exover.cli.status import ExitStatus
from exover.cli.streams import out
from exover.dataclass import dataclass
from exover.engines.process import NotRunnable
from exover.engines.process import run as run_program

PATIENCE = 20.0
"""The seconds that a program has to print its version."""


@dataclass(frozen=True, slots=True)
class Help:
    """A library or program that exover can use: what it gains, what happens without it, how to get it.

    `found`: returns the version that is installed; raises `NotRunnable` if none is. `slow`: it has a slow fall-back.
    """

    name: str
    found: Callable[[], str]
    gain: str
    without: str
    remedy: str
    slow: bool = False


def run(arguments: argparse.Namespace) -> ExitStatus:
    """Print the versions and the system, then each of `HELPS`; that one is missing is no error."""
    system = f"{platform.system()} on {platform.machine()}"
    out(f"exover {__version__}, Python {platform.python_version()}, {system}\n\n")
    slow = [help_.name for help_ in HELPS if _tell(help_) == "!"]
    in_place = f"in place of {' and '.join(slow)}" if slow else "none"
    out(f"\nslow fall-backs at work: {in_place}\n")
    return ExitStatus.OK


def _tell(help_: Help) -> str:
    """Print whether it is installed, and the remedy if it is not; return its mark: `+`, `-`, or `!` of a slow one."""
    try:
        out(f"+ {help_.name}: {help_.found()}; {help_.gain}\n")
    except (NotRunnable, TimeoutError) as reason:
        mark = "!" if help_.slow else "-"
        out(f"{mark} {help_.name}: not there ({reason}); {help_.without}\n    to do: {help_.remedy}\n")
        return mark
    return "+"


def _cudd() -> str:
    _package("dd")
    if find_spec("dd.cudd") is None:
        raise NotRunnable("dd as it is installed here has none")
    return f"in dd {_package('dd')}"


def _package(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError as reason:
        raise NotRunnable(f"{name} is not installed") from reason


def _abc() -> str:
    from exover.engines.aig.abc import prover

    program = prover.find()
    why = prover.unusable(program)
    if why:
        raise NotRunnable(why)
    return f"{_said([program, '-q', 'version'], 'ABC')} at {program}"


def _nusmv() -> str:
    from exover.engines.smv.program import environment, find

    program = find()
    with TemporaryDirectory(prefix="exover-") as folder:
        libraries = environment(Path(folder))
        return f"{_said([program, '-h'], 'This is', libraries)} at {program}"


def _c_compiler() -> str:
    from exover.engines.compiler import NativeUnavailable, find_compiler

    try:
        command = find_compiler()
    except NativeUnavailable as reason:
        raise NotRunnable(str(reason)) from reason
    return _said([*command, "--version"])


def _rustc() -> str:
    from exover.engines.compiler import NativeUnavailable
    from exover.run.rust import find_rustc

    try:
        return _said([*find_rustc(), "--version"])
    except NativeUnavailable as reason:
        raise NotRunnable(str(reason)) from reason


def _cargo() -> str:
    if shutil.which("cargo") is None:
        raise NotRunnable("no cargo was found on PATH")
    return _said(["cargo", "--version"])


def _graphviz() -> str:
    from exover.graph.svg import find

    program = find()
    ended = run_program([program, "-V"], Path(program).parent, seconds=PATIENCE)
    return f"{(ended.printed + ended.complained).strip()} at {program}"


def _said(command: list[str], word: str = "", variables: Mapping[str, str] | None = None) -> str:
    """Return the first line with `word` that a program prints; raises `NotRunnable` and `TimeoutError`."""
    with TemporaryDirectory(prefix="exover-") as folder:
        ended = run_program(command, Path(folder), variables, PATIENCE)
    for line in map(str.strip, (ended.printed + ended.complained).splitlines()):
        if line and word in line:
            return line.removeprefix("*** ").removeprefix("This is ")
    raise NotRunnable(f"{command[0]} does not say its version")


HELPS = (
    Help(
        "CUDD",
        _cudd,
        "decision diagrams many times faster, and they may be reordered",
        "decision diagrams in Python take its place, many times slower",
        "use Linux on x86-64, where the wheel of dd has it, or build dd with CUDD as its README says",
        slow=True,
    ),
    Help(
        "Z3",
        lambda: _package("z3-solver"),
        "what diagrams and circuits leave open; --engine z3; certificates are checked with it",
        "exover was not installed whole",
        "python -m pip install exover",
    ),
    Help(
        "python-sat",
        lambda: _package("python-sat"),
        "invariants and runs of circuits, where diagrams grow too large",
        "exover was not installed whole",
        "python -m pip install exover",
    ),
    Help(
        "ABC",
        _abc,
        "the engine aig several times faster on large specs; what it says is checked",
        "the embedded solver takes its place, several times slower on large specs",
        "install the Debian package berkeley-abc, or name another ABC by --abc PATH",
        slow=True,
    ),
    Help(
        "NuSMV",
        _nusmv,
        "--engine nusmv, and one engine more for --engine all",
        "no --engine nusmv, and one engine less for --engine all",
        "python -m pip install 'exover[nusmv]' (Linux on x86-64), or put NuSMV or nuXmv on PATH",
    ),
    Help(
        "pygls",
        lambda: _package("pygls"),
        "exover lsp",
        "no exover lsp",
        "python -m pip install 'exover[lsp]'",
    ),
    Help(
        "Cyclone DDS",
        lambda: _package("cyclonedds"),
        "exover gate ros2",
        "no exover gate ros2",
        "python -m pip install 'exover[ros2]'",
    ),
    Help(
        "rosbags",
        lambda: _package("rosbags"),
        "exover import --ros, exover audit of bags, exover gate ros2",
        "no exover import --ros, no exover audit of bags, no exover gate ros2",
        "python -m pip install 'exover[ros2]'",
    ),
    Help(
        "pyarrow",
        lambda: _package("pyarrow"),
        "exover audit of Parquet, and --out",
        "no exover audit of Parquet, and no --out",
        "python -m pip install 'exover[audit]'",
    ),
    Help(
        "dask.distributed",
        lambda: _package("distributed"),
        "exover audit --cluster",
        "no exover audit --cluster",
        "python -m pip install 'exover[cluster]'",
    ),
    Help(
        "opentelemetry",
        lambda: _package("opentelemetry-api"),
        "--otel of exover gate",
        "no --otel of exover gate",
        "python -m pip install 'exover[otel]'",
    ),
    Help(
        "Graphviz",
        _graphviz,
        "exover graph --format svg; drawings of what emit --target dot writes",
        "no exover graph --format svg; dot and mermaid are written without it",
        "install the Debian package graphviz, or see https://graphviz.org/download",
    ),
    Help(
        "C compiler",
        _c_compiler,
        "random runs several times faster; runs are replayed on the emitted C; --engine c",
        "runs are not replayed on the emitted C; no --engine c",
        "install gcc or clang, or name a compiler in $CC",
    ),
    Help(
        "rustc",
        _rustc,
        "--engine rust",
        "no --engine rust",
        "install Rust from https://rustup.rs, or name it in $RUSTC",
    ),
    Help(
        "cargo",
        _cargo,
        "builds crates that use the emitted one",
        "emitted crates cannot be built here",
        "install Rust from https://rustup.rs",
    ),
)
"""The libraries and programs, in the order in which they are printed."""
