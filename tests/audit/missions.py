"""Missions for the tests of audits: what robots under other rules did, and audits of them by each engine."""

import json
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any

import pytest

from exover.audit.checkers import ReferenceChecker, TableChecker
from exover.audit.follow import AuditChecker, Follower
from exover.audit.mission import read_line
from exover.audit.native import FLAGS, NativeAuditor, compile_library
from exover.audit.sources import whole_lines
from exover.audit.trail import AuditRow, MissionFigures
from exover.engines.compiler import NativeUnavailable, find_compiler
from exover.model.model import Model
from exover.model.wire import answer_line
from exover.ocrd.tables import Tables
from exover.pipeline import build, load
from exover.run.simulate import ReferenceEngine, answers
from exover.source import Source
from tests.support.events import Stream

WARNINGS = ("-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
QUICKLY = (*(flag for flag in FLAGS if flag != "-O3"), *WARNINGS)
ROOT = Path(__file__).parents[2]
CRANE = """spec crane;
poster wind: int in 0 .. 40 = 0 else 40;
poster calm: real in 0 .. 1 = 1;
module hoist {
    request lift(load: real in 0 .. 12) { check light: load <= 8 or wind <= 5 because "a heavy load needs calm air"; }
    request hold(side: {left, right}, grip: bool, n: int in 0 .. 3) returns (height: real in 0 .. 30)
            fails (slipped, lost) instances 2 { wait until wind <= 20; }
}
module slew { request turn() { interrupts self; } request park(); }
mutex one: hoist.lift, slew.turn by wait because "one motion at a time";
mutex away: slew.park over hoist.hold;
launch home: slew.park() when wind > 30;
"""
LOOSE = (
    CRANE.replace("by wait because", "by reject because").replace("launch home", "launch house").replace("> 30", "> 35")
)
"""The same requests under other rules."""
FREE = CRANE[: CRANE.index("mutex")]

Audited = tuple[list[AuditRow], MissionFigures]


@cache
def built(text: str) -> tuple[Model, Tables]:
    """Return a model and its tables."""
    model = load(Source("test.exo", text)).model
    assert model is not None
    return model, build(model).tables


@cache
def library(text: str) -> bytes:
    """Return the audit of a spec in C, compiled in the shortest time; skips the test where there is no compiler."""
    try:
        find_compiler()
    except NativeUnavailable as reason:
        pytest.skip(str(reason))
    return compile_library(*built(text), QUICKLY)


def by_python(text: str, lines: Iterable[bytes], make: Callable[[Model, Tables], AuditChecker]) -> Audited:
    """Return the rows and figures of an audit that is done in Python."""
    model, tables = built(text)
    rows: list[AuditRow] = []
    follower = Follower(model, make(model, tables), rows.append, wants_asks=True)
    for number, noted in whole_lines(model, BytesIO(b"\n".join(lines))):
        follower.take(number, noted)
    return rows, follower.figures.plain()


def by_reference(text: str, lines: Iterable[bytes]) -> Audited:
    """Return the audit of the reference interpreter."""
    return by_python(text, lines, lambda model, _: ReferenceChecker(model))


def by_tables(text: str, lines: Iterable[bytes]) -> Audited:
    """Return the audit of the walked tables."""
    return by_python(text, lines, TableChecker)


def by_c(text: str, lines: Iterable[bytes]) -> Audited:
    """Return the audit in C."""
    model, tables = built(text)
    rows: list[AuditRow] = []
    auditor = NativeAuditor(model, tables, library(text))
    try:
        auditor.start(rows.append, wants_asks=True)
        data = b"\n".join(lines)
        taken = auditor.lines(data, True, lambda _, *line: read_line(model, *line) if line[0].strip() else None)
        assert taken == len(data)
        return rows, auditor.figures()
    finally:
        auditor.close()


def told(text: str, seed: int, length: int) -> list[bytes]:
    """Return what a robot did under the rules of a spec, as the log of its gate."""
    model, _ = built(text)
    found = []
    for number, (line, answer) in enumerate(Stream(model, seed).answered(length)):
        decision = {"time": 1700000000.5 + number, "event": json.loads(line), "actions": json.loads(answer)["actions"]}
        found.append(json.dumps(decision).encode())
    return found


def simulated(text: str, seed: int, length: int) -> list[tuple[bytes, bytes]]:
    """Return events, many of them reports and aborts of what is not active, with the answers of `exover simulate`."""
    model, _ = built(text)
    random = Random(seed)
    lines: list[str] = []
    for line in Stream(model, seed).lines(length):
        lines.append(line)
        request = random.choice(model.requests)
        slot = {"instance": random.randrange(request.instances)}
        ends = ({"outcome": "interrupted"}, {"outcome": random.choice(("failed", "ok", "none"))})
        stray = {"report": request.name, **slot, **random.choice(ends)}
        strays = (stray, {"abort": request.name, **slot}, {"abort": request.name, "waiting": True})
        if random.randrange(2):
            lines.append(json.dumps(random.choice(strays)))
    found = answers(model, ReferenceEngine(model), lines)
    return [
        (line.encode(), answer_line(model, step, actions).encode())
        for step, (line, (_event, actions)) in enumerate(zip(lines, found, strict=True), 1)
    ]


def mixed(text: str, seed: int, length: int) -> list[bytes]:
    """Return a log of which parts are missing, stand in lines of their own, or come twice."""
    random = Random(seed)
    found: list[bytes] = []
    for line in told(text, seed, length):
        entries: dict[str, Any] = json.loads(line)
        kind = random.randrange(10)
        if kind == 0:
            continue
        event, actions = entries["event"], entries["actions"]
        if kind < 4:
            found.append(json.dumps({**event, "time": entries["time"]}).encode())
            if kind == 1:
                found += [json.dumps(action).encode() for action in actions]
            elif kind == 2:
                found.append(json.dumps({"step": 1, "actions": actions}).encode())
        elif kind < 6:
            found += [json.dumps(event).encode()]
            for action in actions:
                if "launch" in action and random.randrange(2):
                    action.pop("args", None)
                found.append(json.dumps(action).encode())
        else:
            kept = [action for action in actions if random.randrange(4)]
            found.append(json.dumps({"event": event, "actions": kept}).encode())
    return found


def shown(found: Audited) -> tuple[list[str], MissionFigures]:
    """Return rows and figures in a form in which NaN is NaN."""
    return [str(row) for row in found[0]], found[1]


def write(folder: Path, name: str, lines: Sequence[bytes | str]) -> Path:
    """Write a mission of lines."""
    path = folder / name
    path.write_bytes(b"".join((line.encode() if isinstance(line, str) else line) + b"\n" for line in lines))
    return path
