"""The packed tables: what the robot's checker reads, as numbers, and their bytes.

A table is a list of *sections*, each a list of records of small integers, and a list of doubles. All numbers have one
width, the least of 2, 4 and 8 bytes that holds them. The bytes are little-endian: header, doubles, words, and a check
word for each record and double, unless the bit rows alone keep everything that is unsafe from being launched.
docs/runtime.md describes every field for whoever reads the bytes without this program.
"""

import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from functools import reduce
from itertools import chain
from operator import attrgetter, xor
from typing import Any

MAGIC = b"EXOV"
VERSION = 3
UNCHECKED = 1
"""Flag: the table was emitted although the checks do not hold."""
NONE = -1
"""No entry, no slot, no index; as a node, the end of the path."""
ALWAYS = -2
"""As a predicate: true of all arguments."""

REJECT, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE = range(1, 10)
"""Codes of actions."""
BOOL, INT, ENUM, REAL = range(4)
"""Codes of types."""
POSTER, STATE, LATCH = range(3)
"""Codes of variables."""
SET, FORGET = range(2)
"""Codes of effects."""
NO_DENIALS, CLEARINGS, ALL_DENIALS = range(3)
"""Of a reason: which decisions for it show that a conflict of the newcomer is active."""
BLOCK = 16
"""Requests in one block of a bit row."""


@dataclass(frozen=True, slots=True)
class Node:
    """`code >= 0`: go to `low` if entry `code` is at most `bound`, else to `high`.

    `code < 0`: do action `-code` for reason `bound`, then go to `low`; `high` is the action's target: a request, or
    `-1 - slot` for one slot of all.
    """

    code: int
    bound: int
    low: int
    high: int


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of the state vector: initial value, rules to look at when it changes, sums of which it is a part."""

    initial: int
    rules: int
    rules_end: int
    sums: int
    sums_end: int


@dataclass(frozen=True, slots=True)
class RequestRow:
    """A request. Ranges `x .. x_end` are of the section of that name; `decide` is a node; `slots` the first of all.

    `values`: where the arguments of its first slot stand among those of all slots and waiting places.
    """

    decide: int
    slots: int
    instances: int
    values: int
    interrupts_self: int
    statuses: int
    params: int
    results: int
    params_end: int
    orders: int
    orders_end: int
    features: int
    features_end: int
    pasts: int
    pasts_end: int
    consumes: int
    produces: int
    produces_end: int
    on_launch: int
    on_ok: int
    on_failed: int
    on_interrupted: int
    effects_end: int
    last: int
    conflicts: int
    conflicts_end: int


@dataclass(frozen=True, slots=True)
class ParamRow:
    """A parameter or result: type, range (of a real: indices of doubles), its constants in `reals`, its entries."""

    type: int
    low: int
    high: int
    cuts: int
    cuts_end: int
    value: int
    rank: int


@dataclass(frozen=True, slots=True)
class OrderRow:
    """Two reals to compare: parameter `k` of the request, or variable `v` as `-1 - v`; 0 less, 1 equal, 2 greater."""

    left: int
    right: int
    entry: int


@dataclass(frozen=True, slots=True)
class FeatureRow:
    """What a slot or waiting place counts for: if `predicate` agrees, the entry of its phase gets 1 more, or with
    `weight` the value of that parameter; with `slot`, only that slot counts.
    """

    predicate: int
    slot: int
    weight: int
    running: int
    stopping: int
    waiting: int
    clearing: int


@dataclass(frozen=True, slots=True)
class PastRow:
    """An entry that is 1 iff the past satisfies `predicate`."""

    predicate: int
    entry: int


@dataclass(frozen=True, slots=True)
class AmountRow:
    """An amount of a consumable, taken or given if `predicate` agrees."""

    stock: int
    amount: int
    predicate: int


@dataclass(frozen=True, slots=True)
class EffectRow:
    """Set variable `target` to `value`, or forget the past of request `target`."""

    kind: int
    target: int
    value: int


@dataclass(frozen=True, slots=True)
class VariableRow:
    """A poster, state or latch; for reals `low high initial fallback` are indices of doubles.

    `raw`: where the value of a real is kept; `refresh`: requests in `lists` whose features read it; `orders`: pairs of
    posters to compare anew.
    """

    role: int
    type: int
    low: int
    high: int
    initial: int
    has_fallback: int
    fallback: int
    cuts: int
    cuts_end: int
    value: int
    rank: int
    raw: int
    refresh: int
    refresh_end: int
    orders: int
    orders_end: int


@dataclass(frozen=True, slots=True)
class LatchRow:
    """A latch: its variable, its condition, and in `lists` the requests whose report ok clears it."""

    variable: int
    condition: int
    resets: int
    resets_end: int


@dataclass(frozen=True, slots=True)
class StockRow:
    """A consumable resource."""

    capacity: int
    initial: int
    entry: int


@dataclass(frozen=True, slots=True)
class RuleRow:
    """A rule that can come to be broken: the diagram that restores it, and its reason."""

    root: int
    reason: int


@dataclass(frozen=True, slots=True)
class LaunchRow:
    """A required launch: when, of what, with which arguments (`lists`; of a real the index of a double)."""

    condition: int
    request: int
    args: int
    reason: int


@dataclass(frozen=True, slots=True)
class LimitRow:
    """Bounds: tests and actions of one walk, passes of steps 3 to 5 of one event, violations raised at its end."""

    tests: int
    actions: int
    passes: int
    violations: int


@dataclass(frozen=True, slots=True)
class ConflictRow:
    """A block of a bit row: bit i of `mask`, in two's complement, is request `BLOCK * block + i`."""

    block: int
    mask: int


