"""Builds the symbol table from all declarations of a spec, so that names may be used before they are declared."""

from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.types import Bool, Enum, Real, Type
from exover.resolve.circles import in_order, note_circle
from exover.resolve.mistakes import Mistakes, same_name
from exover.resolve.names import ModuleNames, QuantityName, ResourceName, Signature, SymbolTable, entries
from exover.resolve.types import enum_of, type_of
from exover.resolve.values import Constant, Constants, Symbol, at, constant_of, no_constant
from exover.source import Span
from exover.syntax import tree

Holder = tree.Param | tree.Poster | tree.State


@dataclass(slots=True)
class _Reader:
    """The symbol table so far; `top` and `kinds` hold the places of the first declarations."""

    mistakes: Mistakes
    names: SymbolTable
    top: dict[str, Span] = field(default_factory=dict)
    kinds: dict[str, dict[str, Span]] = field(default_factory=dict)

    def is_new(self, kind: str, name: tree.Name) -> bool:
        """Return whether this is the first declaration of the name in its kind; if not, note a mistake."""
        return self._free(self.kinds.setdefault(kind, {}), kind, name)

    def is_new_at_top(self, kind: str, name: tree.Name) -> bool:
        """Return whether this is the first top-level poster, latch, const or define of the name; if not, note it."""
        return self._free(self.top, kind, name)

    def _free(self, taken: dict[str, Span], what: str, name: tree.Name) -> bool:
        first = same_name(taken, name.text, name.span)
        if first:
            self.mistakes.again(name.text, what, name.span, first)
        return first is None


def declare(spec: tree.Spec, mistakes: Mistakes) -> SymbolTable:
    """Return the symbol table of a spec, and note the mistakes in its declarations, but not those in conditions."""
    enums = _enums(spec, mistakes)
    top = [item for item in spec.items if isinstance(item, tree.Const | tree.Define | tree.Poster | tree.Latch)]
    others = frozenset(item.name.text for item in top if not isinstance(item, tree.Const))
    known = Constants(_consts(spec), _enum_values(spec, enums), others)
    _check_consts(spec, known, mistakes)
    reader = _Reader(mistakes, SymbolTable(known, enums, {}, {}, {}, {}, {}, {}, {}))
    for item in spec.items:
        match item:
            case tree.Const(name):
                reader.is_new_at_top("const", name)
            case tree.Define(name):
                if reader.is_new_at_top("define", name):
                    reader.names.defines[name.text] = item
            case tree.Poster(name):
                kind = _type(reader, item.type)
                if reader.is_new_at_top("poster", name):
                    reader.names.quantities[name.text] = QuantityName(name.text, "poster", kind, name.span)
            case tree.Latch(name):
                if reader.is_new_at_top("latch", name):
                    reader.names.quantities[name.text] = QuantityName(name.text, "latch", Bool(), name.span)
            case tree.Resource(name):
                if reader.is_new("resource", name):
                    reader.names.resources[name.text] = ResourceName(name.text, item.consumable, name.span)
            case tree.Module():
                _module(reader, item)
            case _:
                pass
    _check_observables(spec, mistakes)
    _groups(spec, reader)
    return reader.names


def _type(reader: _Reader, node: tree.Type) -> Type | None:
    return type_of(node, reader.names.enums, reader.names.constants, reader.mistakes)


def _enums(spec: tree.Spec, mistakes: Mistakes) -> dict[str, Enum]:
    enums: dict[str, Enum] = {}
    taken: dict[str, Span] = {}
    for item in spec.items:
        if isinstance(item, tree.Enum):
            kind = enum_of(item.values, mistakes)
            first = same_name(taken, item.name.text, item.name.span)
            if first:
                mistakes.again(item.name.text, "enum", item.name.span, first)
            enums.setdefault(item.name.text, kind)
    return enums


def _enum_values(spec: tree.Spec, enums: dict[str, Enum]) -> frozenset[str]:
    """Return the values of all enums of the spec, those without a name included."""
    values = {value for kind in enums.values() for value in kind.values}
    for item in spec.items:
        members = item.members if isinstance(item, tree.Module) else (item,)
        for member in members:
            holders: tuple[Holder, ...] = ()
            if isinstance(member, tree.Request):
                holders = (*member.params, *member.results)
            elif isinstance(member, tree.Poster | tree.State):
                holders = (member,)
            for holder in holders:
                if isinstance(holder.type, tree.SetType):
                    values |= {name.text for name in holder.type.values}
    return frozenset(values)


def _consts(spec: tree.Spec) -> dict[str, Constant | None]:
    """Return the value of each const, None for one in a cycle and for those that need it."""
    nodes: dict[str, tree.Const] = {}
    for item in spec.items:
        if isinstance(item, tree.Const):
            nodes.setdefault(item.name.text, item)
    found: dict[str, Constant | None] = {}
    for name in in_order(_const_needs(nodes))[0]:
        node = nodes[name].value
        if isinstance(node, tree.Word) and node.name.text in nodes:
            constant = found.get(node.name.text)
            found[name] = None if constant is None else at(constant, node.span)
        else:
            found[name] = constant_of(node, Constants({}, frozenset()))
    return found


