"""Are the records of the decoded tables what the model says? All but the diagrams: domains, effects, amounts, pasts."""

from collections.abc import Iterator

from exover.model.decision import Reason
from exover.model.evaluate import Scope, applies, bind, holds
from exover.model.event import Args
from exover.model.expression import Cond
from exover.model.model import Effect, Forget, Location, Model, Parameter, Request, SetState
from exover.model.types import Bool, Enum, Int, Real, Type, ordinal
from exover.ocrd import tables as t
from exover.ocrd.conflicts import conflicts, denials
from exover.ocrd.conflicts import row as bit_row
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import ParamRow, VariableRow
from exover.ocrd.vector import HasPast, ordinal_range
from exover.verify.loop import ClosedLoop

CODES: dict[type, int] = {Bool: t.BOOL, Int: t.INT, Enum: t.ENUM, Real: t.REAL}


def kinds_of_events(model: Model) -> Iterator[tuple[str, str, Location]]:
    """Yield the kinds of events: ask, report and abort of each request, observation of each poster and consumable."""
    for kind in ("ask", "report", "abort"):
        yield from ((kind, request.name, request.location) for request in model.requests)
    yield from (("observe", v.name, v.location) for v in model.variables if v.kind == "poster")
    yield from (("observe", r.name, r.location) for r in model.resources if r.consumable)


def different_records(loop: ClosedLoop, kind: str, name: str) -> Iterator[str]:
    """Yield the records about this kind of event (ask, report, abort, observe) that say otherwise than the model."""
    if kind == "observe":
        yield from _observed(loop, name)
        return
    number = loop.request_number[name]
    request, row = loop.model.requests[number], loop.tables.requests[number]
    if row.instances != request.instances or bool(row.interrupts_self) != request.interrupts_self:
        yield f"the slots of `{name}`"
    rows = loop.tables.params[row.params : row.params_end]
    for parameter, its in zip((*request.params, *request.results), rows, strict=True):
        if not _same_domain(loop, request.name, parameter, its):
            yield f"the domain of `{parameter.name}` of `{name}`"
    if kind == "ask":
        yield from _asked(loop, number)
    elif kind == "report":
        yield from _reported(loop, number)


def unwatched(loop: ClosedLoop) -> Iterator[str]:
    """Yield the entries whose change is not told to exactly the rules that test them."""
    testing: dict[int, set[int]] = {}
    for number, rule in enumerate(loop.tables.rules):
        for entry in loop.tested(rule.root):
            testing.setdefault(entry, set()).add(number)
    for entry, row in enumerate(loop.tables.entries):
        if set(loop.tables.lists[row.rules : row.rules_end]) != testing.get(entry, set()):
            yield f"the rules that look at entry {entry}"


def wrong_conflicts(loop: ClosedLoop) -> Iterator[str]:
    """Yield what the second channel reads otherwise than in the model: bit rows, and reasons."""
    for request, row, others in zip(loop.model.requests, loop.tables.requests, conflicts(loop.model), strict=True):
        if loop.tables.conflicts[row.conflicts : row.conflicts_end] != tuple(bit_row(others)):
            yield f"the conflicts of `{request.name}`"
    if [row.denials for row in loop.tables.reasons] != denials(loop.model, reasons(loop.model)):
        yield "what reasons say of conflicts"


def wrong_rows(loop: ClosedLoop) -> Iterator[str]:
    """Yield the launches and latches whose records name something else than the model: requests, arguments, reasons."""
    tables, start = loop.tables, len(loop.model.variables)
    for launch, required in zip(loop.model.launches, tables.launches, strict=True):
        request = loop.model.request[launch.request]
        words = tables.lists[required.args : required.args + len(launch.args)]
        same = len(words) == len(launch.args) and all(
            tables.reals[word] == value if isinstance(p.type, Real) else word == ordinal(p.type, value)
            for p, word, value in zip(request.params, words, launch.args, strict=True)
        )
        whose = loop.request_number[launch.request] == required.request
        if not (whose and same and loop.reasons[required.reason] == Reason(launch.name, launch.because)):
            yield f"what launch `{launch.name}` launches"
    if [latch.variable for latch in tables.latches] != [start + k for k in range(len(loop.model.latches))]:
        yield "the variables of latches"
    if [row.statuses for row in tables.requests] != [len(request.statuses) for request in loop.model.requests]:
        yield "the statuses of reports"


def _same_domain(loop: ClosedLoop, request: str | None, parameter: Parameter, row: ParamRow | VariableRow) -> bool:
    cuts = loop.thresholds.get((request, parameter.name), ())
    if loop.tables.reals[row.cuts : row.cuts_end] != cuts:
        return False
    return row.type == CODES[type(parameter.type)] and _range(loop, row) == _declared(parameter.type)


def _range(loop: ClosedLoop, row: ParamRow | VariableRow) -> tuple[float, float]:
    if row.type == t.REAL:
        return loop.tables.reals[row.low], loop.tables.reals[row.high]
    return row.low, row.high


def _declared(kind: Type) -> tuple[float, float]:
    return (kind.low, kind.high) if isinstance(kind, Real) else ordinal_range(kind)


