"""Reports and observations lead to the home states that are found, and what may be active there is what comes again."""

from collections.abc import Callable, Sequence
from contextlib import closing

import pytest

from exover.engines.aig.circuit.answer import Answer, Inputs
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.induction import pdr
from exover.engines.aig.induction.implicants import Decide
from exover.engines.aig.simulation.evaluation import Evaluator, whole_evaluator
from exover.engines.aig.simulation.exploration import Seed, state_of
from exover.engines.aig.simulation.lanes import LaneState, at_lane, side_by_side
from exover.engines.aig.ways.home_ranking import _Launches, home_space
from exover.engines.aig.ways.home_states import HomeSpace
from exover.model.property import NO_PROPERTIES
from tests.engines.aig.runs import known_runs
from tests.support.engines import model_of
from tests.support.small import VARIED, compiled, small_spec_of

OWED = """spec s; module m { request on(); request off() { on ok forget m.on; } request reset(); request other(); }
poster hot: bool = false;
latch alarm: when hot until m.reset;
launch l: m.off() when alarm and past(m.on);
"""
AGAIN = OWED.replace(" { on ok forget m.on; }", ";")
DUE = """spec s; resource stock: 1 consumable by reject; mutex hands: m.work, m.hold by wait;
module m { request work() { consumes stock 1; } request hold(); request refill() { produces stock 1; } }
launch fill: m.refill() when level(stock) < 1;
"""
DUE_AGAIN = DUE + "launch again: m.work() when past(m.refill);\n"
OTHER_OUTCOME = """spec s; module m { state open: bool = true; request go() { on ok set open = true; }
    request lock() fails (jammed) { on failed set open = false; on ok set open = true; } }
launch shut: m.lock() when m.open;
"""
CHAIN = """spec s; module m { request a(); request b() { on ok forget m.a; } request c() { on ok forget m.b; } }
launch l: m.b() when past(m.a); launch k: m.c() when past(m.b);
"""
NEVER_DUE = """spec s; module m { state on: bool = false; request off();
    request a() { on launch set on = true; on ok set on = false; on failed set on = false;
        on interrupted set on = false; }
}
launch l: m.off() when m.on and not active(m.a);
"""
WAITS = """spec s; poster hot: bool = false; mutex x: m.a, m.b by wait; mutex y: m.b, m.off by wait;
module m { request a() instances 2; request b() instances 2; request off(); request reset(); }
latch alarm: when hot until m.reset; launch l: m.off() when alarm;
"""
COLD = "spec s; poster cold: bool = true; module m { request heat(); request other(); } launch l: m.heat() when cold;"


def unasked(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    """Leave it open what can be reached."""


def decide(circuit: Circuit, say: Callable[[int, Answer], None], stop: Callable[[], bool]) -> None:
    pdr.decide(circuit, say, stop=stop, budget=20_000_000)


def home_of(spec: str, decide: Decide = unasked) -> tuple[Encoding, HomeSpace | None]:
    encoding = Encoding(compiled(model_of(spec)), NO_PROPERTIES)
    _ = encoding.moments.owed, encoding.moments.domain
    return encoding, home_space(encoding, encoding.graph.copy(), [None], decide, lambda: False)


@pytest.mark.parametrize(
    ("spec", "free"),
    [
        (OWED, set()),  # any report may be what launches `m.off`, which was owed already; its own makes the rule calm
        (AGAIN, {"m.off"}),
        (DUE, set()),  # who waited makes it due
        (DUE_AGAIN, {"m.refill", "m.work"}),
        (OTHER_OUTCOME, set()),
        (CHAIN, set()),
        (NEVER_DUE, {"m.off"}),
        (WAITS, {"m.off"}),
    ],
)
def test_what_comes_again_and_again_may_be_active_at_home(spec: str, free: set[str]) -> None:
    _, home = home_of(spec)
    assert home is not None
    assert home.free == free


def test_what_no_reachable_state_launches_again_is_idle_at_home() -> None:
    _, home = home_of(NEVER_DUE, decide)
    assert home is not None
    assert not home.free


def test_there_is_no_home_where_no_report_of_a_slot_is_a_step() -> None:
    encoding, home = home_of(OWED)
    assert home is not None
    events = [event for event in encoding.events if (event.kind.verb, event.kind.name) == ("report", "m.on")]
    encoding.legal = encoding.graph.all((encoding.legal, *(lit(event.chosen) ^ 1 for event in events)))
    assert home_space(encoding, encoding.graph.copy(), [None], unasked, lambda: False) is None


def test_readings_are_taken_with_which_home_states_are_found() -> None:
    """At first it is cold, and whatever is heated is heated again."""
    encoding, home = home_of(COLD)
    assert home is not None
    assert home.free == {"m.heat"}
    (literal,) = encoding.latches.literals["cold"]
    warm = frozenset(node for node, initial in encoding.graph.latches if initial and node != literal >> 1)
    found = home_space(encoding, encoding.graph.copy(), [warm, None], unasked, lambda: False)
    assert found is not None
    assert not found.free
    assert not found.fixed[literal >> 1]


def led(cone: Evaluator, state: LaneState, runs: Sequence[Inputs]) -> LaneState:
    """Return the states to which runs lead from states side by side, one from each."""
    for step in range(max(map(len, runs))):
        going, inputs = side_by_side(runs, step)
        state = cone.after(cone.values(state, inputs), going)
    return state


@pytest.mark.parametrize("spec", [OWED, AGAIN, DUE, OTHER_OUTCOME, CHAIN, WAITS, *VARIED])
def test_reports_and_observations_lead_there(spec: str | int) -> None:
    encoding, home = home_of(small_spec_of(spec) if isinstance(spec, int) else spec)
    assert home is not None
    circuit = encoding.circuit([encoding.graph.all(encoding.following)])
    start = Seed(frozenset(latch.node for latch in circuit.latches if latch.initial), ())
    runs, cone = known_runs(encoding), whole_evaluator(circuit)
    known = led(cone, state_of(circuit.latches, [start] * len(runs)), runs)
    once = led(cone, known, [home.run] * len(runs))
    often = led(cone, once, [home.run * 3] * len(runs))
    lanes = range(len(runs))
    assert any(at_lane(known, lane) != at_lane(once, lane) for lane in lanes)
    for lane in lanes:
        true = at_lane(often, lane)
        assert {node: node in true for node in home.fixed} == home.fixed


def test_what_is_active_again_after_its_report_is_newly_active() -> None:
    encoding, _ = home_of(AGAIN)
    graph = encoding.graph.copy()
    active = encoding.latches.slots["m.off", 0].active
    (before,) = encoding.latches.literals[active]
    (report,) = (lit(e.chosen) for e in encoding.events if str(e.kind) == "report m.off[0] ok")
    again = graph.all((report, encoding.legal, before, encoding.following[before], encoding.moments.domain))
    new = _Launches(encoding, graph).of("m.off", active)
    with closing(Solver(graph.within_step())) as solver:
        assert solver.satisfiable([solver.literal(again)])
        assert not solver.satisfiable([solver.literal(again), solver.literal(new ^ 1)])
