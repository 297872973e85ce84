"""Machine closure: every finite run under the assumptions is the beginning of an infinite, fair one.

(Apt, Francez, Katz 1988: feasibility of a fairness condition; Abadi, Lamport 1991: machine closure.)
"""

from collections.abc import Callable, Sequence

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.symbolic_simulation import substituted
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import Exploration, Seed
from exover.engines.aig.ways.home_states import inputs_of

Excludes = Callable[[Circuit], bool]
"""Returns whether a model checker shows that no reachable state makes any bad literal of a circuit true."""


def is_machine_closed(encoding: Encoding, fair: bool, excluded: Excludes) -> bool:
    """Return whether it is proved that every run can go on for ever, and if `fair` fairly.

    A run can go on if in every reachable state some event with the least of its values is allowed; it can go on fairly
    if besides every active slot can be reported at once, for then slots can be reported in turn.
    """
    graph, active, domain = encoding.graph, encoding.latches, encoding.moments.domain
    solver = Solver(graph.within_step())
    events = [(event.kind, inputs_of(encoding, number)) for number, event in enumerate(encoding.events)]
    needs: list[tuple[Sequence[Literal], list[frozenset[int]]]] = []
    free = [inputs for kind, inputs in events if kind.verb in ("ask", "observe", "observe level")]
    needs.append(((), free))
    for (name, number), slot in active.slots.items() if fair else ():
        mine = [i for kind, i in events if kind.verb == "report" and (kind.name, kind.slot) == (name, number)]
        needs.append(((active.literals[slot.active][0],), mine))
    open_cases: list[Literal] = []
    try:
        for state, choices in needs:
            if not any(_allowed(encoding, solver, (*state, domain), inputs) for inputs in choices):
                open_cases.append(_refused(encoding, state, choices))
    finally:
        solver.close()
    if not open_cases:
        return True
    following = [encoding.following[2 * node] for node, _ in graph.latches]
    return excluded(graph.circuit(following, open_cases))


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


def _allowed(encoding: Encoding, solver: Solver, state: Sequence[Literal], true: frozenset[int]) -> bool:
    """Return whether an event is an allowed step in all states of a cube."""
    inputs = [2 * node + (node not in true) for node in encoding.graph.inputs]
    asked = (*state, *inputs, encoding.legal ^ 1)
    return not solver.satisfiable([solver.literal(each) for each in asked])


def _refused(encoding: Encoding, state: Sequence[Literal], choices: Sequence[frozenset[int]]) -> Literal:
    """Return a literal over the state: it is in a cube, and none of the events is an allowed step."""
    graph, steps = encoding.graph, []
    for true in choices:
        constant = {node: int(node in true) for node in graph.inputs}
        steps += substituted(graph, [encoding.legal], constant)
    return graph.all((*state, graph.any(steps) ^ 1))
