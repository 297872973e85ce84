"""What exover_load refuses: every cause has its own code, and whatever loads runs without leaving its memory."""

import random
import struct
from collections import Counter
from dataclasses import fields, replace
from functools import reduce
from itertools import accumulate
from operator import xor
from pathlib import Path

import pytest

from exover.bounds.sizes import ram_bytes
from exover.ocrd.packing import COUNTS, HEADER, SECTIONS, checks, pack, words
from exover.ocrd.packing import START as WORDS
from exover.ocrd.tables import Entry, Tables
from exover.pipeline import build
from tests.runtime.compiling import (
    BAD_CHECKSUM,
    BAD_COUNTS,
    BAD_INDEX,
    BAD_LIMITS,
    BAD_NODE,
    BAD_SUM,
    FAULTY,
    NO_MAGIC,
    OTHER_FORMAT,
    OTHER_WIDTH,
    READY,
    SPECS,
    Harness,
    built,
    field_at,
    sealed,
)
from tests.support.engines import model_of

ROVER = next(path for path in SPECS if path.parent.name == "specs" and path.stem == "rover")
CORNERS = next(path for path in SPECS if path.stem == "corners")


SIZES = [len(fields(kind)) for _, kind in SECTIONS] + [2, 1]
"""Words of the records of each section."""


def checked(data: bytes) -> bytes:
    """Return the bytes, of width 2, with the check words that belong to their records and doubles."""
    *counts, checks = struct.unpack_from(f"<{COUNTS + 1}I", data, HEADER.size)
    (reals,) = struct.unpack_from("<I", data, 16)
    records = [size for size, count in zip(SIZES, counts, strict=True) for _ in range(count)] + [4] * reals
    doubles = data[WORDS : WORDS + 8 * reals]
    numbers = struct.unpack(f"<{sum(records)}h", data[WORDS + 8 * reals : len(data) - 2 * checks] + doubles)
    ends = accumulate(records)
    words = [~reduce(xor, numbers[end - size : end], 0) for end, size in zip(ends, records, strict=True)]
    return data[: len(data) - 2 * checks] + struct.pack(f"<{checks}h", *words[:checks])


def changed(tables: Tables, section: str, record: int, name: str, value: int) -> bytes:
    """Return the bytes with another number in one field, the checksum put right."""
    data = bytearray(pack(tables))
    at = len(data) - 2 * (len(words(tables)) + len(checks(tables))) + 2 * field_at(tables, section, record, name)
    data[at : at + 2] = struct.pack("<h", value)
    return sealed(checked(bytes(data)))


