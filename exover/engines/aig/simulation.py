"""Many runs of a circuit at once: a Python integer holds one signal in every run, a bit (a *lane*) for each."""

import ctypes
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import compress, repeat
from operator import and_, itemgetter, or_, xor
from random import Random
from typing import Any, Protocol

from exover.dataclass import dataclass
from exover.engines.aig.answer import Inputs, Reachable
from exover.engines.aig.graph import Circuit, LatchNode, Literal, ordered
from exover.engines.aig.kernel import Kernel, kernel

LaneWord = int
"""In which lanes something is true."""
NOTHING: Mapping[int, LaneWord] = {}
LaneState = Mapping[int, LaneWord]
"""By latch, by its node, in which lanes it is true."""
Stimulus = Callable[[int, LaneState], Mapping[int, LaneWord]]
"""By step (from 0) and state a word for each node of an input; inputs that are not named are false."""
LANES = 2048
STEPS = 40

WORTH = 1000
"""Conjunctions from which on it is worth while to compile what evaluates them."""

Fetch = Callable[[Sequence[LaneWord]], Iterable[LaneWord]]
"""Returns the operands of a batch of conjunctions among the values so far."""


ConeValues = Any
"""The values of a cone, as only the evaluator knows them that made them."""


class Evaluator(Protocol):
    """Evaluates the cone of some literals, and what some latches are after the step, in any number of lanes."""

    def values(self, state: LaneState, inputs: Mapping[int, LaneWord] = NOTHING) -> ConeValues:
        """Return the values of the cone, for `read`; leaves that are not given are false in every lane."""
        ...

    def read(self, values: ConeValues, literal: Literal, lanes: LaneWord) -> LaneWord:
        """Return in which of the lanes a literal of the cone is true."""
        ...

    def after(self, values: ConeValues, going: LaneWord) -> LaneState:
        """Return, by node, where the latches are true after the step, which the lanes take that are `going`."""
        ...


@dataclass(frozen=True, slots=True)
class LevelEvaluator:
    """Evaluates level by level, without a line of Python for each conjunction.

    `leaves`: the latches, and what else is a leaf of the cone. `places`: by node twice its place among the values, plus
    one where its complement is held: of two complements the disjunction is one operation, and so no word is ever
    complemented. `batches`: conjunctions of one level, by which of their operands are complemented (none, both, the
    second).
    """

    latches: tuple[LatchNode, ...]
    leaves: tuple[int, ...]
    places: Mapping[int, int]
    batches: tuple[tuple[int, Fetch, Fetch], ...]

    def values(self, state: LaneState, inputs: Mapping[int, LaneWord] = NOTHING) -> list[LaneWord]:
        """Return the values of the cone."""
        values = [0, *map({**state, **inputs}.get, self.leaves, repeat(0))]
        for kind, first, second in self.batches:
            if kind == 0:
                values += map(and_, first(values), second(values))
            elif kind == 1:
                values += map(or_, first(values), second(values))
            else:
                values += map(xor, map(or_, first(values), second(values)), second(values))
        return values

    def read(self, values: ConeValues, literal: Literal, lanes: LaneWord) -> LaneWord:
        """Return in which of the lanes a literal of the cone is true."""
        place = self.places[literal >> 1]
        word: LaneWord = values[place >> 1]
        return word ^ lanes if (place ^ literal) & 1 else word

    def after(self, values: ConeValues, going: LaneWord) -> dict[int, LaneWord]:
        """Return, by node, where the latches are true after the step."""
        found = {}
        for latch, before in zip(self.latches, values[1 : 1 + len(self.latches)], strict=True):
            found[latch.node] = _taken(before, self.read(values, latch.next, going), going)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class PackedState(Mapping[int, LaneWord]):
    """The words of latches side by side in memory, each of `size` bytes; `places`: by node, in order."""

    places: Mapping[int, int]
    memory: bytes
    size: int

    def __getitem__(self, node: int) -> LaneWord:
        start = self.places[node] * self.size
        return int.from_bytes(self.memory[start : start + self.size], "little")

    def __iter__(self) -> Iterator[int]:
        return iter(self.places)

    def __len__(self) -> int:
        return len(self.places)

    def at_lane(self, lane: int) -> frozenset[int]:
        """Return the latches that are true in a lane."""
        column = self.memory[lane >> 3 :: self.size]
        return frozenset(compress(self.places, map((1 << (lane & 7)).__and__, column)))


