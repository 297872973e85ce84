"""The values of a circuit in many lanes at once: level by level in Python, or by a loop in C."""

from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import repeat
from operator import and_, itemgetter, or_, xor
from typing import Any, Protocol

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Circuit, LatchNode, Literal
from exover.engines.aig.circuit.kernel import Kernel, address, held, kernel_for
from exover.engines.aig.simulation.lanes import LaneState, LaneWord, PackedState

NOTHING: Mapping[int, LaneWord] = {}
Fetch = Callable[[Sequence[LaneWord]], Iterable[LaneWord]]
"""Returns the operands of a batch of conjunctions among the values so far."""
ConeValues = Any
"""The values of a cone, in a format known only to the evaluator that made them."""


class Evaluator(Protocol):
    """Evaluates the cone of some literals, and what some latches are after the step, in any number of lanes."""

    def values(self, state: LaneState, inputs: Mapping[int, LaneWord] = NOTHING) -> ConeValues:
        """Return the values of the cone, for `read`; leaves that are not given are false in every lane."""
        ...

    def read(self, values: ConeValues, literal: Literal, lanes: LaneWord) -> LaneWord:
        """Return in which of the lanes a literal of the cone is true."""
        ...

    def somewhere(self, values: ConeValues, literals: Sequence[Literal], lanes: LaneWord) -> Sequence[int]:
        """Return the places of the literals that are true in some of the lanes."""
        ...

    def signatures(self, values: ConeValues, literals: Sequence[Literal]) -> Sequence[int]:
        """Return a number for each literal: equal ones for such as are equal in every lane, for others hardly ever."""
        ...

    def after(self, values: ConeValues, going: LaneWord) -> LaneState:
        """Return, by node, where the latches are true after the step; lanes that are not `going` take no step."""
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
        return (~word if (place ^ literal) & 1 else word) & lanes

    def somewhere(self, values: ConeValues, literals: Sequence[Literal], lanes: LaneWord) -> list[int]:
        """Return which literals of the cone, by place, are true in some of the lanes."""
        return [place for place, literal in enumerate(literals) if self.read(values, literal, lanes)]

    def signatures(self, values: ConeValues, literals: Sequence[Literal]) -> list[int]:
        """Return the values of the literals."""
        return [self.read(values, literal, -1) for literal in literals]

    def after(self, values: ConeValues, going: LaneWord) -> dict[int, LaneWord]:
        """Return, by node, where the latches are true after the step."""
        found = {}
        for latch, before in zip(self.latches, values[1 : 1 + len(self.latches)], strict=True):
            found[latch.node] = _taken(before, self.read(values, latch.next, going), going)
        return found


