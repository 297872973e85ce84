"""Which steps are dropped from a lasso together, and what is left."""

from collections.abc import Mapping

import pytest

from exover.checks.run import check_all
from exover.checks.schedule.engines import Engines
from exover.checks.schedule.plan import CheckPlan
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import LassoQuestion
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.liveness import judging
from exover.engines.aig.liveness.lassos import _joined, _left, _resting, _rolled, closed, shorter, shown
from exover.engines.aig.liveness.random_lassos import InputLasso, SimulatedCircuit
from exover.engines.aig.ways.home_states import HomeSpace, inputs_of
from exover.model.event import Ask, Report
from exover.model.expression import Status
from exover.model.property import NO_PROPERTIES, Atom, Happened, always, finally_
from exover.model.semantics import Reference
from exover.model.trace import run
from tests.engines.aig.runs import known_runs
from tests.support.engines import model_of
from tests.support.small import compiled

STEPS = tuple(frozenset({number}) for number in range(8))


def test_steps_that_overlap_are_not_dropped_twice() -> None:
    pairs = [frozenset({at, at + 1}) for at in (0, 1, 2, 4, 5, 7)]
    assert _joined(pairs) == [frozenset({0, 1, 2, 3}), frozenset({0, 1, 2, 3, 4, 5, 7, 8})]
    assert _joined(pairs[:2]) == []


TWO = "spec s; module m { request a(); request b(n: int in 0 .. 9); }"
AGAIN = LassoQuestion(always(finally_(Happened("ended", "m.a"))), False)


