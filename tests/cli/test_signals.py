"""Ctrl-C and SIGTERM are heard wherever they come: while an object is freed, within a call of a library, in Z3."""

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import combinations
from threading import Timer
from typing import Any, Self

import pytest

from exover import pipeline
from exover.certificate.check import Checker
from exover.certificate.table import decode
from exover.cli.main import ExitGuard, main
from exover.cli.signals import persistent_signals
from exover.engines.aig.circuit.graph import Graph
from exover.engines.aig.circuit.solver import Solver
from exover.engines.smt.solver import new_solver
from tests.cli.specs import SPEC
from tests.support.engines import model_of

SOON, MUCH = 0.05, 20.0
needs_signals = pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C")


class Freed:
    """An object while whose end a signal comes."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __del__(self) -> None:
        signal.raise_signal(self.number)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
@pytest.mark.parametrize("ignored", [True, False])
def test_a_closed_terminal_is_heard_unless_it_is_ignored(ignored: bool) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN if ignored else signal.SIG_DFL)
    try:
        assert main(["--version"]) == 0
        assert (signal.getsignal(signal.SIGHUP) == signal.SIG_IGN) == ignored
        assert callable(signal.getsignal(signal.SIGHUP)) != ignored
    finally:
        signal.signal(signal.SIGHUP, before)


@needs_signals
@pytest.mark.parametrize(("number", "kind"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)])
def test_a_signal_is_heard_that_comes_while_an_object_is_freed(number: int, kind: type[BaseException]) -> None:
    before = signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(143)), sys.unraisablehook
    try:
        with pytest.raises(kind), persistent_signals():
            Freed(number)
            time.sleep(MUCH)
        assert sys.unraisablehook == before[1]
    finally:
        signal.signal(signal.SIGTERM, before[0])


def test_what_else_goes_wrong_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Wrong:
        def __del__(self) -> None:
            raise ValueError

    told: list[Any] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda error: told.append(error.exc_type))
    with persistent_signals():
        Wrong()
    assert told == [ValueError]


@needs_signals
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_is_heard_that_comes_while_arguments_are_converted(number: int, status: int) -> None:
    class Converted:
        @classmethod
        def from_param(cls, value: object) -> Self:
            signal.raise_signal(number)
            time.sleep(MUCH)
            return cls()

    function = ctypes.CFUNCTYPE(None)(lambda: None)
    function.argtypes = [Converted]
    before = signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(143))
    try:
        outcome = ExitGuard()
        with outcome:
            function(0)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert outcome.status == status


@needs_signals
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_is_heard_that_comes_while_a_class_is_made(number: int, status: int) -> None:
    class Named:
        def __set_name__(self, owner: type, name: str) -> None:
            signal.raise_signal(number)
            time.sleep(MUCH)

    before = signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(143))
    try:
        outcome = ExitGuard()
        with outcome:
            type("Made", (), {"named": Named()})
    finally:
        signal.signal(signal.SIGTERM, before)
    assert outcome.status == status


def solver_of_a_certificate() -> Any:
    return Checker(decode(pipeline.build(model_of(SPEC)).data)).solver([True])


@needs_signals
@pytest.mark.parametrize("make", [new_solver, solver_of_a_certificate])
def test_z3_leaves_ctrl_c_to_python(make: Callable[[], Any]) -> None:
    import z3

    solver = make()
    x, y, z = z3.Ints("x y z")
    solver.add(x > 1, y > 1, z > 1, x * x * x + y * y * y == z * z * z)  # it takes long to see that there are none
    solver.set("timeout", int(4000 * SOON))
    timer = Timer(SOON, os.kill, [os.getpid(), signal.SIGINT])
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        solver.check()
        time.sleep(MUCH)


@needs_signals
@pytest.mark.parametrize("granted", [None, 10**9])
def test_the_embedded_solver_leaves_ctrl_c_to_python(granted: int | None) -> None:
    solver, before = Solver(Graph().circuit((), ())), signal.getsignal(signal.SIGINT)
    places = [[solver.fresh() for _ in range(8)] for _ in range(9)]
    for one in places:
        solver.add(one)
    for one, other in combinations(places, 2):  # nine things have eight places
        for a, b in zip(one, other, strict=True):
            solver.add([-a, -b])
    # no thread of this process could send it: none runs while a solver keeps the interpreter's lock
    sender = subprocess.Popen(["sh", "-c", f"sleep {SOON}; kill -INT {os.getpid()}"])
    with sender, pytest.raises(KeyboardInterrupt):
        solver.satisfiable([], granted)
        time.sleep(MUCH)
    assert signal.getsignal(signal.SIGINT) == before


WHILE_IMPORTING = """
import os, runpy, signal, sys
class Interrupting:
    def find_spec(self, name, path, target=None):
        if name == module:
            os.kill(os.getpid(), signal.SIGINT)
module, sys.argv[1] = sys.argv[1], "--version"
sys.meta_path.insert(0, Interrupting())
runpy.run_module("exover", run_name="__main__", alter_sys=True)
"""


@needs_signals
@pytest.mark.parametrize("module", ["exover.cli.main", "exover.cli.arguments", "exover.raised"])
def test_ctrl_c_before_anything_is_imported_ends_the_command_in_silence(module: str) -> None:
    done = subprocess.run([sys.executable, "-c", WHILE_IMPORTING, module], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@needs_signals
def test_ctrl_c_that_is_ignored_stays_so() -> None:
    ignoring = f"import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n{WHILE_IMPORTING}"
    line = [sys.executable, "-c", ignoring, "exover.cli.main"]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
