"""What can be read off tables without looking at states: what entries plainly count, and diagrams that are alike.

Most tables ask what the rules ask, in the same order; then no set of states is needed to see that they decide alike.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence

from exover.model.decision import Reason
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.ocrd import decision as do
from exover.ocrd import tables as t
from exover.ocrd.diagram import NO, Act, Manager, Test
from exover.ocrd.entries import initial
from exover.ocrd.tables import ALWAYS, NONE, Node, Tables
from exover.ocrd.vector import (
    Arg,
    ArgRank,
    Element,
    HasPast,
    InPlace,
    LastOutcome,
    Quantity,
    Rank,
    Slots,
    Stock,
    Value,
    Vocabulary,
)

CODES: dict[type, int] = {
    do.DoReject: t.REJECT,
    do.DoWait: t.WAIT,
    do.DoClear: t.CLEAR,
    do.DoSettle: t.SETTLE,
    do.DoKill: t.KILL,
    do.DoDismiss: t.DISMISS,
    do.DoLaunch: t.LAUNCH,
    do.DoViolation: t.VIOLATION,
    do.DoAgree: t.AGREE,
}


def plain_entries(model: Model, tables: Tables) -> dict[int, Element]:
    """Return by entry what it counts, for entries of which the records say that without a predicate of arguments.

    What several records count in one entry is its sum. Left out are also those that two records set, and those that
    start otherwise.
    """
    found: dict[int, list[Quantity | None]] = {}
    for entry, quantity in _said(model, tables):
        if entry != NONE:
            found.setdefault(entry, []).append(quantity)
    for said in found.values():
        if len(said) > 1 and not all(isinstance(quantity, Slots | InPlace) for quantity in said):
            said[:] = [None]
    parts: dict[int, list[tuple[int, Quantity | None]]] = {}
    for entry, row in enumerate(tables.entries):
        for total, factor in tables.sums[row.sums : row.sums_end]:
            parts.setdefault(total, []).extend((factor, quantity) for quantity in found.get(entry, [None]))
    start, vocabulary = Reference(model).start(), Vocabulary(model)
    plain: dict[int, Element] = {}
    for entry, row in enumerate(tables.entries):
        terms = parts.get(entry) or [(1, quantity) for quantity in found.get(entry, [None])]
        element = tuple((factor, quantity) for factor, quantity in terms if quantity is not None)
        whole = len(element) == len(terms) and not (entry in parts and entry in found)
        if whole and sum(factor * initial(vocabulary, quantity, start) for factor, quantity in element) == row.initial:
            plain[entry] = tuple(sorted(element, key=lambda term: repr(term[1]))) if len(element) > 1 else element
    return plain


def _said(model: Model, tables: Tables) -> Iterator[tuple[int, Quantity | None]]:
    """Yield what each record says of an entry; None if it is not plain."""
    for request, row in zip(model.requests, tables.requests, strict=True):
        name, params = request.name, (*request.params, *request.results)
        yield row.last, LastOutcome(name)
        for param, its in zip(params, tables.params[row.params : row.params_end], strict=True):
            yield its.value, Arg(name, param.name)
            yield its.rank, ArgRank(name, param.name)
        for past in tables.pasts[row.pasts : row.pasts_end]:
            yield past.entry, HasPast(name, None) if past.predicate == ALWAYS else None
        for order in tables.orders[row.orders : row.orders_end]:
            yield order.entry, None
        for feature in tables.features[row.features : row.features_end]:
            plain = feature.predicate == ALWAYS and feature.weight == NONE
            slot = None if feature.slot == NONE else feature.slot
            yield feature.running, Slots(name, slot, None, "running") if plain else None
            yield feature.stopping, Slots(name, slot, None, "stopping") if plain else None
            yield feature.waiting, InPlace(name, None, "waiting") if plain and slot is None else None
            yield feature.clearing, InPlace(name, None, "clearing") if plain and slot is None else None
    names = [*(variable.name for variable in model.variables), *(latch.name for latch in model.latches)]
    for name, variable in zip(names, tables.variables, strict=True):
        yield variable.value, Value(name)
        yield variable.rank, Rank(name)
        yield from ((order.entry, None) for order in tables.orders[variable.orders : variable.orders_end])
    stocks = [resource.name for resource in model.resources if resource.consumable]
    for name, stock in zip(stocks, tables.stocks, strict=True):
        yield stock.entry, Stock(name)


def alike(
    manager: Manager,
    diagram: int,
    nodes: Sequence[Node],
    root: int,
    entry: Callable[[int], int | None],
    same: Callable[[Act, Node], bool],
) -> bool:
    """Return whether a diagram of the rules and one of the tables are seen to do the same in every state.

    That is so if they ask the same in the same order. `entry`: the entry of the tables that is the
    element of this number; `same`: whether two actions are the same.
    """
    seen: set[tuple[int, int, int, int]] = set()
    stack = [(diagram, 0, -1, root)]
    while stack:
        pair = number, first, last, right = stack.pop()
        if pair in seen:
            continue
        seen.add(pair)
        mine, its = manager.node(number), None if right == NONE else nodes[right]
        if isinstance(mine, Test):
            inside = mine.cuts[first:last] if last >= 0 else mine.cuts  # what is still to be asked of this entry
            if its is None or its.code != entry(manager.entries[mine.level]) or its.bound not in inside:
                return False
            middle, last = first + inside.index(its.bound), first + len(inside)
            for start, end, child in ((first, middle, its.low), (middle + 1, last, its.high)):
                stack.append((mine.children[start], 0, -1, child) if start == end else (number, start, end, child))
        elif isinstance(mine, Act):
            if its is None or not same(mine, its):
                return False
            stack.append((mine.child, 0, -1, its.low))
        elif its is not None or number != NO:
            return False
    return True


def same_action(mine: Act, its: Node, tables: Tables, requests: Mapping[str, int], reasons: tuple[Reason, ...]) -> bool:
    """Return whether two action nodes say the same."""
    action = mine.action
    if CODES[type(action)] != -its.code:
        return False
    reason = getattr(action, "reason", None)
    if reason is not None and reasons[its.bound] != reason:
        return False
    match action:
        case do.DoKill((name, slot)):
            request = requests[name]
            return its.high == (request if slot is None else -1 - (tables.requests[request].slots + slot))
        case do.DoDismiss(name):
            return its.high == requests[name]
        case _:
            return True
