"""The symbol table of a spec, and the resolution of names of modules, requests, resources and groups."""

from collections.abc import Sequence
from dataclasses import field
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.types import Enum, Type
from exover.resolve.mistakes import Mistakes, known_here
from exover.resolve.values import Constants
from exover.source import Span
from exover.syntax import tree


@dataclass(frozen=True, slots=True)
class Signature:
    """A declared request: its full name and the types of its parameters and results, None for a type with a mistake."""

    name: str
    module: str
    params: dict[str, Type | None]
    results: dict[str, Type | None]


@dataclass(frozen=True, slots=True)
class QuantityName:
    """A poster, state or latch by its full name, declared at `span`; the type is None if it has a mistake."""

    name: str
    kind: Literal["poster", "state", "latch"]
    type: Type | None
    span: Span


@dataclass(frozen=True, slots=True)
class ResourceName:
    """A resource, declared at `span`."""

    name: str
    consumable: bool
    span: Span


@dataclass(frozen=True, slots=True)
class ModuleNames:
    """The declarations of a module, by their names within it."""

    requests: dict[str, Signature] = field(default_factory=dict)
    quantities: dict[str, QuantityName] = field(default_factory=dict)

    @property
    def all(self) -> tuple[str, ...]:
        """The full names of the requests in the order of declaration."""
        return tuple(signature.name for signature in self.requests.values())


@dataclass(frozen=True, slots=True)
class SymbolTable:
    """The symbol table: all names of a spec, by kind."""

    constants: Constants
    enums: dict[str, Enum]
    modules: dict[str, ModuleNames]
    quantities: dict[str, QuantityName]
    """Top-level posters and latches."""
    defines: dict[str, tree.Define]
    resources: dict[str, ResourceName]
    groups: dict[str, tuple[str, ...]]
    requests: dict[str, Signature]
    """By full name, in the order of declaration."""
    nodes: dict[str, tree.Request]
    """The declaration of each request, by full name."""


@dataclass(frozen=True, slots=True)
class ListedRequest:
    """A request in a list, and the span of its entry there, which `m.*` and groups share among several requests."""

    request: str
    span: Span


def find_module(names: SymbolTable, name: tree.Name, mistakes: Mistakes, hint: str = "") -> ModuleNames | None:
    """Return the module of this name, or None with a mistake noted."""
    found = names.modules.get(name.text)
    if found is None:
        mistakes.unknown(
            "E202", f"unknown module {quote(name.text)}", name.text, name.span, lambda: names.modules, hint
        )
    return found


def find_request(names: SymbolTable, ref: tree.Ref, mistakes: Mistakes) -> Signature | None:
    """Return the request that `m.r` names, or None with a mistake noted."""
    module = find_module(names, ref.module, mistakes)
    if module is None:
        return None
    found = module.requests.get(ref.request.text)
    if found is None:
        name = f"{ref.module.text}.{ref.request.text}"
        if ref.request.text in module.quantities:
            kind = module.quantities[ref.request.text].kind
            known = known_here([request.name for request in module.requests.values()])
            known = known or f"name a request of module {quote(ref.module.text)}, as `{ref.module.text}.REQUEST`"
            mistakes.add("E219", f"{quote(name)} is a {kind}, a request is needed here", ref.span, hint=known)
        else:
            mistakes.unknown(
                "E203", f"unknown request {quote(name)}", name, ref.span, lambda: _near(names, ref.module.text)
            )
    return found


def _near(names: SymbolTable, module: str) -> list[str]:
    """Return the requests of a module; those of the whole spec if it has none."""
    return list(names.modules[module].all) or list(names.requests)


def instances_of(names: SymbolTable, request: str) -> int:
    """Return how many slots a request has."""
    instances = names.nodes[request].instances
    return int(instances.text) if instances else 1


def find_resource(names: SymbolTable, name: tree.Name, mistakes: Mistakes) -> ResourceName | None:
    """Return the resource of this name, or None with a mistake noted."""
    found = names.resources.get(name.text)
    if found is None:
        message = f"unknown resource {quote(name.text)}"
        mistakes.unknown("E205", message, name.text, name.span, lambda: names.resources)
    return found


def listed(names: SymbolTable, node: tree.Listed, mistakes: Mistakes) -> tuple[str, ...]:
    """Return the requests that one entry of a list names, in order; an unknown name is noted, and names none."""
    match node:
        case tree.Ref():
            signature = find_request(names, node, mistakes)
            return (signature.name,) if signature else ()
        case tree.ModuleAll(name):
            module = find_module(names, name, mistakes)
            if module and not module.requests:
                message = f"`{name.text}.*` names no request: module {quote(name.text)} declares none"
                mistakes.add("E413", message, node.span, hint="name the requests, or leave it out")
            return module.all if module else ()
        case tree.GroupName(name):
            if name.text not in names.groups:
                hint = _meant(names, name.text)
                message = f"unknown group {quote(name.text)}"
                mistakes.unknown("E204", message, name.text, name.span, lambda: names.groups, hint)
            return names.groups.get(name.text, ())
        case _:
            assert_never(node)


def _meant(names: SymbolTable, name: str) -> str:
    """Return the advice on a name that is no group: it may be a module, or a request without its module."""
    declaring = (module for module, known in names.modules.items() if name in known.requests)
    if name in ("reject", "wait", "kill"):
        return f"remedies are joined by `or`: `by kill MODULE.REQUEST or {'wait' if name == 'wait' else 'reject'}`"
    full = [f"{name}.*"] if name in names.modules else [f"{module}.{name}" for module in declaring]
    return f"did you mean {quote(full[0])}?" if full else ""


def entries(names: SymbolTable, nodes: Sequence[tree.Listed], mistakes: Mistakes) -> tuple[ListedRequest, ...]:
    """Return the requests of a list in order, groups and `m.*` expanded, without duplicates, which are mistakes."""
    found: dict[str, ListedRequest] = {}
    for node in nodes:
        twice = ""
        for request in listed(names, node, mistakes):
            if request in found:
                twice = twice or request
            else:
                found[request] = ListedRequest(request, node.span)
        if twice:
            mistakes.add("E409", f"{quote(twice)} stands twice in one list", node.span)
    return tuple(found.values())


def requests(names: SymbolTable, nodes: Sequence[tree.Listed], mistakes: Mistakes) -> tuple[str, ...]:
    """Return the names of the requests of a list; as `entries`."""
    if len(nodes) == 1:
        return listed(names, nodes[0], mistakes)  # shared, not copied: a group may be large and used everywhere
    return tuple(entry.request for entry in entries(names, nodes, mistakes))
