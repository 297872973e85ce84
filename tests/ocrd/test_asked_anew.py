"""Decisions that would have to remember too much ask anew: they stay small, and decide as the rules say."""

from dataclasses import replace

import pytest

from exover.equivalence.path_equivalence import PathComparison, UndecidedPaths
from exover.equivalence.path_feasibility import PathFeasibility
from exover.ocrd import decision
from exover.ocrd.compile import Compiled, compile_model
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.forest import CONTEXTS_IN_ALL, Forest
from exover.ocrd.order import SiftingWork, sift
from exover.ocrd.roots import decided
from exover.ocrd.vector import Vocabulary
from tests.support.engines import DIGEST, disagreement, model_of
from tests.support.events import Stream
from tests.support.generate import Size, random_spec


def entangled(rules: int) -> str:
    """Return rules of one request that each read two posters: together they refuse it, each alone kills a slot."""
    posters = "".join(f"poster p{n}: bool = false; poster q{n}: bool = false; " for n in range(rules))
    requests = "".join(f"request x{n}(); " for n in range(rules))
    told = "".join(
        f"forbid f{n}: active(m.r) and ((p{n} and q{n}) or (active(m.x{n}) and (p{n} or q{n}))) by kill m.x{n};\n"
        for n in range(rules)
    )
    return f"spec s; {posters} module m {{ request r(); {requests} }}\n{told}"


def made(text: str) -> Compiled:
    return compile_model(model_of(text), DIGEST)


def test_a_decision_of_many_independent_rules_that_kill_is_linear_in_them() -> None:
    """As one diagram that asks each poster once, the decision on `m.r` has 3^n nodes."""
    small, middle, large = (made(entangled(count)).figures.nodes for count in (20, 40, 60))
    assert large - middle <= 1.5 * (middle - small) < small


def test_what_asks_anew_answers_as_the_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decision, "LARGE", 100)
    monkeypatch.setattr(decision, "SMALL", 10)
    text = entangled(6)
    found = disagreement(text, tuple(Stream(model_of(text), 0).lines(400)), native=True)
    assert found is None, f"\n{found}"


@pytest.mark.parametrize("seed", range(12))
def test_random_specs_answer_alike_however_often_they_ask_anew(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    text = random_spec(seed, Size())
    once = made(text).tables.nodes
    monkeypatch.setattr(decision, "LARGE", 0)
    monkeypatch.setattr(decision, "SMALL", seed % 3)
    assert seed or made(text).tables.nodes != once
    found = disagreement(text, tuple(Stream(model_of(text), seed).lines(150)))
    assert found is None, f"\n{found}"


def test_the_tables_are_compared_with_the_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decision, "LARGE", 100)
    monkeypatch.setattr(decision, "SMALL", 10)
    compiled = made(entangled(6))
    assert PathComparison(compiled, PathFeasibility(compiled)).decides("m.r")
    nodes = list(compiled.tables.nodes)
    tested = next(
        number for number in compiled.tables.below(compiled.tables.requests[0].decide) if nodes[number].code >= 0
    )
    nodes[tested] = replace(nodes[tested], low=nodes[tested].high, high=nodes[tested].low)
    damaged = replace(compiled, tables=replace(compiled.tables, nodes=tuple(nodes)))
    with pytest.raises(UndecidedPaths):  # sets of states tell
        PathComparison(damaged, PathFeasibility(damaged)).decides("m.r")


def test_the_work_for_smaller_diagrams_is_bounded_for_all_together() -> None:
    """So large specs take longer by their nodes, and not by what is granted to each of hundreds of diagrams."""
    requests = "".join(f"request x{n}() {{ on launch set s = {n % 9}; }} " for n in range(12))
    posters = "".join(f"poster p{n}: bool = false; " for n in range(6))
    rules = "".join(
        f"forbid f{n}: m.s > {n} and (p{n} or active(m.x{5 - n})) and active(m.x{n}) by kill m.x{n};\n"
        for n in range(6)
    )
    model = model_of(f"spec s; {posters} module m {{ state s: int in 0 .. 9 = 0; {requests} }}\n{rules}")
    questions = DecisionContext(Vocabulary(model))
    manager, root = decided(questions, "m.x7")
    work = SiftingWork(100)
    assert sift(manager, root, work)[1] != root and work.left <= 0
    assert sift(manager, root, work) == (manager, root)
    reached = len(manager.below([root]))
    free, bound = Forest(questions.numbers), Forest(questions.numbers, contexts=0)
    assert free.plant(manager, root) != bound.plant(manager, root)
    assert free.contexts < CONTEXTS_IN_ALL and -2 * reached <= bound.contexts <= 0
