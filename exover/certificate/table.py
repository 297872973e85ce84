"""The bytes of a table, decoded for the checker alone (docs/runtime.md, "The bytes")."""

import hashlib
import math
import struct
import zlib
from collections import namedtuple
from fractions import Fraction
from types import SimpleNamespace
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


class Table(SimpleNamespace):
    """The records, an attribute for each section; `sha256`, `spec`, `doubles`, and `reals`: these, exact where finite.

    `sources`: by entry of the vector what it is the sum of: a `side` (a name of the state, or a request and the number
    of an argument), the `rank` of one, the `order` of two, a `past`, a `count` of slots and places, `part`s.
    """

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

    def tested(self, root: int) -> list[int]:
        """Return the entries that the diagram below a root tests."""
        seen, stack = {NONE, ALWAYS}, [root]
        while stack:
            number = stack.pop()
            if number not in seen:
                seen.add(number)
                node = self.nodes[number]
                stack += [node.low] if node.code < 0 else [node.low, node.high]
        return sorted({self.nodes[number].code for number in seen if number >= 0 and self.nodes[number].code >= 0})


def decode(data: bytes) -> Table:
    """Return the table; `Refused` if the bytes are none, or its records do not fit together."""
    at = HEADER.size + 4 * len(LAYOUT)
    if len(data) < at:
        raise Refused("the table is too short")
    magic, version, width, _, crc, real_count, spec = HEADER.unpack_from(data)
    if magic != b"EXOV" or version != 2 or width not in (2, 4, 8):
        raise Refused("the file is no table of format 2")
    if zlib.crc32(data[16:], zlib.crc32(data[:12] + bytes(4))) != crc:
        raise Refused("the checksum of the table is wrong")
    counts = struct.unpack_from(f"<{len(LAYOUT)}I", data, HEADER.size)
    at += -at % 8
    total = sum(count * len(row._fields) for count, row in zip(counts, ROWS.values(), strict=True))
    if len(data) != at + 8 * real_count + width * total:
        raise Refused("the table has not the length that it says")
    doubles = struct.unpack_from(f"<{real_count}d", data, at)
    words = iter(struct.unpack_from(f"<{total}{ {2: 'h', 4: 'i', 8: 'q'}[width] }", data, at + 8 * real_count))
    sections = {}
    for (name, row), count in zip(ROWS.items(), counts, strict=True):
        flat = [next(words) for _ in range(count * len(row._fields))]
        sections[name] = [*map(row, *(flat[k :: len(row._fields)] for k in range(len(row._fields))))]
    reals = [Fraction(x) if math.isfinite(x) else x for x in doubles]
    table = Table(sha256=hashlib.sha256(data).hexdigest(), spec=spec.hex(), doubles=doubles, reals=reals, **sections)
    try:
        _well_formed(table)
        table.sources = _sources(table)
    except (IndexError, KeyError, ValueError) as error:
        raise Refused("the records of the table do not fit together") from error
    return table


def _well_formed(table: Table) -> None:
    for name, row in ROWS.items():
        rows = getattr(table, name)
        for field, column in zip(row._fields, zip(*rows, strict=True), strict=False):
            least = ALWAYS if field == "predicate" else NONE
            if field not in ANY and name != "effects" and min(column) < least:
                raise Refused(f"`{field}` of a record of {name} points nowhere")
    for number, node in enumerate(table.nodes):
        children = (node.low,) if node.code < 0 else (node.low, node.high)
        if not all(child == NONE or number < child < len(table.nodes) for child in children):
            raise Refused(f"a child of node {number} does not come after it")
        if not -AGREE <= node.code < len(table.entries):
            raise Refused(f"node {number} is no test and no action")
    if len(table.limits) != 1 or table.limits[0].passes < 1:
        raise Refused("the table has no limits")
    slots = [slot for request in range(len(table.requests)) for slot in table.slots(request)]
    if slots != list(range(len(slots))):
        raise Refused("the slots of the requests do not follow each other")


def _sources(table: Table) -> dict[int, list[tuple[Any, ...]]]:
    """Return of every entry what it is. All its sources are set at once, or all are counted."""
    found: dict[int, list[tuple[Any, ...]]] = {}

    def add(entry: int, *source: Any) -> None:
        if entry >= len(table.entries):
            raise Refused(f"there is no entry {entry}")
        if entry != NONE and (source[0] in ("count", "part") or source not in found.get(entry, ())):
            found.setdefault(entry, []).append(source)

    def read(row: Any, side: Any) -> None:
        add(row.value, "side", side)
        add(row.rank, "rank", side, tuple(table.reals[row.cuts : row.cuts_end]))

    for r, row in enumerate(table.requests):
        add(row.last, "side", f"last.{r}")
        for k, param in enumerate(table.params[row.params : row.params_end]):
            read(param, (r, k))
        for order in table.orders[row.orders : row.orders_end]:
            add(order.entry, "order", *((r, k) if k >= 0 else f"reading.{-1 - k}" for k in order[:2]))
        for past in table.pasts[row.pasts : row.pasts_end]:
            add(past.entry, "past", r, past.predicate)
        for feature in table.features[row.features : row.features_end]:
            for slot in table.slots(r):
                if feature.slot in (NONE, slot - row.slots):
                    add(feature.running, "count", r, f"phase.{slot}", 1, f"arg.{slot}", feature)
                    add(feature.stopping, "count", r, f"phase.{slot}", 2, f"arg.{slot}", feature)
            if feature.slot == NONE:
                add(feature.waiting, "count", r, f"place.{r}", 1, f"held.{r}", feature)
                add(feature.clearing, "count", r, f"place.{r}", 2, f"held.{r}", feature)
    for v, row in enumerate(table.variables):
        read(row, f"reading.{v}")
        for order in table.orders[row.orders : row.orders_end]:
            add(order.entry, "order", *(f"reading.{-1 - k}" for k in order[:2]))
    for k, row in enumerate(table.stocks):
        add(row.entry, "side", f"level.{k}")
    for number, row in enumerate(table.entries):
        for total in table.sums[row.sums : row.sums_end]:
            add(total.entry, "part", number, total.factor)
    for entry, sources in found.items():
        kinds = {source[0] for source in sources}
        if len(kinds) > 1 or (len(sources) > 1 and kinds not in ({"count"}, {"part"})):
            raise Refused(f"entry {entry} is more than one thing")
        if kinds == {"part"} and any(other[0] == "part" for source in sources for other in found.get(source[1], ())):
            raise Refused("a sum is part of a sum")
    return found