def _const_needs(nodes: dict[str, tree.Const]) -> dict[str, tuple[str, ...]]:
    return {name: (node.value.name.text,) if isinstance(node.value, tree.Word) else () for name, node in nodes.items()}


def _check_consts(spec: tree.Spec, known: Constants, mistakes: Mistakes) -> None:
    """Note cycles of consts, and consts that are neither a number nor a bool nor an enum value."""
    nodes = {item.name.text: item for item in reversed(spec.items) if isinstance(item, tree.Const)}
    for circle in in_order(_const_needs(nodes))[1]:
        note_circle("const", [nodes[name].name for name in circle], mistakes)
    for node in nodes.values():
        symbol = constant_of(node.value, Constants({}, frozenset()))
        if isinstance(symbol, Symbol) and symbol.name not in known.consts and symbol.name not in known.enum_values:
            no_constant(symbol, None, known, mistakes)


def _module(reader: _Reader, node: tree.Module) -> None:
    """Add the members of a module; a second module of one name, a mistake, adds what the first does not have."""
    is_new = reader.is_new("module", node.name)
    module = reader.names.modules.setdefault(node.name.text, ModuleNames())
    requests: dict[str, Span] = {}
    quantities: dict[str, Span] = {}
    for member in node.members:
        name = member.name.text
        full = f"{node.name.text}.{name}"
        taken = requests if isinstance(member, tree.Request) else quantities
        first = same_name(taken, name, member.name.span)
        if first and is_new:
            what = type(member).__name__.lower()
            reader.mistakes.again(name, what, member.name.span, first)
        match member:
            case tree.Request():
                signature = _signature(reader, member, node.name.text)
                if module.requests.setdefault(name, signature) is signature:
                    reader.names.requests[full] = signature
                    reader.names.nodes[full] = member
            case tree.Poster():
                kind = _type(reader, member.type)
                module.quantities.setdefault(name, QuantityName(full, "poster", kind, member.name.span))
            case tree.State():
                kind = _state_type(reader, member)
                module.quantities.setdefault(name, QuantityName(full, "state", kind, member.name.span))
            case _:
                assert_never(member)


def _state_type(reader: _Reader, node: tree.State) -> Type | None:
    kind = _type(reader, node.type)
    if not isinstance(kind, Real):
        return kind
    reader.mistakes.add("E312", f"state {quote(node.name.text)} is a bool, an int or an enum, no real", node.type.span)
    return None


def _signature(reader: _Reader, node: tree.Request, module: str) -> Signature:
    taken: dict[str, Span] = {}
    params = _params(reader, node.params, "parameter", taken)
    for result in node.results:
        if result.name.text in params:
            message = f"{quote(result.name.text)} is a parameter and a result"
            reader.mistakes.add("E213", message, result.name.span)
    results = _params(reader, node.results, "result", {})
    statuses: dict[str, Span] = {}
    for status in node.statuses:
        first = same_name(statuses, status.text, status.span)
        if first:
            reader.mistakes.again(status.text, "status", status.span, first)
    return Signature(f"{module}.{node.name.text}", module, params, results)


def _params(
    reader: _Reader, nodes: tuple[tree.Param, ...], what: str, taken: dict[str, Span]
) -> dict[str, Type | None]:
    found: dict[str, Type | None] = {}
    for node in nodes:
        kind = _type(reader, node.type)
        first = same_name(taken, node.name.text, node.name.span)
        if first:
            reader.mistakes.again(node.name.text, what, node.name.span, first)
        found.setdefault(node.name.text, kind)
    return found


def _check_observables(spec: tree.Spec, mistakes: Mistakes) -> None:
    """Note a consumable resource and a top-level poster or latch of one name: events and states name either of them."""
    taken: dict[str, tree.Poster | tree.Latch | tree.Resource] = {}
    for item in spec.items:
        if isinstance(item, tree.Poster | tree.Latch) or (isinstance(item, tree.Resource) and item.consumable):
            first = taken.setdefault(item.name.text, item)
            if isinstance(first, tree.Resource) != isinstance(item, tree.Resource):
                other = first if isinstance(item, tree.Resource) else item
                kind = "poster" if isinstance(other, tree.Poster) else "latch"
                message = f"{quote(item.name.text)} is a {kind} and a consumable resource"
                label = f"first declared {mistakes.on_line(first.name.span, item.name.span)}"
                hint = "an observation names either of them" if kind == "poster" else "a run shows the values of both"
                mistakes.add("E210", message, item.name.span, label=label, hint=hint)


def _groups(spec: tree.Spec, reader: _Reader) -> None:
    """Expand the groups, each after those that it names, and note cycles."""
    nodes: dict[str, tree.Group] = {}
    for item in spec.items:
        if isinstance(item, tree.Group) and reader.is_new("group", item.name):
            nodes[item.name.text] = item
    needs = {
        name: [entry.name.text for entry in node.requests if isinstance(entry, tree.GroupName)]
        for name, node in nodes.items()
    }
    order, circles = in_order(needs)
    for circle in circles:
        note_circle("group", [nodes[name].name for name in circle], reader.mistakes)
        for name in circle:
            reader.names.groups[name] = ()
    for name in order:
        if name not in reader.names.groups:
            found = entries(reader.names, nodes[name].requests, reader.mistakes)
            reader.names.groups[name] = tuple(entry.request for entry in found)
