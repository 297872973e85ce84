"""Are the records of the decoded tables what the model says? All but the diagrams: domains, effects, amounts, pasts."""

from collections.abc import Callable, Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.expression import Cond
from exover.model.index import ModelIndex
from exover.model.model import Effect, Forget, Location, Model, Parameter, SetState
from exover.model.types import Real, Type, ordinal
from exover.ocrd import tables as t
from exover.ocrd.conflicts import conflicts, denials
from exover.ocrd.conflicts import row as bit_row
from exover.ocrd.reasons import reasons
from exover.ocrd.structure import TYPE_CODES
from exover.ocrd.tables import NONE, ParamRow, VariableRow
from exover.ocrd.vector import Element, HasPast, Vocabulary, ordinal_range

Alike = Callable[[int, int, Cond | None, bool], bool]
"""Whether a predicate of the tables is true of just those arguments, with results if so, of which a condition is: the
number of the request, the root, the condition, and whether there are results."""


@dataclass(frozen=True)
class Records:
    """Decoded tables, what each of their entries is, and `alike`, who compares their predicates with conditions."""

    model: Model
    tables: t.Tables
    entries: tuple[Element, ...]
    alike: Alike

    @cached_property
    def reasons(self) -> tuple[Reason, ...]:
        """The reasons by their numbers."""
        return reasons(self.model)

    @cached_property
    def index(self) -> ModelIndex:
        """The numbers of what the model names."""
        return ModelIndex(self.model)

    @cached_property
    def thresholds(self) -> dict[tuple[str | None, str], tuple[float, ...]]:
        """The constants that reals are compared with, by (request, parameter) or (None, poster)."""
        return Vocabulary(self.model).thresholds


def kinds_of_events(model: Model) -> Iterator[tuple[str, str, Location]]:
    """Yield the kinds of events: ask, report and abort of each request, observation of each poster and consumable."""
    for kind in ("ask", "report", "abort"):
        yield from ((kind, request.name, request.location) for request in model.requests)
    index = ModelIndex(model)
    yield from (("observe", poster.name, poster.location) for _, poster in index.posters)
    yield from (("observe", resource.name, resource.location) for resource in index.consumables)


def different_records(records: Records, kind: str, name: str) -> Iterator[str]:
    """Yield the records about this kind of event (ask, report, abort, observe) that say otherwise than the model."""
    if kind == "observe":
        yield from _observed(records, name)
        return
    number = records.index.request[name]
    request, row = records.model.requests[number], records.tables.requests[number]
    if row.instances != request.instances or bool(row.interrupts_self) != request.interrupts_self:
        yield f"the slots of `{name}`"
    rows = records.tables.params[row.params : row.params_end]
    for parameter, its in zip((*request.params, *request.results), rows, strict=True):
        if not _same_domain(records, request.name, parameter, its):
            yield f"the domain of `{parameter.name}` of `{name}`"
    if kind == "ask":
        yield from _asked(records, number)
    elif kind == "report":
        yield from _reported(records, number)


def different_for_all(records: Records) -> Iterator[str]:
    """Yield the records that every kind of event reads and that say otherwise than the model."""
    yield from _unwatched(records)
    yield from _wrong_comparisons(records)
    yield from _wrong_conflicts(records)
    yield from _wrong_rows(records)


def _unwatched(records: Records) -> Iterator[str]:
    """Yield the entries whose change is not told to exactly the rules that test them."""
    testing: dict[int, set[int]] = {}
    for number, rule in enumerate(records.tables.rules):
        for entry in records.tables.tested(rule.root):
            testing.setdefault(entry, set()).add(number)
    for entry, row in enumerate(records.tables.entries):
        if set(records.tables.lists[row.rules : row.rules_end]) != testing.get(entry, set()):
            yield f"the rules that look at entry {entry}"


def _wrong_comparisons(records: Records) -> Iterator[str]:
    """Yield the real posters that are compared by the value of another, or whose change is not told to what compares
    them: with posters, or with arguments.
    """
    tables = records.tables
    raws = [row.raw for row in tables.variables if row.raw != NONE]
    orders = [set(tables.orders[row.orders : row.orders_end]) for row in tables.variables]
    every = set().union(*orders)
    for number, (name, row) in enumerate(zip(records.index.readings, tables.variables, strict=True)):
        if raws.count(row.raw) > 1:
            yield f"where the value of `{name}` is kept"
        if any(-1 - number in (order.left, order.right) for order in every - orders[number]):
            yield f"the posters that `{name}` is compared with"
        for request, its in enumerate(tables.requests):
            rows = tables.orders[its.orders : its.orders_end]
            reading = {order.entry for order in rows if -1 - number in (order.left, order.right)}
            features = tables.features[its.features : its.features_end]
            read = any(reading & tables.tested(feature.predicate) for feature in features) if reading else False
            if read and request not in tables.lists[row.refresh : row.refresh_end]:
                yield f"the requests that look at `{name}`"


def _wrong_conflicts(records: Records) -> Iterator[str]:
    """Yield what the second channel reads otherwise than in the model: bit rows, and reasons."""
    for request, row, others in zip(
        records.model.requests, records.tables.requests, conflicts(records.model), strict=True
    ):
        if records.tables.conflicts[row.conflicts : row.conflicts_end] != tuple(bit_row(others)):
            yield f"the conflicts of `{request.name}`"
    if [row.denials for row in records.tables.reasons] != denials(records.model, reasons(records.model)):
        yield "what reasons say of conflicts"


