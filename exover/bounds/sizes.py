"""What the emitted checker takes: bytes of tables, memory and stack, and worst-case bounds of one event.

The layout of the memory is that of `lay_out` and `place` in exover.c; the C runtime refuses a memory that is smaller.
"""

from dataclasses import fields
from itertools import accumulate

from exover.bounds.events import EventBounds, bounds
from exover.dataclass import dataclass
from exover.ocrd.packing import SECTIONS, checks, counts, is_checked, pack, width, words
from exover.ocrd.tables import ALWAYS, BLOCK, CLEAR, KILL, NONE, SETTLE, WAIT, Tables

STACK_TARGET = "arm-none-eabi-gcc 12 -Os -mcpu=cortex-m4"
STACK, STACK_PLAIN, PLAIN_USES = 1320, 528, 0x1CDC027
"""Most bytes of stack as `make targets` measures them: of any spec; of one slot each and `uses` within PLAIN_USES."""
SCRUB = 4
"""Bytes of the tables that each step adds to a running checksum: `EXOVER_SCRUB` of exover.h."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """The figures that are emitted as constants."""

    rom: int
    """Bytes of the tables."""
    ram: int
    """Bytes of the memory that `exover_load` demands."""
    tests: int
    """The most tests `v[i] <= k` of an event."""
    actions: int
    """The most answers of an event."""
    passes: int
    """The most passes of steps 3 to 5 of an event."""
    stack: int
    """The most bytes of stack of a call on the reference target (`STACK_TARGET`)."""


def sizes(tables: Tables, most: EventBounds | None = None) -> Sizes:
    """Return all figures of the tables; `most`: tighter bounds of events, if known, than those of the tables alone."""
    worst = (most or bounds(tables)).worst
    return Sizes(len(pack(tables)), ram_bytes(tables), worst.tests, worst.answers, worst.passes, stack_bytes(tables))


def slot_count(tables: Tables) -> int:
    """Return the number of slots of all requests."""
    return sum(request.instances for request in tables.requests)


def word_bytes(tables: Tables) -> int:
    """Return the width of the numbers of the tables in bytes: `EXOVER_WIDTH`."""
    return width(words(tables))


def state_bytes(tables: Tables) -> int:
    """Return the width of the entries of the state vector in bytes: `EXOVER_STATE`.

    4 iff no entry can leave 32 bits: every part of a sum fits a word, so a sum is at most (sum of |factors|) * a word.
    """
    factors: dict[int, int] = {}
    for entry, factor in tables.sums:
        factors[entry] = factors.get(entry, 0) + abs(factor)
    greatest = max(factors.values(), default=1) << (8 * word_bytes(tables) - 1)
    return 4 if greatest < 1 << 31 else 8


def actions_per_event(tables: Tables) -> int:
    """Return the answers of one event for which memory is reserved: an upper bound that needs no diagram.

    A slot is launched and killed at most once each; what waits is rejected at most once; the ask of the event and that
    of each required launch give two more at most, and take a waiting place that may be emptied again.
    """
    slots, launches = slot_count(tables), len(tables.launches)
    return 2 * slots + len(tables.requests) + 3 * launches + tables.limits[0].violations + 4


def uses(tables: Tables) -> int:
    """Return a bit for every section that has records, in the order of the bytes; then for doubles, for check words,
    for decisions by which something waits, for those by which something is killed, for last outcomes that are read.
    """
    actions = {-node.code for node in tables.nodes if node.code < 0}
    done = bool(actions & {WAIT, CLEAR, SETTLE}), KILL in actions, any(row.last != NONE for row in tables.requests)
    there = [*counts(tables), len(tables.reals), is_checked(tables), *done]
    return sum(1 << number for number, count in enumerate(there) if count)


def plain(tables: Tables) -> bool:
    """Return whether slots count alike, whatever their arguments."""
    return all((row.predicate, row.slot, row.weight) == (ALWAYS, NONE, NONE) for row in tables.features)


def stack_bytes(tables: Tables) -> int:
    """Return the most bytes of stack of a call on the reference target: fewer for mutexes of requests of one slot."""
    single = slot_count(tables) == len(tables.requests)
    return STACK_PLAIN if single and plain(tables) and not uses(tables) & ~PLAIN_USES else STACK


def shape(tables: Tables) -> tuple[int, ...]:
    """Return the numbers of `enum exover_shape` of exover.h but the checksum: of the words, then of the memory."""
    sizes = [len(fields(kind)) for _, kind in SECTIONS] + [2, 1]
    *starts, end = accumulate((size * count for size, count in zip(sizes, counts(tables), strict=True)), initial=0)
    checked = [end + before if is_checked(tables) else 0 for before in accumulate(counts(tables), initial=0)]
    requests, launches, slots = len(tables.requests), len(tables.launches), slot_count(tables)
    params = [request.results - request.params for request in tables.requests]
    kept = sum(own * (r.instances + 1) for own, r in zip(params, tables.requests, strict=True))
    raws = 1 + max((variable.raw for variable in tables.variables), default=NONE)
    rules = _bits(len(tables.rules), 32)
    regions = (
        len(tables.entries),
        slots + requests,
        requests,
        _bits(requests, BLOCK),
        rules,
        rules,
        _bits(requests, 32),
        requests if launches else 0,
        launches,
        _bits(launches + requests, 32),
    )
    scratch = max(params, default=0) if launches else 0
    limits = (actions_per_event(tables), tables.limits[0].actions)
    cells = accumulate(regions, initial=0)
    words = (*starts, end, *counts(tables), len(tables.reals), *checked, end + len(checks(tables)))
    return (*words, *cells, kept, kept + raws, scratch, *limits)


def ram_bytes(tables: Tables) -> int:
    """Return the bytes of memory that `exover_load` demands of a runtime that is configured for these tables."""
    fixed, by_state = memory_bytes(tables)
    return fixed + by_state * state_bytes(tables)


def memory_bytes(tables: Tables) -> tuple[int, int]:
    """Return (a, b) such that `exover_load` demands a + b * EXOVER_STATE bytes: its arrays, each rounded up to 8."""
    cells, _, values, scratch, answers, actions = shape(tables)[-6:]
    word = word_bytes(tables)
    arrays = [
        (2 * values + scratch, 8),
        (answers + 1, 6 * word),  # one more for a fault
        (actions, word),
    ]
    return sum((count * size + 7) // 8 * 8 for count, size in arrays), 2 * cells


def record_bytes(tables: Tables) -> int:
    """Return the bytes of the record of a state, that `exover_export` writes: a head of 56, and 8 for each number."""
    held = [(row.instances + 1) * (1 + row.results - row.params) for row in tables.requests]
    pasts = [1 + row.pasts_end - row.pasts for row in tables.requests]
    launches = len(tables.launches)
    origins = len(tables.requests) + launches if launches else 0
    return 56 + 8 * (len(tables.variables) + len(tables.stocks) + sum(held) + sum(pasts) + origins)


def scrub_steps(tables: Tables) -> int:
    """Return the number of steps within which a changed bit of the tables or of the state is found.

    A whole pass takes one step more, which compares the checksum; a bit may change just after it was read, so twice.
    """
    *_, cells, _, values, _, _, _ = shape(tables)
    return 2 * max(len(pack(tables)) // SCRUB + 1, cells + values + 1) + 1


def _bits(count: int, bits: int) -> int:
    return -(-count // bits)
