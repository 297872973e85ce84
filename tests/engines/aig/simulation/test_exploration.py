"""Random runs that are guided: by what is new, and by progress."""

from exover.engines.aig.circuit.graph import Circuit, Graph
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import Exploration
from exover.engines.aig.simulation.runs import random_words
from tests.support.circuits import is_number

STAGES, WIDTH, LANES, ROUNDS = 14, 4, 128, 16


def lock() -> tuple[Circuit, tuple[int, ...], tuple[int, ...]]:
    """Return a circuit that reaches its bad state by the numbers 0, 1, 2, … in turn, and falls back by others that are
    odd; the nodes of its stages, and of latches that hold the last number.
    """
    graph = Graph()
    given = [graph.input() for _ in range(WIDTH)]
    stages = [graph.latch(False) for _ in range(STAGES)]
    seen = [graph.latch(False) for _ in range(WIDTH)]
    due = [
        graph.all((*stages[:number], *(each ^ 1 for each in stages[number:]), is_number(graph, given, number)))
        for number in range(STAGES)
    ]
    stays = graph.conjunction(given[0], graph.any(due) ^ 1) ^ 1
    after = [graph.conjunction(stays, graph.any(pair)) for pair in zip(stages, due, strict=True)]
    circuit = graph.circuit([*after, *given], [graph.all(stages)])
    return circuit, tuple(each >> 1 for each in stages), tuple(each >> 1 for each in seen)


def test_runs_go_on_from_where_most_progress_is_made() -> None:
    circuit, stages, seen = lock()

    def is_opened(progress: tuple[int, ...]) -> bool:
        goals = CoverageGoals(mode=(*stages, *seen), progress=progress)
        exploration = Exploration(circuit, [0], random_words(circuit, LANES), goals, LANES)
        return bool(exploration.run(ROUNDS))

    assert is_opened(stages) and not is_opened(())
