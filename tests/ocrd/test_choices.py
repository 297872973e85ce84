"""What `self.p` chooses among is told by few counters, and asked just after what chooses."""

from pathlib import Path

from exover.ocrd.compile import compile_model
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
