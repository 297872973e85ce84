"""The search for lassos by simulation: random runs that stay where they must, until one comes back to where it was.

Each lane of the simulation repeats a short random word of events; an event by which its run would leave is left out. A
word that is repeated soon repeats states, too, so that few lanes and few steps are needed.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, reduce
from operator import and_
from random import Random

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Influence, LatchNode, Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.random_events import RandomEvents
from exover.engines.aig.liveness.k_liveness import Staying
from exover.engines.aig.simulation.evaluation import Evaluator, evaluator
from exover.engines.aig.simulation.exploration import Seed, state_of
from exover.engines.aig.simulation.lanes import (
    LaneState,
    LaneWord,
    PackedState,
    at_lane,
    differing,
    initial,
    lowest,
    numbers,
    packed,
)
from exover.engines.aig.simulation.replay import replay
from exover.model.lasso import Lasso

MOVES = 6
"""How many events a word has, besides a report of every slot."""
LANES = 64
"""How many words are tried for a question side by side."""
LaneWords = dict[int, LaneWord]
"""By input, by its node, in which lanes it is true."""
InputLasso = Lasso[frozenset[int]]
"""A lasso of a circuit: by step the inputs that are true."""


@dataclass(frozen=True)
class SimulatedCircuit:
    """A circuit with the literals that questions look at, and their evaluator."""

    encoding: Encoding
    circuit: Circuit
    staying: tuple[Staying, ...]
    cone: Evaluator
    latches: tuple[LatchNode, ...]
    """The latches of the cone."""
    others: tuple[Literal, ...] = ()
    """Literals that are evaluated besides."""

    @staticmethod
    def of(encoding: Encoding, staying: Sequence[Staying]) -> "SimulatedCircuit":
        """Return the simulated circuit for these questions."""
        return _simulated(encoding, encoding.circuit(()), tuple(staying), ())

    @cached_property
    def looked_at(self) -> tuple[frozenset[int], ...]:
        """By question the latches that a loop must return to their values: those in its cone of influence."""
        influence = Influence(self.circuit)
        return tuple(
            frozenset(latch.node for latch in influence.on([self.encoding.legal, *self.others, *_asked(each)]))
            for each in self.staying
        )

    @cached_property
    def exact(self) -> "SimulatedCircuit":
        """The same with all variables of the encoding, also those that no question looks at."""
        variables = self.encoding.latches.literals.values()
        return _simulated(self.encoding, self.circuit, self.staying, [bit for bits in variables for bit in bits])

    def subject(self, step: frozenset[int]) -> str:
        """Return the subject of the event of a step: a request, a poster, a resource."""
        return self.encoding.chosen(step).kind.name

    def states(self, run: Inputs) -> Iterator[LaneState]:
        """Return the states after the steps of a run."""
        return (state for _, _, state in replay(self.cone, initial(self.latches, 1), [run]))

    def returned(self, index: int, run: Inputs, keep: int) -> InputLasso:
        """Return the lasso of a run: its loop begins with the first step that has the input `keep` while the run stays.

        Illegal steps are left out, and so is the last one.
        """
        begun = self.staying[index].begun >> 1
        kept: list[frozenset[int]] = []
        first: int | None = None
        state = initial(self.latches, 1)
        for step, (_, values, after) in zip(run, replay(self.cone, state, [run[:-1]]), strict=False):
            if self.cone.read(values, self.encoding.legal, 1):
                if first is None and keep in step and state[begun]:
                    first = len(kept)
                kept.append(step)
            state = after
        assert first is not None, "no state of the run is kept"
        return InputLasso(tuple(kept[:first]), tuple(kept[first:]))

    def moved(self, lasso: InputLasso) -> set[int]:
        """Return the latches that have other values after one turn of the loop, by their nodes."""
        states = [initial(self.latches, 1), *self.states(lasso.steps)]
        before = states[len(lasso.stem)]
        return {node for node, word in states[-1].items() if word != before[node]}

    def lively(self, run: Inputs) -> Inputs:
        """Return the run without the steps that change nothing."""
        before = initial(self.latches, 1)
        kept = []
        for step, state in zip(run, self.states(run), strict=True):
            if differing(state, before):
                kept.append(step)
            before = state
        return tuple(kept)

    def seeds_of(self, index: int, run: Inputs) -> list[Seed]:
        """Return the states of a run in which the `begun` of a question is true, each with the run to it."""
        begun = self.staying[index].begun >> 1
        return [
            Seed(at_lane(state, 0), run[:number]) for number, state in enumerate(self.states(run), 1) if state[begun]
        ]


def _asked(staying: Staying) -> tuple[Literal, ...]:
    """Return the literals that a question looks at."""
    return staying.begun, staying.step, *staying.signals


def _simulated(
    encoding: Encoding, circuit: Circuit, staying: tuple[Staying, ...], others: Sequence[Literal]
) -> SimulatedCircuit:
    roots = [encoding.legal, *others, *(literal for each in staying for literal in _asked(each))]
    latches = circuit.support(roots)
    return SimulatedCircuit(encoding, circuit, staying, evaluator(circuit, roots, latches), latches, tuple(others))


class RandomLassos:
    """Simulates random words for questions, in `LANES` lanes each, which begin at its seeds."""

    def __init__(self, machine: SimulatedCircuit, seeds: Mapping[int, Sequence[Seed]], seed: int) -> None:
        self.machine = machine
        self.chance = RandomEvents(machine.encoding, Random(seed))
        self.owners = [index for index in seeds for _ in range(LANES)]
        self.begun = [found[lane % len(found)] for found in seeds.values() for lane in range(LANES)]
        self.lanes = len(self.owners)
        self.mine = {index: ((1 << LANES) - 1) << LANES * place for place, index in enumerate(seeds)}
        self.state = state_of(machine.latches, self.begun)
        self.taken: list[tuple[PackedState, LaneWord]] = []
        self.missed: dict[int, set[int]] = {index: set() for index in seeds}
        """By question the signals, by index, that some step of its runs does not make true."""
        self._ends: dict[int, tuple[int, int]] = {}
        """By question a lane, and after how many steps it had seen all signals while a word was repeated."""

    def lassos(self, rounds: int) -> Iterator[tuple[int, InputLasso]]:
        """Yield lassos by the index of their questions; a round is a word, twice."""
        for _ in range(rounds):
            words = [self.chance.word(MOVES) for _ in range(LANES)]
            inputs = [self._for_all(self.chance.inputs(kinds)) for kinds in zip(*words, strict=True)]
            self._pass(inputs)
            before, since = self.state, len(self.taken)
            fair, moved = self._pass(inputs)
            self._ends |= {i: (lowest(mine & fair), len(self.taken)) for i, mine in self.mine.items() if mine & fair}
            fair &= ~differing(self.state, before)
            for index in [index for index, mine in self.mine.items() if fair & moved & mine]:
                found = fair & moved & self.mine.pop(index)
                yield index, min((self._lasso(lane, since) for lane in numbers(found)), key=lambda lasso: lasso.length)
            if not self.mine:
                return

    def _for_all(self, inputs: LaneWords) -> LaneWords:
        """Return the inputs of `LANES` lanes, repeated for each question."""
        turns = sum(1 << first for first in range(0, self.lanes, LANES))
        return {node: word * turns for node, word in inputs.items()}

    def _pass(self, inputs: Iterable[LaneWords]) -> tuple[LaneWord, LaneWord]:
        """Follow a word; return the lanes in which all signals were seen meanwhile, and those that took a step."""
        machine, cone = self.machine, self.machine.cone
        everywhere = (1 << self.lanes) - 1
        signals = dict.fromkeys(literal for index in self.mine for literal in machine.staying[index].signals)
        seen, missed = dict.fromkeys(signals, 0), dict.fromkeys(signals, 0)
        moved = 0
        for words in inputs:
            values = cone.values(self.state, words)
            steps = 0
            for index, mine in self.mine.items():
                steps |= cone.read(values, machine.staying[index].step, everywhere) & mine
            for signal in signals:
                word = cone.read(values, signal, everywhere) & steps
                seen[signal] |= word
                missed[signal] |= word ^ steps
            self.state = cone.after(values, steps)
            self.taken.append((packed(words, self.lanes), steps))
            moved |= steps
        fair = 0
        for index, mine in self.mine.items():
            asked = machine.staying[index].signals
            fair |= reduce(and_, map(seen.__getitem__, asked), mine)
            self.missed[index].update(place for place, signal in enumerate(asked) if missed[signal] & mine)
        return fair, moved

    def rounds(self) -> dict[int, Inputs]:
        """Return runs, by question, that have seen all signals and stay, of questions without a lasso."""
        return {index: self._run(*end) for index, end in self._ends.items() if index in self.mine}

    def _run(self, lane: int, until: int) -> Inputs:
        return (*self.begun[lane].run, *self._steps(lane, 0, until))

    def _steps(self, lane: int, first: int, until: int) -> list[frozenset[int]]:
        return [at_lane(words, lane) for words, steps in self.taken[first:until] if steps >> lane & 1]

    def _lasso(self, lane: int, since: int) -> InputLasso:
        """Return the lasso of a lane whose loop began after so many steps."""
        return InputLasso(self._run(lane, since), tuple(self._steps(lane, since, len(self.taken))))
