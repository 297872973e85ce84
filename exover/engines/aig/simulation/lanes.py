"""Many runs side by side: a Python integer says in which runs a literal is true, a bit (a *lane*) for each run."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import compress
from operator import or_

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import LatchNode

BIT = [bytes(byte >> place & 1 for byte in range(256)) for place in range(8)]
"""By place the bit there of each byte."""
LaneWord = int
"""In which lanes something is true."""
LaneState = Mapping[int, LaneWord]
"""By latch, by its node, in which lanes it is true."""
StateBits = bytes
"""A state in one lane: by latch, in their order, 1 where it is true, else 0."""
DIGITS = bytes(b"01"[byte & 1] for byte in range(256))
"""By byte of state bits its digit."""


@dataclass(frozen=True, slots=True, eq=False)
class PackedState(Mapping[int, LaneWord]):
    """The words of nodes side by side in memory, each of `size` bytes; `places`: by node, in order."""

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

    def differing(self, other: "PackedState") -> LaneWord | None:
        """Return in which lanes two states differ, None if their memory is laid out otherwise."""
        if self.places is not other.places or self.size != other.size:
            return None
        size, found = self.size, 0
        for start in range(0, len(self.memory) if self.memory != other.memory else 0, size):
            one, another = self.memory[start : start + size], other.memory[start : start + size]
            if one != another:
                found |= int.from_bytes(one, "little") ^ int.from_bytes(another, "little")
        return found

    def at_lane(self, lane: int) -> frozenset[int]:
        """Return the latches that are true in a lane."""
        return frozenset(compress(self.places, self.bits_at(lane)))

    def bits_at(self, lane: int) -> StateBits:
        """Return the state in a lane."""
        return self.memory[lane >> 3 :: self.size].translate(BIT[lane & 7])


def packed(words: Mapping[int, LaneWord], lanes: int) -> PackedState:
    """Return words of so many lanes side by side: a lane is read from them in a fifth of the time."""
    size = lanes // 8 + 1
    memory = b"".join([word.to_bytes(size, "little") for word in words.values()])
    return PackedState({node: place for place, node in enumerate(words)}, memory, size)


def turned(states: Sequence[StateBits], nodes: Sequence[int]) -> dict[int, LaneWord]:
    """Return states side by side, a lane for each; `nodes`: those of the latches, in their order."""
    digits, wide = b"".join(reversed(states)).translate(DIGITS), len(nodes)
    return {node: int(digits[place::wide], 2) for place, node in enumerate(nodes)}


def initial(latches: Iterable[LatchNode], lanes: LaneWord) -> LaneState:
    """Return the state at the start, in these lanes."""
    return {latch.node: lanes if latch.initial else 0 for latch in latches}


def differing(one: LaneState, other: LaneState) -> LaneWord:
    """Return in which lanes two states of the same latches differ."""
    if isinstance(one, PackedState) and isinstance(other, PackedState):
        found = one.differing(other)
        if found is not None:
            return found
    return reduce(or_, (word ^ other[node] for node, word in one.items()), 0)


def lowest(word: LaneWord) -> int:
    """Return the number of the lowest lane that is set."""
    return (word & -word).bit_length() - 1


def numbers(word: LaneWord) -> Iterator[int]:
    """Yield the numbers of the lanes that are set, the lowest first."""
    while word:
        yield lowest(word)
        word &= word - 1


def at_lane(words: Mapping[int, LaneWord], lane: int) -> frozenset[int]:
    """Return the nodes that are true in a lane."""
    if isinstance(words, PackedState):
        return words.at_lane(lane)
    bit = 1 << lane
    return frozenset(compress(words, map(bit.__and__, words.values())))


def side_by_side(runs: Sequence[Inputs], number: int) -> tuple[LaneWord, dict[int, LaneWord]]:
    """Return which runs, a lane for each, have a step of this number, and by input in which of them it is true."""
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
