"""Stores the names of a spec in its model, and rebuilds a symbol table from there for a properties file."""

from collections.abc import Iterable

from exover.diagnostics import quote
from exover.model.expression import And, Compare, Cond, Not, Or, Reading, atoms
from exover.model.model import Model, Parameter, SourceNames
from exover.model.types import Bool, Real, Type, Value
from exover.resolve.names import ModuleNames, QuantityName, ResourceName, Signature, SymbolTable
from exover.resolve.scope import Meaning, ReadKind
from exover.resolve.values import Constant, Constants, Numeral, Symbol
from exover.source import Span

ELSEWHERE = Span(0, 0)
"""A span for declarations in another text."""


def vocabulary(names: SymbolTable, meanings: dict[str, Meaning | None]) -> SourceNames:
    """Return the names of a spec without mistakes that are not in the rest of its model."""
    consts = {name: _value(constant) for name, constant in names.constants.consts.items() if constant is not None}
    defines = {name: meaning.cond for name, meaning in meanings.items() if meaning}
    enums = {name: kind.values for name, kind in names.enums.items()}
    return SourceNames(consts, defines, dict(names.groups), names.constants.enum_values, enums, tuple(names.modules))


def _value(constant: Constant) -> Value:
    match constant:
        case Numeral(text, whole):
            return float(text) if whole is None else whole
        case Symbol(name):
            return name
        case _:
            return constant


def names_of(model: Model) -> SymbolTable:
    """Return the symbol table of the spec of a model, without defines (see `meanings_of`), enums and declarations."""
    words = model.vocabulary
    modules = {name: ModuleNames() for name in words.modules}
    requests: dict[str, Signature] = {}
    quantities = {latch.name: QuantityName(latch.name, "latch", Bool(), ELSEWHERE) for latch in model.latches}
    for request in model.requests:
        module, _, name = request.name.partition(".")
        signature = Signature(request.name, module, _types(request.params), _types(request.results))
        requests[request.name] = modules.setdefault(module, ModuleNames()).requests[name] = signature
    for variable in model.variables:
        module, _, name = variable.name.rpartition(".")
        known = modules.setdefault(module, ModuleNames()).quantities if module else quantities
        known[name] = QuantityName(variable.name, variable.kind, variable.type, ELSEWHERE)
    resources = {each.name: ResourceName(each.name, each.consumable, ELSEWHERE) for each in model.resources}
    consts = {name: _constant(value) for name, value in words.consts.items()}
    constants = Constants(consts, words.enum_values)
    return SymbolTable(constants, {}, modules, quantities, {}, resources, words.groups, requests, {})


def _types(parameters: Iterable[Parameter]) -> dict[str, Type | None]:
    return {parameter.name: parameter.type for parameter in parameters}


def _constant(value: Value) -> Constant:
    match value:
        case bool():
            return value
        case str():
            return Symbol(value, ELSEWHERE)
        case int():
            return Numeral(str(value), value, ELSEWHERE)
        case _:
            return Numeral(repr(value), None, ELSEWHERE)


def meanings_of(model: Model) -> dict[str, Meaning | None]:
    """Return the meanings of the defines of a spec; their reads hold only those that a property may not have."""
    return {
        name: Meaning(cond, frozenset(_pairs(model, cond)), sum(1 for _ in atoms(cond)), _depth(cond))
        for name, cond in model.vocabulary.defines.items()
    }


def _pairs(model: Model, cond: Cond) -> Iterable[tuple[ReadKind, str]]:
    """Yield a read `pair` for each comparison of two real posters."""
    for atom in atoms(cond):
        match atom:
            case Compare(_, Reading(left), Reading()) if isinstance(_type(model, left), Real):
                yield "pair", quote(left)


def _type(model: Model, reading: str) -> Type | None:
    variable = model.variable.get(reading)
    return variable.type if variable else None


def _depth(cond: Cond) -> int:
    match cond:
        case Not(part):
            return 1 + _depth(part)
        case And(parts) | Or(parts):
            return 1 + max(map(_depth, parts), default=0)
        case _:
            return 1
