"""The tables: the numbers that the checker on the robot reads.

Tables are *sections*, each a list of records of small integers, and a list of doubles. docs/runtime.md describes every
field, for readers of the bytes (`exover.ocrd.packing`) without this program.
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
"""Codes of reasons: which decisions for it imply that a request in conflict with the newcomer is active."""
BLOCK = 16
"""Requests in one block of a bit row."""


@dataclass(frozen=True, slots=True)
class Node:
    """`code >= 0`: go to `low` if entry `code` is at most `bound`, else to `high`.

    `code < 0`: do action `-code` for reason `bound`, then go to `low`; `high` is the target of the action: a request,
    or `-1 - slot` for one slot, numbered over all requests.
    """

    code: int
    bound: int
    low: int
    high: int


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of the state vector: initial value, rules to evaluate when it changes, sums of which it is a part."""

    initial: int
    rules: int
    rules_end: int
    sums: int
    sums_end: int


@dataclass(frozen=True, slots=True)
class RequestRow:
    """A request. `x .. x_end` are ranges in the section of that name; `decide` is the root of its decision; `slots` is
    the number of its first slot among all slots.

    `values`: the index of the first argument of its first slot among those of all slots and waiting places.
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
    """What a slot or waiting place adds to counters: if `predicate` agrees, the entry of its phase is increased by 1,
    or, with `weight`, by the value of that parameter; with `slot`, only that slot is counted.
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
    """An amount of a consumable, consumed or produced iff `predicate` agrees."""

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

    `raw`: the index where the value of a real is kept; `refresh`: in `lists`, the requests whose features read it;
    `orders`: pairs of posters to compare again when it changes.
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
    """A latch: its variable, the root of its condition, and in `lists` the requests whose report `ok` clears it."""

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
    """A rule that can come to be broken: the root of the diagram that restores it, and its reason."""

    root: int
    reason: int


@dataclass(frozen=True, slots=True)
class LaunchRow:
    """A launch rule: root of its condition, request, arguments (`lists`; of a real the index of a double), reason."""

    condition: int
    request: int
    args: int
    reason: int


@dataclass(frozen=True, slots=True)
class LimitRow:
    """Bounds: tests and actions of one walk, passes of one event, violations at the end of one event."""

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
    """A reason: one of NO_DENIALS, CLEARINGS, ALL_DENIALS."""

    denials: int


@dataclass(frozen=True, slots=True)
class InvariantRow:
    """A rule that only a launch could break, and that is in no bit row: the root of a diagram that raises a violation
    where it is broken.
    """

    root: int
    reason: int


@dataclass(frozen=True, slots=True)
class Tables:
    """The decoded tables. Indices count the records of a section: pairs (entry, factor) in `sums`, words in `lists`."""

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
        """Return the numbers of the requests in the bit row of a request."""
        row = self.requests[request]
        blocks = self.conflicts[row.conflicts : row.conflicts_end]
        return frozenset(BLOCK * each.block + bit for each in blocks for bit in range(BLOCK) if each.mask >> bit & 1)

    def request_of(self, slot: int) -> int:
        """Return the request of a slot, which is numbered over all requests."""
        return bisect_right(self.requests, slot, key=lambda row: row.slots) - 1

    def parts(self) -> dict[int, list[tuple[int, int]]]:
        """Return by sum its parts, each with its factor."""
        found: dict[int, list[tuple[int, int]]] = {}
        for part, row in enumerate(self.entries):
            for total, factor in self.sums[row.sums : row.sums_end]:
                found.setdefault(total, []).append((part, factor))
        return found

    def below(self, root: int) -> list[int]:
        """Return the nodes of the diagram with this root in increasing order, so that children follow their parents."""
        found: set[int] = set()
        stack = [root]
        while stack:
            number = stack.pop()
            if number >= 0 and number not in found:
                found.add(number)
                node = self.nodes[number]
                stack += [node.low] if node.code < 0 else [node.high, node.low]
        return sorted(found)

    def actions(self, root: int) -> set[int]:
        """Return the codes of the actions in the diagram with this root."""
        return {-self.nodes[number].code for number in self.below(root) if self.nodes[number].code < 0}

    def may_wait(self) -> tuple[bool, ...]:
        """Return for each request whether some decision lets it wait."""
        return tuple(not self.actions(row.decide).isdisjoint({WAIT, CLEAR, SETTLE}) for row in self.requests)

    def may_fall(self) -> tuple[bool, ...]:
        """Return for each request whether it can fall from clearing to waiting."""
        found = (self.actions(row.decide) for row in self.requests)
        return tuple(WAIT in actions and not actions.isdisjoint({CLEAR, SETTLE}) for actions in found)

    def tested(self, root: int) -> set[int]:
        """Return the entries that the nodes of the diagram with this root test."""
        return {self.nodes[number].code for number in self.below(root) if self.nodes[number].code >= 0}
