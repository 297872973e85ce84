"""The C identifiers of a spec, all made here: legal, of one prefix, each once; the same model gives the same names."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from exover.model.model import Model, Parameter
from exover.model.types import Enum, Type
from exover.ocrd.reasons import reasons

OWN = "exover"
"""The prefix of the runtime; a spec of that name gets another."""

Constant = tuple[str, int]
"""An identifier and its value."""


def prefix(name: str) -> str:
    """Return what the identifiers of a spec begin with: its name, unless that is the runtime's or reserved in C."""
    clean = re.sub(r"\W", "_", name, flags=re.ASCII)
    if not clean or clean.startswith("_") or clean[0].isdigit() or clean.lower() == OWN:
        return f"spec_{clean.lstrip('_')}"
    return clean


@dataclass(frozen=True, slots=True)
class Constants:
    """The enumerators that a host names things by, in the order of their numbers."""

    requests: tuple[Constant, ...]
    posters: tuple[Constant, ...]
    """The variables that can be observed."""
    stocks: tuple[Constant, ...]
    statuses: tuple[Constant, ...]
    values: tuple[Constant, ...]
    """The values of enums, by the parameter, result or poster of that type."""
    reasons: tuple[Constant, ...]


@dataclass
class _Maker:
    """Makes upper-case names with one prefix, and numbers those that would be made twice."""

    start: str
    taken: set[str] = field(default_factory=set)

    def make(self, *parts: str) -> str:
        text = "_".join(re.sub(r"\W", "_", part, flags=re.ASCII) for part in parts)
        wanted = name = f"{self.start}_{text}".upper()
        number = 2
        while name in self.taken:
            name = f"{wanted}_{number}"
            number += 1
        self.taken.add(name)
        return name

    def all(self, *parts: str, of: Iterable[str]) -> tuple[Constant, ...]:
        return tuple((self.make(*parts, name), number) for number, name in enumerate(of))


FIGURES = (
    "MEMORY_BYTES", "TABLE_BYTES", "TESTS", "ACTIONS", "PASSES", "SCRUB_STEPS",
    "REQUESTS", "VARIABLES", "STOCKS", "REASONS", "PARAMS", "STATUSES", "TABLES_H", "NAMES_H",
)  # fmt: skip
"""The macros of every spec, behind its prefix; nothing else gets their names."""


def figure(name: str, what: str) -> str:
    """Return the macro `what` of a spec."""
    assert what in FIGURES
    return f"{prefix(name)}_{what}".upper()


def constants(model: Model, name: str) -> Constants:
    """Return the enumerators of a model whose files are called `name`."""
    maker = _Maker(prefix(name), {figure(name, what) for what in FIGURES})
    requests = maker.all(of=[request.name for request in model.requests])
    variables = [(number, v) for number, v in enumerate(model.variables) if v.kind == "poster"]
    posters = tuple((maker.make("poster", variable.name), number) for number, variable in variables)
    stocks = maker.all("level", of=[resource.name for resource in model.resources if resource.consumable])
    statuses: tuple[Constant, ...] = ()
    values: tuple[Constant, ...] = ()
    for request in model.requests:
        statuses += maker.all("status", request.name, of=request.statuses)
        for parameter in (*request.params, *request.results):
            values += _values(maker, f"{request.name}.{parameter.name}", parameter.type)
    for _, variable in variables:
        values += _values(maker, variable.name, variable.type)
    given = maker.all("reason", of=[reason.rule for reason in reasons(model)])
    return Constants(requests, posters, stocks, statuses, values, given)


def _values(maker: _Maker, owner: str, kind: Type) -> tuple[Constant, ...]:
    return maker.all("value", owner, of=kind.values) if isinstance(kind, Enum) else ()


def parameters(model: Model) -> list[tuple[str, Parameter]]:
    """Return the parameters and results of all requests, with the request, in the order of the tables."""
    return [(request.name, p) for request in model.requests for p in (*request.params, *request.results)]
