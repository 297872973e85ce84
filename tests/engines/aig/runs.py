"""Runs that get about, to begin with where a test asks no question that would show them."""

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation.exploration import Exploration
from exover.engines.aig.simulation.stimulus import RandomStimulus


def known_runs(encoding: Encoding) -> list[Inputs]:
    """Return some runs of the loop."""
    never = encoding.graph.all(encoding.following)
    stimulus = RandomStimulus(encoding, 256).stimulus()
    exploration = Exploration(encoding.circuit([never]), [0], stimulus, coverage_goals(encoding.latches), 256)
    exploration.run(4)
    return [seed.run for seed in exploration.corpus(64)]
