"""Random runs guided by coverage: they start again where something new was seen.

Many runs go side by side. What counts as new is a *pair* of latches with values that no run had together before, a
*mode* (a valuation of all states of modules and latches of the spec) in which none was, or a bad literal that none made
true. States in which that was so are kept, and the next runs begin there, so that states with long preconditions are
reached little by little (after AFL's corpus and ATPG's state coverage).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from heapq import nlargest
from random import Random
from typing import TypeVar

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs, Reachable
from exover.engines.aig.circuit.graph import Circuit, LatchNode
from exover.engines.aig.simulation.coverage import CoverageGoals, ModeCoverage, PairCoverage, value_pairs
from exover.engines.aig.simulation.evaluation import ConeValues, Evaluator, evaluator
from exover.engines.aig.simulation.lanes import LaneState, LaneWord, at_lane, initial, lowest, packed
from exover.engines.aig.simulation.replay import replay
from exover.engines.aig.simulation.runs import Stimulus

LANES = 1024
STEPS = 12
"""Steps of a round."""
SEEDS = 64
"""From how many kept states a round begins: the latest, random ones, lest the latest lead nowhere, and the furthest if
latches tell progress; as many of each."""
PATIENCE = 8
"""How many rounds in a row may show nothing new."""
ROUNDS = 30
MOST_PAIRS = 100_000
"""How many pairs of values are looked for at most."""
MOST_NEW = 64
"""How many states are kept at once, at most, for new pairs, and as many for new modes."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Seed:
    """The latches that are true in a state that some run reached, and the run."""

    true: frozenset[int]
    run: Inputs


@dataclass(frozen=True, eq=False)
class _Kept:
    """A lane that showed something new. Its seed is made when it is first asked for: of most it never is.

    `state`: that of all lanes; `begun`: the runs at whose ends they began, dealt out in turn; `inputs`: since then.
    `progress`: how many of the latches that tell it are true.
    """

    state: LaneState
    lane: int
    begun: Sequence[Inputs]
    inputs: Sequence[Mapping[int, LaneWord]] = ()
    progress: int = 0

    @cached_property
    def seed(self) -> Seed:
        """The state of the lane, and the run to it."""
        return seed_at(self.state, self.lane, self.begun, self.inputs)


def seed_at(
    state: LaneState, lane: int, begun: Sequence[Inputs], inputs: Sequence[Mapping[int, LaneWord]] = ()
) -> Seed:
    """Return the state of a lane, and the run to it; the arguments are those of `_Kept`."""
    return Seed(at_lane(state, lane), _run(begun, inputs, lane))


def state_of(latches: Iterable[LatchNode], seeds: Iterable[Seed]) -> LaneState:
    """Return the states of seeds side by side, a lane for each."""
    words = {latch.node: 0 for latch in latches}
    for lane, seed in enumerate(seeds):
        for node in seed.true & words.keys():
            words[node] |= 1 << lane
    return words