@pytest.mark.parametrize("path", SPECS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_tables_load_into_exactly_the_memory_that_is_announced(path: Path, harness: Harness) -> None:
    tables = built(path).tables
    (outcome,) = harness.run([pack(tables)], events=2000)
    assert outcome.status == READY and outcome.fault == READY
    assert outcome.memory == ram_bytes(tables)


def test_every_flipped_bit_is_found(harness: Harness) -> None:
    data = pack(build(model_of(FAULTY)).tables)
    flips = []
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        flips.append(bytes(flipped))
    found = Counter(outcome.status for outcome in harness.run(flips))
    assert READY not in found
    assert found[NO_MAGIC] == 32 and found[OTHER_FORMAT] == found[OTHER_WIDTH] == 16
    # The numbers of records and of doubles; every other bit is left to the checksum.
    assert found[BAD_COUNTS] == 32 * 22
    assert found[BAD_CHECKSUM] == 8 * len(data) - 32 - 32 - 32 * 22


@pytest.mark.parametrize(
    ("section", "field", "value", "status"),
    [
        ("nodes", "low", -3, BAD_INDEX),
        ("nodes", "low", 0, BAD_NODE),
        ("nodes", "high", 0, BAD_NODE),
        ("nodes", "code", 1000, BAD_NODE),
        ("nodes", "code", -10, BAD_NODE),
        ("entries", "sums_end", 1000, BAD_INDEX),
        ("requests", "decide", 1000, BAD_INDEX),
        ("requests", "slots", 1, BAD_INDEX),
        ("requests", "instances", 0, BAD_INDEX),
        ("requests", "instances", -1, BAD_INDEX),
        ("requests", "interrupts_self", 2, BAD_INDEX),
        ("requests", "results", 1000, BAD_INDEX),
        ("requests", "features_end", -1, BAD_INDEX),
        ("requests", "last", 1000, BAD_INDEX),
        ("params", "type", 4, BAD_INDEX),
        ("params", "low", 1000, BAD_INDEX),
        ("params", "value", -2, BAD_INDEX),
        ("features", "predicate", -3, BAD_INDEX),
        ("features", "slot", 1, BAD_INDEX),
        ("features", "weight", 5, BAD_INDEX),
        ("pasts", "entry", 1000, BAD_INDEX),
        ("effects", "kind", 2, BAD_INDEX),
        ("effects", "target", 1000, BAD_INDEX),
        ("variables", "role", 3, BAD_INDEX),
        ("variables", "raw", 1000, BAD_INDEX),
        ("variables", "refresh_end", 1000, BAD_INDEX),
        ("rules", "root", 1000, BAD_INDEX),
        ("launches", "request", -1, BAD_INDEX),
        ("launches", "args", 1000, BAD_INDEX),
        ("requests", "conflicts_end", 1000, BAD_INDEX),
        ("conflicts", "block", 1, BAD_INDEX),
        ("conflicts", "block", -1, BAD_INDEX),
        ("reasons", "denials", 3, BAD_INDEX),
        ("limits", "passes", 0, BAD_LIMITS),
        ("limits", "passes", 32000, BAD_LIMITS),
        ("limits", "violations", 1000, BAD_LIMITS),
    ],
)
def test_a_number_out_of_place_is_refused(section: str, field: str, value: int, status: int, harness: Harness) -> None:
    (outcome,) = harness.run([changed(built(ROVER).tables, section, 0, field, value)])
    assert outcome.status == status


REQUIRED = """spec required;
poster due: bool = false;
module m { request go(x: real in 0.0 .. 5.0, n: int in 0 .. 3); }
launch start: m.go(2.5, 1) when due because "it is due";
"""


def with_each_word_of_lists(tables: Tables) -> list[bytes]:
    """Return the bytes with one word of `lists` too great, for each of the words."""
    damaged = []
    for index in range(len(tables.lists)):
        data = bytearray(pack(tables))
        at = len(data) - 2 * (len(checks(tables)) + len(tables.lists) - index)
        data[at : at + 2] = struct.pack("<h", 30000)
        damaged.append(sealed(checked(bytes(data))))
    return damaged


def test_lists_are_looked_at(harness: Harness) -> None:
    """A word of `lists` counts for what reads it: rules of an entry, requests that clear a latch."""
    damaged = with_each_word_of_lists(built(CORNERS).tables)
    assert [outcome.status for outcome in harness.run(damaged)] == [BAD_INDEX] * 12


def test_arguments_of_a_launch_rule_are_looked_at(harness: Harness) -> None:
    """A real one is the index of a double; an integer one is a number, whatever it is."""
    damaged = with_each_word_of_lists(build(model_of(REQUIRED)).tables)
    assert [outcome.status for outcome in harness.run(damaged)] == [BAD_INDEX, READY]


def test_a_sum_of_sums_is_refused(harness: Harness) -> None:
    tables = built(ROVER).tables
    total = tables.sums[0][0]
    row = tables.entries[total]
    nested = Entry(row.initial, row.rules, row.rules_end, 0, 1)
    entries = (*tables.entries[:total], nested, *tables.entries[total + 1 :])
    (outcome,) = harness.run([pack(replace(tables, entries=entries))])
    assert outcome.status == BAD_SUM


@pytest.mark.parametrize("length", [WORDS, WORDS + 1, 500, -1])
def test_what_is_cut_short_is_refused(length: int, harness: Harness) -> None:
    data = pack(built(ROVER).tables)[:length]
    (outcome,) = harness.run([sealed(data)])
    assert outcome.status == BAD_COUNTS


@pytest.mark.parametrize("path", [ROVER, CORNERS], ids=lambda path: path.stem)
def test_damage_behind_a_right_checksum_is_refused_or_harmless(path: Path, harness: Harness) -> None:
    """Mutations that the checksum does not tell are refused, or stay within their memory and end."""
    lot = random.Random(20261121)
    data = pack(built(path).tables)
    damaged = []
    for _ in range(300):
        mutated = bytearray(data)
        for _ in range(lot.choice((1, 1, 2, 4))):
            at = lot.randrange(WORDS, len(data)) // 2 * 2
            number = lot.choice((-3, -2, -1, 0, 1, 2, 3, 300, 32767, -32768, lot.randrange(150)))
            mutated[at : at + 2] = struct.pack("<h", number)
        damaged.append(sealed(checked(bytes(mutated))))
    found = Counter(outcome.status for outcome in harness.run(damaged, events=200))
    assert found[READY] > 10 and found[BAD_INDEX] > 10 and found[BAD_NODE] > 10
