"""The command `exover` at work: in this process, or in one of its own.

In this process it takes a hundredth of the time: Python has begun and has imported all. What needs a process of its own
gets one: signals, closed and full streams, limits. Another hash seed of Python is had from `tests.support.warm`.
"""

import gc
import os
import signal
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any
from unittest.mock import patch

from exover.cli.arguments import parser
from exover.cli.main import main
from tests.support import warm

COMMAND = [sys.executable, "-m", "exover"]
HERE = frozenset({"input", "cwd", "env"})
"""What can be asked of a command that runs in this process."""

Ended = subprocess.CompletedProcess[str]


def environment(**changes: str) -> dict[str, str]:
    """Return the environment without what would change how Python writes."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return kept | changes


@cache
def one_parser() -> ArgumentParser:
    """Return the parser of all verbs, made once for all commands of this process: it takes as long as many of them.

    Where a command is not told how many processes look for answers it is this one, which knows no limits: to fork one
    that has all tests in it takes longer than most answers. What is about workers, or limits of them, says `--jobs`.
    """
    with patch("exover.cli.arguments.cores", lambda: 1), patch("exover.cli.options.cores", lambda: 0):
        return parser()


@dataclass(frozen=True)
class Run:
    """Runs the command in a folder and returns how it ended; options are those of `subprocess.run`."""

    folder: Path

    def __call__(self, *arguments: object, **options: Any) -> Ended:
        """Run it, in this process where that makes no difference."""
        words = [str(argument) for argument in arguments]
        given = {"cwd": self.folder, "env": environment()} | options
        if not given.keys() <= HERE:
            return self.apart(*words, **options)
        if seed := given["env"].get("PYTHONHASHSEED"):
            return self._started([str(warm.command(seed))], words, options)
        return _here(words, given["cwd"], given["env"], given.get("input", ""))

    def apart(self, *arguments: object, **options: Any) -> Ended:
        """Run it in a process of its own."""
        return self._started(COMMAND, arguments, options)

    def _started(self, program: Sequence[str], arguments: Sequence[object], options: Mapping[str, Any]) -> Ended:
        given: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": 60}
        given |= {"cwd": self.folder, "env": environment(), "encoding": "utf-8"}
        if "input" not in options:
            given["stdin"] = subprocess.DEVNULL
        return subprocess.run([*program, *map(str, arguments)], check=False, **(given | options))


def _here(words: list[str], folder: Path, env: Mapping[str, str], text: str) -> Ended:
    """Run the command in this process, and put back what it changes of the process."""
    out, err = _stream(), _stream()
    with ExitStack() as stack:
        for context in (_kept(), chdir(folder), redirect_stdout(out), redirect_stderr(err)):
            stack.enter_context(context)
        stack.enter_context(patch.dict(os.environ, env, clear=True))
        stack.enter_context(patch.object(sys, "stdin", _stream(text)))
        stack.enter_context(patch.object(sys.modules[main.__module__], "parser", one_parser))
        status = main(words)
    return subprocess.CompletedProcess(["exover", *words], status, _text(out), _text(err))


def _stream(text: str = "") -> TextIOWrapper:
    return TextIOWrapper(BytesIO(text.encode("utf-8")), encoding="utf-8", write_through=True)


def _text(stream: TextIOWrapper) -> str:
    stream.seek(0)
    return stream.read()


@contextmanager
def _kept() -> Iterator[None]:
    """Put back how often garbage is collected, and what SIGTERM does."""
    threshold, handler = gc.get_threshold(), signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        gc.set_threshold(*threshold)
        signal.signal(signal.SIGTERM, handler)
