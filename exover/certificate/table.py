"""The bytes of a table, decoded for the checker alone (docs/runtime.md, "The bytes")."""

import hashlib
import math
import struct
import zlib
from collections import namedtuple
from fractions import Fraction
from itertools import islice
from types import SimpleNamespace
from typing import Any

NONE, ALWAYS = -1, -2
REJECT, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE = range(1, 10)
REAL, UNCHECKED = 3, 1
HEADER = struct.Struct("<4sHHIII32s")
LAYOUT = {
    "nodes": "code bound low high",
    "entries": "initial rules:lists rules_end sums:sums sums_end",
    "requests": "decide slots instances values interrupts_self statuses params:params results:params params_end "
    "orders:orders orders_end features:features features_end pasts:pasts pasts_end consumes:amounts produces:amounts "
    "produces_end on_launch:effects on_ok:effects on_failed:effects on_interrupted:effects effects_end last "
    "conflicts:conflicts conflicts_end",
    "params": "type low high cuts:reals cuts_end value rank",
    "orders": "left right entry",
    "features": "predicate slot weight running stopping waiting clearing",
    "pasts": "predicate entry",
    "amounts": "stock amount predicate",
    "effects": "kind target value",
    "variables": "role type low high initial has_fallback fallback cuts:reals cuts_end value rank raw refresh:lists "
    "refresh_end orders:orders orders_end",
    "latches": "variable condition resets:lists resets_end",
    "stocks": "capacity initial entry",
    "rules": "root reason",
    "launches": "condition request args reason",
    "limits": "tests actions passes violations",
    "conflicts": "block mask",
    "reasons": "denials",
    "invariants": "root reason",
    "sums": "entry factor",
    "lists": "word",
}
"""The sections and the fields of their records; `field:section`: a range of records, the next field is its end."""
ROWS: dict[str, Any] = {
    name: namedtuple(name, [field.split(":")[0] for field in fields.split()]) for name, fields in LAYOUT.items()
}
RANGES = dict(field.split(":") for fields in LAYOUT.values() for field in fields.split() if ":" in field)


class Refused(Exception):
    """A table or a certificate is refused; the text tells the user why."""


class Rows(list[Any]):
    """Records by number; a number or a range that is not within them raises `Refused`, as does a negative one."""

    def __getitem__(self, at: Any) -> Any:
        """Return a record, or those of a range."""
        first, end = (at.start, at.stop) if isinstance(at, slice) else (at, at + 1)
        if not 0 <= first <= end <= len(self):
            raise Refused("a record of the table points nowhere")
        return super().__getitem__(at)


class Table(SimpleNamespace):
    """The records, an attribute for each section, with the ranges of records in place of the fields that name them.

    `sha256`: of the bytes without the flag `UNCHECKED`; `spec`: the sha256 of the spec; `doubles`: as in the bytes;
    `reals`: these as fractions where finite; `words`: as in the bytes; `owner`: the request of each slot; `watched`:
    for each condition on arguments the fact, the request and the condition.
    """

    watched: Any = ()

    def slots(self, request: int) -> range:
        """Return the numbers of a request's slots, which are counted through all requests."""
        row = self.requests[request]
        return range(row.slots, row.slots + row.instances)


def decode(data: bytes) -> Table:
    """Return the table in these bytes; raises `Refused` if they are none, or its records do not fit together."""
    at = HEADER.size + 4 * len(LAYOUT) + 4
    if len(data) < at:
        raise Refused("the table is too short")
    magic, version, width, flags, _, real_count, spec = HEADER.unpack_from(data)
    if magic != b"EXOV" or version != 3 or width not in (2, 4, 8):
        raise Refused("the file is no table of format 3")
    if _sealed(data, flags) != data:
        raise Refused("the checksum of the table is wrong")
    *counts, checks = struct.unpack_from(f"<{len(LAYOUT) + 1}I", data, HEADER.size)
    total = sum(count * len(row._fields) for count, row in zip(counts, ROWS.values(), strict=True))
    if len(data) != at + 8 * real_count + width * (total + checks):
        raise Refused("the table has not the length that it says")
    doubles = struct.unpack_from(f"<{real_count}d", data, at)
    words = struct.unpack_from(f"<{total}{ {2: 'h', 4: 'i', 8: 'q'}[width] }", data, at + 8 * real_count)
    rest, sections = iter(words), {"reals": Rows(Fraction(x) if math.isfinite(x) else x for x in doubles)}
    for (name, row), count in zip(ROWS.items(), counts, strict=True):
        columns = [islice(rest, count * len(row._fields))] * len(row._fields)
        sections[name] = Rows(map(row._make, zip(*columns, strict=True)))
    for name in sorted(ROWS, key="requests".__eq__):  # last: the records in their ranges have ranges themselves
        sections[name] = Rows(_whole(row, sections) for row in sections[name])
    owner = Rows(number for number, row in enumerate(sections["requests"]) for _ in range(row.instances))
    digest = hashlib.sha256(_sealed(data, flags & ~UNCHECKED)).hexdigest()
    table = Table(spec=spec.hex(), sha256=digest, doubles=doubles, words=words, owner=owner, **sections)
    slots = [slot for number in range(len(table.requests)) for slot in table.slots(number)]
    values = [at for r in table.requests for at in range(r.values, r.values + len(r.params) * (r.instances + 1))]
    if slots != list(range(len(slots))) or values != list(range(len(values))):
        raise Refused("the slots of the requests, or what they hold, do not follow each other")
    return table


def _sealed(data: bytes, flags: int) -> bytes:
    """Return the bytes with these flags and the checksum that belongs to them."""
    head = data[:8] + struct.pack("<I", flags)
    return head + struct.pack("<I", zlib.crc32(data[16:], zlib.crc32(head + bytes(4)))) + data[16:]


def _whole(row: Any, sections: dict[str, Rows]) -> Any:
    """Return a record with the records of its ranges in place of the ranges, and reals in place of their numbers."""
    fields = zip(row._fields, row, row[1:], strict=False)
    found = {field: sections[RANGES[field]][first:end] for field, first, end in fields if field in RANGES}
    if getattr(row, "type", None) == REAL:
        known = {field: at for field, at in row._asdict().items() if field in ("low", "high", "initial", "fallback")}
        found |= {field: sections["reals"][at] for field, at in known.items()}
    return row._replace(**found)
