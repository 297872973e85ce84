"""What a `fail when` compares with `self.p` is compared slot by slot: its tables do not grow with the values."""

import pytest

from exover.emit.describe import Description
from exover.ocrd import symbolic
from exover.ocrd.compile import Compiled, compile_model
from exover.ocrd.vector import PlaceValue
from tests.support.engines import DIGEST, agree_at_random, model_of
from tests.support.oracle import explore
from tests.support.small import compiled, differences, findings_of

OWN = """spec own; module m {{
    request a(x: int in 0 .. {last}) instances {slots} {{ fail when active(m.a with x {op} self.x); {more} }}
}}"""
OTHER = """spec other; module m {{
    request a(x: int in 0 .. {last}) instances {slots} {{ fail when active(m.b with y {op} self.x); {more} }}
    request b(y: int in 0 .. {last}) instances {others};
}}"""


def made(text: str) -> Compiled:
    return compile_model(model_of(text), DIGEST)


@pytest.mark.parametrize("more", ["", "interrupts self;"])
@pytest.mark.parametrize("op", ["==", "!=", "<", ">="])
def test_the_slots_of_a_request_are_compared_whatever_values_they_have(op: str, more: str) -> None:
    """Two slots with 40 values took more than 1 500 000 nodes while they were made."""
    for slots, most in ((2, 60), (3, 200)):
        few, many = (made(OWN.format(last=last, slots=slots, op=op, more=more)) for last in (19, 199))
        assert few.figures.nodes == many.figures.nodes < most


@pytest.mark.parametrize("op", ["==", "<"])
def test_the_slots_of_two_requests_are_compared_whatever_values_they_have(op: str) -> None:
    """Of 40 values these tables had 15 000 nodes."""
    for slots, others in ((1, 1), (2, 1), (2, 2), (1, 4)):
        texts = [OTHER.format(last=last, slots=slots, others=others, op=op, more="") for last in (19, 199)]
        few, many = (made(text).figures.nodes for text in texts)
        assert few == many < 150


def test_what_is_in_many_slots_is_counted_by_its_values() -> None:
    """So many comparisons have more outcomes than there are values: of 20 slots they were too many to be told apart."""
    few, many = (made(OTHER.format(last=2, slots=2, others=others, op="==", more="")) for others in (3, 20))
    assert few.figures.nodes == many.figures.nodes < 200


CLEARING = """spec clearing; module m {
    request a(x: int in -2 .. 2) instances 2 { fail apart: when active(m.b with y == self.x); }
    request b(y: int in -2 .. 2) { fail late: when active(m.b with y > self.y) or active(m.a with x > self.y); }
}"""
SPECS = {
    "clearing": CLEARING,
    "what is clearing, of two bools": """spec s; module m {
        request a(x: bool, n: {one, two}) { fail apart: when active(m.b with y == self.x and n != self.n); }
        request b(y: bool, n: {one, two}) { interrupts m.a; fail when active(m.a with x != self.y or n == self.n); }
    }""",
    "sums and constants": """spec s; module m {
        request a(x: int in 0 .. 9, z: int in 0 .. 3) instances 2 {
            fail near: when active(m.a with x + z < 2 * self.x - self.z and not (x in 4 .. 6 or self.z == 1));
            interrupts self else wait;
        }
    }""",
    "reals beside": """spec s; poster hot: bool = false; module m {
        request a(x: int in 0 .. 9, v: real in 0 .. 1) instances 2 {
            fail fast: when active(m.b with (v > 0.5 or y > self.x) and y != self.x) and hot else wait;
        }
        request b(y: int in 0 .. 9, v: real in 0 .. 1) instances 2 { settle until not active(m.a with x == self.y); }
    } mutex m.b over m.a;""",
    "named by another kill": """spec s; poster hot: bool = false; module m {
        request a(x: int in 1 .. 5) instances 3 { fail when active(m.a with x < self.x) or not active(m.b); }
        request b(y: int in 1 .. 5) { fail when active(m.a with x + 1 >= self.y) and past(m.a with x == self.y); }
    } forbid active(m.a) and active(m.b) and hot by kill m.a or kill m.b;""",
}


@pytest.mark.parametrize("text", SPECS.values(), ids=SPECS)
def test_slots_that_are_compared_answer_as_the_rules(text: str) -> None:
    for seed in range(4):
        agree_at_random(text, seed, events=300, native=not seed, rust=not seed and text is CLEARING)


GUARD = """spec guard; module m {{
    request a(x: int in 0 .. {last}, z: int in 0 .. {last}) {{
        check not {phase}(m.b with y == self.x and w == self.z);
    }}
    request b(y: int in 0 .. {last}, w: int in 0 .. {last}) instances 2 {{ {clause} }}
}}"""


@pytest.mark.parametrize("phase", ["active", "running", "stopping", "waiting"])
def test_two_arguments_of_a_guard_are_compared_if_they_have_many_values_together(phase: str) -> None:
    """With 64 values each they had 16 000 nodes."""
    few, many = (made(GUARD.format(last=last, phase=phase, clause="")).figures.nodes for last in (16, 127))
    assert few == many < 40


@pytest.mark.parametrize(
    "clause", ["interrupts self;", "wait until not active(m.a); fail when active(m.a with x > self.w);"]
)
@pytest.mark.parametrize("phase", ["active", "running", "stopping", "waiting"])
def test_guards_that_compare_answer_as_the_rules(phase: str, clause: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = GUARD.format(last=2, phase=phase, clause=clause)
    counted = made(text).tables
    monkeypatch.setattr(symbolic, "MOST_SELECTED", 0)
    assert made(text).tables != counted
    for seed in range(3):
        agree_at_random(text, seed, events=300)


def places(found: Compiled) -> set[PlaceValue]:
    """Return the arguments of waiting places that tables look at."""
    return {quantity for element in found.entries for _, quantity in element if isinstance(quantity, PlaceValue)}


def test_an_argument_that_is_clearing_is_compared_too() -> None:
    found = made(CLEARING)
    assert places(found) == {PlaceValue("m.a", "x"), PlaceValue("m.b", "y")}
    assert "waiting(m.b).y" in Description(found.model, found.tables).entries


@pytest.mark.parametrize("kind", ["bool", "int in 4 .. 5"])
def test_the_checks_find_what_enumeration_finds(kind: str) -> None:
    text = f"""spec s; module m {{
        request a(x: {kind}) {{ fail apart: when active(m.b with y == self.x); }}
        request b(y: {kind}) {{ interrupts self; fail late: when active(m.a with x != self.y); }}
    }}"""
    found = compiled(model_of(text))
    assert places(found)
    assert not differences(explore(found.model, 500, 5000), findings_of(found))
