"""Random decisions, one after another: the emitted C decides as the rules, the tables and the reference do.

Of mutexes a million are compared with the rules, read a second time in C (`make soak`: 10^9). Of specs with all kinds
of rules 25 000 are compared with a walk of the same tables in Python (`make soak`: 10^6); what these are drawn from
has been answered by the reference interpreter first, and alike.
"""

import os
import subprocess
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from benchmarks.families import mutexes
from exover.emit import c
from exover.model.event import Abort, AbortWaiting, Action, Ask, Event, Observe, Report
from exover.ocrd.machine import Machine
from exover.ocrd.memory import IDLE
from exover.pipeline import build
from exover.run.native import NativeEngine
from tests.runtime.compiling import COMPILERS, SPECS, WARNINGS, built, compile_c, model_of, mutex_words
from tests.support.events import Stream

DECISIONS = int(os.environ.get("EXOVER_DECISIONS", "1000000"))
WALKED = int(os.environ.get("EXOVER_WALKED", "25000"))
SAMPLE = 600
BATCH = 10_000


def test_random_decisions(tmp_path: Path) -> None:
    model = model_of(mutexes(50))
    for artefact in c.emit(model, build(model).tables, "mutexes"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    sources = [Path(__file__).parent / "decisions.c", tmp_path / "mutexes_tables.c", tmp_path / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, "-O2", f"-I{tmp_path}"], sources, tmp_path / "decisions")
    command = [tmp_path / "decisions", str(DECISIONS)]
    done = subprocess.run(command, input=mutex_words(model), capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode()
    launched, rejected, reported = map(int, done.stdout.split())
    assert launched + rejected == DECISIONS
    assert min(launched, rejected, reported) > DECISIONS // 10


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_random_decisions_on_all_kinds_of_rules(path: Path) -> None:
    found = built(path)
    walker = Machine(found.model, found.tables)
    sample, expected = map(list, zip(*Stream(found.model, 1).events(SAMPLE), strict=True))
    with NativeEngine(found.model, found.tables) as engine:
        assert list(map(walker.step, sample)) == expected
        assert list(engine.replay(sample)) == expected
        lot = Random(path.stem)
        for _ in range(0, -(-WALKED // len(SPECS)), BATCH):
            walker.restart()
            events, answers = walk(walker, sample, lot, min(BATCH, -(-WALKED // len(SPECS))))
            assert list(engine.replay(events)) == answers


def walk(walker: Machine, sample: list[Event], lot: Random, count: int) -> tuple[list[Event], list[tuple[Action, ...]]]:
    """Return random events, most of them drawn from the sample, and how the tables answer them."""
    requests = walker.model.requests
    slots = [(request.name, slot) for request in requests for slot in range(request.instances)]
    reports = {request.name: [Report(request.name, 0, "interrupted")] for request in requests}
    others: list[Event] = []
    for event in sample:
        if isinstance(event, Report):
            reports[event.request].append(event)
        elif isinstance(event, Ask | Observe):
            others.append(event)
    events, answers = [], []
    for _ in range(count):
        active = [slot for slot, phase in zip(slots, walker.phase, strict=True) if phase != IDLE]
        kind = lot.randrange(100)
        event = lot.choice(others)
        if kind < 35 and active:
            name, slot = lot.choice(active)
            event = replace(lot.choice(reports[name]), slot=slot)
        elif kind < 40 and active:
            event = Abort(*lot.choice(active))
        elif kind < 43:
            event = AbortWaiting(lot.choice(requests).name)
        events.append(event)
        answers.append(walker.step(event))
    return events, answers
