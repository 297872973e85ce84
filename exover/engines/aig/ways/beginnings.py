"""Reachable states in which ways begin: those on known runs, and those to which random runs lead from them.

Where home states are reached from everywhere, ways begin there: each state stands for the home state to which the
reports of home lead from it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.simulation import exploration
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.evaluation import Evaluator
from exover.engines.aig.simulation.exploration import Seed, seed_at, state_of, thinned
from exover.engines.aig.simulation.lanes import at_lane
from exover.engines.aig.simulation.replay import replay
from exover.engines.aig.simulation.runs import Stimulus
from exover.engines.aig.simulation.stimulus import RandomStimulus

LANES = 128
"""How many random runs are simulated side by side."""
ROUNDS = 60
"""Rounds of random runs that look for states of all kinds."""
STEPS = 24
"""Steps of a random run."""


@dataclass
class Beginnings:
    """Where ways begin in the circuit of an encoding.

    `cone` evaluates its latches; `fresh`: latches that are true where a way begins; `home`: the run that leads home,
    empty if home states are not reached from everywhere.
    """

    encoding: Encoding
    circuit: Circuit
    cone: Evaluator
    fresh: frozenset[int]
    home: Inputs = ()
    _steps: int = 0
    """How many steps of random runs were drawn."""

    @cached_property
    def start(self) -> Seed:
        """The state at the start."""
        return Seed(frozenset(latch.node for latch in self.circuit.latches if latch.initial), ())

    @cached_property
    def _stimulus(self) -> Stimulus:
        return RandomStimulus(self.encoding, LANES).stimulus()

    def of(self, seeds: Iterable[Seed]) -> list[Seed]:
        """Return the states in which ways begin, each once: those to which `home` leads from these."""
        known = list(_once(seeds))
        return [self.fresh_at(seed) for seed in _once(self.led(known, [self.home] * len(known)))]

    def fresh_at(self, seed: Seed) -> Seed:
        """Return a state with the `fresh` latches true, as where a way begins."""
        return replace(seed, true=seed.true | self.fresh)

    def passed(self, runs: Sequence[Inputs], most: int) -> list[Seed]:
        """Return up to `most` of the states on runs from the start, those of early steps first."""
        found = [self.start]
        begun = state_of(self.circuit.latches, [self.start] * len(runs))
        for length, (_, _, state) in enumerate(replay(self.cone, begun, runs), 1):
            for lane, run in enumerate(runs):
                if len(found) == most:
                    return found
                if length <= len(run):
                    found.append(Seed(at_lane(state, lane), run[:length]))
        return found

    def of_new_modes(self, runs: Sequence[Inputs], most: int) -> list[Seed]:
        """Return up to `most` states: of the start, the ends of runs, and new modes of random runs from these."""
        goals = CoverageGoals(mode=coverage_goals(self.encoding.latches).mode)
        if not goals.mode:
            return []
        stimulus = RandomStimulus(self.encoding, exploration.LANES).stimulus()
        going_on = exploration.Exploration(self.circuit, (), stimulus, goals, cone=self.cone)
        going_on.follow(runs)
        going_on.run(ROUNDS)
        return going_on.corpus(most)

    def led(self, seeds: Sequence[Seed], runs: Sequence[Inputs]) -> list[Seed]:
        """Return the states to which runs lead, one from each seed."""
        state = state_of(self.circuit.latches, seeds)
        for _, _, after in replay(self.cone, state, runs):
            state = after
        whole = [(*seed.run, *run) for seed, run in zip(seeds, runs, strict=True)]
        return [seed_at(state, lane, whole) for lane in range(len(whole))]

    def ends(self, runs: Sequence[Inputs]) -> list[Seed]:
        """Return the states to which runs from the start lead."""
        return self.led([self.start] * len(runs), runs)

    def reached(self, runs: Sequence[Inputs]) -> list[Seed]:
        """Return the states to which runs from the start lead, each once, with the `fresh` latches true."""
        return [self.fresh_at(seed) for seed in _once(self.ends(runs))]

    def near(self, seeds: Sequence[Seed]) -> list[Seed]:
        """Return where ways begin from states to which random runs lead from these; each call draws other runs."""
        chosen = thinned(seeds, LANES)
        begun = [chosen[lane % len(chosen)] for lane in range(LANES)]
        state = state_of(self.circuit.latches, begun)
        taken = []
        for _ in range(STEPS):
            taken.append(self._stimulus(self._steps, state))
            self._steps += 1
            state = self.cone.after(self.cone.values(state, taken[-1]), (1 << LANES) - 1)
        runs = [seed.run for seed in begun]
        return self.of(seed_at(state, lane, runs, taken) for lane in range(LANES))


def _once(seeds: Iterable[Seed]) -> Iterable[Seed]:
    """Return the seeds; of several with one state, the first."""
    found: dict[frozenset[int], Seed] = {}
    for seed in seeds:
        found.setdefault(seed.true, seed)
    return found.values()
