"""The bounds that are emitted hold: no event of the vectors takes more tests, answers or passes."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from exover.emit.sizes import sizes, state_bytes
from exover.model.event import Invalid
from exover.model.wire import read_event
from exover.ocrd.machine import Machine
from exover.ocrd.tables import NONE, Node
from exover.pipeline import build
from tests.runtime.compiling import ROOT, built, model_of

VECTORS = sorted(ROOT.glob("tests/vectors/*.exo"))


@dataclass
class Counting(Machine):
    """The machine that counts the tests of an event."""

    tests: int = 0

    def _walk(self, node: int) -> list[Node]:
        at = node
        while at != NONE:
            here = self.tables.nodes[at]
            self.tests += here.code >= 0
            at = here.low if here.code < 0 or self.vector[here.code] <= here.bound else here.high
        return super()._walk(node)


@pytest.mark.parametrize("path", VECTORS, ids=lambda path: path.stem)
def test_no_event_exceeds_the_bounds(path: Path) -> None:
    found = built(path)
    bounds = sizes(found.tables)
    machine = Counting(found.model, found.tables)
    most = 0
    for line in path.with_suffix(".events.jsonl").read_text(encoding="utf-8").splitlines():
        event = read_event(found.model, line)
        if not isinstance(event, Invalid):
            machine.tests = 0
            assert len(machine.step(event)) <= bounds.actions
            assert machine.tests <= bounds.tests
            most = max(most, machine.tests)
    assert most > 0


@pytest.mark.parametrize(("bound", "expected"), [(100, 4), (32_767, 4), (40_000, 8), (2**40, 8)])
def test_entries_have_room_for_sums(bound: int, expected: int) -> None:
    domain = f"int in 0 .. {bound}"
    model = model_of(f"spec s; poster a: {domain} = 0; module m {{ request r(x: {domain}) {{ check x + a < 9; }} }}")
    assert state_bytes(build(model).tables) == expected
