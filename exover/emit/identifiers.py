"""The C identifiers of a spec: all are legal, distinct and of one prefix; the same model gives the same names."""

import re
from collections.abc import Collection, Iterable
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter, Request
from exover.model.types import Enum
from exover.ocrd.reasons import reasons

OWN = "exover"
"""The prefix of the runtime; a spec of that name gets another."""

NamedConstant = tuple[str, int]
"""An identifier and its value."""


def prefix(name: str) -> str:
    """Return the prefix of a spec's identifiers: its name, or `spec_NAME` if that is the runtime's or reserved in C."""
    clean = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not clean or clean.startswith("_") or clean[0].isdigit() or clean.lower() == OWN:
        return f"spec_{clean.lstrip('_')}"
    return clean


@dataclass(frozen=True, slots=True)
class Enumeration:
    """An enum type and its enumerators."""

    type: str
    constants: tuple[NamedConstant, ...]


@dataclass(frozen=True, slots=True)
class Call:
    """The function that raises an event, and the enumerator of that event in a buffer."""

    function: str
    event: str


@dataclass(frozen=True, slots=True)
class RequestNames:
    """The names in the typed API that belong to one request."""

    args: str
    results: str
    statuses: Enumeration
    ask: Call
    ok: Call
    failed: Call
    interrupted: Call
    abort: Call
    abort_waiting: Call
    read: str
    """The function that reads the arguments of a slot."""
    slot: str
    """The function that returns what a slot holds."""
    place: str
    """The function that returns what the waiting place holds."""


@dataclass(frozen=True, slots=True)
class SpecIdentifiers:
    """The identifiers of a spec for a host, each tuple in the order of the numbers in the tables."""

    requests: tuple[NamedConstant, ...]
    posters: tuple[NamedConstant, ...]
    """The posters: their numbers are among all variables."""
    stocks: tuple[NamedConstant, ...]
    reasons: tuple[NamedConstant, ...]
    enums: dict[Enum, Enumeration]
    """By type, those of parameters, results and posters."""
    typed: tuple[RequestNames, ...]
    observe: tuple[Call, ...]
    level: tuple[Call, ...]
    taken: frozenset[str]
    """All of these names, and those that the files of every spec define."""


@dataclass
class _Maker:
    """Makes names with one prefix, constants in upper case; a name that is taken gets `_2`, `_3`, …"""

    start: str
    taken: set[str] = field(default_factory=set)

    def make(self, *parts: str) -> str:
        """Return the name of a constant."""
        return self._new("_".join([self.start, *parts]).upper())

    def name(self, *parts: str) -> str:
        """Return the name of a type or a function."""
        return self._new("_".join([self.start, *parts]))

    def call(self, *parts: str) -> Call:
        return Call(self.name(*parts), self.make("event", *parts))

    def _new(self, text: str) -> str:
        wanted = name = re.sub(r"\W", "_", text, flags=re.ASCII)
        number = 2
        while name in self.taken:
            name = f"{wanted}_{number}"
            number += 1
        self.taken.add(name)
        return name

    def all(self, *parts: str, of: Iterable[str]) -> tuple[NamedConstant, ...]:
        return tuple((self.make(*parts, name), number) for number, name in enumerate(of))


FIGURES = (
    "MEMORY_BYTES", "TABLE_BYTES", "RECORD_BYTES", "TESTS", "ACTIONS", "PASSES", "STACK_BYTES", "SCRUB_STEPS",
    "REQUESTS", "VARIABLES", "STOCKS", "REASONS", "PARAMS", "ROOM", "TABLES_H",
    "NAMES_H", "API_H",
)  # fmt: skip
"""The macros of every spec, each after its prefix; no other identifier gets these names."""


