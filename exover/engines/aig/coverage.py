"""Which pairs of values runs had together, as far as that is looked for."""

import ctypes
from array import array
from collections.abc import Iterable, Sequence

from exover.engines.aig.kernel import kernel
from exover.engines.aig.simulation import Word, lowest


class PairCoverage:
    """Pairs of signals, by their places, that no run of those that were shown had true together."""

    def __init__(self, pairs: Iterable[tuple[int, int]]) -> None:
        self._pairs = array("I", [place for pair in pairs for place in pair])

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self._pairs) // 2

    def cover(self, signals: Sequence[Word], lanes: int, most: int) -> list[int]:
        """Return up to so many lanes that have pairs none had before, each with one that those before it have not.

        Pairs that these lanes have are covered, in the order of the pairs; where `most` is reached the others stay.
        """
        native = kernel()
        if native is None:
            return self._covered(signals, most)
        size = lanes // 64 + 1
        words = b"".join(word.to_bytes(8 * size, "little") for word in signals)
        held = (ctypes.c_uint32 * len(self._pairs)).from_buffer(self._pairs)
        found, have = (ctypes.c_uint32 * (most + 1))(), (ctypes.c_uint64 * size)()
        left = native.cover(words, size, held, len(self), most, found, have)
        del held
        del self._pairs[2 * left :]
        return found[1 : 1 + found[0]]

    def _covered(self, signals: Sequence[Word], most: int) -> list[int]:
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
