"""Many runs of a circuit at once: a Python integer holds one signal in every run, a bit (a *lane*) for each."""

import ctypes
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress, repeat
from operator import and_, itemgetter, or_, xor
from random import Random
from typing import Any, Protocol

from exover.engines.aig.answer import Inputs, Reachable
from exover.engines.aig.graph import Circuit, LatchNode, Literal, ordered
from exover.engines.aig.kernel import Kernel, kernel

Word = int
Stimulus = Callable[[int, Mapping[int, Word]], Mapping[int, Word]]
"""By step (from 0) and state a word for each node of an input; inputs that are not named are false."""
LANES = 2048
STEPS = 40

WORTH = 1000
"""Conjunctions from which on it is worth while to compile what evaluates them."""

Fetch = Callable[[Sequence[Word]], Iterable[Word]]
"""Returns the operands of a batch of conjunctions among the values so far."""


Memory = Any
"""The values of a cone, as only the evaluator knows them that made them."""


class Evaluator(Protocol):
    """Evaluates the cone of some literals, in any number of lanes."""

    def values(self, leaves: Mapping[int, Word]) -> Memory:
        """Return the values of the cone, for `read`; leaves that are not given are false in every lane."""
        ...

    def read(self, values: Memory, literal: Literal, lanes: Word) -> Word:
        """Return in which of the lanes a literal of the cone is true."""
        ...

    def after(self, values: Memory, latches: Iterable[LatchNode], lanes: Word) -> dict[int, Word]:
        """Return, by node, in which of the lanes latches are true after the step."""
        ...


@dataclass(frozen=True, slots=True)
class LevelEvaluator:
    """Evaluates level by level, without a line of Python for each conjunction.

    `leaves`: inputs and latches of the cone. `places`: by node twice its place among the values, plus one where its
    complement is held: of two complements the disjunction is one operation, and so no word is ever complemented.
    `batches`: conjunctions of one level, by which of their operands are complemented (none, both, the second).
    """

    leaves: tuple[int, ...]
    places: Mapping[int, int]
    batches: tuple[tuple[int, Fetch, Fetch], ...]

    def values(self, leaves: Mapping[int, Word]) -> list[Word]:
        """Return the values of the cone."""
        values = [0, *map(leaves.get, self.leaves, repeat(0))]
        for kind, first, second in self.batches:
            if kind == 0:
                values += map(and_, first(values), second(values))
            elif kind == 1:
                values += map(or_, first(values), second(values))
            else:
                values += map(xor, map(or_, first(values), second(values)), second(values))
        return values

    def read(self, values: Memory, literal: Literal, lanes: Word) -> Word:
        """Return in which of the lanes a literal of the cone is true."""
        place = self.places[literal >> 1]
        word: Word = values[place >> 1]
        return word ^ lanes if (place ^ literal) & 1 else word

    def after(self, values: Memory, latches: Iterable[LatchNode], lanes: Word) -> dict[int, Word]:
        """Return, by node, in which of the lanes latches are true after the step."""
        return {latch.node: self.read(values, latch.next, lanes) for latch in latches}


@dataclass(frozen=True, slots=True)
class NativeEvaluator:
    """Evaluates by a loop in C. `leaves` and `places` as in `LevelEvaluator`; `operands`: two of 32 bits a conjunction.

    The values stand side by side in memory. The last bit of each is that of all lanes that no leaf names, so that as a
    signed number it is the value in infinitely many lanes.
    """

    leaves: tuple[int, ...]
    places: Mapping[int, int]
    operands: bytes
    loop: Kernel

    def values(self, leaves: Mapping[int, Word]) -> Memory:
        """Return the values of the cone."""
        words = [0, *map(leaves.get, self.leaves, repeat(0))]
        width = 1 + max(map(int.bit_length, words)) // 64
        count, size = len(self.operands) // 8, 8 * width
        memory = bytearray(b"".join([word.to_bytes(size, "little", signed=True) for word in words]))
        memory.extend(bytes(count * size))
        held = (ctypes.c_char * len(memory)).from_buffer(memory)
        self.loop(ctypes.addressof(held), width, len(words), count, self.operands)
        return memory

    def read(self, values: Memory, literal: Literal, lanes: Word) -> Word:
        """Return in which of the lanes a literal of the cone is true."""
        size = len(values) // len(self.places)
        start = self.places[literal >> 1] * size
        word = int.from_bytes(values[start : start + size], "little", signed=True)
        return (~word if literal & 1 else word) & lanes

    def after(self, values: Memory, latches: Iterable[LatchNode], lanes: Word) -> dict[int, Word]:
        """Return, by node, in which of the lanes latches are true after the step; in one loop, for it is most of it."""
        size, places, found = len(values) // len(self.places), self.places, {}
        for latch in latches:
            start = places[latch.next >> 1] * size
            word = int.from_bytes(values[start : start + size], "little", signed=True)
            found[latch.node] = (~word if latch.next & 1 else word) & lanes
        return found


def evaluator(circuit: Circuit, roots: Iterable[Literal]) -> Evaluator:
    """Return what evaluates the cone of these literals."""
    nodes = circuit.cone(roots)
    loop = kernel() if len(nodes) >= WORTH else None
    return _batches(circuit, nodes) if loop is None else _compiled(circuit, nodes, loop)


def _leaves(circuit: Circuit, nodes: set[int]) -> tuple[int, ...]:
    return tuple(node for node in sorted(nodes) if node and circuit.fanins[node] is None)