def _wrong_rows(records: Records) -> Iterator[str]:
    """Yield what launches, latches and variables name otherwise than the model: requests, arguments, reasons, roles."""
    tables, start = records.tables, len(records.model.variables)
    for launch, required in zip(records.model.launches, tables.launches, strict=True):
        request = records.model.request[launch.request]
        words = tables.lists[required.args : required.args + len(launch.args)]
        same = len(words) == len(launch.args) and all(
            tables.reals[word] == value if isinstance(p.type, Real) else word == ordinal(p.type, value)
            for p, word, value in zip(request.params, words, launch.args, strict=True)
        )
        whose = records.index.request[launch.request] == required.request
        if not (whose and same and records.reasons[required.reason] == Reason(launch.name, launch.because)):
            yield f"what launch `{launch.name}` launches"
    if [latch.variable for latch in tables.latches] != [start + k for k in range(len(records.model.latches))]:
        yield "the variables of latches"
    roles = [t.POSTER if variable.kind == "poster" else t.STATE for variable in records.model.variables]
    if [row.role for row in tables.variables] != [*roles, *(t.LATCH for _ in records.model.latches)]:
        yield "which variables are observed"
    if [row.statuses for row in tables.requests] != [len(request.statuses) for request in records.model.requests]:
        yield "the statuses of reports"


def _same_domain(records: Records, request: str | None, parameter: Parameter, row: ParamRow | VariableRow) -> bool:
    cuts = records.thresholds.get((request, parameter.name), ())
    if records.tables.reals[row.cuts : row.cuts_end] != cuts:
        return False
    return row.type == TYPE_CODES[type(parameter.type)] and _range(records, row) == _declared(parameter.type)


def _range(records: Records, row: ParamRow | VariableRow) -> tuple[float, float]:
    if row.type == t.REAL:
        return records.tables.reals[row.low], records.tables.reals[row.high]
    return row.low, row.high


def _declared(kind: Type) -> tuple[float, float]:
    return (kind.low, kind.high) if isinstance(kind, Real) else ordinal_range(kind)


def _asked(records: Records, number: int) -> Iterator[str]:
    request, row = records.model.requests[number], records.tables.requests[number]
    clauses = [(clause.resource, clause.amount, clause.when) for clause in request.consumptions]
    if not _same_amounts(records, number, records.tables.amounts[row.consumes : row.produces], clauses):
        yield f"what `{request.name}` consumes"
    if _effects(records, row.on_launch, row.on_ok) != _declared_effects(records, request.on_launch):
        yield f"what the launch of `{request.name}` changes"


def _reported(records: Records, number: int) -> Iterator[str]:
    request, row = records.model.requests[number], records.tables.requests[number]
    clauses = [(share.resource, share.amount, share.when) for share in request.productions]
    if not _same_amounts(records, number, records.tables.amounts[row.produces : row.produces_end], clauses):
        yield f"what `{request.name}` produces"
    if not all(_same_past(records, number, past) for past in records.tables.pasts[row.pasts : row.pasts_end]):
        yield f"the past of `{request.name}`"
    ends = ((request.on_ok, row.on_ok, row.on_failed), (request.on_failed, row.on_failed, row.on_interrupted))
    for declared, start, end in (*ends, (request.on_interrupted, row.on_interrupted, row.effects_end)):
        if _effects(records, start, end) != _declared_effects(records, declared):
            yield f"what a report of `{request.name}` changes"
    for latch, its_latch in zip(records.model.latches, records.tables.latches, strict=True):
        resets = [records.model.requests[k].name for k in records.tables.lists[its_latch.resets : its_latch.resets_end]]
        if tuple(resets) != latch.resets:
            yield f"what clears latch `{latch.name}`"


def _same_amounts(
    records: Records, number: int, rows: tuple[t.AmountRow, ...], clauses: list[tuple[str, int, Cond | None]]
) -> bool:
    stock = records.index.stock
    if [(row.stock, row.amount) for row in rows] != [(stock[name], amount) for name, amount, _ in clauses]:
        return False
    pairs = zip(rows, clauses, strict=True)
    return all(records.alike(number, row.predicate, when, False) for row, (_, _, when) in pairs)


def _same_past(records: Records, number: int, past: t.PastRow) -> bool:
    quantity = records.entries[past.entry][0][1]
    if not isinstance(quantity, HasPast) or quantity.request != records.model.requests[number].name:
        return False
    return records.alike(number, past.predicate, quantity.where, True)


def _effects(records: Records, start: int, end: int) -> list[tuple[int, int, int]]:
    return [(effect.kind, effect.target, effect.value) for effect in records.tables.effects[start:end]]


def _declared_effects(records: Records, effects: tuple[Effect, ...]) -> list[tuple[int, int, int]]:
    found = []
    for effect in effects:
        match effect:
            case SetState(state, value):
                number = ordinal(records.model.variable[state].type, value)
                found.append((t.SET, records.index.reading[state], number))
            case Forget(requests):
                found += [(t.FORGET, records.index.request[request], 0) for request in requests]
    return found


def _observed(records: Records, name: str) -> Iterator[str]:
    variable = records.model.variable.get(name)
    if variable is None:
        number = records.index.stock[name]
        row, stock = records.tables.stocks[number], records.index.consumables[number]
        if (row.capacity, row.initial) != (stock.capacity, stock.initial):
            yield f"the capacity of `{name}`"
        return
    its = records.tables.variables[records.index.reading[name]]
    if not _same_domain(records, None, Parameter(name, variable.type), its):
        yield f"the domain of `{name}`"
    if bool(its.has_fallback) != (variable.fallback is not None):
        yield f"the fallback of `{name}`"
    pairs = [(its.initial, variable.initial)] + (
        [(its.fallback, variable.fallback)] if variable.fallback is not None else []
    )
    for number, value in pairs:
        stored = records.tables.reals[number] if its.type == t.REAL else number
        if stored != (value if isinstance(variable.type, Real) else ordinal(variable.type, value)):
            yield f"a value of `{name}`"
