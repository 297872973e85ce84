"""Machine closure: every finite run under the assumptions is the beginning of an infinite, fair one.

(Apt, Francez, Katz 1988: feasibility of a fairness condition; Abadi, Lamport 1991: machine closure.)
"""

from collections.abc import Callable, Container, Mapping, Sequence
from contextlib import closing
from typing import TypeVar

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal, valuation
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.symbolic_simulation import substituted
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import Exploration, Seed
from exover.engines.aig.ways.home_states import inputs_of
from exover.model.state import SlotId

T = TypeVar("T")
Excludes = Callable[[Circuit], Container[int]]
"""Returns the bad literals of a circuit, by index, that a model checker shows to be true in no reachable state."""


@dataclass(frozen=True, slots=True)
class _Case:
    """States, as a cube of literals, in each of which one of some events has to be allowed; an event by its inputs."""

    state: tuple[Literal, ...]
    choices: Sequence[frozenset[int]]


def can_go_on(encoding: Encoding, excluded: Excludes) -> bool:
    """Return whether it is proved that every run can go on for ever.

    It can if in every reachable state some event with the least of its values is allowed.
    """
    kinds = enumerate(event.kind for event in encoding.events)
    free = [inputs_of(encoding, number) for number, kind in kinds if kind.verb in ("ask", "observe", "observe level")]
    return not _left(encoding, _open(encoding, {None: _Case((), free)}), _refused, excluded)


def unreported(encoding: Encoding, excluded: Excludes) -> list[SlotId]:
    """Return the slots of which it is not proved that, wherever they are active, some report of them is allowed.

    If there are none, every run that can go on can do so fairly: slots can be reported in turn. It is first asked
    whether the first report is always allowed, a smaller question than whether any of them is.
    """
    latches, numbers = encoding.latches, encoding.reports
    left = _open(
        encoding,
        {
            owner: _Case((latches.literals[slot.active][0],), [inputs_of(encoding, each) for each in numbers[owner]])
            for owner, slot in latches.slots.items()
        },
    )
    for refused in (_refused_first, _refused):
        left = _left(encoding, left, refused, excluded)
    return list(left)


def _open(encoding: Encoding, cases: Mapping[T, _Case]) -> dict[T, _Case]:
    """Return the cases in which no single event is allowed in all states that there may be."""
    domain = encoding.moments.domain
    with closing(Solver(encoding.graph.within_step())) as solver:
        return {
            name: case
            for name, case in cases.items()
            if not any(_allowed(encoding, solver, (*case.state, domain), inputs) for inputs in case.choices)
        }


def _left(
    encoding: Encoding, cases: Mapping[T, _Case], refused: Callable[[Encoding, _Case], Literal], excluded: Excludes
) -> dict[T, _Case]:
    """Return the cases of which it is not proved that in no reachable state the events are `refused`."""
    if not cases:
        return {}
    shown = excluded(encoding.circuit([refused(encoding, case) for case in cases.values()]))
    return {name: case for number, (name, case) in enumerate(cases.items()) if number not in shown}


def stranded(encoding: Encoding, runs: Sequence[Inputs]) -> Inputs | None:
    """Return the shortest of some runs to a state from which the assumptions allow no step, None if there is none.

    No inputs are an allowed step from there, nor an unsettled one, of which it is not known whether it is allowed. The
    states asked about are the start and the ends of the runs.
    """
    steps = (encoding.legal, *encoding.unsettled_parts)
    circuit = encoding.circuit(steps)
    latches = [latch.node for latch in circuit.support(steps)]
    reached = Exploration(circuit, range(len(steps)), lambda step, state: {}, CoverageGoals())
    reached.follow(runs)
    with closing(Solver(encoding.graph.within_step())) as solver:

        def allows_some(seed: Seed) -> bool:
            state = valuation(latches, seed.true)
            return any(solver.possible((*state, step)) for step in steps)

        nearest = sorted(reached.seeds, key=lambda seed: len(seed.run))
        return next((seed.run for seed in nearest if not allows_some(seed)), None)


def _allowed(encoding: Encoding, solver: Solver, state: Sequence[Literal], true: frozenset[int]) -> bool:
    """Return whether an event is an allowed step in all states of a cube."""
    return not solver.possible((*state, *valuation(encoding.graph.inputs, true), encoding.legal ^ 1))


def _refused_first(encoding: Encoding, case: _Case) -> Literal:
    """Return a literal over a step: it is that by the first event, in the states of a case, and is not allowed."""
    first = valuation(encoding.graph.inputs, case.choices[0])
    return encoding.graph.all((*case.state, *first, encoding.legal ^ 1))


def _refused(encoding: Encoding, case: _Case) -> Literal:
    """Return a literal over the state: it is one of a case, and none of the events is an allowed step."""
    graph, steps = encoding.graph, []
    for true in case.choices:
        constant = {node: int(node in true) for node in graph.inputs}
        steps += substituted(graph, [encoding.legal], constant)
    return graph.all((*case.state, graph.any(steps) ^ 1))
