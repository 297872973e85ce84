"""Entry equivalence: by the records of the tables, entries of the state vector count the elements they stand for.

An entry is the sum of what its records say of it, or of its parts. Each record says one quantity, of a counter with the
predicate of the arguments that it counts; so an entry is what it is taken for if record by record the quantities are
the same, and the predicates are true of the same arguments.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Literal

from exover.dataclass import dataclass
from exover.model.expression import Cond, Param, Reading
from exover.model.index import ModelIndex
from exover.model.model import Model, Request
from exover.model.semantics import Reference
from exover.ocrd import tables as t
from exover.ocrd.compile import DecodedTables
from exover.ocrd.entries import initial
from exover.ocrd.tables import ALWAYS, NONE, OrderRow, Tables
from exover.ocrd.vector import (
    Arg,
    ArgRank,
    Element,
    HasPast,
    InPlace,
    LastOutcome,
    Order,
    PlaceValue,
    Quantity,
    Rank,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
    Vocabulary,
)

Judged = Literal["same", "other", "open"]
"""Whether an entry is what it is taken for, or something else, or that is not seen."""


@dataclass(frozen=True, slots=True)
class EntryRecord:
    """What one record says of an entry: a quantity, of a request's counter without its condition, and the predicate."""

    quantity: Quantity
    request: int = NONE
    predicate: int = ALWAYS


@dataclass(frozen=True)
class Counting:
    """What the entries of the tables count by their records, beside what they are taken for.

    `alike`: whether a predicate is true of the arguments of a request of which a condition is (see `Records`).
    """

    compiled: DecodedTables
    alike: Callable[[int, int, Cond | None, bool], bool]

    def wrong(self) -> Iterator[str]:
        """Yield the entries that count something else in some state, or start as something else."""
        tables, entries = self.compiled.tables, self.compiled.entries
        if len(tables.entries) != len(entries) or any(not 0 <= entry < len(entries) for entry in self.said):
            yield "records of entries that there are not"
            return
        start = Reference(self.compiled.model).start()
        for entry, element in enumerate(entries):
            if self._judged[entry] == "other":
                yield f"entry {entry} of the state vector"
            first = sum(factor * initial(self._vocabulary, quantity, start) for factor, quantity in element)
            if first != tables.entries[entry].initial:
                yield f"the initial value of entry {entry}"

    def open(self) -> Iterator[str]:
        """Yield the entries of which the records do not say plainly what they count."""
        yield from (f"entry {entry} of the state vector" for entry, said in enumerate(self._judged) if said == "open")

    @cached_property
    def _vocabulary(self) -> Vocabulary:
        return Vocabulary(self.compiled.model)

    @cached_property
    def said(self) -> dict[int, list[EntryRecord]]:
        """By entry what its records say."""
        return records_by_entry(self.compiled.model, self.compiled.tables)

    @cached_property
    def parts(self) -> dict[int, list[tuple[int, int]]]:
        """The parts of each sum with their factors."""
        return self.compiled.tables.parts()

    @cached_property
    def _judged(self) -> list[Judged]:
        return [self._judge(entry, element) for entry, element in enumerate(self.compiled.entries)]

    def _judge(self, entry: int, element: Element) -> Judged:
        """Return whether the records say, one by one, that an entry is the sum that an element is.

        If each counts something else than the others, one that counts other arguments than it should is enough for a
        state in which the entry is another number.
        """
        parts = self.parts.get(entry)
        if parts is None:
            found, rows = [(1, each) for each in self.said.get(entry, [])], [entry]
        else:
            found = [(factor, each) for part, factor in parts for each in self.said.get(part, [])]
            rows = [part for part, _ in parts]
        if (parts is not None and entry in self.said) or len(found) > len(element):
            return "other"
        if len(found) < len(element) or not all(map(self._summed, rows)) or (parts and set(rows) & self.parts.keys()):
            return "open"
        left: dict[tuple[int, Quantity], list[EntryRecord]] = {}
        for factor, said in found:
            left.setdefault((factor, said.quantity), []).append(said)
        if all(self._taken(left, *term) for term in element):
            return "same"
        apart = {_of_all_slots(said.quantity) for _, said in found}
        meant = {(factor, _bare(quantity)[0]) for factor, quantity in element}
        return "other" if len(apart) == len(found) and meant == {(f, said.quantity) for f, said in found} else "open"

    def _summed(self, entry: int) -> bool:
        """Return whether what the records say of an entry adds up: it is one, or all are counters."""
        said = self.said.get(entry, [])
        return len(said) == 1 or all(isinstance(each.quantity, Slots | InPlace) for each in said)

    def _taken(self, left: dict[tuple[int, Quantity], list[EntryRecord]], factor: int, quantity: Quantity) -> bool:
        """Take what says a term from what is left of the records; return whether there is one."""
        bare, where = _bare(quantity)
        candidates = left.get((factor, bare), [])
        for number, said in enumerate(candidates):
            if self._means(said, where):
                del candidates[number]
                return True
        return False

    def _means(self, said: EntryRecord, where: Cond | None) -> bool:
        if said.request == NONE:
            return True
        return self.alike(said.request, said.predicate, where, isinstance(said.quantity, HasPast))


# ---- records ----