@pytest.fixture(scope="module")
def found() -> tuple[SimulatedCircuit, InputLasso, Inputs]:
    """A lasso on which `m.a` ends again and again, and the steps that ask for `m.b` and report it."""
    encoding = Encoding(compiled(model_of(TWO)), NO_PROPERTIES)
    number = {(each.kind.verb, each.kind.name): place for place, each in enumerate(encoding.events)}
    lassos: list[InputLasso] = []

    def noted(machine: SimulatedCircuit, found: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
        short = shorter(machine, found)
        lassos.extend(short.values())
        return short

    asked = judging.Judging(encoding, [AGAIN], decide, lambda *_: None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judging, "shorter", noted)
        asked.run(known_runs(encoding))
    (lasso,) = lassos
    guesses = lasso.loop[0].difference(encoding.given)
    others = tuple(inputs_of(encoding, number[verb, "m.b"], (3,)) | guesses for verb in ("ask", "report"))
    return asked.machine, lasso, others


def test_steps_that_undo_each_other_are_dropped_together(found: tuple[SimulatedCircuit, InputLasso, Inputs]) -> None:
    """What asks for `m.b` takes its report with it; the report cannot be dropped alone."""
    machine, lasso, (ask, report) = found
    first, last = lasso.loop
    longer = InputLasso((*lasso.stem, ask, report), (ask, first, report, last))
    turn = len(longer.stem)
    drops = [frozenset[int](), frozenset({turn}), frozenset({turn + 2}), frozenset({turn, turn + 2})]
    less = InputLasso(longer.stem, (first, last))
    assert closed(machine, [(0, longer.without(each)) for each in drops]) == [longer, less, None, less]
    assert len(shorter(machine, {0: longer})[0].loop) == 2


def test_a_loop_brings_back_what_no_question_looks_at(found: tuple[SimulatedCircuit, InputLasso, Inputs]) -> None:
    """The past of `m.b` is no matter to the question; followed once more, the loop brings it back, too."""
    machine, lasso, (ask, report) = found
    longer = InputLasso(lasso.stem, (*lasso.loop, ask, report))
    turned = InputLasso(lasso.stem + longer.loop, longer.loop)
    assert closed(machine, [(0, longer)]) == [longer]
    assert closed(machine.exact, [(0, longer), (0, turned)]) == [None, turned]
    short = shorter(machine, {0: longer})[0]
    trace = shown(Concretizer(machine.encoding), short)
    assert trace is not None
    assert trace.loop_start is not None and len(trace.moments) - trace.loop_start == len(short.loop)
    assert trace.loop_start <= len(short.stem)


def test_what_stands_before_a_loop_and_at_its_end_is_in_the_loop() -> None:
    """Asked while it is active `m.a` is refused, which changes nothing."""
    reference = Reference(model_of(TWO))
    ask, other, ended = Ask("m.a"), Ask("m.b", (3,)), Report("m.b", 0, "failed")
    events = (other, ended, ask, other, ask, ended, other, ask)
    states = [reference.start()]
    for event in events:
        states.append(reference.step(states[-1], event)[0])
    trace = _rolled(run(reference, events, 5), states)
    assert trace == run(reference, events[:6], 3)
    assert _rolled(trace, states) == trace


def test_a_loop_that_observes_reads_what_is_left_to_be_read() -> None:
    """That `p` is 7 matters to nothing: without the first observation the loop reads what `p` is at the start."""
    encoding = Encoding(
        compiled(model_of("spec s; poster p: int in 0 .. 9 = 2; module m { request a(); }")), NO_PROPERTIES
    )
    number = {(each.kind.verb, each.kind.name): place for place, each in enumerate(encoding.events)}
    machine = judging.Judging(encoding, [AGAIN], decide, lambda *_: None).machine.exact
    seven, two = (inputs_of(encoding, number["observe", "p"], (value,)) for value in (7, 2))
    ask = inputs_of(encoding, number["ask", "m.a"])
    assert _left(machine, InputLasso((seven, ask), (seven,)), frozenset({0})) == InputLasso((ask,), (two,))
    assert _left(machine, InputLasso((two, ask, seven), (seven,)), frozenset({2})) == InputLasso((two, ask), (two,))
    assert _left(machine, InputLasso((seven, ask), (seven,)), frozenset({1})) == InputLasso((seven,), (seven,))


def test_a_loop_may_begin_where_its_monitor_does() -> None:
    """That `m.a` waits is true of the moments after the step that asks for it, and is watched from the next on."""
    late = "spec late; poster ok: bool = false; module m { request a() { wait until ok; } request b() { check ok; } }"
    outcome = check_all(compiled(model_of(late)), lambda _: None, CheckPlan({"starvation"}, engines=Engines(("aig",))))
    (finding,) = (each for each in outcome.findings if each.subject == "m.a")
    assert finding.trace is not None
    assert (len(finding.trace.moments), finding.trace.loop_start) == (2, 1)


LATE = """spec late; poster p: bool = true; module m { request a() { wait until p; } request b(); }
mutex m.a, m.b by wait;"""


def test_what_makes_a_request_wait_for_ever_comes_before_it_asks() -> None:
    """Else something else has to keep it waiting until then: no single step can be dropped, nor any two."""
    encoding = Encoding(compiled(model_of(LATE)), NO_PROPERTIES)
    number = {(each.kind.verb, each.kind.name): place for place, each in enumerate(encoding.events)}
    ask, other = (inputs_of(encoding, number["ask", name]) for name in ("m.a", "m.b"))
    ended, low = inputs_of(encoding, number["report", "m.b"]), inputs_of(encoding, number["observe", "p"], (0,))
    waits = LassoQuestion(finally_(always(Atom(Status("waiting", "m.a")))), True)
    machine = judging.Judging(encoding, [waits], decide, lambda *_: None).machine
    (short,) = shorter(machine, {0: InputLasso((other, ask, low, ended), (low,))}).values()
    assert short == InputLasso((low, ask), (low,))


def test_once_all_is_reported_a_run_is_at_rest() -> None:
    """The report is none of the steps of the lasso, and a second one is impossible."""
    encoding = Encoding(compiled(model_of(LATE)), NO_PROPERTIES)
    number = {(each.kind.verb, each.kind.name): place for place, each in enumerate(encoding.events)}
    ask, other = (inputs_of(encoding, number["ask", name]) for name in ("m.a", "m.b"))
    high = inputs_of(encoding, number["observe", "p"], (1,))
    ended = next(slot.events[0] for slot in HomeSpace(encoding).slots() if slot.request == "m.b")
    launched = LassoQuestion(finally_(Happened("launched", "m.b")), True)
    machine = judging.Judging(encoding, [launched], decide, lambda *_: None).machine.exact
    rest = InputLasso((other, ended), (high,))
    assert _resting(machine, {0: InputLasso((other,), (ask,))}) == {0: rest}
    assert closed(machine, [(0, InputLasso((other, ended, ended), (high,)))]) == [rest]