def _compiled(circuit: Circuit, nodes: set[int], loop: Kernel) -> NativeEvaluator:
    leaves = _leaves(circuit, nodes)
    places = {node: place for place, node in enumerate((0, *leaves))}
    operands = array("I")
    for node, left, right in ordered(circuit, nodes):
        operands.append(2 * places[left >> 1] + (left & 1))
        operands.append(2 * places[right >> 1] + (right & 1))
        places[node] = len(places)
    return NativeEvaluator(leaves, places, operands.tobytes(), loop)


def _batches(circuit: Circuit, nodes: set[int]) -> LevelEvaluator:
    leaves = _leaves(circuit, nodes)
    levels: dict[int, int] = dict.fromkeys((0, *leaves), 0)
    inverted = dict.fromkeys((0, *leaves), 0)
    groups: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
    for node, left, right in ordered(circuit, nodes):
        levels[node] = level = 1 + max(levels[left >> 1], levels[right >> 1])
        signs = (left ^ inverted[left >> 1]) & 1, (right ^ inverted[right >> 1]) & 1
        inverted[node] = int(signs == (1, 1))
        kind = 2 if signs[0] != signs[1] else signs[0]
        one, other = (right, left) if signs == (1, 0) else (left, right)
        groups.setdefault((level, kind), []).append((node, one >> 1, other >> 1))
    places = {node: 2 * place for place, node in enumerate((0, *leaves))}
    batches = []
    for (_, kind), group in sorted(groups.items()):
        first, second = (_fetch([places[row[side]] >> 1 for row in group]) for side in (1, 2))
        for node, _, _ in group:
            places[node] = 2 * len(places) + inverted[node]
        batches.append((kind, first, second))
    return LevelEvaluator(leaves, places, tuple(batches))


def _fetch(places: list[int]) -> Fetch:
    """Return what reads these places."""
    if len(places) == 1:
        return itemgetter(slice(places[0], places[0] + 1))
    return itemgetter(*places)


def lowest(word: Word) -> int:
    """Return the number of the lowest lane that is set."""
    return (word & -word).bit_length() - 1


def at_lane(words: Mapping[int, Word], lane: int) -> frozenset[int]:
    """Return the nodes that are true in a lane."""
    bit = 1 << lane
    return frozenset(compress(words, map(bit.__and__, words.values())))


def side_by_side(runs: Sequence[Inputs], number: int) -> tuple[Word, dict[int, Word]]:
    """Return in which lanes there is a step of this number, a lane for each run, and its inputs."""
    lanes: dict[frozenset[int], Word] = {}
    for lane, steps in enumerate(runs):
        if number < len(steps):
            lanes[steps[number]] = lanes.get(steps[number], 0) | 1 << lane
    there, words = 0, dict[int, Word]()
    for step, where in lanes.items():
        there |= where
        for node in step:
            words[node] = words.get(node, 0) | where
    return there, words


def like(known: Sequence[frozenset[int]], first: Inputs, lanes: int, seed: int) -> Stimulus:
    """Return inputs like the known ones: most lanes follow a run at first, in a quarter some inputs are changed."""
    nodes = sorted(frozenset().union(*known, *first))

    def words(step: int, _: Mapping[int, Word]) -> dict[int, Word]:
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

    def words(step: int, _: Mapping[int, Word]) -> dict[int, Word]:
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
    states: tuple[Mapping[int, Word], ...]
    inputs: tuple[Mapping[int, Word], ...]
    hits: Mapping[int, tuple[int, int]]

    def run(self, step: int, lane: int) -> Inputs:
        """Return the run of a lane up to and with this step."""
        return tuple(at_lane(words, lane) for words in self.inputs[: step + 1])

    def answers(self) -> dict[int, Reachable]:
        """Return, by index of the bad literals that were seen true, a run to each."""
        return {index: Reachable(self.run(*hit)) for index, hit in self.hits.items()}


@dataclass(frozen=True, slots=True)
class Simulator:
    """What evaluates bad literals (by index) and all that they depend on."""

    circuit: Circuit
    asked: tuple[int, ...]
    latches: tuple[LatchNode, ...]
    cone: Evaluator

    def runs(self, stimulus: Stimulus, steps: int, lanes: int) -> Runs:
        """Return runs from the start; they end early when all that is asked was seen."""
        everywhere = (1 << lanes) - 1
        state = {latch.node: everywhere if latch.initial else 0 for latch in self.latches}
        states, inputs = [], []
        hits: dict[int, tuple[int, int]] = {}
        for step in range(steps):
            words = stimulus(step, state)
            states.append(state)
            inputs.append(words)
            values = self.cone.values({**state, **words})
            for index in self.asked:
                if index not in hits:
                    seen = self.cone.read(values, self.circuit.bad[index], everywhere)
                    if seen:
                        hits[index] = step, lowest(seen)
            if len(hits) == len(self.asked):
                break
            state = self.cone.after(values, self.latches, everywhere)
        return Runs(lanes, tuple(states), tuple(inputs), hits)


def simulator(circuit: Circuit, asked: Iterable[int] | None = None) -> Simulator:
    """Return what evaluates these bad literals (by index; all if `None`)."""
    asked = tuple(range(len(circuit.bad)) if asked is None else asked)
    roots = [circuit.bad[index] for index in asked]
    latches = circuit.support(roots)
    return Simulator(circuit, asked, latches, evaluator(circuit, roots + [latch.next for latch in latches]))


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
