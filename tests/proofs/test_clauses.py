"""Clauses of the model checker become formulas that say the same, and prove what only whole steps exclude."""

from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from random import Random
from typing import Any

import pytest

from exover.certificate.check import Checker
from exover.certificate.table import Refused, decode
from exover.certificate.verify import read, verify
from exover.engines.aig.circuit.words import Grid
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.state import AllocatedRange, Latches
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace
from exover.ocrd.packing import pack
from exover.pipeline import Build, build
from exover.proofs.certify import certificate, render
from exover.proofs.clauses import Clauses, pieces
from exover.proofs.runs import RunWriter
from exover.proofs.statement import Statement, Unsaid
from tests.proofs.runs import REALS, steps
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

SPEC = """spec order;
poster p: int in 0 .. 9 = 0 else 9;
module m {
    state deep: int in 0 .. 3 = 0;
    request a() {}
    request b() { wait until p > 5 and running(m.a); on launch set deep = 1; }
    request c() { check deep == 1; on ok set deep = 3; }
}
forbid high: active(m.a) and p > 5 by kill m.a because "too high";
"""
Json = dict[str, Any]
NEVER = "m.c"
"""What never happens, for the rule kills before what waits is looked at."""


# ---- what clauses say ----


def bits_of(latches: Latches, state: State) -> dict[int, bool]:
    """Return the values of latches, by node, in a concrete state."""
    found = {}
    for name, term in latches.of_state(state).items():
        span = latches.spans[name]
        value = term.constant if span.grid is None else span.grid.position(Fraction(term.number))
        for k, bit in enumerate(latches.literals[name]):
            found[bit >> 1] = bool((int(value) - span.low) >> k & 1)
    return found


@pytest.mark.parametrize("seed", (0, 2, 4))
def test_clauses_say_of_states_what_they_say_of_latches(seed: int) -> None:
    text, random = REALS if seed == 0 else small_spec_of(seed), Random(seed)
    model = model_of(text)
    made = compiled(model)
    latches = Encoding(made, NO_PROPERTIES).latches
    writer, checker = Clauses(latches, Statement(model)), Checker(decode(pack(made.tables)))
    nodes = [bit for bits in latches.literals.values() for bit in bits]
    clauses = [(node ^ sign,) for node in nodes for sign in (0, 1)]
    clauses += [tuple(bit ^ random.randrange(2) for bit in random.choices(nodes, k=4)) for _ in range(24)]
    said = {}
    for clause in clauses:
        try:
            said[clause] = checker.formula(writer.text(clause))
        except Unsaid:
            assert text == REALS
    assert len(said) > len(clauses) / 3
    reference, state, now = Reference(model), Reference(model).start(), checker.initial
    seen = set()
    for moment in steps(text, seed):
        state, _ = reference.step(state, moment.event)
        (one,) = RunWriter(writer.statement).steps(Trace((moment,)))
        now = checker.whole(checker.event(one["event"]), now, [])[0].state
        values = bits_of(latches, state)
        for clause, formula in said.items():
            truth = any(values[literal >> 1] != bool(literal & 1) for literal in clause)
            assert checker.true(formula, now) is truth, writer.text(clause)
            seen.add(truth)
    assert seen == {True, False}


def test_a_bit_of_a_number_is_ranges() -> None:
    assert pieces(AllocatedRange(3, 9), {0: True}) == [(4, 4), (6, 6), (8, 8)]
    assert pieces(AllocatedRange(3, 9), {1: False}) == [(3, 4), (7, 8)]
    assert pieces(AllocatedRange(3, 9), {2: True, 1: True}) == [(5, 9)]
    grid = Grid((Fraction(0), Fraction(5), Fraction(9)), 1)
    assert pieces(AllocatedRange(2, 10, grid), {1: True}) == [(2, 2), (4, 4)]


def test_what_cannot_be_said_is_left_out() -> None:
    grid = Grid((Fraction(0), Fraction(5), Fraction(9)), 1)
    with pytest.raises(Unsaid, match="compared"):
        pieces(AllocatedRange(2, 10, grid), {0: True})
    with pytest.raises(Unsaid, match="too many"):
        pieces(AllocatedRange(0, 1023), {0: True})
    with pytest.raises(Unsaid, match="too many"):
        pieces(AllocatedRange(0, 1_000_000), {0: True})


# ---- what they prove ----


@pytest.fixture(scope="module")
def built() -> Build:
    return build(model_of(SPEC))


@pytest.fixture(scope="module")
def made(built: Build) -> Json:
    findings = check_by_diagrams(built.compiled).findings
    asked = [each for each in findings if each.check not in ("tables", "redundancy", "idle-guard")]
    return certificate(built.compiled, built.data, asked, NO_PROPERTIES, "0", lambda what: None)


def finding(made: Json, check: str, subject: str) -> Json:
    (found,) = [each for each in made["findings"] if (each["check"], each["subject"]) == (check, subject)]
    return found


def test_what_only_whole_steps_keep_proves_what_never_happens(built: Build, made: Json) -> None:
    assert finding(made, "reachability", NEVER)["verdict"] == "violated"
    assert finding(made, "reachability", NEVER)["proof"] == {"kind": "formula", "parts": [{"kind": "invariant"}]}
    assert made["kept"]
    found = verify(built.data, read(render(made)), None, 20)
    assert NEVER in {each["subject"] for each in found.proved if each["check"] == "reachability"}


def drop(made: Json) -> None:
    """Drop a clause without which the others are not kept."""
    made["kept"] = [text for text in made["kept"] if "reading.1" not in text]


def flip(made: Json) -> None:
    """Say the contrary of a clause."""
    made["kept"][0] = f"(not {made['kept'][0]})"


def move_up(made: Json) -> None:
    """Say that every part of a pass keeps what only whole steps keep."""
    made["invariant"] += made["kept"]


def forget_goal(made: Json) -> None:
    """Keep nothing, so that nothing follows."""
    made["kept"] = []


def claim_more(made: Json) -> None:
    """Say of what happens that it does not."""
    other = finding(made, "reachability", "m.a")
    other.update(verdict="violated", proof=deepcopy(finding(made, "reachability", NEVER)["proof"]))


def claim_in_kept(made: Json) -> None:
    """Say the same among what is kept."""
    made["kept"].append("(not launch.0)")


def claim_all(made: Json) -> None:
    """Keep what every step keeps, but no first step brings about."""
    made["kept"].append("false")


WRONG: dict[str, tuple[Callable[[Json], None], str]] = {
    "a clause is left out": (drop, "makes `kept` false"),
    "a literal is flipped": (flip, "makes `kept` false"),
    "steps for parts": (move_up, "makes false what should be invariant"),
    "false from the start on": (claim_all, "makes `kept` false"),
    "nothing kept": (forget_goal, "does not follow"),
    "a property that is not excluded": (claim_more, "does not follow"),
    "a property that is not kept": (claim_in_kept, "makes `kept` false"),
}


@pytest.mark.parametrize("what", WRONG)
def test_changed_invariants_are_refused(built: Build, made: Json, what: str) -> None:
    change, reason = WRONG[what]
    changed = deepcopy(made)
    change(changed)
    assert changed != made
    with pytest.raises(Refused, match=reason):
        verify(built.data, changed, None, 20)
