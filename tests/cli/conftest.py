"""The command as a process of its own, as users run it."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.cli.command import COMMAND, SPEC, environment

Run = Callable[..., subprocess.CompletedProcess[str]]


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
