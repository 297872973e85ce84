"""The packed records of the tables: bytes written and decoded.

All words have one width, the least of 2, 4 and 8 bytes that holds every number. The bytes are little-endian: header,
counts, doubles, words, and a check word for each record and double. There are no check words if the bit rows alone
prevent every unsafe launch (`is_checked`).
"""

import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import fields
from functools import reduce
from itertools import chain
from operator import attrgetter, xor
from typing import Any

from exover.ocrd.tables import (
    NO_DENIALS,
    AmountRow,
    ConflictRow,
    EffectRow,
    Entry,
    FeatureRow,
    InvariantRow,
    LatchRow,
    LaunchRow,
    LimitRow,
    Node,
    OrderRow,
    ParamRow,
    PastRow,
    ReasonRow,
    RequestRow,
    RuleRow,
    StockRow,
    Tables,
    VariableRow,
)

MAGIC = b"EXOV"
VERSION = 3
SECTIONS: tuple[tuple[str, type[Any]], ...] = (
    ("nodes", Node),
    ("entries", Entry),
    ("requests", RequestRow),
    ("params", ParamRow),
    ("orders", OrderRow),
    ("features", FeatureRow),
    ("pasts", PastRow),
    ("amounts", AmountRow),
    ("effects", EffectRow),
    ("variables", VariableRow),
    ("latches", LatchRow),
    ("stocks", StockRow),
    ("rules", RuleRow),
    ("launches", LaunchRow),
    ("limits", LimitRow),
    ("conflicts", ConflictRow),
    ("reasons", ReasonRow),
    ("invariants", InvariantRow),
)
"""The sections of records in the order of the bytes; `sums` and `lists` follow."""
FIELDS: dict[str, tuple[str, ...]] = {
    **{name: tuple(each.name for each in fields(kind)) for name, kind in SECTIONS},
    "sums": ("entry", "factor"),
    "lists": ("word",),
}
"""The fields of the records of each section, in the order of the bytes."""

HEADER = struct.Struct("<4sHHIII32s")
"""magic, version, width, flags, CRC-32 of all bytes (this field as 0), count of doubles, SHA-256 of the spec."""
COUNTS = len(SECTIONS) + 2
START = HEADER.size + 4 * (COUNTS + 1)
"""The offset of the doubles: after the header, the counts of records and the count of check words."""
CODES = {2: "h", 4: "i", 8: "q"}
"""The format characters of `struct` by width."""
COVERED = ("nodes", "entries", "requests", "features", "limits", "conflicts", "reasons")
"""The only nonempty sections of a spec that says nothing but which requests exclude each other."""


class DamagedTable(ValueError):
    """The bytes are no table, or were changed after they were written."""


def row(record: Any) -> tuple[int, ...]:
    """Return the fields of one record in order."""
    return tuple([getattr(record, name) for name in record.__slots__])


def words(tables: Tables) -> list[int]:
    """Return all words of the records in the order of the bytes."""
    return list(chain.from_iterable(chain.from_iterable(rows(tables))))


def rows(tables: Tables) -> Iterator[Iterable[tuple[int, ...]]]:
    """Yield the records as tuples of words, section by section."""
    for name, _ in SECTIONS:
        yield zip(*(map(attrgetter(each), getattr(tables, name)) for each in FIELDS[name]), strict=True)
    yield tables.sums
    yield ((word,) for word in tables.lists)


def is_checked(tables: Tables) -> bool:
    """Return whether there are check words. There are none iff no section but those of COVERED is used, there are no
    doubles, each request has one slot, and each reason implies a conflict: then the bit rows check every launch.
    """
    others = (name for name, _ in SECTIONS if name not in COVERED)
    return bool(
        any(getattr(tables, name) for name in others)
        or tables.reals
        or any(request.instances != 1 for request in tables.requests)
        or any(reason.denials == NO_DENIALS for reason in tables.reasons)
    )


