"""GenoM3 descriptions to parts of specs (docs/imports.md)."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from functools import cache
from pathlib import Path

from lark import Lark, Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from exover.dataclass import dataclass
from exover.imports.idl import ExoType, IdlMember, Name, ParseTree, Types, declared
from exover.imports.part import (
    TYPE_WORDS,
    Imported,
    ImportedField,
    PartText,
    UnreadableDescription,
    module_head,
    near,
    spelt,
)
from exover.imports.preprocess import Preprocessed
from exover.syntax.lex import RESERVED

ALL = "all"
WRITTEN_FREELY = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text",
    "CHAR": "a character",
    "ROOT": "`::`",
    "CODELS_REQUIRE": "`codels-require`",
    "CLOCK_RATE": "`clock-rate`",
}
"""The words for the terminals of the grammar that are patterns."""
MOST_EXPECTED = 6
"""The most expected tokens that an error message lists."""


@dataclass(slots=True)
class Service:
    """An activity, a function or an attribute, and where it is declared; `lists`: services by kind of list."""

    kind: str
    name: str
    place: str
    doc: list[str] = field(default_factory=list)
    parameters: list[tuple[str, ImportedField]] = field(default_factory=list)
    throws: list[str] = field(default_factory=list)
    lists: dict[str, list[Token]] = field(default_factory=dict)

    @property
    def signature(self) -> tuple[str, list[tuple[str, str, str | None]]]:
        """Its kind, and the direction, name and type of each parameter."""
        return self.kind, [(direction, each.name, each.kind) for direction, each in self.parameters]


@dataclass(slots=True)
class GenomComponent:
    """A component, with what the interfaces that it provides declare."""

    name: str
    place: str
    doc: list[str] = field(default_factory=list)
    throws: list[str] = field(default_factory=list)
    ids: dict[str, IdlMember] = field(default_factory=dict)
    services: dict[str, Service] = field(default_factory=dict)
    ports: list[ParseTree] = field(default_factory=list)
    unknown: list[Token] = field(default_factory=list)
    """The interfaces that it provides and no file declares."""


@cache
def _grammar() -> Lark:
    text = Path(__file__).with_name("genom.lark").read_text("utf-8")
    return Lark(text, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def import_genom(given: Preprocessed, head: str) -> Imported:
    """Return a part with a module for each component that the file itself describes; `head`: its first lines.

    Raises `UnreadableDescription` if the text is no GenoM3 description, or describes no component.
    """
    try:
        return _Importer(given).imported(_parsed(given), head)
    except RecursionError as error:
        raise UnreadableDescription(given.name, "modules or structs are nested too deep") from error


def _parsed(given: Preprocessed) -> ParseTree:
    line: int
    try:
        return _grammar().parse(given.text)
    except UnexpectedCharacters as error:
        found, place = repr(given.text[error.pos_in_stream or 0]), f"{given.place(error.line or 1)}:{error.column}"
        raise UnreadableDescription(place, f"unexpected {found}") from error
    except UnexpectedToken as error:
        found = f"`{error.token}`" if error.token.type != "$END" else "the end of the file"
        line = given.text.count("\n") + 1 if error.token.type == "$END" else error.line or 1
        place = f"{given.place(line or 1)}:{max(error.column, 1)}"
        raise UnreadableDescription(place, f"unexpected {found}; {_expected(error)}") from error
    except UnexpectedInput as error:
        raise UnreadableDescription(given.place(1), "this is no GenoM3 description") from error


def _expected(error: UnexpectedToken) -> str:
    """Return the expected tokens in words, those of WRITTEN_FREELY first."""
    accepts = {name for name in error.accepts or () if name != "$END"}
    words = sorted(_grammar().get_terminal(name).pattern.value for name in accepts - WRITTEN_FREELY.keys())
    kinds = [kind for name, kind in WRITTEN_FREELY.items() if name in accepts]
    shown = [*dict.fromkeys(kinds), *(f"`{word}`" for word in words)]
    return f"expected {', '.join(shown[:MOST_EXPECTED])}{', …' * (len(shown) > MOST_EXPECTED)}"


class _Importer:
    """The state of one import: the declared types, the interfaces, the IDS of each, and the part so far."""

    def __init__(self, given: Preprocessed) -> None:
        self._given = given
        self._types = Types()
        self._interfaces: dict[str, ParseTree] = {}
        self._ids: dict[str, dict[str, IdlMember]] = {}
        self._part = PartText()

    def _place(self, node: ParseTree) -> str:
        return self._given.place((node.line if isinstance(node, Token) else node.meta.line) or 1)

    def imported(self, tree: ParseTree, head: str) -> Imported:
        components = []
        for node in tree.children:
            if node.data == "interface":
                self._interfaces[str(node.children[0])] = node
                self._declare(node)
            elif node.data == "component":
                self._declare(node)
                if self._given.is_own(node.children[0].line):
                    components.append(node)
            else:
                self._types.declare(node, ())
        if not components:
            raise UnreadableDescription(self._given.name, "the file describes no component")
        for missing in self._given.missing:
            self._part.leave_open(self._given.name, missing)
        bodies = [self._component(node) for node in components]
        self._part.lines += self._enums()
        for body in bodies:
            self._part.lines += body
        return self._part.finished(self._given.name, head)

    def _declare(self, node: ParseTree) -> None:
        name, *exports = node.children
        for each in exports:
            if each.data == "ids":
                ids = self._ids.setdefault(str(name), {})
                ids.update(self._types.fields(each.children, (str(name), "ids")))
            else:
                self._types.declare(each, (str(name),))

    def _enums(self) -> Iterator[str]:
        for name, values in self._types.enums.items():
            place = self._given.name
            shown = self._part.name(name, place, RESERVED | TYPE_WORDS)
            yield f"enum {shown} {{ {', '.join(self._part.name(value, place) for value in values)} }}"

    # ---- components ----

    def _component(self, node: ParseTree) -> list[str]:
        """Return the lines of a module."""
        found = GenomComponent(str(node.children[0]), self._place(node.children[0]))
        self._read(found, node, set())
        outer, self._part.lines = self._part.lines, []
        name = self._part.name(found.name, found.place)
        for each in found.unknown:
            self._part.leave_open(
                self._place(each),
                f"interface `{each}` is declared in no file that was read: what it provides is left out",
            )
        if found.throws:
            listed = ", ".join(dict.fromkeys(found.throws))
            self._part.leave_open(found.place, f"the component may throw {listed}, no matter what runs")
        for port in found.ports:
            self._port(port, (found.name,))
        for service in found.services.values():
            self._service(service, found, name)
        lines, self._part.lines = self._part.lines, outer
        return [module_head(name, found.doc[0] if found.doc else ""), *lines, "}"]

    def _read(self, found: GenomComponent, node: ParseTree, seen: set[str]) -> None:
        """Read into `found` what a component or interface declares, and the interfaces that it provides."""
        scope = (str(node.children[0]),)
        found.ids.update(self._ids.get(scope[0], {}))
        for each in node.children[1:]:
            match each.data:
                case "doc":
                    found.doc += [_text(each)]
                case "throws":
                    found.throws += _throws([each])
                case "port":
                    found.ports.append(each)
                case "service" | "attribute":
                    _join(found.services, self._declared(each, scope, found.ids))
                case "provides":
                    self._provide(found, each, seen)
                case _:
                    pass

    def _provide(self, found: GenomComponent, node: ParseTree, seen: set[str]) -> None:
        for name in node.children:
            if name not in self._interfaces:
                found.unknown.append(name)
            elif name not in seen:
                seen.add(str(name))
                self._read(found, self._interfaces[name], seen)

    # ---- services ----

    def _declared(self, node: ParseTree, scope: Name, ids: Mapping[str, IdlMember]) -> Service:
        children = list(node.children)
        kind = "attribute" if node.data == "attribute" else str(children.pop(0).children[0])
        name = children.pop(0)
        service = Service(kind, str(name), self._place(name))
        for each in children:
            match each.data:
                case "parameter":
                    _, type_, declarator, *_ = each.children
                    member = IdlMember(type_, scope, len(declarator.children) - 1)
                    self._types.type(type_, scope)
                    self._parameter(service, each, declared(declarator), member)
                case "element":
                    self._element(service, each, ids)
                case "doc":
                    service.doc.append(_text(each))
                case "throws":
                    service.throws += _throws([each])
                case "interrupts" | "after" | "before":
                    service.lists.setdefault(each.data, []).extend(each.children)
                case _:
                    pass
        return service

    def _element(self, service: Service, node: ParseTree, ids: Mapping[str, IdlMember]) -> None:
        """Read a parameter of an attribute, whose type is that of an element of the IDS."""
        path = [each for part in node.find_data("path") for each in part.children]
        names = [str(each) for each in path if isinstance(each, Token)]
        alias = next((str(each.children[0]) for each in node.find_data("alias")), "")
        member = self._types.element(path, ids) if path else None
        self._parameter(service, node, alias or names[-1], member)

    def _parameter(self, service: Service, node: ParseTree, name: str, member: IdlMember | None) -> None:
        direction = str(node.children[0].children[0])
        kind = self._types.exo(member) if member else ExoType(None, why="it is no element of the IDS that was read")
        service.parameters.append((direction, ImportedField(name, kind.text, self._place(node), kind.why)))

    def _service(self, service: Service, component: GenomComponent, module: str) -> None:
        """Add the request for a service, with its comments and clauses."""
        part = self._part
        if service.doc:
            part.say(service.doc[0])
        if service.kind != "activity":
            part.say(f"{near(service.place)}: {service.kind}: it ends at once")
        going = [each for direction, each in service.parameters if direction in ("in", "inout")]
        coming = [each for direction, each in service.parameters if direction in ("out", "inout")]
        params = part.fields(going)
        results = part.fields(coming, [each.name for each in going if each.kind])
        fails = ", ".join(dict.fromkeys(part.name(name, service.place) for name in service.throws))
        clauses = list(self._clauses(service, component, module))
        head = f"request {part.name(service.name, service.place)}({params})"
        head += f" returns ({results})" if results else ""
        head += f" fails ({fails})" if fails else ""
        part.lines += [f"{head} {{", *clauses, "}"] if clauses else [f"{head};"]

    def _clauses(self, service: Service, component: GenomComponent, module: str) -> Iterator[str]:
        for word, names in service.lists.items():
            listed = self._listed(service, component, word, names)
            shown = ["self" if each == service.name else f"{module}.{spelt(each)}" for each in listed]
            if shown:
                yield f"{word} {', '.join(shown)};"

    def _listed(self, service: Service, component: GenomComponent, word: str, names: Iterable[Token]) -> list[str]:
        """Return the services that a list names; those that exo cannot express are left out with a remark."""
        found: dict[str, None] = {}
        for name in names:
            if name == ALL:
                found.update(dict.fromkeys(self._all(service, component, word)))
            elif reason := _refused(service, component, word, str(name)):
                self._part.leave_open(self._place(name), f"`{word} {name}` of `{service.name}` is left out: {reason}")
            else:
                found[str(name)] = None
        return list(found)

    def _all(self, service: Service, component: GenomComponent, word: str) -> list[str]:
        return [name for name in component.services if not _refused(service, component, word, name)]

    # ---- ports ----

    def _port(self, node: ParseTree, scope: Name) -> None:
        multiple = any(isinstance(each, Token) and each.type == "MULTIPLE" for each in node.children)
        direction, kind, name, *_ = (each for each in node.children if not _is_multiple(each))
        place = self._place(name)
        if str(direction.children[0]) == "in":
            self._part.say(f"{near(place)}: port in {name}: what another component publishes is a poster of that one")
            return
        found = self._types.exo(IdlMember(kind, scope, 0))
        why = "it is published under many names" if multiple else found.why
        if multiple or found.text is None:
            self._part.leave_open(place, f"port out `{name}` is left out: {why}")
            return
        if why:
            self._part.leave_open(place, f"port out `{name}` is taken for `{found.text}`: {why}")
        self._part.poster(str(name), found.text, found.initial, place)


def _join(services: dict[str, Service], service: Service) -> None:
    """Add a service, or what another declaration of it says besides, as in GenoM.

    Raises `UnreadableDescription` if the two differ in kind or parameters.
    """
    first = services.setdefault(service.name, service)
    if first is service:
        return
    if first.signature != service.signature:
        reason = f"`{service.name}` is declared with another kind or other parameters at {near(first.place)}"
        raise UnreadableDescription(service.place, reason)
    first.doc += service.doc
    first.throws += service.throws
    for word, names in service.lists.items():
        first.lists.setdefault(word, []).extend(names)


def _is_multiple(node: ParseTree) -> bool:
    return isinstance(node, Token) and node.type == "MULTIPLE"


def _refused(service: Service, component: GenomComponent, word: str, name: str) -> str:
    """Return why the list `word` of `service` cannot have service `name`; empty if it can."""
    other = component.services.get(name)
    if other is None:
        return "no such service is declared in what was read"
    if word == "interrupts" and other.kind != "activity":
        return f"a{'n' * (other.kind[0] == 'a')} {other.kind} ends at once"
    if word != "interrupts" and name == service.name:
        return "it is the service itself"
    return ""


def _text(node: ParseTree) -> str:
    return "".join(str(each)[1:-1].replace('\\"', '"').replace("\\\\", "\\") for each in node.children)


def _throws(nodes: list[ParseTree]) -> list[str]:
    return [str(each.children[-1]) for node in nodes for each in node.children]
