"""Runs of a circuit, many side by side, and the bad literals that they make true."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from random import Random

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs, Reachable
from exover.engines.aig.circuit.graph import Circuit, LatchNode
from exover.engines.aig.simulation.evaluation import Evaluator, evaluator
from exover.engines.aig.simulation.lanes import LaneState, LaneWord, at_lane, initial, lowest

Stimulus = Callable[[int, LaneState], Mapping[int, LaneWord]]
"""By step (from 0) and state a word for each node of an input; inputs that are not named are false."""
LANES = 2048
STEPS = 40


def like(known: Sequence[frozenset[int]], first: Inputs, lanes: int, seed: int) -> Stimulus:
    """Return inputs drawn from the known ones, at first mostly those of a run; some bits of some lanes are flipped."""
    nodes = sorted(frozenset().union(*known, *first))

    def words(step: int, _: Mapping[int, LaneWord]) -> dict[int, LaneWord]:
        source = Random(f"{seed} {step}")
        drawn = source.choices(known, k=lanes)
        if step < len(first):
            drawn = [first[step] if source.random() < 0.75 else each for each in drawn]
        found = dict.fromkeys(nodes, 0)
        for lane, each in enumerate(drawn):
            for node in each:
                found[node] |= 1 << lane
        changed = source.getrandbits(lanes) & source.getrandbits(lanes)
        for node in nodes:
            found[node] ^= changed & source.getrandbits(lanes) & source.getrandbits(lanes) & source.getrandbits(lanes)
        return found

    return words


def random_words(circuit: Circuit, lanes: int = LANES, seed: int = 0) -> Stimulus:
    """Return random inputs, each true in half of the lanes; equal arguments give equal words."""

    def words(step: int, _: Mapping[int, LaneWord]) -> dict[int, LaneWord]:
        source = Random(f"{seed} {step}")
        return {node: source.getrandbits(lanes) for node in circuit.inputs}

    return words


@dataclass(frozen=True, slots=True)
class Runs:
    """Runs that were simulated side by side.

    `states`: by step the words of the latches of the cone; `inputs`: by step those of the inputs. `hits`: by index of
    a bad literal the first step and there the lowest lane in which it was true.
    """

    lanes: int
    states: tuple[Mapping[int, LaneWord], ...]
    inputs: tuple[Mapping[int, LaneWord], ...]
    hits: Mapping[int, tuple[int, int]]

    def run(self, step: int, lane: int) -> Inputs:
        """Return the run of a lane up to and with this step."""
        return tuple(at_lane(words, lane) for words in self.inputs[: step + 1])

    def answers(self) -> dict[int, Reachable]:
        """Return, by index of the bad literals that were seen true, a run to each."""
        return {index: Reachable(self.run(*hit)) for index, hit in self.hits.items()}


@dataclass(frozen=True, slots=True)
class Simulator:
    """Simulates bad literals (by index) and their cone of influence."""

    circuit: Circuit
    asked: tuple[int, ...]
    latches: tuple[LatchNode, ...]
    cone: Evaluator

    def runs(self, stimulus: Stimulus, steps: int, lanes: int) -> Runs:
        """Return runs from the start; they end early when all that is asked was seen."""
        everywhere = (1 << lanes) - 1
        state = initial(self.latches, everywhere)
        states, inputs = [], []
        hits: dict[int, tuple[int, int]] = {}
        for step in range(steps):
            words = stimulus(step, state)
            states.append(state)
            inputs.append(words)
            values = self.cone.values(state, words)
            for index in self.asked:
                if index not in hits:
                    seen = self.cone.read(values, self.circuit.bad[index], everywhere)
                    if seen:
                        hits[index] = step, lowest(seen)
            if len(hits) == len(self.asked):
                break
            state = self.cone.after(values, everywhere)
        return Runs(lanes, tuple(states), tuple(inputs), hits)


def simulator(circuit: Circuit, asked: Iterable[int] | None = None) -> Simulator:
    """Return the simulator of these bad literals (by index; all if `None`)."""
    asked = tuple(range(len(circuit.bad)) if asked is None else asked)
    roots = [circuit.bad[index] for index in asked]
    latches = circuit.support(roots)
    return Simulator(circuit, asked, latches, evaluator(circuit, roots, latches))


def simulate(
    circuit: Circuit,
    asked: Iterable[int] | None = None,
    stimulus: Stimulus | None = None,
    steps: int = STEPS,
    lanes: int = LANES,
) -> Runs:
    """Return `lanes` runs of `steps` steps from the start, and where each bad literal (by index) is first true.

    Only what these literals depend on is simulated. It ends early when all of them were seen.
    """
    return simulator(circuit, asked).runs(stimulus or random_words(circuit, lanes), steps, lanes)