@dataclass(frozen=True, slots=True)
class ReasonRow:
    """A reason: which decisions for it show that a conflict of the newcomer is active."""

    denials: int


@dataclass(frozen=True, slots=True)
class InvariantRow:
    """A rule that only a launch could break, and that is in no bit row: the diagram that says so where it is broken."""

    root: int
    reason: int


@dataclass(frozen=True, slots=True)
class Tables:
    """The decoded tables. `lists` and `sums` (entry, factor) are flat; indices count records, in `lists` words."""

    digest: bytes
    flags: int
    nodes: tuple[Node, ...]
    entries: tuple[Entry, ...]
    requests: tuple[RequestRow, ...]
    params: tuple[ParamRow, ...]
    orders: tuple[OrderRow, ...]
    features: tuple[FeatureRow, ...]
    pasts: tuple[PastRow, ...]
    amounts: tuple[AmountRow, ...]
    effects: tuple[EffectRow, ...]
    variables: tuple[VariableRow, ...]
    latches: tuple[LatchRow, ...]
    stocks: tuple[StockRow, ...]
    rules: tuple[RuleRow, ...]
    launches: tuple[LaunchRow, ...]
    limits: tuple[LimitRow, ...]
    conflicts: tuple[ConflictRow, ...]
    reasons: tuple[ReasonRow, ...]
    invariants: tuple[InvariantRow, ...]
    sums: tuple[tuple[int, int], ...]
    lists: tuple[int, ...]
    reals: tuple[float, ...]

    def conflicting(self, request: int) -> frozenset[int]:
        """Return the requests in the bit row of a request, by number."""
        row = self.requests[request]
        blocks = self.conflicts[row.conflicts : row.conflicts_end]
        return frozenset(BLOCK * each.block + bit for each in blocks for bit in range(BLOCK) if each.mask >> bit & 1)

    def below(self, root: int) -> list[int]:
        """Return the nodes of the diagram with this root, in increasing order: children after their parents."""
        found: set[int] = set()
        stack = [root]
        while stack:
            number = stack.pop()
            if number >= 0 and number not in found:
                found.add(number)
                node = self.nodes[number]
                stack += [node.low] if node.code < 0 else [node.high, node.low]
        return sorted(found)


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
"""The sections of records, in the order of the bytes; `sums` (two words each) and `lists` (one) follow."""

