"""The packed tables: what is packed is decoded again, and what is damaged is not."""

import os
import random
import struct
import subprocess
import sys
import zlib
from dataclasses import fields
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exover.ocrd import packing
from exover.ocrd.compile import compile_model
from exover.ocrd.packing import COUNTS, HEADER, SECTIONS, DamagedTable, decode, pack
from exover.ocrd.tables import Tables
from tests.support.engines import DIGEST, model_of, tables_of
from tests.support.fuzz import spec_of

SMALL = """spec small;
    poster v: real in 0 .. 1 = 0.5;
    resource p: 3 consumable;
    module m { request a(w: real in 0 .. 1) { check w < 0.25 or v > 0.75; consumes p 1; } request b(); }
    mutex m.a, m.b by wait;"""
CRC_AT = 12
"""Where the checksum stands in the header."""

integers = st.one_of(st.integers(-3, 300), st.integers(-(1 << 63), (1 << 63) - 1))


def rows(kind: type[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    one = st.tuples(*(integers for _ in fields(kind))).map(lambda numbers: kind(*numbers))
    return st.lists(one, max_size=3).map(tuple)


all_tables = st.builds(
    Tables,
    digest=st.binary(min_size=32, max_size=32),
    flags=st.integers(0, 1),
    sums=st.lists(st.tuples(integers, integers), max_size=3).map(tuple),
    lists=st.lists(integers, max_size=5).map(tuple),
    reals=st.lists(st.floats(allow_nan=False), max_size=4).map(tuple),
    **{name: rows(kind) for name, kind in SECTIONS},
)


@settings(max_examples=50)
@given(all_tables)
def test_decoding_undoes_packing(tables: Tables) -> None:
    data = pack(tables)
    assert decode(data) == tables
    assert pack(decode(data)) == data


def test_words_are_as_narrow_as_their_numbers_allow() -> None:
    for number, size in ((1 << 15, 4), ((1 << 15) - 1, 2), (-(1 << 15), 2), (1 << 31, 8), (-(1 << 31) - 1, 8)):
        assert packing.width([0, number]) == size
    with pytest.raises(OverflowError):
        packing.width([1 << 63])


# ---- damage ----


def with_checksum(data: bytes) -> bytes:
    """Return the bytes with the checksum that they should have."""
    blank = data[:CRC_AT] + bytes(4) + data[CRC_AT + 4 :]
    return data[:CRC_AT] + struct.pack("<I", zlib.crc32(blank)) + data[CRC_AT + 4 :]


def test_any_changed_byte_is_found() -> None:
    data = pack(tables_of(model_of(SMALL)))
    assert with_checksum(data) == data
    for place in range(len(data)):
        for change in (0x01, 0x80, 0xFF):
            damaged = bytearray(data)
            damaged[place] ^= change
            with pytest.raises(DamagedTable):
                decode(bytes(damaged))


def test_any_missing_or_further_byte_is_found() -> None:
    data = pack(tables_of(model_of(SMALL)))
    for length in range(len(data)):
        with pytest.raises(DamagedTable):
            decode(data[:length])
        if length >= HEADER.size:
            with pytest.raises(DamagedTable):
                decode(with_checksum(data[:length]))
    for further in (b"\0", b"\0" * 8):
        with pytest.raises(DamagedTable):
            decode(data + further)
        with pytest.raises(DamagedTable):
            decode(with_checksum(data + further))


@pytest.mark.parametrize("section", range(COUNTS))
@pytest.mark.parametrize("change", [-1, 1, 1 << 31])
def test_a_wrong_length_is_found_even_under_a_right_checksum(section: int, change: int) -> None:
    data = bytearray(pack(tables_of(model_of(SMALL))))
    at = HEADER.size + 4 * section
    (count,) = struct.unpack_from("<I", data, at)
    if count + change < 0:
        change = 2
    struct.pack_into("<I", data, at, (count + change) % (1 << 32))
    with pytest.raises(DamagedTable, match="length"):
        decode(with_checksum(bytes(data)))


@pytest.mark.parametrize(("place", "value"), [(0, 0), (4, 99), (6, 3), (6, 0)])
def test_another_format_is_refused_even_under_a_right_checksum(place: int, value: int) -> None:
    """Magic, version, width."""
    data = bytearray(pack(tables_of(model_of(SMALL))))
    data[place] = value
    with pytest.raises(DamagedTable, match="format"):
        decode(with_checksum(bytes(data)))


@given(st.binary(max_size=400))
@settings(max_examples=200)
def test_bytes_that_are_no_table_are_refused(data: bytes) -> None:
    with pytest.raises(DamagedTable):
        decode(data)
    with pytest.raises(DamagedTable):
        decode(with_checksum(b"EXOV\x01\x00\x02\x00" + data + bytes(40)))


# ---- same input, same bytes; size ----

PACKING = """
import hashlib
from tests.support.engines import DIGEST, model_of
from tests.support.fuzz import spec_of
from exover.ocrd.compile import compile_model
from exover.ocrd.packing import pack
for seed in (0, 2, 5, 13):
    print(hashlib.sha256(pack(compile_model(model_of(spec_of(seed)), DIGEST).tables)).hexdigest())
"""


def test_the_same_spec_gives_the_same_bytes_in_every_process() -> None:
    found = set()
    for seed in ("0", "1", "2"):  # the order of sets of strings depends on it
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        found.add(
            subprocess.run([sys.executable, "-c", PACKING], env=environment, capture_output=True, check=True).stdout
        )
    assert len(found) == 1


def test_a_second_compilation_gives_the_same_bytes() -> None:
    """Nothing is left over from the first time."""
    for seed in (1, 4, 6):
        model = model_of(spec_of(seed))
        assert pack(compile_model(model, DIGEST).tables) == pack(compile_model(model, DIGEST).tables)


def mutexed(requests: int) -> tuple[int, int, int]:
    """Return nodes, words and depth of the tables of so many requests in random binary mutexes, three a request."""
    choice = random.Random(requests)
    names = [f"m.r{number}" for number in range(requests)]
    pairs: set[tuple[str, str]] = set()
    while len(pairs) < 3 * requests // 2:
        first, second = choice.sample(names, 2)
        pairs.add((min(first, second), max(first, second)))
    rules = "\n".join(f"mutex {a}, {b} by {choice.choice(('wait', 'reject', 'kill ' + a))};" for a, b in sorted(pairs))
    text = f"spec s; module m {{ {' '.join(f'request r{number}();' for number in range(requests))} }}\n{rules}"
    compiled = compile_model(model_of(text), DIGEST)
    return len(compiled.tables.nodes), len(packing.words(compiled.tables)), compiled.figures.depth


def test_tables_are_linear_in_the_rules() -> None:
    nodes, words, depth = mutexed(50)
    many_nodes, many_words, many_depth = mutexed(200)
    assert nodes < 10 * 75 and depth < 40
    assert many_nodes < 5 * nodes and many_words < 5 * words, "four times the rules, about four times the table"
    assert many_depth < 2 * depth


@pytest.mark.parametrize("clause", ["fail when", "check not"])
@pytest.mark.parametrize("about", ["active(m.b with n == self.w)", "past(m.b with d == self.w)"])
def test_tables_are_linear_in_the_values_of_a_self_parameter(clause: str, about: str) -> None:
    """The predicates of all values are there; which of them counts is asked before any of them."""
    nodes = []
    for values in (16, 64):
        span = f"int in 1 .. {values}"
        text = f"request a(w: {span}) {{ {clause} {about}; }} request b(n: {span}) returns (d: {span});"
        nodes.append(len(tables_of(model_of(f"spec s; module m {{ {text} }}")).nodes))
    assert nodes[0] < 12 * 16 and nodes[1] < 5 * nodes[0]