def thinned(items: Sequence[T], most: int) -> Sequence[T]:
    """Return up to so many of some items, the first of them, then others that are equally far apart."""
    return items[:: -(-len(items) // most)]


@dataclass
class Exploration:
    """Looks for runs to the bad literals that are asked about, by index; if none is, for what is new alone.

    `goals`: what counts as new, of up to `MOST_PAIRS` pairs, those of the first latches; `lanes`: how many runs go
    side by side. `cone`: an evaluator of all bad literals and latches, if there is one already.
    """

    circuit: Circuit
    asked: Iterable[int]
    stimulus: Stimulus
    goals: CoverageGoals
    lanes: int = LANES
    cone: Evaluator | None = None
    found: dict[int, Reachable] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.left = dict.fromkeys(self.asked)
        self._latches: tuple[LatchNode, ...] = self.circuit.latches
        if self.cone is None:
            bad = [self.circuit.bad[index] for index in self.left]
            nodes = *self.goals.pairs, *self.goals.mode, *self.goals.progress
            self._latches = self.circuit.support([*bad, *(2 * node for node in nodes)])
        self._focus()
        kept = {latch.node for latch in self._latches}
        self._chosen = [node for node in self.goals.pairs if node in kept]
        while len(self._chosen) * (len(self._chosen) - 1) * 2 > MOST_PAIRS:
            self._chosen.pop()
        # a round keeps few states: with pairs ordered by distance, these cover all latches, not the first ones alone
        self._pairs = PairCoverage(value_pairs(len(self._chosen)))
        """The pairs of values of chosen latches that no run had."""
        self._mode = [node for node in self.goals.mode if node in kept]
        self._modes = ModeCoverage()
        self._kept = [_Kept(initial(self._latches, 1), 0, [()])]
        """What showed something new, the start first."""
        self._everywhere = (1 << self.lanes) - 1
        self._done = 0

    def _focus(self) -> None:
        """Evaluate only the bad literals left, and the next state."""
        self._looked_for = len(self.left)
        roots = [self.circuit.bad[index] for index in self.left]
        self._cone = self.cone or evaluator(self.circuit, roots, self._latches)

    def follow(self, runs: Sequence[Inputs]) -> dict[int, Reachable]:
        """Follow known runs side by side, keep their ends as seeds, and return all runs found so far, by index."""
        state = initial(self._latches, (1 << len(runs)) - 1)
        for length, (going, values, after) in enumerate(replay(self._cone, state, runs), 1):
            for index, seen in self._seen(values, going):
                self.found[index] = Reachable(runs[lowest(seen)][:length])
            state = after
        self._keep(state, range(len(runs)), runs)
        return dict(self.found)

    def run(self, rounds: int = ROUNDS) -> dict[int, Reachable]:
        """Go on for so many rounds, as long as they show anything new; return runs to what they found, maybe long."""
        vain, known = 0, set(self.found)
        for _ in range(rounds):
            if vain == PATIENCE or (self.found and not self.left):
                break
            if self.left and len(self.left) <= self._looked_for // 2:
                self._focus()
            before = self._known
            self._round(self._done)
            self._done += 1
            vain = vain + 1 if before == self._known else 0
        return {index: run for index, run in self.found.items() if index not in known}

    @property
    def _known(self) -> tuple[int, int, int]:
        """Counts that change iff something new is seen."""
        return len(self.left), len(self._pairs), len(self._modes)

    def corpus(self, most: int) -> list[Seed]:
        """Return up to so many of the states that showed something new, from early to late ones."""
        return [kept.seed for kept in thinned(self._kept, most)]

    @property
    def seeds(self) -> list[Seed]:
        """All states that showed something new, the start first."""
        return self.corpus(len(self._kept))

    def _round(self, number: int) -> None:
        seeds = [kept.seed for kept in self._chosen_states(Random(number))]
        begun = [seed.run for seed in seeds]
        state: LaneState = self._dealt(seeds)
        inputs: list[Mapping[int, LaneWord]] = []
        for step in range(STEPS):
            given = self.stimulus(number * STEPS + step, state)
            inputs.append(packed(given, self.lanes))
            values = self._cone.values(state, given)
            for index, seen in self._seen(values, self._everywhere):
                self.found[index] = Reachable(_run(begun, inputs, lowest(seen)))
            state = self._cone.after(values, self._everywhere)
            if step % 3 == 2:
                self._cover(begun, tuple(inputs), state)

    def _chosen_states(self, random: Random) -> list[_Kept]:
        """Return the states from which a round begins."""
        furthest: list[_Kept] = []
        share = SEEDS // 2
        if self.goals.progress:
            share = SEEDS // 3
            furthest = nlargest(share, self._kept, key=lambda kept: (kept.progress, random.random()))
        chosen = [*furthest, *self._kept[-share:]]
        return chosen + random.choices(self._kept, k=SEEDS - len(chosen))

    def _seen(self, values: ConeValues, lanes: LaneWord) -> Iterator[tuple[int, LaneWord]]:
        """Yield the indices left whose bad literals are true in some lanes, with these lanes, and remove them."""
        asked = list(self.left)
        bad = [self.circuit.bad[index] for index in asked]
        for place in self._cone.somewhere(values, bad, lanes):
            del self.left[asked[place]]
            yield asked[place], self._cone.read(values, bad[place], lanes)

    def _dealt(self, begun: Sequence[Seed]) -> dict[int, LaneWord]:
        """Return the words of the latches where the lanes begin at these seeds in turn."""
        turns = -(-self.lanes // len(begun))
        every = sum(1 << len(begun) * turn for turn in range(turns))
        state = {latch.node: 0 for latch in self._latches}
        for lane, seed in enumerate(begun):
            mine = every << lane & self._everywhere
            for node in seed.true:
                state[node] |= mine
        return state

    def _cover(self, begun: Sequence[Inputs], inputs: Sequence[Mapping[int, LaneWord]], state: LaneState) -> None:
        """Keep a state for each pair of values that is new, one for as many as it has, and for each new mode."""
        words = [state[node] ^ flip for node in self._chosen for flip in (0, self._everywhere)]
        lanes = self._pairs.cover(words, self.lanes, MOST_NEW)
        lanes += self._modes.cover([state[node] for node in self._mode], self.lanes, MOST_NEW)
        self._keep(state, dict.fromkeys(lanes), begun, inputs)

    def _keep(
        self,
        state: LaneState,
        lanes: Iterable[int],
        begun: Sequence[Inputs],
        inputs: Sequence[Mapping[int, LaneWord]] = (),
    ) -> None:
        telling = [state[node] for node in self.goals.progress]
        for lane in lanes:
            self._kept.append(_Kept(state, lane, begun, inputs, sum(word >> lane & 1 for word in telling)))


def _run(begun: Sequence[Inputs], inputs: Sequence[Mapping[int, LaneWord]], lane: int) -> Inputs:
    """Return the run of a lane: one of `begun`, which are dealt out in turn, then the inputs of the lane."""
    return (*begun[lane % len(begun)], *(at_lane(words, lane) for words in inputs))
