"""Machine closure: every finite run under the assumptions is the beginning of an infinite, fair one.

(Apt, Francez, Katz 1988: feasibility of a fairness condition; Abadi, Lamport 1991: machine closure.)
"""

from collections.abc import Callable, Container, Iterator, Sequence

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.symbolic_simulation import substituted
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import Exploration, Seed
from exover.engines.aig.ways.home_states import inputs_of

Excludes = Callable[[Circuit], Container[int]]
"""Returns the bad literals of a circuit, by index, that a model checker shows to be true in no reachable state."""


@dataclass(frozen=True, slots=True)
class _Case:
    """States, as a cube of literals, in each of which one of some events has to be allowed; an event by its inputs."""

    state: tuple[Literal, ...]
    choices: Sequence[frozenset[int]]


def is_machine_closed(encoding: Encoding, fair: bool, excluded: Excludes) -> bool:
    """Return whether it is proved that every run can go on for ever, and if `fair` fairly.

    A run can go on if in every reachable state some event with the least of its values is allowed; it can go on fairly
    if besides every active slot can be reported at once, for then slots can be reported in turn. Of a slot it is first
    asked whether its first report is always allowed, a smaller question than whether any of them is.
    """
    domain = encoding.moments.domain
    solver = Solver(encoding.graph.within_step())
    try:
        left = [
            case
            for case in _cases(encoding, fair)
            if not any(_allowed(encoding, solver, (*case.state, domain), inputs) for inputs in case.choices)
        ]
    finally:
        solver.close()
    if slots := [case for case in left if case.state]:
        always = excluded(encoding.circuit([_refused_first(encoding, case) for case in slots]))
        left = [*(case for case in left if not case.state), *(c for n, c in enumerate(slots) if n not in always)]
    if not left:
        return True
    shown = excluded(encoding.circuit([_refused(encoding, case) for case in left]))
    return all(number in shown for number in range(len(left)))


def _cases(encoding: Encoding, fair: bool) -> Iterator[_Case]:
    """Yield the case of all states, and if `fair` that of each slot where it is active."""
    events = [(event.kind, inputs_of(encoding, number)) for number, event in enumerate(encoding.events)]
    yield _Case((), [inputs for kind, inputs in events if kind.verb in ("ask", "observe", "observe level")])
    latches = encoding.latches
    for owner, slot in latches.slots.items() if fair else ():
        mine = [inputs for kind, inputs in events if kind.verb == "report" and (kind.name, kind.slot) == owner]
        yield _Case((latches.literals[slot.active][0],), mine)


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
    solver = Solver(encoding.graph.within_step())

    def allows_some(seed: Seed) -> bool:
        state = [solver.literal(2 * node + (node not in seed.true)) for node in latches]
        return any(solver.satisfiable([*state, solver.literal(step)]) for step in steps)

    try:
        nearest = sorted(reached.seeds, key=lambda seed: len(seed.run))
        return next((seed.run for seed in nearest if not allows_some(seed)), None)
    finally:
        solver.close()


def _given(encoding: Encoding, true: frozenset[int]) -> list[Literal]:
    """Return the cube of inputs of which these are true, and no others."""
    return [2 * node + (node not in true) for node in encoding.graph.inputs]


def _allowed(encoding: Encoding, solver: Solver, state: Sequence[Literal], true: frozenset[int]) -> bool:
    """Return whether an event is an allowed step in all states of a cube."""
    asked = (*state, *_given(encoding, true), encoding.legal ^ 1)
    return not solver.satisfiable([solver.literal(each) for each in asked])


def _refused_first(encoding: Encoding, case: _Case) -> Literal:
    """Return a literal over a step: it is that by the first event, in the states of a case, and is not allowed."""
    return encoding.graph.all((*case.state, *_given(encoding, case.choices[0]), encoding.legal ^ 1))


def _refused(encoding: Encoding, case: _Case) -> Literal:
    """Return a literal over the state: it is one of a case, and none of the events is an allowed step."""
    graph, steps = encoding.graph, []
    for true in case.choices:
        constant = {node: int(node in true) for node in graph.inputs}
        steps += substituted(graph, [encoding.legal], constant)
    return graph.all((*case.state, graph.any(steps) ^ 1))
