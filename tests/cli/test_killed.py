"""A command that is killed leaves no process behind, whatever it is doing."""

import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.cli.processes import ENDLESS, FOREVER, processes
from tests.cli.specs import SPEC
from tests.support.command import COMMAND, environment

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
ENDLESS_COMMAND = [sys.executable, "-c", ENDLESS]
LONG = "spec long;\n" + "".join(f"module m{n} {{ request a(); request b() {{ interrupts a; }}}}\n" for n in range(8000))
"""Reading it takes some seconds, and so does making its tables."""
HARD = f"spec hard;\nmodule m {{ {' '.join(f'request r{n}();' for n in range(40))} }}\n" + "".join(
    f"mutex m.r{n}, m.r{(n * n + 7) % 40}, m.r{(3 * n + 1) % 40} by wait;\n"
    for n in range(40)
    if len({n, (n * n + 7) % 40, (3 * n + 1) % 40}) == 3
)
"""No engine is done with it soon."""
ONCE = "spec demo;\nmodule m { request a() { check not past(m.a); } }\n"
"""A run shows that the request is locked out."""


@pytest.fixture
def token() -> Iterator[str]:
    """What the environment of a command and of all its processes has; none of them outlives the test."""
    token = uuid.uuid4().hex
    yield token
    for process in processes(token):
        os.kill(process, signal.SIGKILL)


def within(seconds: float, done: Callable[[], bool]) -> bool:
    """Return whether it is done within some seconds."""
    until = time.monotonic() + seconds
    while not (found := done()) and time.monotonic() < until:
        time.sleep(0.02)
    return found


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "forever"
    path.write_text(FOREVER)
    path.chmod(0o755)
    return path


def killed(command: list[object], folder: Path, token: str, least: int, delay: float = 0.0, **more: str) -> None:
    """Kill a command some time after it has become so many processes, and assert that none is left soon."""
    with subprocess.Popen(
        [str(part) for part in command],
        cwd=folder,
        env=environment(TOKEN=token, **more),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        begun = within(30, lambda: len(processes(token)) >= least)
        time.sleep(delay)
        running = process.poll() is None
        process.kill()
    assert begun and running
    assert within(30, lambda: not processes(token))  # they would go on for minutes


@pytest.mark.parametrize("delay", [0.2, 0.6])
def test_while_it_reads_or_makes_the_tables(tmp_path: Path, token: str, delay: float) -> None:
    (tmp_path / "long.exo").write_text(LONG)
    killed([*COMMAND, "check", "long.exo", "--timeout", "60"], tmp_path, token, 1, delay)


@pytest.mark.parametrize("options", [("--timeout", "60"), ("--jobs", "2"), ("--jobs", "3", "--timeout", "60")])
def test_while_diagrams_are_built(tmp_path: Path, token: str, options: tuple[str, ...]) -> None:
    (tmp_path / "demo.exo").write_text(SPEC)
    jobs = int(options[1]) if "--jobs" in options else 1
    killed([*ENDLESS_COMMAND, "check", "demo.exo", *options], tmp_path, token, 1 + jobs)


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_while_z3_searches(tmp_path: Path, token: str, delay: float) -> None:
    (tmp_path / "hard.exo").write_text(HARD)
    killed([*COMMAND, "check", "hard.exo", "--engine", "z3", "--timeout", "60"], tmp_path, token, 2, delay)


@pytest.mark.parametrize("options", [(), ("--timeout", "60"), ("--jobs", "2")])
def test_while_nusmv_runs(tmp_path: Path, token: str, program: Path, options: tuple[str, ...]) -> None:
    (tmp_path / "demo.exo").write_text(SPEC)
    command = [*COMMAND, "check", "demo.exo", "--engine", "nusmv", "--nusmv", program, *options]
    killed(command, tmp_path, token, 4 if not options else 5)


def test_while_a_compiler_runs(tmp_path: Path, token: str, program: Path) -> None:
    (tmp_path / "demo.exo").write_text(ONCE)
    killed([*COMMAND, "check", "demo.exo"], tmp_path, token, 4, CC=str(program))
