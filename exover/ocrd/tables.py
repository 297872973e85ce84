"""The tables: what the robot's checker reads, as numbers.

A table is a list of *sections*, each a list of records of small integers, and a list of doubles. docs/runtime.md
describes every field for whoever reads the bytes (`exover.ocrd.packing`) without this program.
"""

from bisect import bisect_right

from exover.dataclass import dataclass

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

    def request_of(self, slot: int) -> int:
        """Return the number of the request that a slot is of; slots are counted over all requests."""
        return bisect_right(self.requests, slot, key=lambda row: row.slots) - 1

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
