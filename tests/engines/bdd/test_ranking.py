"""Layers of a ranking are as they should be, state by state; what is in none has a fair run that stays."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from random import Random
from types import SimpleNamespace

import pytest

from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.engines.bdd.fair_steps import Constraint, LoopSteps, fair_reports
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.manager import Set
from exover.engines.bdd.ranking import Layer, ranking
from exover.loop.finite.step_predicates import moments
from exover.model.expression import Status
from exover.model.model import NOWHERE, Model
from exover.model.property import Atom, Formula, Properties, Property
from exover.model.semantics import Reference
from tests.support.engines import model_of
from tests.support.formulas import Formulas
from tests.support.small import compiled, small_spec_of

SEEDS = (*range(10), 11, 12, *range(14, 20), 22, 23)
"""Of small specs, whose diagrams are soon made."""


@cache
def analysed(seed: int) -> tuple[Analysis, Formula]:
    """Return the loop of a small spec, in which what a random formula asks of a moment is told apart."""
    model = model_of(small_spec_of(seed))
    formula = Formulas(Random(seed), model).condition(2)
    return looked_at(model, formula), formula


def looked_at(model: Model, formula: Formula) -> Analysis:
    asked = Properties((Property("p", None, "ctl", formula, None, NOWHERE),), (), True)
    return Analysis(compiled(model), Reference(model), lambda what: None, asked)


CHAINED = """spec chained;
module m {
    request a() { check not waiting(m.b) and not waiting(m.c); }
    request b() { check not waiting(m.c); wait until not active(m.a); }
    request c() { wait until not active(m.a) and not active(m.b) and not waiting(m.b); }
}
"""


def chained() -> tuple[Analysis, Formula]:
    """Return a loop, and what lasts in it until one report after the other has come."""
    formula = Atom(Status("waiting", "m.c"))
    return looked_at(model_of(CHAINED), formula), formula


def amiss(of: Analysis, constraints: list[Constraint], part: Set, layers: list[Layer]) -> Iterator[str]:
    """Yield what is not so of the layers, by steps forwards from the reachable states that are in them."""
    stepper, none = of.stepper, of.space.none
    before = none
    for number, layer in enumerate(layers):
        states = layer.states & of.reached
        if states & (before | ~part) != none:
            yield f"layer {number} is not among the states that are left"
        never = None if layer.never is None else constraints[layer.never]
        if never is not None and states & never.states != none:
            yield f"layer {number} meets what it should not"
        for event in range(len(of.loop.events)):
            allowed = before if never is None or event in never.events else before | layer.states
            if stepper.post(states, event) & part & ~allowed != none:
                yield f"event {event} leads up from layer {number}"
        before |= layer.states


@cache
def ranked(seed: int, fair: bool) -> tuple[Analysis, Fixpoints, Set, list[Layer]]:
    """Return the loop, what is computed of it, the states in which the formula is true, and a ranking of these."""
    of, formula = analysed(seed)
    steps = LoopSteps(BackwardReachability(of.stepper, of.stepper.universe, None))
    part = moments(of.meaning, formula) & steps.universe
    fixpoints = Fixpoints(steps, fair_reports(of.stepper) if fair else [])
    return of, fixpoints, part, list(ranking(fixpoints, part))


@pytest.mark.parametrize("seed", SEEDS)
def test_layers_lead_down(seed: int) -> None:
    for fair in (True, False):
        of, fixpoints, part, layers = ranked(seed, fair)
        assert not [*amiss(of, fair_reports(of.stepper) if fair else [], part, layers)]
        left = part
        for layer in layers:
            left &= ~layer.states
        assert left == fixpoints.always(part)


def test_random_rankings_are_of_every_kind() -> None:
    """Some have several layers, some need fair reports, some do without."""
    kinds = set()
    for seed in SEEDS:
        *_, layers = ranked(seed, fair=True)
        kinds |= {(len(layers) > 1, layer.never is None) for layer in layers}
    assert kinds == {(True, True), (True, False), (False, True), (False, False)}


def test_what_is_amiss_is_seen() -> None:
    """Rankings without the first layer, in another order, or whose layers all lead out, are not as they should be."""
    of, formula = chained()
    constraints, part = fair_reports(of.stepper), moments(of.meaning, formula)
    layers = _layers(of, formula)
    assert len(layers) > 1
    assert not [*amiss(of, constraints, part, layers)]
    others = (layers[1:], layers[::-1], layers * 2, *([Layer(k, each.states) for each in layers] for k in (None, 0)))
    assert all([*amiss(of, constraints, part, wrong)] for wrong in others)


def _layers(of: Analysis, formula: Formula) -> list[Layer]:
    steps = LoopSteps(BackwardReachability(of.stepper, of.stepper.universe, None))
    return list(ranking(Fixpoints(steps, fair_reports(of.stepper)), moments(of.meaning, formula)))


@dataclass
class Graph:
    """Steps of a random graph; a set of its states is a number, with a bit for each."""

    random: Random
    space: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(none=0))
    universe: int = 255
    events: range = range(2)

    def __post_init__(self) -> None:
        self.after = [[self.few() for _ in range(8)] for _ in self.events]

    def few(self) -> int:
        """Return a set with few states."""
        return self.random.getrandbits(8) & self.random.getrandbits(8) & self.random.getrandbits(8)

    def touching(self, states: int) -> range:
        return self.events

    def pre(self, states: int, number: int) -> int:
        return sum(1 << source for source, after in enumerate(self.after[number]) if after & states)


def test_layers_of_random_graphs_lead_down() -> None:
    for seed in range(300):
        lead_down(Graph(Random(seed)), seed)


def lead_down(graph: Graph, seed: int) -> None:
    part = 255 & ~graph.few()
    constraints = [Constraint(~graph.few() & 255, frozenset()), Constraint(graph.few() | graph.few(), frozenset({0}))]
    fixpoints = Fixpoints(graph, constraints)
    before = 0
    for layer in ranking(fixpoints, part):
        never = None if layer.never is None else constraints[layer.never]
        assert layer.states and not layer.states & (before | ~part), seed
        assert never is None or not layer.states & never.states, seed
        for event, after in enumerate(graph.after):
            lower = before if never is None or event in never.events else before | layer.states
            for source in range(8):
                assert not layer.states >> source & 1 or not after[source] & part & ~lower, seed
        before |= layer.states
    assert part & ~before == fixpoints.always(part)