def _asked(loop: ClosedLoop, number: int) -> Iterator[str]:
    request, row, arguments = loop.model.requests[number], loop.tables.requests[number], loop.arguments[number]
    for cell in arguments.cells:
        its = [
            (a.stock, a.amount, arguments.agrees(a.predicate, arguments.loaded(cell.args)))
            for a in loop.tables.amounts[row.consumes : row.produces]
        ]
        clauses = [(clause.resource, clause.amount, clause.when) for clause in request.consumptions]
        if its != _amounts(loop, request, clauses, cell.args):
            yield f"what `{request.name}` consumes"
            break
    if _effects(loop, row.on_launch, row.on_ok) != _declared_effects(loop, request.on_launch):
        yield f"what the launch of `{request.name}` changes"


def _reported(loop: ClosedLoop, number: int) -> Iterator[str]:
    request, row, arguments = loop.model.requests[number], loop.tables.requests[number], loop.arguments[number]
    for kind in arguments.classes:
        its = [
            (a.stock, a.amount, arguments.agrees(a.predicate, arguments.loaded(kind.args)))
            for a in loop.tables.amounts[row.produces : row.produces_end]
        ]
        clauses = [(share.resource, share.amount, share.when) for share in request.productions]
        if its != _amounts(loop, request, clauses, kind.args):
            yield f"what `{request.name}` produces"
            break
    if any(
        _past_differs(loop, number, k.args, results) for k in arguments.classes for results in arguments.result_samples
    ):
        yield f"the past of `{request.name}`"
    ends = ((request.on_ok, row.on_ok, row.on_failed), (request.on_failed, row.on_failed, row.on_interrupted))
    for declared, start, end in (*ends, (request.on_interrupted, row.on_interrupted, row.effects_end)):
        if _effects(loop, start, end) != _declared_effects(loop, declared):
            yield f"what a report of `{request.name}` changes"
    for latch, its_latch in zip(loop.model.latches, loop.tables.latches, strict=True):
        resets = [loop.model.requests[k].name for k in loop.tables.lists[its_latch.resets : its_latch.resets_end]]
        if tuple(resets) != latch.resets:
            yield f"what clears latch `{latch.name}`"


def _amounts(
    loop: ClosedLoop, request: Request, clauses: list[tuple[str, int, Cond | None]], args: Args
) -> list[tuple[int, int, bool]]:
    stocks = [resource.name for resource in loop.model.resources if resource.consumable]
    scope = Scope(bind(request.params, args))
    nothing = loop.arguments[0].nothing
    return [(stocks.index(r), n, applies(loop.model, nothing, when, scope)) for r, n, when in clauses]


def _past_differs(loop: ClosedLoop, number: int, args: Args, results: Args) -> bool:
    request, row, arguments = loop.model.requests[number], loop.tables.requests[number], loop.arguments[number]
    scope = Scope(bind(request.params + request.results, args + results))
    rows = loop.tables.pasts[row.pasts : row.pasts_end]
    for past, value in zip(rows, arguments.pasts(args, results), strict=True):
        quantity = loop.entries[past.entry][0][1]
        if not isinstance(quantity, HasPast) or quantity.request != request.name:
            return True
        if value != (quantity.where is None or holds(loop.model, arguments.nothing, quantity.where, scope)):
            return True
    return False


def _effects(loop: ClosedLoop, start: int, end: int) -> list[tuple[int, int, int]]:
    return [(effect.kind, effect.target, effect.value) for effect in loop.tables.effects[start:end]]


def _declared_effects(loop: ClosedLoop, effects: tuple[Effect, ...]) -> list[tuple[int, int, int]]:
    found = []
    for effect in effects:
        match effect:
            case SetState(state, value):
                number = ordinal(loop.model.variable[state].type, value)
                found.append((t.SET, loop.names.index(state), number))
            case Forget(requests):
                found += [(t.FORGET, loop.request_number[request], 0) for request in requests]
    return found


def _observed(loop: ClosedLoop, name: str) -> Iterator[str]:
    variable = loop.model.variable.get(name)
    if variable is None:
        stocks = [resource for resource in loop.model.resources if resource.consumable]
        number = [resource.name for resource in stocks].index(name)
        row = loop.tables.stocks[number]
        if (row.capacity, row.initial) != (stocks[number].capacity, stocks[number].initial):
            yield f"the capacity of `{name}`"
        return
    its = loop.tables.variables[loop.names.index(name)]
    if not _same_domain(loop, None, Parameter(name, variable.type), its):
        yield f"the domain of `{name}`"
    if bool(its.has_fallback) != (variable.fallback is not None):
        yield f"the fallback of `{name}`"
    pairs = [(its.initial, variable.initial)] + (
        [(its.fallback, variable.fallback)] if variable.fallback is not None else []
    )
    for number, value in pairs:
        stored = loop.tables.reals[number] if its.type == t.REAL else number
        if stored != (value if isinstance(variable.type, Real) else ordinal(variable.type, value)):
            yield f"a value of `{name}`"
