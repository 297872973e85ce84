"""Random runs guided by coverage: they start again where something new was seen.

Many runs go side by side. What counts as new is a *pair* of latches with values that no run had together before, or a
bad literal that no run made true. States in which that was so are kept, and the next runs begin there, so that what has
long preconditions is come to by and by (after AFL's corpus and ATPG's state coverage).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from exover.engines.aig.answer import Inputs, Reachable
from exover.engines.aig.graph import Circuit, Latch, Literal
from exover.engines.aig.simulation import Evaluator, Stimulus, Word, evaluator

LANES = 1024
STEPS = 12
"""Steps of a round."""
SEEDS = 64
"""From so many states a round begins."""
PATIENCE = 6
"""So many rounds may show nothing new."""
ROUNDS = 60
MOST_PAIRS = 40_000
"""Up to so many pairs of values are looked for."""


@dataclass(frozen=True, slots=True)
class Seed:
    """A state that some run reached, and the run."""

    state: Mapping[int, bool]
    run: Inputs


@dataclass
class Exploration:
    """Looks for runs to the bad literals that are asked about, by index.

    `watched`: the latches whose pairs of values count as coverage.
    """

    circuit: Circuit
    asked: Iterable[int]
    stimulus: Stimulus
    watched: Sequence[int]
    found: dict[int, Reachable] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._left = dict.fromkeys(self.asked)
        roots = [self.circuit.bad[index] for index in self._left]
        self._latches: tuple[Latch, ...] = self.circuit.support(roots)
        self._cone: Evaluator = evaluator(self.circuit, roots + [latch.next for latch in self._latches])
        kept = {latch.node for latch in self._latches}
        watched = [node for node in self.watched if node in kept]
        while len(watched) * (len(watched) - 1) * 2 > MOST_PAIRS:
            watched.pop()
        values = [2 * node + sign for node in watched for sign in (0, 1)]
        self._pairs = {(a, b) for a, b in combinations(values, 2) if a >> 1 != b >> 1}
        self._seeds = [Seed({latch.node: latch.initial for latch in self._latches}, ())]
        self._everywhere = (1 << LANES) - 1
        self._done = 0

    def run(self, rounds: int = ROUNDS) -> dict[int, Reachable]:
        """Go on for so many rounds, as long as they show anything new; return runs to what they found, maybe long."""
        vain, known = 0, set(self.found)
        for _ in range(rounds):
            if vain == PATIENCE or not self._left:
                break
            before = len(self._left), len(self._pairs)
            self._round(self._done)
            self._done += 1
            vain = vain + 1 if before == (len(self._left), len(self._pairs)) else 0
        return {index: run for index, run in self.found.items() if index not in known}

    def _round(self, number: int) -> None:
        begun = self._seeds[-SEEDS:]
        origin = [begun[(lane + number) % len(begun)] for lane in range(LANES)]
        state = self._joined([seed.state for seed in origin])
        inputs: list[Mapping[int, Word]] = []
        for step in range(STEPS):
            inputs.append(self.stimulus(number * STEPS + step, state))
            values = self._cone.values({**state, **inputs[-1]})
            for index in list(self._left):
                seen = self._cone.read(values, self.circuit.bad[index], self._everywhere)
                if seen:
                    self.found[index] = Reachable(self._run(origin, inputs, lowest(seen)))
                    del self._left[index]
            state = {latch.node: self._cone.read(values, latch.next, self._everywhere) for latch in self._latches}
            if step % 3 == 2:
                self._cover(origin, inputs, state)

    def _joined(self, states: Sequence[Mapping[int, bool]]) -> dict[int, Word]:
        return {
            latch.node: int("".join("01"[state[latch.node]] for state in reversed(states)), 2)
            for latch in self._latches
        }

    def _run(self, origin: Sequence[Seed], inputs: Sequence[Mapping[int, Word]], lane: int) -> Inputs:
        steps = (frozenset(node for node, word in words.items() if word >> lane & 1) for words in inputs)
        return (*origin[lane].run, *steps)

    def _cover(self, origin: Sequence[Seed], inputs: Sequence[Mapping[int, Word]], state: Mapping[int, Word]) -> None:
        """Keep a state for each pair of values that is new, one state for as many as it has."""

        def word(literal: Literal) -> Word:
            return state[literal >> 1] ^ (self._everywhere if literal & 1 else 0)

        words = {literal: word(literal) for literal in {one for pair in self._pairs for one in pair}}
        new: dict[int, None] = {}
        covered, have = [], 0
        for one, other in self._pairs:
            both = words[one] & words[other]
            if both:
                covered.append((one, other))
                if not both & have:
                    have |= both & -both
                    new[lowest(both)] = None
        self._pairs.difference_update(covered)
        for lane in new:
            bits = {node: bool(its >> lane & 1) for node, its in state.items()}
            self._seeds.append(Seed(bits, self._run(origin, inputs, lane)))


def lowest(word: Word) -> int:
    """Return the number of the lowest lane that is set."""
    return (word & -word).bit_length() - 1