def plain_entries(model: Model, tables: Tables) -> dict[int, Element]:
    """Return by entry what it counts, for entries of which the records say that without a predicate of arguments.

    What several records count in one entry is its sum. Left out are also those that two records set, and those that
    start otherwise.
    """
    found = {entry: list(map(_plain, said)) for entry, said in records_by_entry(model, tables).items()}
    for said in found.values():
        if len(said) > 1 and not all(isinstance(quantity, Slots | InPlace) for quantity in said):
            said[:] = [None]
    parts = tables.parts()
    start, vocabulary = Reference(model).start(), Vocabulary(model)
    plain: dict[int, Element] = {}
    for entry, row in enumerate(tables.entries):
        counted = parts.get(entry, [(entry, 1)])
        terms = [(factor, quantity) for part, factor in counted for quantity in found.get(part, [None])]
        element = tuple((factor, quantity) for factor, quantity in terms if quantity is not None)
        whole = len(element) == len(terms) and not (entry in parts and entry in found)
        if whole and sum(factor * initial(vocabulary, quantity, start) for factor, quantity in element) == row.initial:
            plain[entry] = tuple(sorted(element, key=lambda term: repr(term[1]))) if len(element) > 1 else element
    return plain


def _plain(said: EntryRecord) -> Quantity | None:
    counted = said.predicate == ALWAYS and not isinstance(said.quantity, Order | SlotValue | PlaceValue)
    return said.quantity if counted else None


def records_by_entry(model: Model, tables: Tables) -> dict[int, list[EntryRecord]]:
    """Return by entry what its records say; an order of two posters is a record of both, and counts once."""
    found: dict[int, list[EntryRecord]] = {}
    index = ModelIndex(model)
    for entry, said in (*_of_requests(index, tables), *dict.fromkeys(_of_variables(index, tables))):
        if entry != NONE:
            found.setdefault(entry, []).append(said)
    return found


def _of_requests(index: ModelIndex, tables: Tables) -> Iterator[tuple[int, EntryRecord]]:
    for number, (request, row) in enumerate(zip(index.model.requests, tables.requests, strict=True)):
        name, params = request.name, (*request.params, *request.results)
        yield row.last, EntryRecord(LastOutcome(name))
        for param, its in zip(params, tables.params[row.params : row.params_end], strict=True):
            yield its.value, EntryRecord(Arg(name, param.name))
            yield its.rank, EntryRecord(ArgRank(name, param.name))
        for past in tables.pasts[row.pasts : row.pasts_end]:
            yield past.entry, EntryRecord(HasPast(name, None), number, past.predicate)
        for order in tables.orders[row.orders : row.orders_end]:
            yield order.entry, EntryRecord(_order(index, order, request))
        for feature in tables.features[row.features : row.features_end]:
            yield from _of_feature(request, number, feature)


def _of_feature(request: Request, number: int, feature: t.FeatureRow) -> Iterator[tuple[int, EntryRecord]]:
    name, slot = request.name, None if feature.slot == NONE else feature.slot
    if feature.weight != NONE:
        held, placed = (feature.running, feature.stopping), (feature.waiting, feature.clearing)
        param = request.params[feature.weight].name
        value = PlaceValue(name, param) if slot is None else SlotValue(name, slot, param)
        counting, other = (placed, held) if slot is None else (held, placed)
        plain = counting[0] == counting[1] and set(other) == {NONE} and feature.predicate == ALWAYS
        for entry in {*held, *placed}:
            yield entry, EntryRecord(value) if plain else EntryRecord(value, number, NONE)
        return
    in_place = feature.predicate if slot is None else NONE  # with a slot, no waiting place is counted
    yield feature.running, EntryRecord(Slots(name, slot, None, "running"), number, feature.predicate)
    yield feature.stopping, EntryRecord(Slots(name, slot, None, "stopping"), number, feature.predicate)
    yield feature.waiting, EntryRecord(InPlace(name, None, "waiting"), number, in_place)
    yield feature.clearing, EntryRecord(InPlace(name, None, "clearing"), number, in_place)


def _of_variables(index: ModelIndex, tables: Tables) -> Iterator[tuple[int, EntryRecord]]:
    for name, variable in zip(index.readings, tables.variables, strict=True):
        yield variable.value, EntryRecord(VariableValue(name))
        yield variable.rank, EntryRecord(Rank(name))
        for order in tables.orders[variable.orders : variable.orders_end]:
            yield order.entry, EntryRecord(_order(index, order, None))
    for name, stock in zip(index.stocks, tables.stocks, strict=True):
        yield stock.entry, EntryRecord(Stock(name))


def _order(index: ModelIndex, row: OrderRow, request: Request | None) -> Order:
    params = (*request.params, *request.results) if request else ()

    def side(number: int) -> Param | Reading:
        return Param(params[number].name) if number >= 0 else Reading(index.readings[-1 - number])

    return Order(request.name if request else None, side(row.left), side(row.right))


def _of_all_slots(quantity: Quantity) -> Quantity:
    return replace(quantity, slot=None) if isinstance(quantity, Slots) else quantity


def _bare(quantity: Quantity) -> tuple[Quantity, Cond | None]:
    """Return a quantity without the condition on what it counts, and that condition."""
    match quantity:
        case Slots(_, _, where, _) | InPlace(_, where, _) | HasPast(_, where):
            return replace(quantity, where=None), where
        case _:
            return quantity, None
