"""What `self.p` chooses among is told by few counters, and asked just after what chooses."""

from pathlib import Path

import pytest

from exover.ocrd.compile import compile_model
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import Manager
from exover.ocrd.vector import Vocabulary
from tests.support.engines import DIGEST, model_of

SPECS = Path(__file__).parents[1] / "specs"

PAST = """spec past;
enum kind {{ red, green, blue, white }}
module m {{
    request put(what: kind, n: int in 1 .. 100);
    request go(at: kind);
    request take(what: kind, n: int in 1 .. 100, at: kind) {{
        check like: past(m.put with {where});
        check there: past(m.go with at == self.at);
    }}
}}
"""


def nodes(where: str) -> int:
    return compile_model(model_of(PAST.format(where=where)), DIGEST).figures.nodes


def test_parts_of_a_past_add_up_and_do_not_multiply() -> None:
    """A flag for each value of a parameter, a test of it, one that chooses it and one or two that tell it."""
    assert nodes("what == self.what and n >= self.n") < 4 * (4 + 100 + 4) + 40
    assert nodes("not (what != self.what or n < self.n)") < 4 * (4 + 100 + 4) + 40


def test_the_tables_of_a_cell_for_sample_preparation_are_small() -> None:
    """They had 3 392 nodes: 800 flags of `head.aspirate`, for each liquid and volume, and what chooses among them."""
    model = model_of((SPECS / "lab_automation.exo").read_text(encoding="utf-8"))
    found = compile_model(model, DIGEST)
    assert found.figures.nodes < 1050
    assert len(found.tables.entries) < 350


@pytest.mark.parametrize("values", [10, 20])
def test_what_slots_select_by_is_tested_before_what_they_select_from(values: int) -> None:
    """The second slot's argument was tested after the counters, whose values a diagram then has to remember."""
    held = f"(p: int in 1 .. {values}) instances 2"
    clean = f"request clean{held} {{ fail when active(m.go with p == self.p); }}"
    questions = DecisionContext(Vocabulary(model_of(f"spec s; module m {{ request go{held}; {clean} }}")))
    manager = Manager()
    Decider(questions, manager).decide(questions.model.request["m.go"])
    assert len(manager) < 40 * values