OWN_NAMES = (
    "tables", "reals", "words", "request_names", "variable_names", "stock_names", "reason_names", "reason_because",
    "param_names", "param_values", "variable_values", "status_names",
    "checker", "answer", "event", "event_kind", "start", "start_stopped", "resume", "cycle",
    "start_recorded", "record",
)  # fmt: skip
"""The other identifiers of every spec, each after its prefix."""
RESERVED = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern", "float",
    "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed", "sizeof",
    "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile", "while", "alignas", "alignof",
    "asm", "constexpr", "nullptr", "static_assert", "thread_local", "typeof", "typeof_unqual", "fortran", "and",
    "and_eq", "bitand", "bitor", "catch", "class", "compl", "concept", "const_cast", "consteval", "constinit",
    "char8_t", "char16_t", "char32_t", "co_await", "co_return", "co_yield", "decltype", "delete", "dynamic_cast",
    "explicit", "export", "friend",
    "mutable", "namespace", "new", "noexcept", "not", "not_eq", "operator", "or", "or_eq", "private", "protected",
    "public", "reinterpret_cast", "requires", "static_cast", "template", "this", "throw", "try", "typeid", "typename",
    "using", "virtual", "wchar_t", "xor", "xor_eq", "bool", "true", "false", "errno", "stdin", "stdout", "stderr",
    "complex", "imaginary", "noreturn", "math_errhandling", "L_tmpnam", "L_ctermid", "L_cuserid", "P_tmpdir",
    "st_atime", "st_ctime", "st_mtime", "h_errno", "h_addr", "d_fileno", "msg_cbytes", "AF_DECnet", "PF_DECnet",
    "unix", "linux", "i386", "near", "far", "size_t", "ptrdiff_t", "r2c", "answer", "slot", "status", "kind", "of",
    "values", "answered",
))  # fmt: skip
"""Names that no parameter gets: keywords of C and C++, macros that a host may define, and locals of emitted code."""
FAMILIES = re.compile(
    r"exover(_\w*)?|u?int\w*_t|(PRI|SCN)[a-zX]\w*|(sa|si|s6|sigev|if[acr])_\w*|M_[A-Z0-9_]+(l|f\d*x?)|_\w*", re.ASCII
)
"""Patterns of names that no parameter gets: of the runtime, and reserved for standard headers of C and POSIX."""


def figure(name: str, what: str) -> str:
    """Return the name of the macro `what`, one of FIGURES, of a spec."""
    assert what in FIGURES
    return f"{prefix(name)}_{what}".upper()


def constants(model: Model, name: str) -> SpecIdentifiers:
    """Return the identifiers of a model whose files are called `name`."""
    start = prefix(name)
    maker = _Maker(start, {figure(name, what) for what in FIGURES} | {f"{start}_{own}" for own in OWN_NAMES})
    index = ModelIndex(model)
    requests = maker.all(of=index.requests)
    posters = tuple((maker.make("poster", variable.name), number) for number, variable in index.posters)
    stocks = maker.all("level", of=index.stocks)
    given = maker.all("reason", of=[reason.rule for reason in reasons(model)])
    return SpecIdentifiers(
        requests,
        posters,
        stocks,
        given,
        _enums(model, maker),
        tuple(_typed(maker, request) for request in model.requests),
        tuple(maker.call("observe", variable.name) for _, variable in index.posters),
        tuple(maker.call("level", stock) for stock in index.stocks),
        frozenset(maker.taken),
    )


def _enums(model: Model, maker: _Maker) -> dict[Enum, Enumeration]:
    """Return the enum types, named as the spec declares them, else after the first parameter or poster of the type."""
    owners = [(f"{request}.{parameter.name}", parameter.type) for request, parameter in parameters(model)]
    owners += [(variable.name, variable.type) for variable in model.variables if variable.kind == "poster"]
    declared = {Enum(values): name for name, values in reversed(model.vocabulary.enums.items())}
    found: dict[Enum, Enumeration] = {}
    for owner, kind in owners:
        if isinstance(kind, Enum) and kind not in found:
            title = declared.get(kind, owner)
            found[kind] = Enumeration(maker.name(title), maker.all(title, of=kind.values))
    return found


def _typed(maker: _Maker, request: Request) -> RequestNames:
    name = request.name
    unsaid = (maker.make("status", name, "unsaid"), -1)
    return RequestNames(
        maker.name(name, "args"),
        maker.name(name, "results"),
        Enumeration(maker.name(name, "status"), (unsaid, *maker.all("status", name, of=request.statuses))),
        maker.call("ask", name),
        maker.call("report", name, "ok"),
        maker.call("report", name, "failed"),
        maker.call("report", name, "interrupted"),
        maker.call("abort", name),
        maker.call("abort_waiting", name),
        maker.name("args", name),
        maker.name("slot", name),
        maker.name("place", name),
    )


def fields(params: Iterable[Parameter], taken: Collection[str]) -> tuple[str, ...]:
    """Return the identifiers of parameters or results: their names in the spec, or others where these are not free.

    `taken`: names that are not free where they are used, beside those that C excludes.
    """
    found: list[str] = []
    for parameter in params:
        name = parameter.name
        if name in RESERVED or name in taken or FAMILIES.fullmatch(name) or name.isupper():
            name = f"p_{name}"
        while name in found:
            name += "_"
        found.append(name)
    return tuple(found)


def parameters(model: Model) -> list[tuple[str, Parameter]]:
    """Return the parameters and results of all requests, with the request, in the order of the tables."""
    return [(request.name, p) for request in model.requests for p in (*request.params, *request.results)]
