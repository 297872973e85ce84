"""Finds where each name of a text is declared and used, by the scopes of docs/language.md section 2.

This needs the tree only, so a text that does not resolve to a model has its symbols all the same.
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import field, fields, is_dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

from exover.dataclass import dataclass
from exover.source import Span
from exover.syntax import tree

SymbolSort = Literal[
    "spec",
    "enum",
    "value",
    "const",
    "define",
    "group",
    "module",
    "request",
    "parameter",
    "result",
    "status",
    "poster",
    "state",
    "latch",
    "resource",
    "rule",
    "property",
]


class SpecSymbol(NamedTuple):
    """What a name stands for: its sort and full name; all enum values of one name are one symbol."""

    sort: SymbolSort
    name: str


class SymbolOccurrence(NamedTuple):
    """One place where a symbol is named; `declares` iff it is declared there."""

    span: Span
    symbol: SpecSymbol
    declares: bool


@dataclass(frozen=True, slots=True)
class Declared:
    """A declaration: its symbol, the span of the name, and its node in the tree."""

    symbol: SpecSymbol
    span: Span
    node: Any


@dataclass
class Index:
    """All occurrences of names in one text, and its declarations."""

    occurrences: list[SymbolOccurrence] = field(default_factory=list)
    declared: dict[SpecSymbol, Declared] = field(default_factory=dict)

    @cached_property
    def _sorted(self) -> list[SymbolOccurrence]:
        return sorted(self.occurrences, key=lambda each: each.span)

    def at(self, offset: int) -> SymbolOccurrence | None:
        """Return the name at an offset, or that ends there; None if there is none."""
        place = bisect_right(self._sorted, offset, key=lambda each: each.span.start)
        nearest = self._sorted[place - 1] if place else None
        return nearest if nearest and offset <= nearest.span.end else None

    def of(self, symbol: SpecSymbol) -> list[SymbolOccurrence]:
        """Return the occurrences of a symbol, in the order of the text."""
        return [each for each in self._sorted if each.symbol == symbol]


@dataclass(frozen=True, slots=True)
class _Place:
    """The scope of a name: a module, the request `owner` whose clause it is in, and the request `subject` of a `with`.

    `results`: whether names may also be results of `subject`.
    """

    module: str = ""
    owner: str = ""
    subject: str = ""
    results: bool = False


TOP = _Place()
_SORTS: dict[type, SymbolSort] = {
    tree.Enum: "enum",
    tree.Const: "const",
    tree.Define: "define",
    tree.Group: "group",
    tree.Latch: "latch",
    tree.Resource: "resource",
    tree.Property: "property",
}
_READ: tuple[SymbolSort, ...] = ("poster", "state", "latch")


def children(node: Any) -> Iterator[Any]:
    """Yield the nodes just below a node of a tree, in the order of its fields."""
    for each in fields(node):
        value = getattr(node, each.name)
        yield from filter(is_dataclass, value if isinstance(value, tuple) else (value,))


def index_of(root: tree.Spec | tree.Part | tree.Properties, known: Index | None = None) -> Index:
    """Return the index of a spec or a part; or of a properties file, whose spec has the index `known`."""
    found = Index()
    declared = dict(known.declared) if known else {}
    for name, symbol, node in _declarations(root):
        declared.setdefault(symbol, Declared(symbol, name.span, node))
        found.declared.setdefault(symbol, Declared(symbol, name.span, node))
        found.occurrences.append(SymbolOccurrence(name.span, symbol, declares=True))
    reader = _Reader(frozenset(declared), found.occurrences)
    if isinstance(root, tree.Properties):
        reader.note(root.spec, SpecSymbol("spec", root.spec.text))
    for item in root.items:
        reader.read(item, TOP)
    return found


# ---- declarations ----


def _declarations(root: tree.Spec | tree.Part | tree.Properties) -> Iterator[tuple[tree.Name, SpecSymbol, Any]]:
    """Yield name, symbol and node of each declaration."""
    if isinstance(root, tree.Spec):
        yield root.name, SpecSymbol("spec", root.name.text), root
    for item in root.items:
        if isinstance(item, tree.Module):
            yield item.name, SpecSymbol("module", item.name.text), item
            for member in item.members:
                yield from _member(item.name.text, member)
        elif isinstance(item, tree.Poster):
            yield item.name, SpecSymbol("poster", item.name.text), item
            yield from _values(item.type)
        elif isinstance(item, tree.Context):
            yield from _labels(f"{item.request.module.text}.{item.request.request.text}.", item.clauses)
        elif type(item) in _SORTS:
            named: Any = item
            yield named.name, SpecSymbol(_SORTS[type(item)], named.name.text), item
            if isinstance(item, tree.Enum):
                yield from ((value, SpecSymbol("value", value.text), item) for value in item.values)
        else:
            yield from _labels("", (item,))


def _member(module: str, member: tree.Member) -> Iterator[tuple[tree.Name, SpecSymbol, Any]]:
    full = f"{module}.{member.name.text}"
    if not isinstance(member, tree.Request):
        yield member.name, SpecSymbol("poster" if isinstance(member, tree.Poster) else "state", full), member
        yield from _values(member.type)
        return
    yield member.name, SpecSymbol("request", full), member
    for param in (*member.params, *member.results):
        sort: SymbolSort = "parameter" if param in member.params else "result"
        yield param.name, SpecSymbol(sort, f"{full}.{param.name.text}"), param
        yield from _values(param.type)
    yield from ((status, SpecSymbol("status", f"{full}.{status.text}"), member) for status in member.statuses)
    yield from _labels(f"{full}.", member.clauses)


def _values(kind: tree.Type) -> Iterator[tuple[tree.Name, SpecSymbol, Any]]:
    if isinstance(kind, tree.SetType):
        yield from ((value, SpecSymbol("value", value.text), kind) for value in kind.values)


def _labels(prefix: str, nodes: Iterable[Any]) -> Iterator[tuple[tree.Name, SpecSymbol, Any]]:
    for node in nodes:
        label = getattr(node, "label", None)
        if label is not None:
            yield label, SpecSymbol("rule", prefix + label.text), node


# ---- uses ----


@dataclass(frozen=True, slots=True)
class _Reader:
    declared: frozenset[SpecSymbol]
    found: list[SymbolOccurrence]

    def note(self, name: tree.Name, symbol: SpecSymbol) -> None:
        """Note a use of a symbol if it is declared."""
        self.first(name, (symbol,))

    def first(self, name: tree.Name, symbols: Iterable[SpecSymbol]) -> None:
        """Note a use of the first of these symbols that is declared."""
        found = next((symbol for symbol in symbols if symbol in self.declared), None)
        if found:
            self.found.append(SymbolOccurrence(name.span, found, declares=False))

    def read(self, node: Any, place: _Place) -> None:
        """Note every use in a node and below it."""
        match node:
            case tree.Module(name, _, members):
                for member in members:
                    owner = f"{name.text}.{member.name.text}" if isinstance(member, tree.Request) else ""
                    self._below(member, _Place(name.text, owner))
            case tree.Context(ref, clauses):
                self.read(ref, place)
                owner = f"{ref.module.text}.{ref.request.text}"
                for clause in clauses:
                    self.read(clause, _Place(ref.module.text, owner))
            case tree.Ref(module, request):
                self.note(module, SpecSymbol("module", module.text))
                self.note(request, SpecSymbol("request", f"{module.text}.{request.text}"))
            case tree.ModuleAll(module):
                self.note(module, SpecSymbol("module", module.text))
            case tree.GroupName(name):
                self.note(name, SpecSymbol("group", name.text))
            case tree.NamedType(name):
                self.note(name, SpecSymbol("enum", name.text))
            case tree.Word(name):
                self.first(name, _constants(name.text))
            case tree.SelfName(name):
                self.note(name, SpecSymbol("parameter", f"{place.owner}.{name.text}"))
            case tree.NameUse():
                self._use(node, place)
            case tree.OnSet():
                self._use(node.state, _Place(place.module))
                self.read(node.value, place)
            case tree.Predicate(kind, (tree.Ref(module, request),), condition) if condition is not None:
                self.read(node.requests[0], place)
                subject = f"{module.text}.{request.text}"
                self.read(condition, _Place(place.module, place.owner, subject, kind == "past"))
            case tree.Uses() | tree.Consumes() | tree.Produces() | tree.Used() | tree.Level():
                self.note(node.resource, SpecSymbol("resource", node.resource.text))
                self._below(node, place)
            case tree.Name():
                pass  # a declaration, or a use that is noted above
            case _:
                self._below(node, place)

    def _below(self, node: Any, place: _Place) -> None:
        for child in children(node):
            self.read(child, place)

    def _use(self, use: tree.NameUse, place: _Place) -> None:
        name = use.name.text
        if use.module is not None:
            self.note(use.module, SpecSymbol("module", use.module.text))
            full = f"{use.module.text}.{name}"
            self.first(use.name, (SpecSymbol("poster", full), SpecSymbol("state", full)))
        elif place.subject:
            sorts: tuple[SymbolSort, ...] = ("parameter", "result") if place.results else ("parameter",)
            own = [SpecSymbol(sort, f"{place.subject}.{name}") for sort in sorts]
            self.first(use.name, (*own, *_constants(name)))
        else:
            inside = (SpecSymbol(sort, f"{place.module}.{name}") for sort in _READ)
            above = (SpecSymbol(sort, name) for sort in (*_READ, "define"))
            self.first(use.name, (SpecSymbol("parameter", f"{place.owner}.{name}"), *inside, *above, *_constants(name)))


def _constants(name: str) -> tuple[SpecSymbol, SpecSymbol]:
    return SpecSymbol("const", name), SpecSymbol("value", name)