@dataclass(frozen=True, slots=True)
class NativeEvaluator:
    """Evaluates by a loop in C. `leaves` as in `LevelEvaluator`; `operands`: two of 32 bits a conjunction.

    `places`: by node its place among the values, of which there are `count`. The values stand side by side in memory,
    those of the latches first, so that a state is copied as it is. The last bit of each is that of all lanes that no
    leaf names, so that as a signed number it is the value in infinitely many lanes. `following`: an operand by latch,
    its value after the step; `order`: the place of each among the latches.
    """

    latches: tuple[LatchNode, ...]
    leaves: tuple[int, ...]
    places: Sequence[int]
    count: int
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
        self.kernel.simulate(held(memory), size // 8, 1 + len(self.leaves), len(self.operands) // 8, self.operands)
        return memory

    def read(self, values: ConeValues, literal: Literal, lanes: LaneWord) -> LaneWord:
        """Return in which of the lanes a literal of the cone is true."""
        size = len(values) // self.count
        start = self.places[literal >> 1] * size
        word = int.from_bytes(values[start : start + size], "little", signed=True)
        return (~word if literal & 1 else word) & lanes

    def somewhere(self, values: ConeValues, literals: Sequence[Literal], lanes: LaneWord) -> Sequence[int]:
        """Return which literals of the cone, by place, are true in some of the lanes."""
        size = len(values) // self.count
        if _is_beyond(lanes, size):
            return [place for place, literal in enumerate(literals) if self.read(values, literal, lanes)]
        operands = _operands(literals, self.places)
        found = array("I", bytes(4 * len(operands)))
        mask = lanes.to_bytes(size, "little")
        count = self.kernel.somewhere(held(values), size // 8, len(operands), operands.tobytes(), mask, address(found))
        return found[:count]

    def signatures(self, values: ConeValues, literals: Sequence[Literal]) -> "array[int]":
        """Return 64 bits that the values of each literal are mixed into."""
        size, operands = len(values) // self.count, _operands(literals, self.places)
        found = array("Q", bytes(8 * len(operands)))
        self.kernel.sign(held(values), size // 8, len(operands), operands.tobytes(), address(found))
        return found

    def after(self, values: ConeValues, going: LaneWord) -> LaneState:
        """Return, by node, where the latches are true after the step."""
        size, count = len(values) // self.count, len(self.latches)
        if _is_beyond(going, size):
            return {
                latch.node: _taken(self.read(values, 2 * latch.node, -1), self.read(values, latch.next, going), going)
                for latch in self.latches
            }
        following = bytearray(count * size)
        mask = going.to_bytes(size, "little")
        self.kernel.follow(held(values), size // 8, count, self.following, mask, held(following))
        return PackedState(self.order, bytes(following), size)


def _taken(before: LaneWord, after: LaneWord, going: LaneWord) -> LaneWord:
    """Return a word after a step that only some lanes take."""
    return before ^ ((before ^ after) & going)


def _is_beyond(lanes: LaneWord, size: int) -> bool:
    """Return whether some of these lanes lie beyond words of so many bytes."""
    return lanes.bit_length() // 64 * 8 + 8 > size


def _operands(literals: Iterable[Literal], places: Sequence[int]) -> "array[int]":
    """Return literals as operands: twice the place of each among the values, plus one where it is complemented."""
    return array("I", [2 * places[literal >> 1] + (literal & 1) for literal in literals])


def evaluator(circuit: Circuit, roots: Iterable[Literal], latches: Sequence[LatchNode] = ()) -> Evaluator:
    """Return the evaluator of the cone of these literals, and of these latches after the step."""
    nodes = circuit.cone([*roots, *(latch.next for latch in latches)])
    known = {latch.node for latch in latches}
    packed = circuit.fanins.packed
    others = [node for node in nodes if not packed[2 * node + 1] and node and node not in known]
    leaves = (*(latch.node for latch in latches), *others)
    native = kernel_for(len(nodes))
    if native is None:
        return _batches(circuit, tuple(latches), leaves, nodes)
    return _compiled(circuit, tuple(latches), leaves, nodes, native)


def whole_evaluator(circuit: Circuit) -> Evaluator:
    """Return the evaluator of all bad literals of a circuit, and of all its latches after the step."""
    return evaluator(circuit, circuit.bad, circuit.latches)


def _compiled(
    circuit: Circuit, latches: tuple[LatchNode, ...], leaves: tuple[int, ...], nodes: list[int], native: Kernel
) -> NativeEvaluator:
    fanins, first = circuit.fanins, 1 + len(leaves)
    places, chosen = array("I", bytes(4 * len(fanins))), array("I", nodes)
    for place, node in enumerate(leaves, 1):
        places[node] = place
    operands = array("I", bytes(8 * len(nodes)))
    count = native.place(address(fanins.packed), len(nodes), address(chosen), first, address(places), address(operands))
    del operands[2 * (count - first) :]
    following = _operands((latch.next for latch in latches), places)
    order = {latch.node: place for place, latch in enumerate(latches)}
    return NativeEvaluator(latches, leaves, places, count, operands.tobytes(), following.tobytes(), order, native)


def _batches(
    circuit: Circuit, latches: tuple[LatchNode, ...], leaves: tuple[int, ...], nodes: list[int]
) -> LevelEvaluator:
    levels: dict[int, int] = dict.fromkeys((0, *leaves), 0)
    inverted = dict.fromkeys((0, *leaves), 0)
    groups: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
    for node, left, right in circuit.fanins.conjunctions(nodes):
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
    """Return the function that reads these places of the values."""
    if len(places) == 1:
        return itemgetter(slice(places[0], places[0] + 1))
    return itemgetter(*places)
