"""Bytes that are no tables, or not those of the spec, are told to be so: never a fault of the program itself."""

from dataclasses import replace
from random import Random
from zlib import crc32

from exover.ocrd.packing import pack
from exover.pipeline import build, different
from exover.proofs.bytes import UndecidedBytes
from tests.support.engines import model_of

SPEC = """spec small;
poster wind: int in 0 .. 9 = 0;
module m {
    request go(s: {l, r}) { fail gust: when wind > 5; }
    request st();
}
mutex halt: m.st over m.go;
"""


def sealed(data: bytes | bytearray) -> bytes:
    """Return the bytes with the checksum that they have."""
    return bytes(data[:12]) + crc32(data[:12] + bytes(4) + data[16:]).to_bytes(4, "little") + bytes(data[16:])


def test_damaged_tables_whose_checksum_is_right_are_refused() -> None:
    model = model_of(SPEC)
    data, random = build(model).data, Random(5)
    assert different(model, sealed(data)) == []
    found = set[str]()
    for _ in range(80):
        changed = bytearray(data)
        changed[random.randrange(16, len(data))] ^= 1 << random.randrange(8)
        try:
            said = different(model, sealed(changed))
        except UndecidedBytes:
            continue
        assert said
        found.update(said)
    assert "the check words are wrong" in found


def test_a_weight_that_is_no_integer_is_told_by_its_record() -> None:
    model = model_of(
        "spec weighed; module m { request go(v: real in 0 .. 9); request st(); } mutex halt: m.st over m.go;"
    )
    built = build(model)
    first, *others = built.tables.features
    damaged = replace(built.tables, features=(replace(first, weight=0), *others))
    assert different(model, pack(damaged)) == ["record 0 of the section requests cannot be of this spec"]
