"""Whether assumptions let runs go on is seen, and where they do not it is not claimed."""

import pytest

from exover.engines.aig.answer import Answer, Unreachable
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import Circuit
from exover.engines.aig.machine_closure import is_machine_closed
from exover.engines.aig.pdr import decide
from exover.pipeline import build, load, load_properties
from exover.source import Source

SPEC = """spec small;
poster charge: int in 0 .. 100 = 50;
module m { request go() { fail low: when charge < 10; } request stop(); }
"""


def excluded(circuit: Circuit) -> bool:
    answers: list[Answer] = []
    decide(circuit, lambda _, answer: answers.append(answer))
    return all(isinstance(answer, Unreachable) for answer in answers)


@pytest.mark.parametrize(
    ("assumed", "wanted"),
    [
        ("", True),
        ("assume always (charge >= 5);", True),  # the least reading is not allowed, but an ask is
        ("assume never (charge < 5); assume fair reports;", True),
        ("assume never (ended(m.go));", False),  # what runs is never reported
        ("assume always (charge > 100);", False),
    ],
)
def test_runs_go_on_as_far_as_assumptions_let_them(assumed: str, wanted: bool) -> None:
    model = load(Source("small.exo", SPEC)).model
    assert model is not None
    properties = load_properties(Source("small.prop", f"for small; {assumed}"), model).properties
    assert properties is not None
    encoding = Encoding(build(model).compiled, properties)
    assert is_machine_closed(encoding, True, excluded) is wanted
