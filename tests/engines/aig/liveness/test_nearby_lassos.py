"""Lassos that are shorter than a known one, of its steps in another order and of other reports."""

import pytest

from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import LassoQuestion
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.liveness import judging, lassos
from exover.engines.aig.liveness.judging import LassoAnswer, ShownLasso
from exover.engines.aig.liveness.lassos import closed, nearer, shorter
from exover.engines.aig.liveness.nearby_lassos import nearby
from exover.engines.aig.liveness.random_lassos import InputLasso, SimulatedCircuit
from exover.engines.aig.ways.home_states import inputs_of
from exover.model.expression import Status
from exover.model.property import NO_PROPERTIES, Atom, always, finally_
from exover.model.trace import Trace
from tests.support.engines import model_of
from tests.support.small import compiled

RELAY = """spec relay;
module m {
    state on: bool = false;
    request w();
    request a() { check not on; on ok set on = true; }
    request b();
    request off() { on launch set on = false; }
}
mutex m.w, m.a by wait;
mutex m.w, m.b by wait;"""
"""While `a` and `b` take turns `w` waits for ever. An `a` that ends well can be asked again only after `off`."""
WAITS = LassoQuestion(finally_(always(Atom(Status("waiting", "m.w")))), True)


def _relay() -> tuple[SimulatedCircuit, dict[str, frozenset[int]]]:
    """Return the circuit that is asked whether `w` waits for ever, and the steps by verb, request and outcome."""
    encoding = Encoding(compiled(model_of(RELAY)), NO_PROPERTIES)
    machine = judging.Judging(encoding, [WAITS], decide, lambda *_: None).machine
    kinds = [event.kind for event in encoding.events]
    texts = [f"{each.verb} {each.name[2:]}" + f" {each.outcome}" * (each.verb == "report") for each in kinds]
    return machine, {text: inputs_of(encoding, number) for number, text in enumerate(texts)}


def _lasso(step: dict[str, frozenset[int]], *loop: str) -> InputLasso:
    """Return the lasso that asks for `a` and `w`, and then repeats steps."""
    return InputLasso((step["ask a"], step["ask w"]), tuple(step[each] for each in loop))


def test_where_less_is_done_less_has_to_be_undone() -> None:
    """Of the given lasso no steps can be dropped: an `a` that fails is none of its steps."""
    machine, step = _relay()
    once = _lasso(step, "ask b", "report a ok", "ask off", "report off ok", "ask a", "report b ok")
    local = shorter(machine, {0: InputLasso(once.stem + once.loop, once.loop)})
    assert step["ask off"] in local[0].steps
    (short,) = nearer(machine, local).values()
    assert closed(machine.exact, [(0, short)]) == [short]
    assert step["ask off"] not in short.steps
    assert (len(short.stem), len(short.loop)) == (6, 4)


def test_no_lasso_is_shorter_than_the_shortest() -> None:
    machine, step = _relay()
    shortest = _lasso(step, "ask b", "report a failed", "ask a", "report b ok")
    assert nearby(machine, 0, shortest) is None
    found = nearby(machine, 0, InputLasso(shortest.stem + shortest.loop, shortest.loop))
    assert found is not None and found.length == shortest.length
    assert closed(machine, [(0, found)]) == [found]


def test_where_the_shorter_lasso_is_no_run_the_longer_one_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where reals are compared with each other, the states of a lasso need not come back."""
    machine, step = _relay()
    once = _lasso(step, "ask b", "report a ok", "ask off", "report off ok", "ask a", "report b ok")
    answers: list[LassoAnswer] = []
    asked = judging.Judging(machine.encoding, [WAITS], decide, lambda _, answer: answers.append(answer))
    tried: list[InputLasso] = []

    def shown(concretizer: Concretizer, lasso: InputLasso) -> Trace | None:
        tried.append(lasso)
        return lassos.shown(concretizer, lasso) if len(tried) > 1 else None

    monkeypatch.setattr(judging, "shown", shown)
    asked._found({0: InputLasso(once.stem + once.loop, once.loop)})
    (answer,) = answers
    assert isinstance(answer, ShownLasso)
    assert tried[0].length < tried[1].length == len(answer.trace.moments)