HEADER = struct.Struct("<4sHHIII32s")
"""magic, version, width, flags, CRC-32 of all bytes (this field as 0), count of doubles, sha256 of the spec."""
COUNTS = len(SECTIONS) + 2
START = HEADER.size + 4 * (COUNTS + 1)
"""Where the doubles begin: behind the numbers of records and that of check words."""
CODES = {2: "h", 4: "i", 8: "q"}
"""The letters of `struct` by width."""
COVERED = ("nodes", "entries", "requests", "features", "limits", "conflicts", "reasons")
"""Sections of specs that say nothing but which requests exclude each other."""


class DamagedTable(ValueError):
    """The bytes are no table, or not the table that was written."""


def row(record: Any) -> tuple[int, ...]:
    """Return the numbers of one record in the order of its fields."""
    return tuple([getattr(record, name) for name in record.__slots__])


def words(tables: Tables) -> list[int]:
    """Return all integers of the records in the order of the bytes."""
    return list(chain.from_iterable(chain.from_iterable(_rows(tables))))


def _rows(tables: Tables) -> Iterator[Iterable[tuple[int, ...]]]:
    """Yield the numbers of the records, section by section."""
    for name, kind in SECTIONS:
        yield zip(*(map(attrgetter(each.name), getattr(tables, name)) for each in fields(kind)), strict=True)
    yield tables.sums
    yield ((word,) for word in tables.lists)


def is_checked(tables: Tables) -> bool:
    """Return whether records have check words: unless each has one slot, none has anything but conflicts, and whatever
    is denied is denied for these. Then no diagram can launch against the bit rows.
    """
    others = (name for name, _ in SECTIONS if name not in COVERED)
    return bool(
        any(getattr(tables, name) for name in others)
        or tables.reals
        or any(request.instances != 1 for request in tables.requests)
        or any(reason.denials == NO_DENIALS for reason in tables.reasons)
    )


def checks(tables: Tables) -> list[int]:
    """Return the check words, of each record and then of each double: the complement of all its words, added without
    carry; none where the bit rows do as well.
    """
    if not is_checked(tables):
        return []
    size = width(words(tables))
    doubles = (struct.unpack(f"<{8 // size}{CODES[size]}", struct.pack("<d", real)) for real in tables.reals)
    return [~reduce(xor, record, 0) for record in chain(chain.from_iterable(_rows(tables)), doubles)]


def counts(tables: Tables) -> list[int]:
    """Return the number of records of every section."""
    return [*(len(getattr(tables, name)) for name, _ in SECTIONS), len(tables.sums), len(tables.lists)]


def width(numbers: list[int]) -> int:
    """Return the least of 2, 4, 8 bytes that holds every number; `OverflowError` if none does."""
    low, high = min(numbers, default=0), max(numbers, default=0)
    for size in (2, 4, 8):
        edge = 1 << (8 * size - 1)
        if -edge <= low and high < edge:
            return size
    raise OverflowError("a number of the tables does not fit 64 bits")


def pack(tables: Tables) -> bytes:
    """Return the bytes of the tables: header, counts, doubles, words, check words; the same tables
    give the same bytes."""
    numbers, checking = words(tables), checks(tables)
    size = width(numbers)
    body = struct.pack(f"<{COUNTS + 1}I", *counts(tables), len(checking))
    body += struct.pack(f"<{len(tables.reals)}d", *tables.reals)
    body += struct.pack(f"<{len(numbers) + len(checking)}{CODES[size]}", *numbers, *checking)

    def head(crc: int) -> bytes:
        return HEADER.pack(MAGIC, VERSION, size, tables.flags, crc, len(tables.reals), tables.digest)

    return head(zlib.crc32(head(0) + body)) + body


def decode(data: bytes) -> Tables:
    """Return the tables that these bytes pack; `DamagedTable` if they pack none."""
    if len(data) < START:
        raise DamagedTable("too short for a table")
    magic, version, size, flags, crc, real_count, digest = HEADER.unpack_from(data)
    if magic != MAGIC or version != VERSION or size not in (2, 4, 8):
        raise DamagedTable("no table of this format")
    if zlib.crc32(data[:12] + bytes(4) + data[16:]) != crc:
        raise DamagedTable("the checksum is wrong")
    *lengths, checking = struct.unpack_from(f"<{COUNTS + 1}I", data, HEADER.size)
    sizes = [len(fields(kind)) for _, kind in SECTIONS] + [2, 1]
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
