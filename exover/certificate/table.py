"""The bytes of a table, decoded for the checker alone (docs/runtime.md, "The bytes")."""

import hashlib
import math
import struct
import zlib
from collections import namedtuple
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

NONE, ALWAYS = -1, -2
REJECT, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE = range(1, 10)
REAL = 3
HEADER = struct.Struct("<4sHHIII32s")
LAYOUT = {
    "nodes": "code bound low high",
    "entries": "initial rules rules_end sums sums_end",
    "requests": "decide slots instances values interrupts_self statuses params results params_end orders orders_end "
    "features features_end pasts pasts_end consumes produces produces_end on_launch on_ok on_failed on_interrupted "
    "effects_end last conflicts conflicts_end",
    "params": "type low high cuts cuts_end value rank",
    "orders": "left right entry",
    "features": "predicate slot weight running stopping waiting clearing",
    "pasts": "predicate entry",
    "amounts": "stock amount predicate",
    "effects": "kind target value",
    "variables": "role type low high initial has_fallback fallback cuts cuts_end value rank raw refresh refresh_end "
    "orders orders_end",
    "latches": "variable condition resets resets_end",
    "stocks": "capacity initial entry",
    "rules": "root reason",
    "launches": "condition request args reason",
    "limits": "tests actions passes violations",
    "conflicts": "block mask",
    "reasons": "denials",
    "sums": "entry factor",
    "lists": "word",
}
ANY = {"code", "bound", "low", "high", "initial", "fallback", "factor", "mask", "word", "left", "right"}
"""Fields that may be any number; every other is an index or a count, at least -1, a predicate at least -2."""
ROWS: dict[str, Any] = {name: namedtuple(name, names) for name, names in LAYOUT.items()}


class Refused(Exception):
    """What is wrong with a table or a certificate; the text tells it to the user."""


