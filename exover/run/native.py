"""An engine that runs the emitted C, or Rust, in a process: compiled with the system's compiler, asked line by line.

`runner.c` describes the lines. Neither process nor file outlives the engine: the folder of the sources is removed as
soon as the process runs, and the process ends with its input.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO

from exover.emit.artefact import runtime_file
from exover.emit.c import emit_tables
from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler
from exover.model.event import (
    Action,
    Event,
)
from exover.model.model import Model
from exover.ocrd.tables import Tables
from exover.run.codec import FAULTY, ActionNumbers, Codec

FLAGS = ("-std=c99", "-O0", "-pipe")
"""Without optimization, since compiling takes longer than running a few thousand events."""
BATCH = 4000
"""The most bytes sent before answers are read; a pipe holds them, so that there is no deadlock."""


class NativeFault(RuntimeError):
    """The compiled checker failed where it must not, which is a fault of exover."""


def build(model: Model, tables: Tables, folder: Path, flags: Sequence[str] = FLAGS) -> Path:
    """Return the path of the checker's program, compiled in `folder`; raises `NativeUnavailable`."""
    return compile_with("runner.c", "runner", model, tables, folder, flags)


def compile_with(host: str, name: str, model: Model, tables: Tables, folder: Path, flags: Sequence[str]) -> Path:
    """Compile the checker with a host file to `folder/name`, and return that path; raises `NativeUnavailable`."""
    compiler = find_compiler()
    for artefact in emit_tables(model, tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / host).write_bytes(runtime_file(host))
    compile_in(folder, [*compiler, *flags, host, "exover.c", "native_tables.c", "-o", name], name)
    return folder / name


Builder = Callable[[Model, Tables, Path, Sequence[str]], Path]
"""Compiles a checker in a folder with these flags and returns the path of the program, as `build` does."""


class NativeEngine:
    """An engine in a process, which runs while the context is open; it begins in the initial state."""

    def __init__(
        self, model: Model, tables: Tables, flags: Sequence[str] = FLAGS, compiled_by: Builder = build
    ) -> None:
        self._model = model
        self._tables = tables
        self._flags = flags
        self._build = compiled_by
        self._process: subprocess.Popen[bytes] | None = None
        self._errors: IO[bytes] | None = None
        self._codec = Codec(model, tables)

    def __enter__(self) -> "NativeEngine":
        """Compile and start; raises `NativeUnavailable`."""
        try:
            self._start()
        except OSError as error:
            self._end()
            raise NativeUnavailable(f"cannot compile and run the checker: {error}") from error
        except BaseException:
            self._end()
            raise
        return self

    def _start(self) -> None:
        with tempfile.TemporaryDirectory(prefix="exover-") as folder:
            program = self._build(self._model, self._tables, Path(folder), self._flags)
            self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - it is closed when the process is
            self._process = subprocess.Popen(
                [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors
            )
            self._expect(b"ready\n")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the process."""
        self._end()

    def step(self, event: Event) -> tuple[Action, ...]:
        """Take a well-formed event and return the actions that answer it."""
        (answer,) = self._exchange([self.line(event)])
        return self._actions(answer, event)

    def replay(self, events: Iterable[Event]) -> tuple[tuple[Action, ...], ...]:
        """Reset the engine to the initial state, and return the actions that answer each of the events."""
        known = list(events)
        answers = self._exchange(["z", *map(self.line, known)])
        return tuple(self._actions(answer, event) for answer, event in zip(answers, known, strict=True))

    # ---- the process ----

    def _exchange(self, lines: Iterable[str]) -> Iterator[str]:
        """Send lines in batches, and yield the answers."""
        batch: list[bytes] = []
        size = 0
        for line in lines:
            data = line.encode() + b"\n"
            if batch and size + len(data) > BATCH:
                yield from self._send(batch)
                batch, size = [], 0
            batch.append(data)
            size += len(data)
        yield from self._send(batch)

    def _send(self, batch: list[bytes]) -> Iterator[str]:
        process = self._running()
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(b"".join([*batch, b"f\n"]))
            process.stdin.flush()
        except BrokenPipeError as error:
            raise self._fault() from error
        for _ in range(sum(line != b"z\n" for line in batch)):
            answer = process.stdout.readline()
            if not answer.endswith(b"\n"):
                raise self._fault()
            yield answer.decode("ascii")

    def _expect(self, line: bytes) -> None:
        process = self._running()
        assert process.stdout is not None
        if process.stdout.readline() != line:
            raise self._fault()

    def _running(self) -> "subprocess.Popen[bytes]":
        if self._process is None:
            raise NativeFault("the compiled checker does not run")
        return self._process

    def _fault(self) -> NativeFault:
        process = self._running()
        process.kill()
        status = process.wait()
        text = ""
        if self._errors is not None:
            self._errors.seek(0)
            text = self._errors.read().decode("utf-8", "replace").strip()
        return NativeFault(f"the compiled checker ended with status {status}: {text or 'it said nothing'}")

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    _close(stream)
            process.wait()
        if self._errors is not None:
            self._errors.close()

    # ---- events and answers ----

    def line(self, event: Event) -> str:
        """Return the line of an event for the process, without its end."""
        found = self._codec.event(event)
        counted = [str(len(found.bits))] if found.letter in "ar" else []
        return " ".join([found.letter, *map(str, found.numbers), *counted, *(f"{bits:016x}" for bits in found.bits)])

    def _actions(self, line: str, event: Event) -> tuple[Action, ...]:
        said = (self._action(text.split(), event) for text in line.split(";")[:-1])
        return (*self._codec.untold(event), *said)

    def _action(self, words: list[str], event: Event) -> Action:
        kind, request, slot, reason, launch_rule = map(int, words[:5])
        values = b"".join(int(digits, 16).to_bytes(8, sys.byteorder) for digits in words[5:])
        found = ActionNumbers(kind, request, slot, reason, launch_rule, values)
        if found.reason == FAULTY:
            raise NativeFault("the compiled checker denies everything: it found its tables inconsistent")
        try:
            return self._codec.action(found, event)
        except ValueError as error:
            raise NativeFault(f"the compiled checker answers {words}") from error


def _close(stream: IO[bytes]) -> None:
    """Close a pipe, also if its other end is closed and data is left to flush."""
    with suppress(BrokenPipeError):
        stream.close()
