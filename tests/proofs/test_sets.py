"""What proofs say of a set of the loop's states is true of exactly those states of runs that stand for one of them."""

import pytest

from exover.certificate.check import Checker
from exover.certificate.table import decode
from exover.engines.bdd.space import Space
from exover.loop.finite.abstraction import abstract
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.variables import MEMORY
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.ocrd.packing import pack
from exover.proofs.runs import RunWriter
from exover.proofs.sets import Sets
from exover.proofs.statement import Statement
from tests.proofs.runs import REALS, steps
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

KINDS = {"phase", "class", "order", "place", "cell", "standing", "past", "last", "reading", "pair", "level"}


def kinds_said(text: str, seed: int) -> set[object]:
    """Return of which kinds of variables the texts were compared with the states of a random run."""
    model = model_of(text)
    made = compiled(model)
    loop = ClosedLoop(model, made.tables, made.entries)
    space, statement, checker = Space(loop), Statement(model), Checker(decode(pack(made.tables)))
    sets, values = Sets(space, statement), [(n, v) for n, each in enumerate(loop.variables) for v in range(each.size)]
    said = {
        (number, value): checker.formula(sets.text(space.is_value(number, value)))
        for number, value in values
        if loop.variables[number].key[0] not in MEMORY
    }
    reference, state, now, seen = Reference(model), Reference(model).start(), checker.initial, set[object]()
    for moment in steps(text, seed):
        state, _ = reference.step(state, moment.event)
        (one,) = RunWriter(statement).steps(Trace((moment,)))
        now = checker.whole(checker.event(one["event"]), now, [])[0].state
        stands = abstract(loop, state)
        for (number, value), formula in said.items():
            assert checker.true(formula, now) is (stands[number] == value), (loop.variables[number].key, value)
            seen |= {loop.variables[number].key[0]} if stands[number] else set()
    return seen


@pytest.mark.parametrize("seed", (1, 2, 5))
def test_sets_of_random_specs_are_said_as_they_are(seed: int) -> None:
    assert kinds_said(small_spec_of(seed), seed)


def test_every_kind_of_variable_is_said_as_it_is() -> None:
    found = {kind for seed in (4, 5) for kind in kinds_said(REALS, seed)}
    assert found >= KINDS - {"level", "last"}
