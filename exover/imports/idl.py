"""Types of the OMG IDL as GenoM3 uses them, and their types in exo."""

from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import Any

from lark import Token

from exover.dataclass import dataclass
from exover.imports.part import TYPE_WORDS, spelt
from exover.syntax.lex import RESERVED

INTEGERS: Mapping[str, tuple[int, int]] = {
    "octet": (0, 2**8 - 1),
    "short": (-(2**15), 2**15 - 1),
    "unsigned short": (0, 2**16 - 1),
    "long": (-(2**31), 2**31 - 1),
    "unsigned long": (0, 2**32 - 1),
    "long long": (-(2**63), 2**63 - 1),
    "unsigned long long": (0, 2**63 - 1),
}
"""Ranges of the types of integers; exo has no integers above 2^63 - 1."""
Name = tuple[str, ...]
ParseTree = Any
"""A tree of lark, whose children are trees and tokens by the rule that it is named after."""
MAX_ALIASES = 100
"""The most typedefs of typedefs that are followed, which ends cycles."""


@dataclass(frozen=True, slots=True)
class ExoType:
    """The type in exo of a type of the IDL; `text`: None if there is none; `why`: the reason, or what differs."""

    text: str | None
    initial: str = ""
    why: str = ""


@dataclass(frozen=True, slots=True)
class IdlMember:
    """The type of a member or a name, to be resolved from `scope`; `arrays`: how many arrays are around it."""

    type: Any
    scope: Name
    arrays: int


@dataclass(slots=True)
class Types:
    """All declared types and members of structs, by full name; the values of the enums used so far, by name in exo."""

    known: dict[Name, IdlMember] = field(default_factory=dict)
    members: dict[Name, dict[str, IdlMember]] = field(default_factory=dict)
    enums: dict[str, tuple[str, ...]] = field(default_factory=dict)
    _called: dict[Name, str] = field(default_factory=dict)

    def declare(self, node: ParseTree, scope: Name) -> None:
        """Record the types that a declaration of the IDL declares, those inside it too."""
        match node.data:
            case "module":
                name, *inner = node.children
                for each in inner:
                    self.declare(each, (*scope, str(name)))
            case "typedef":
                kind, *declarators = node.children
                self.type(kind, scope)
                for each in declarators:
                    self.known[(*scope, declared(each))] = IdlMember(kind, scope, len(each.children) - 1)
            case "declared":
                self.type(node.children[0], scope)
            case "native":
                self.known[(*scope, str(node.children[0]))] = IdlMember(node, scope, 0)
            case _:
                pass  # constants, exceptions, and structs that are declared elsewhere

    def type(self, node: Any, scope: Name) -> None:
        """Record a struct, union or enum that is declared where a type is used; ignore any other node."""
        if node.data not in ("struct", "union", "enum"):
            return
        name = (*scope, str(node.children[0]))
        self.known[name] = IdlMember(node, scope, 0)
        if node.data == "struct":
            self.members[name] = dict(self.fields(node.children[1:], name))

    def fields(self, nodes: list[Any], scope: Name) -> Iterator[tuple[str, IdlMember]]:
        """Yield the members of a struct or of the IDS, by name."""
        for node in nodes:
            kind, *declarators = node.children
            self.type(kind, scope)
            for each in declarators:
                yield declared(each), IdlMember(kind, scope, len(each.children) - 1)

    def find(self, name: Name, scope: Name) -> Name | None:
        """Return the full name of a type, resolved from the innermost scope outwards; None if it is not declared."""
        if name[0] == "::":
            return name[1:] if name[1:] in self.known else None
        scopes = (scope[:length] for length in range(len(scope), -1, -1))
        return next(((*each, *name) for each in scopes if (*each, *name) in self.known), None)

    def resolved(self, member: IdlMember) -> tuple[IdlMember, Name | None]:
        """Return a type with its aliases resolved, and its full name if it is a struct, union or enum."""
        for _ in range(MAX_ALIASES):
            if member.type.data != "scoped" or member.arrays:
                break
            full = self.find(tuple(map(str, member.type.children)), member.scope)
            if full is None:
                break
            member = self.known[full]
        if member.type.data in ("struct", "union", "enum"):
            return member, (*member.scope, str(member.type.children[0]))
        return member, None

    def element(self, path: list[ParseTree], members: Mapping[str, IdlMember]) -> IdlMember | None:
        """Return the member to which a path of names and indices leads in the IDS; None if there is none."""
        here: Mapping[str, IdlMember] = members
        found: IdlMember | None = None
        for each in path:
            found = here.get(str(each)) if isinstance(each, Token) else self._indexed(found)
            if found is None:
                return None
            here = self.members.get(self.resolved(found)[1] or (), {})
        return found

    def _indexed(self, member: IdlMember | None) -> IdlMember | None:
        """Return an element of an array; None if it is none."""
        found = self.resolved(member)[0] if member else None
        return IdlMember(found.type, found.scope, found.arrays - 1) if found and found.arrays else None

    def exo(self, member: IdlMember) -> ExoType:
        """Return the type in exo of a type of the IDL."""
        member, full = self.resolved(member)
        node = member.type
        if member.arrays:
            return ExoType(None, why="an array")
        match node.data:
            case "base":
                return _base(" ".join(map(str, node.children)))
            case "enum":
                assert full
                values = tuple(map(str, node.children[1:]))
                return ExoType(self._enum(full, values), spelt(values[0]))
            case "scoped":
                name = "::".join(str(each).removeprefix("::") for each in node.children)
                return ExoType(None, why=f"its type `{name}` is declared in no file that was read")
            case "struct" | "union":
                return ExoType(None, why=f"a {node.data}")
            case kind:
                return ExoType(None, why=f"a {kind} type" if kind in ("native", "fixed") else f"a {kind}")

    def _enum(self, full: Name, values: tuple[str, ...]) -> str:
        """Return the name of an enum in exo: its last name, after as many of its scopes as make it unique."""
        if full not in self._called:
            names = ["_".join(full[-length:]) for length in range(1, len(full) + 1)]
            name = next((each for each in names if each not in self.enums), "_".join((*full, str(len(self.enums)))))
            self.enums[name] = values
            self._called[full] = spelt(name, RESERVED | TYPE_WORDS)
        return self._called[full]


def _base(name: str) -> ExoType:
    if name == "boolean":
        return ExoType("bool", "false")
    if name in ("float", "double"):
        return ExoType("real", "0")
    if name in INTEGERS:
        low, high = INTEGERS[name]
        why = f"exo has no integers above {high}" if name == "unsigned long long" else ""
        return ExoType(f"int in {low} .. {high}", "0", why)
    return ExoType(None, why=f"`{name}` is none of exo")


def declared(declarator: ParseTree) -> str:
    """Return the name of a declarator."""
    name = declarator.children[0]
    assert isinstance(name, Token)
    return str(name)