@dataclass
class Table:
    """The records by section, the doubles exact (infinities as they are), and by entry what it is (see `sources`)."""

    sha256: str
    spec: str
    flags: int
    reals: list[Any]
    sections: dict[str, list[Any]]
    sources: dict[int, list[tuple[Any, ...]]] = field(default_factory=dict)

    def __getattr__(self, name: str) -> list[Any]:
        """Return the records of a section."""
        if name not in LAYOUT:
            raise AttributeError(name)
        return self.sections[name]

    def owner(self, slot: int) -> int:
        """Return the request of a slot of all."""
        return max(number for number, row in enumerate(self.requests) if row.slots <= slot)

    def slots(self, request: int) -> range:
        """Return the slots of a request among all."""
        row = self.requests[request]
        return range(row.slots, row.slots + row.instances)

    def conflicts_of(self, request: int) -> list[int]:
        """Return the requests in the bit row of a request."""
        row, every = self.requests[request], range(len(self.requests))
        blocks = self.conflicts[row.conflicts : row.conflicts_end]
        return [n for n in every if any(b.block == n // 16 and b.mask >> n % 16 & 1 for b in blocks)]


def decode(data: bytes) -> Table:
    """Return the table; `Refused` if the bytes are none, or its records do not fit together."""
    counts_end = HEADER.size + 4 * len(LAYOUT)
    if len(data) < counts_end:
        raise Refused("the table is too short")
    magic, version, width, flags, crc, real_count, spec = HEADER.unpack_from(data)
    if magic != b"EXOV" or version != 2 or width not in (2, 4, 8):
        raise Refused("the file is no table of format 2")
    if zlib.crc32(data[16:], zlib.crc32(data[:12] + bytes(4))) != crc:
        raise Refused("the checksum of the table is wrong")
    counts = struct.unpack_from(f"<{len(LAYOUT)}I", data, HEADER.size)
    start = counts_end + -counts_end % 8
    total = sum(count * len(row._fields) for count, row in zip(counts, ROWS.values(), strict=True))
    if len(data) != start + 8 * real_count + width * total:
        raise Refused("the table has not the length that it says")
    doubles = struct.unpack_from(f"<{real_count}d", data, start)
    words = iter(struct.unpack_from(f"<{total}{ {2: 'h', 4: 'i', 8: 'q'}[width] }", data, start + 8 * real_count))
    sections = {}
    for (name, row), count in zip(ROWS.items(), counts, strict=True):
        sections[name] = [row(*(next(words) for _ in row._fields)) for _ in range(count)]
    reals = [Fraction(x) if math.isfinite(x) else x for x in doubles]
    table = Table(hashlib.sha256(data).hexdigest(), spec.hex(), flags, reals, sections)
    try:
        _well_formed(table)
        _connect(table)
    except (IndexError, KeyError, ValueError) as error:
        raise Refused("the records of the table do not fit together") from error
    return table


def _well_formed(table: Table) -> None:
    for name, rows in table.sections.items():
        for number, row in enumerate(rows):
            for at, value in zip(row._fields, row, strict=True):
                if value < (ALWAYS if at == "predicate" else NONE) and at not in ANY and name != "effects":
                    raise Refused(f"`{at}` of record {number} of {name} points nowhere")
    for number, node in enumerate(table.nodes):
        children = (node.low,) if node.code < 0 else (node.low, node.high)
        if not all(child == NONE or number < child < len(table.nodes) for child in children):
            raise Refused(f"a child of node {number} does not come after it")
        if node.code >= len(table.entries) or node.code < -AGREE:
            raise Refused(f"node {number} is no test and no action")
    if len(table.limits) != 1 or table.limits[0].passes < 1:
        raise Refused("the table has no limits")
    ends = [(row.slots, row.slots + row.instances) for row in table.requests]
    if [start for start, _ in ends] != [0, *(end for _, end in ends[:-1])][: len(ends)]:
        raise Refused("the slots of the requests do not follow each other")


def _connect(table: Table) -> None:
    """Say of every entry what it is: the sum of its sources. All of them are set at once, or all are counted."""

    def add(entry: int, *source: Any) -> None:
        if entry >= len(table.entries):
            raise Refused(f"there is no entry {entry}")
        if entry != NONE:
            table.sources.setdefault(entry, []).append(source)

    for number, row in enumerate(table.requests):
        add(row.last, "last", number)
        for k, param in enumerate(table.params[row.params : row.params_end]):
            add(param.value, "arg", number, k)
            add(param.rank, "argrank", number, k, table.reals[param.cuts : param.cuts_end])
        for order in table.orders[row.orders : row.orders_end]:
            add(order.entry, "order", number, order.left, order.right)
        for past in table.pasts[row.pasts : row.pasts_end]:
            add(past.entry, "past", number, past.predicate)
        for feature in table.features[row.features : row.features_end]:
            for slot in range(row.instances):
                if feature.slot in (NONE, slot):
                    add(feature.running, "count", number, f"phase.{row.slots + slot}", 1, feature, row.slots + slot)
                    add(feature.stopping, "count", number, f"phase.{row.slots + slot}", 2, feature, row.slots + slot)
            if feature.slot == NONE:
                add(feature.waiting, "count", number, f"place.{number}", 1, feature, NONE)
                add(feature.clearing, "count", number, f"place.{number}", 2, feature, NONE)
    for number, row in enumerate(table.variables):
        add(row.value, "reading", number)
        add(row.rank, "rank", number, table.reals[row.cuts : row.cuts_end])
        for order in table.orders[row.orders : row.orders_end]:
            if ("pair", order.left, order.right) not in table.sources.get(order.entry, []):
                add(order.entry, "pair", order.left, order.right)
    for number, row in enumerate(table.stocks):
        add(row.entry, "level", number)
    for number, row in enumerate(table.entries):
        for total in table.sums[row.sums : row.sums_end]:
            add(total.entry, "part", number, total.factor)
    for entry, found in table.sources.items():
        kinds = {source[0] for source in found}
        if len(kinds) > 1 or (len(found) > 1 and kinds not in ({"count"}, {"part"})):
            raise Refused(f"entry {entry} is more than one thing")
    for source in (s for found in table.sources.values() for s in found if s[0] == "part"):
        if any(other[0] == "part" for other in table.sources.get(source[1], [])):
            raise Refused("a sum is part of a sum")