def checks(tables: Tables) -> list[int]:
    """Return the check words, one for each record, then one for each double: the complement of the XOR of its words.

    Empty unless `is_checked`.
    """
    if not is_checked(tables):
        return []
    size = width(words(tables))
    doubles = (struct.unpack(f"<{8 // size}{CODES[size]}", struct.pack("<d", real)) for real in tables.reals)
    return [~reduce(xor, record, 0) for record in chain(chain.from_iterable(rows(tables)), doubles)]


def counts(tables: Tables) -> list[int]:
    """Return the number of records of each section, in the order of the bytes."""
    return [len(getattr(tables, name)) for name in FIELDS]


def head(tables: Tables) -> tuple[int, ...]:
    """Return the header and the counts of the packed tables, as words of 32 bits."""
    return struct.unpack_from(f"<{START // 4}I", pack(tables))


def bits(real: float) -> int:
    """Return the 64 bits of a double as an unsigned number."""
    found: int = struct.unpack("<Q", struct.pack("<d", real))[0]
    return found


def width(numbers: list[int]) -> int:
    """Return the least of 2, 4, 8 bytes that holds every number in two's complement; raises `OverflowError`."""
    low, high = min(numbers, default=0), max(numbers, default=0)
    for size in (2, 4, 8):
        edge = 1 << (8 * size - 1)
        if -edge <= low and high < edge:
            return size
    raise OverflowError("a number of the tables does not fit 64 bits")


def pack(tables: Tables) -> bytes:
    """Return the bytes of the tables: header, counts, doubles, words, check words. Equal tables give equal bytes."""
    numbers, checking = words(tables), checks(tables)
    size = width(numbers)
    body = struct.pack(f"<{COUNTS + 1}I", *counts(tables), len(checking))
    body += struct.pack(f"<{len(tables.reals)}d", *tables.reals)
    body += struct.pack(f"<{len(numbers) + len(checking)}{CODES[size]}", *numbers, *checking)

    def head(crc: int) -> bytes:
        return HEADER.pack(MAGIC, VERSION, size, tables.flags, crc, len(tables.reals), tables.digest)

    return head(zlib.crc32(head(0) + body)) + body


def decode(data: bytes) -> Tables:
    """Return the tables that these bytes encode, the inverse of `pack`; raises `DamagedTable`."""
    if len(data) < START:
        raise DamagedTable("too short for a table")
    magic, version, size, flags, crc, real_count, digest = HEADER.unpack_from(data)
    if magic != MAGIC or version != VERSION or size not in (2, 4, 8):
        raise DamagedTable("no table of this format")
    if zlib.crc32(data[:12] + bytes(4) + data[16:]) != crc:
        raise DamagedTable("the checksum is wrong")
    *lengths, checking = struct.unpack_from(f"<{COUNTS + 1}I", data, HEADER.size)
    sizes = list(map(len, FIELDS.values()))
    total = sum(length * step for length, step in zip(lengths, sizes, strict=True))
    if len(data) != START + 8 * real_count + size * (total + checking):
        raise DamagedTable("the length is wrong")
    reals = struct.unpack_from(f"<{real_count}d", data, START)
    numbers = struct.unpack_from(f"<{total + checking}{CODES[size]}", data, START + 8 * real_count)
    parts: dict[str, Any] = {}
    at = 0
    for (name, kind), length, step in zip(SECTIONS, lengths[:-2], sizes[:-2], strict=True):
        end = at + step * length
        parts[name] = tuple(map(kind, *(numbers[at + field : end : step] for field in range(step))))
        at = end
    pairs = tuple((numbers[at + 2 * i], numbers[at + 2 * i + 1]) for i in range(lengths[-2]))
    lists = tuple(numbers[at + 2 * lengths[-2] : total])
    tables = Tables(digest=digest, flags=flags, sums=pairs, lists=lists, reals=reals, **parts)
    if numbers[total:] != tuple(checks(tables)):
        raise DamagedTable("the check words are wrong")
    return tables
