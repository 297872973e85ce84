"""The command as a process of its own, as users run it."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., subprocess.CompletedProcess[str]]
COMMAND = [sys.executable, "-m", "exover"]

SPEC = """spec demo;
poster battery: int in 0 .. 100 = 100 else 0;
module nd { request goto(x: real in 0 .. 9); request stop(); }
mutex drive: nd.stop over nd.goto because "a stop is a stop";
"""


def environment(**changes: str) -> dict[str, str]:
    """Return the environment without what would change how Python writes."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return kept | changes


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "demo.exo"
    path.write_text(SPEC)
    return path


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def call(*arguments: object, **options: Any) -> subprocess.CompletedProcess[str]:
        options = {"capture_output": True, "stdin": subprocess.DEVNULL} | options
        if "input" in options:
            del options["stdin"]
        if "stdout" in options:
            options["stderr"] = subprocess.PIPE
            del options["capture_output"]
        command = [*COMMAND, *map(str, arguments)]
        options = {"cwd": tmp_path, "env": environment(), "encoding": "utf-8", "timeout": 60} | options
        return subprocess.run(command, check=False, **options)

    return call