@dataclass(frozen=True, slots=True)
class NativeEvaluator:
    """Evaluates by a loop in C. `leaves` and `places` as in `LevelEvaluator`; `operands`: two of 32 bits a conjunction.

    The values stand side by side in memory, those of the latches first, so that a state is copied as it is. The last
    bit of each is that of all lanes that no leaf names, so that as a signed number it is the value in infinitely many
    lanes. `following`: an operand by latch, its value after the step; `order`: the place of each among the latches.
    """

    latches: tuple[LatchNode, ...]
    leaves: tuple[int, ...]
    places: Mapping[int, int]
    operands: bytes
    following: bytes
    order: Mapping[int, int]
    kernel: Kernel

    def values(self, state: LaneState, inputs: Mapping[int, LaneWord] = NOTHING) -> ConeValues:
        """Return the values of the cone."""
        if isinstance(state, PackedState) and state.places is self.order:
            known, begun = [0, *map(inputs.get, self.leaves[len(self.latches) :], repeat(0))], state.memory
            size = state.size
        else:
            known, begun = [0, *map({**state, **inputs}.get, self.leaves, repeat(0))], b""
            size = 0
        needed = 8 + max(map(int.bit_length, known)) // 64 * 8
        if size and needed > size:
            return self.values(dict(state), inputs)
        size = max(size, needed)
        words = [word.to_bytes(size, "little", signed=True) for word in known]
        leaves = b"".join([words[0], begun, *words[1:]])
        memory = bytearray(len(leaves) + len(self.operands) // 8 * size)
        memory[: len(leaves)] = leaves
        self.kernel.simulate(_held(memory), size // 8, 1 + len(self.leaves), len(self.operands) // 8, self.operands)
        return memory

    def read(self, values: ConeValues, literal: Literal, lanes: LaneWord) -> LaneWord:
        """Return in which of the lanes a literal of the cone is true."""
        size = len(values) // len(self.places)
        start = self.places[literal >> 1] * size
        word = int.from_bytes(values[start : start + size], "little", signed=True)
        return (~word if literal & 1 else word) & lanes

    def after(self, values: ConeValues, going: LaneWord) -> LaneState:
        """Return, by node, where the latches are true after the step."""
        size, count = len(values) // len(self.places), len(self.latches)
        if going.bit_length() // 64 * 8 + 8 > size:  # no leaf names the others
            return {
                latch.node: _taken(self.read(values, 2 * latch.node, -1), self.read(values, latch.next, going), going)
                for latch in self.latches
            }
        following = bytearray(count * size)
        mask = going.to_bytes(size, "little")
        self.kernel.follow(_held(values), size // 8, count, self.following, mask, _held(following))
        return PackedState(self.order, bytes(following), size)


def _taken(before: LaneWord, after: LaneWord, going: LaneWord) -> LaneWord:
    """Return a word after a step that only some lanes take."""
    return before ^ ((before ^ after) & going)


def _held(memory: bytearray) -> "ctypes.Array[ctypes.c_char]":
    """Return memory as C takes it."""
    return (ctypes.c_char * len(memory)).from_buffer(memory)


def evaluator(circuit: Circuit, roots: Iterable[Literal], latches: Sequence[LatchNode] = ()) -> Evaluator:
    """Return what evaluates the cone of these literals, and these latches after the step."""
    nodes = circuit.cone([*roots, *(latch.next for latch in latches)])
    known = {latch.node for latch in latches}
    others = sorted(node for node in nodes - known if node and circuit.fanins[node] is None)
    leaves = (*(latch.node for latch in latches), *others)
    native = kernel() if len(nodes) >= WORTH else None
    if native is None:
        return _batches(circuit, tuple(latches), leaves, nodes)
    return _compiled(circuit, tuple(latches), leaves, nodes, native)


def whole_evaluator(circuit: Circuit) -> Evaluator:
    """Return what evaluates all that is asked of a circuit, and all its latches after the step."""
    return evaluator(circuit, circuit.bad, circuit.latches)


def _compiled(
    circuit: Circuit, latches: tuple[LatchNode, ...], leaves: tuple[int, ...], nodes: set[int], native: Kernel
) -> NativeEvaluator:
    places = {node: place for place, node in enumerate((0, *leaves))}
    operands = array("I")
    for node, left, right in ordered(circuit, nodes):
        operands.append(2 * places[left >> 1] + (left & 1))
        operands.append(2 * places[right >> 1] + (right & 1))
        places[node] = len(places)
    following = array("I", [2 * places[latch.next >> 1] + (latch.next & 1) for latch in latches])
    order = {latch.node: place for place, latch in enumerate(latches)}
    return NativeEvaluator(latches, leaves, places, operands.tobytes(), following.tobytes(), order, native)


def _batches(
    circuit: Circuit, latches: tuple[LatchNode, ...], leaves: tuple[int, ...], nodes: set[int]
) -> LevelEvaluator:
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
    return LevelEvaluator(latches, leaves, places, tuple(batches))


def _fetch(places: list[int]) -> Fetch:
    """Return what reads these places."""
    if len(places) == 1:
        return itemgetter(slice(places[0], places[0] + 1))
    return itemgetter(*places)


def initial(latches: Iterable[LatchNode], lanes: LaneWord) -> LaneState:
    """Return the state at the start, in these lanes."""
    return {latch.node: lanes if latch.initial else 0 for latch in latches}


def differing(one: LaneState, other: LaneState) -> LaneWord:
    """Return in which lanes two states of the same latches differ."""
    return reduce(or_, (word ^ other[node] for node, word in one.items()), 0)


def lowest(word: LaneWord) -> int:
    """Return the number of the lowest lane that is set."""
    return (word & -word).bit_length() - 1


def at_lane(words: Mapping[int, LaneWord], lane: int) -> frozenset[int]:
    """Return the nodes that are true in a lane."""
    if isinstance(words, PackedState):
        return words.at_lane(lane)
    bit = 1 << lane
    return frozenset(compress(words, map(bit.__and__, words.values())))


def side_by_side(runs: Sequence[Inputs], number: int) -> tuple[LaneWord, dict[int, LaneWord]]:
    """Return in which lanes there is a step of this number, a lane for each run, and its inputs."""
    lanes: dict[frozenset[int], LaneWord] = {}
    for lane, steps in enumerate(runs):
        if number < len(steps):
            lanes[steps[number]] = lanes.get(steps[number], 0) | 1 << lane
    there, words = 0, dict[int, LaneWord]()
    for step, where in lanes.items():
        there |= where
        for node in step:
            words[node] = words.get(node, 0) | where
    return there, words


def like(known: Sequence[frozenset[int]], first: Inputs, lanes: int, seed: int) -> Stimulus:
    """Return inputs like the known ones: most lanes follow a run at first, in a quarter some inputs are changed."""
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
    """What evaluates bad literals (by index) and all that they depend on."""

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
    """Return what evaluates these bad literals (by index; all if `None`)."""
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
