"""Damaged tables are refused when they are loaded: 2 000 of them here, 100 000 in `make faults`."""

import os
from collections import Counter
from random import Random

import pytest

from exover.ocrd.packing import pack
from tests.runtime.compiling import READY, SPECS, Harness, built

COUNT = 100_000 if os.environ.get("EXOVER_ALL_FAULTS") else 2_000
BATCH = 1_000
KINDS = ("bits", "burst", "cut", "moved", "zeroed", "swapped")


def damaged(data: bytes, kind: str, lot: Random) -> bytes:
    """Return the bytes with damage of some kind, never the same bytes."""
    found = bytearray(data)
    at = lot.randrange(len(data))
    match kind:
        case "bits":
            for _ in range(lot.randrange(1, 9)):
                found[lot.randrange(len(data))] ^= 1 << lot.randrange(8)
        case "burst":
            found[at : at + 8] = lot.randbytes(len(found[at : at + 8]))
        case "cut":
            found = found[:at]
        case "moved":
            found.insert(at, lot.randrange(256))
        case "zeroed":
            found[at : at + lot.randrange(1, 64)] = bytes(len(found[at : at + 1]))
        case _:
            other = lot.randrange(len(data))
            found[at], found[other] = found[other], found[at]
    return bytes(found) if found != data else damaged(data, kind, lot)


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_tables_are_refused(kind: str, harness: Harness) -> None:
    lot = Random(kind)
    whole = [pack(built(path).tables) for path in SPECS]
    sound = [data for data in whole if data[6] == 2]
    assert len(sound) > 5
    found: Counter[int] = Counter()
    for start in range(0, COUNT // len(KINDS), BATCH):
        size = min(BATCH, COUNT // len(KINDS) - start)
        found.update(
            outcome.status for outcome in harness.run([damaged(lot.choice(sound), kind, lot) for _ in range(size)])
        )
    assert READY not in found and found.total() == COUNT // len(KINDS)
