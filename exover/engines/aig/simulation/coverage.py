"""State coverage of runs: which pairs of latch values occurred together, and which modes."""

import ctypes
from array import array
from collections.abc import Sequence

from exover.dataclass import dataclass
from exover.engines.aig.circuit.kernel import address, kernel
from exover.engines.aig.simulation.lanes import LaneWord, lowest


@dataclass(frozen=True, slots=True)
class CoverageGoals:
    """The latches, by their nodes, whose values tell what is new.

    `pairs`: two of these with values that no run had together before are new; `mode`: so is a valuation of all these.
    `progress`: the more of these are true in a state, the nearer it is to what is looked for.
    """

    pairs: tuple[int, ...] = ()
    mode: tuple[int, ...] = ()
    progress: tuple[int, ...] = ()


def value_pairs(signals: int) -> "array[int]":
    """Return all pairs of values of two different signals, as a flat array ordered by the distance of the places.

    The place of a value is `2 * k` where the signal at place `k` is true, `2 * k + 1` where it is false.
    """
    count = 2 * signals
    found = array("I")
    for by in range(1, count):
        first = range(count - by) if by > 1 else range(1, count - 1, 2)
        pairs = array("I", bytes(8 * len(first)))
        pairs[::2] = array("I", first)
        pairs[1::2] = array("I", range(first.start + by, first.stop + by, first.step))
        found += pairs
    return found


class PairCoverage:
    """Pairs of signals, by their places, that were never true together in the states covered so far."""

    def __init__(self, pairs: "array[int]") -> None:
        """Take pairs: places, two for each."""
        self._pairs = pairs

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self._pairs) // 2

    def cover(self, signals: Sequence[LaneWord], lanes: int, most: int) -> list[int]:
        """Return up to `most` lanes in which uncovered pairs are true, each with a pair that the lanes before it lack.

        Pairs of these lanes are covered from then on; those of other lanes stay uncovered.
        """
        native = kernel()
        if native is None:
            return self._covered(signals, most)
        size = lanes // 64 + 1
        words = b"".join(word.to_bytes(8 * size, "little") for word in signals)
        found, have = (ctypes.c_uint32 * (most + 1))(), (ctypes.c_uint64 * size)()
        left = native.cover(words, size, address(self._pairs), len(self), most, found, have)
        del self._pairs[2 * left :]
        return found[1 : 1 + found[0]]

    def _covered(self, signals: Sequence[LaneWord], most: int) -> list[int]:
        found: list[int] = []
        left, have = array("I"), 0
        for one, other in zip(self._pairs[::2], self._pairs[1::2], strict=True):
            both = signals[one] & signals[other]
            if both and not both & have and len(found) < most:
                found.append(lowest(both))
                have |= both & -both
            if not both & have:
                left.extend((one, other))
        self._pairs = left
        return found


class ModeCoverage:
    """Valuations of some signals in the lanes that were returned so far."""

    def __init__(self) -> None:
        self._known: set[tuple[str, ...]] = set()

    def __len__(self) -> int:
        """Return the number of valuations."""
        return len(self._known)

    def cover(self, signals: Sequence[LaneWord], lanes: int, most: int) -> list[int]:
        """Return up to `most` lanes with new valuations, one for each valuation; other valuations stay new."""
        rows = (f"{word:0{lanes}b}"[::-1] for word in signals)
        found: list[int] = []
        for lane, valuation in enumerate(zip(*rows, strict=True)):
            if len(found) == most:
                break
            if valuation not in self._known:
                self._known.add(valuation)
                found.append(lane)
        return found
