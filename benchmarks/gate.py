"""The gate: its own time for an event, and what it adds to a call of a tool."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.measure import ROOT, Row
from exover.gate.binding import Binding
from exover.gate.gate import Gate, checker_of
from exover.gate.journal import JournalFile, stamped
from exover.gate.outer import Called, CallId, OuterEvent, Reported, SlotSaid
from exover.gate.reading import read_binding
from exover.model.event import Ask, Report
from exover.model.model import Model
from exover.pipeline import build, load
from exover.source import Source

FOLDER = ROOT / "examples" / "walking_assistant"
SPEC = ROOT / "specs" / "assistant.exo"
CALLS = 300
SERVER = """
import json, sys
for line in sys.stdin.buffer:
    asked = json.loads(line)
    if "id" in asked:
        answer = {"jsonrpc": "2.0", "id": asked["id"], "result": {"content": []}}
        sys.stdout.buffer.write(json.dumps(answer).encode() + b"\\n")
        sys.stdout.buffer.flush()
"""
"""Answers everything at once."""


def _assistant(text: str) -> tuple[Model, Binding]:
    model = load(Source("assistant.exo", SPEC.read_text("utf-8"))).model
    assert model is not None
    binding, mistakes = read_binding(Source("assistant.bind.toml", text), model)
    assert binding is not None, mistakes
    return model, binding


def decisions(rounds: int) -> Iterator[Row]:
    """Yield the microseconds of one outer event: a launch, a refusal or a report, the journal in a file."""
    model, binding = _assistant((FOLDER / "assistant.bind.toml").read_text("utf-8"))
    checker, reason = checker_of(model, build(model).tables)
    with tempfile.TemporaryDirectory() as folder:
        journal = JournalFile(str(Path(folder) / "log.jsonl"), print)
        gate = Gate(model, binding, checker, time.monotonic, stamped(journal))
        for slot in sorted(gate.state.unsaid):
            gate.tell(SlotSaid(slot, False))
        asked: list[OuterEvent] = [
            Called(CallId("c", 0), Ask("base.move", (0.5,))),
            Called(CallId("c", 1), Ask("arm.grab")),
        ]
        asked += [Called(CallId("c", 2), Ask("arm.grab")), Reported(Report("arm.grab", 0, "ok"))]
        asked += [Reported(Report("base.move", 0, "ok"))]
        times = []
        for _ in range(rounds * 200):
            for outer in asked:
                begin = time.perf_counter()
                gate.tell(outer)
                times.append(time.perf_counter() - begin)
        journal.close()
    note = f"99 of 100 within {sorted(times)[len(times) * 99 // 100] * 1e6:.0f} us"
    yield Row("gate: one event, decision log written", median(times) * 1e6, "us", 50, note=reason or note)


def calls(rounds: int) -> Iterator[Row]:
    """Yield the milliseconds that the gate adds to a call of a tool, to and fro."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "server.py").write_text(SERVER)
        (folder / "bind.toml").write_text(_without_watch())
        server = [sys.executable, str(folder / "server.py")]
        options = ["--bind", str(folder / "bind.toml"), "--log", str(folder / "log.jsonl"), "--unchecked"]
        gate = [sys.executable, "-m", "exover", "gate", "mcp", str(SPEC), *options, "--", *server]
        alone, through = _round_trip(server, rounds), _round_trip(gate, rounds)
    note = f"{alone:.2f} ms without it, {through:.2f} ms with it"
    yield Row("gate: added to a call of an MCP tool", through - alone, "ms", 1, note=note)


def _without_watch() -> str:
    """Return a binding that reads nothing, so that nothing but calls goes through."""
    head = '[gate]\nspec = "assistant"\nstart = "idle"\nwait = 5\n'
    bound = {"base.move": "go", "base.stop": "stop", "arm.grab": "grab"}
    return head + "".join(f'[request."{request}"]\ntool = "{tool}"\n' for request, tool in bound.items())


def _round_trip(command: Sequence[str], rounds: int) -> float:
    """Return the median milliseconds of a call that is answered at once."""
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        times = [_call(process, number) for number in range(rounds * CALLS)]
        assert process.stdin
        process.stdin.close()
    return median(times[CALLS // 2 :]) * 1000


def _call(process: "subprocess.Popen[bytes]", number: int) -> float:
    assert process.stdin and process.stdout
    params: dict[str, Any] = {"name": "grab", "arguments": {}}
    line = json.dumps({"jsonrpc": "2.0", "id": number, "method": "tools/call", "params": params}).encode() + b"\n"
    begin = time.perf_counter()
    process.stdin.write(line)
    process.stdin.flush()
    answer = json.loads(process.stdout.readline())
    took = time.perf_counter() - begin
    assert answer["result"] == {"content": []}, answer
    return took
