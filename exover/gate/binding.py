"""A binding: it maps outer calls, fields and statuses to requests, values and outcomes (docs/binding.md)."""

from collections.abc import Mapping
from dataclasses import field
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import combinations
from typing import Any, Literal

from exover.dataclass import dataclass
from exover.gate.fields import FieldPath, ValueField, is_list, same, select
from exover.model.event import Args

BindingKind = Literal["tool", "action", "service"]
KINDS: tuple[BindingKind, ...] = ("tool", "action", "service")
WatchKind = Literal["tool", "notification", "topic"]
SOURCES: tuple[WatchKind, ...] = ("tool", "notification", "topic")
StatusMeaning = Literal["running", "ok", "interrupted", "failed"]
MEANINGS: tuple[StatusMeaning, ...] = ("running", "ok", "interrupted", "failed")
STOP = 5.0
"""The default of `stop`: seconds within which what is cancelled has to report."""


@dataclass(frozen=True, slots=True)
class Defaults:
    """The keys of `[gate]` that hold for the whole binding."""

    spec: str
    unbound: Literal["deny", "pass"]
    passed: tuple[str, ...]
    hide: bool
    methods: Literal["pass", "deny"]
    max_line: int
    client_death: Literal["abort", "leave"]


@dataclass(frozen=True, slots=True)
class CancelTool:
    """The tool call that stops a request; `ends` iff its response says that the request has stopped."""

    tool: str
    arguments: Mapping[str, Any]
    ends: bool


@dataclass(frozen=True, slots=True)
class ReportBinding:
    """How the end of a request is reported: where the status is, what each status means, where the results are.

    Without a `watch` the response reports the end. Without a `status`, success of the protocol is ok, an error failed.
    """

    watch: str | None = None
    status: FieldPath | None = None
    meanings: Mapping[tuple[bool, Any], StatusMeaning] = field(default_factory=dict)
    fails: Mapping[tuple[bool, Any], str] = field(default_factory=dict)
    results: tuple[ValueField, ...] = ()

    def meaning(self, status: Any) -> StatusMeaning | None:
        """Return what a status means; None if the binding does not list it."""
        return self.meanings.get(key_of(status))

    def failure(self, status: Any) -> str | None:
        """Return the name in `fails` of the request that a status stands for; None if there is none."""
        return self.fails.get(key_of(status))


def key_of(status: Any) -> tuple[bool, Any]:
    """Return the key by which a status is looked up: true and 1 have different keys; objects and lists share one."""
    return isinstance(status, bool), status if isinstance(status, str | int | float) else None


@dataclass(frozen=True, slots=True)
class RequestBinding:
    """The outer and the inner interface that one request is bound to; times in seconds."""

    request: str
    kind: BindingKind
    outer: str
    inner: str
    type: str | None = None
    when: tuple[tuple[FieldPath, Any], ...] = ()
    arguments: tuple[ValueField, ...] = ()
    constants: tuple[tuple[FieldPath, Any], ...] = ()
    wait: float | None = None
    answer: float | None = None
    stop: float = STOP
    cancel: CancelTool | None = None
    started: bool = False
    starts_idle: bool = False
    report: ReportBinding = ReportBinding()
    refused: tuple[tuple[FieldPath, Any], ...] = ()
    """Values, by path, of a service's response to a refused call; `{reason}` in a text stands for rule and reason."""

    @property
    def clash(self) -> tuple[FieldPath, FieldPath] | None:
        """Two paths of a call that the gate makes itself, one equal to or within the other; None if there are none."""
        for first, second in combinations(self._made, 2):
            shared = min(len(first), len(second))
            if first[:shared] == second[:shared]:
                return first, second
        return None

    @property
    def gap(self) -> FieldPath | None:
        """The path of a list of which a call that the gate makes itself has not all elements; None if there is none."""
        keys: dict[FieldPath, set[str]] = {}
        for path in self._made:
            for length in range(1, len(path)):
                keys.setdefault(path[:length], set()).add(path[length])
        return next(
            (path for path, found in keys.items() if any(map(str.isdecimal, found)) and not is_list(found)), None
        )

    @property
    def _made(self) -> list[FieldPath]:
        fixed = [
            path for path, _ in dict.fromkeys((path, key_of(value)) for path, value in (*self.when, *self.constants))
        ]
        return [*(each.path for each in self.arguments), *fixed]

    def own_values(self, args: Args) -> list[tuple[FieldPath, Any]]:
        """Return the values, by path, of a call that the gate makes itself."""
        given = [(each.path, each.write(value)) for each, value in zip(self.arguments, args, strict=True)]
        return [*given, *self.when, *self.constants]

    def meant(self, arguments: Any) -> bool:
        """Return whether a call with these outer arguments is of this request."""
        return not self.when or all(same(select(arguments, path), value) for path, value in self.when)


@dataclass(frozen=True, slots=True)
class Watch:
    """A source of readings; `source` names a tool, called again `every` seconds, a notification or a topic."""

    name: str
    kind: WatchKind
    source: str
    type: str | None = None
    arguments: Mapping[str, Any] = field(default_factory=dict)
    every: float = 0.1
    stale: float = 2.0
    latched: bool = False


@dataclass(frozen=True, slots=True)
class PosterBinding:
    """Where a poster, or the level of a consumable resource, is read."""

    poster: str
    watch: str
    field: ValueField


@dataclass(frozen=True)
class Binding:
    """A binding without a mistake, for one spec; all in the order of the file."""

    gate: Defaults
    requests: tuple[RequestBinding, ...]
    watches: tuple[Watch, ...]
    posters: tuple[PosterBinding, ...]

    @property
    def longest_stop(self) -> float:
        """The longest `stop` of all requests, in seconds; 0 without requests."""
        return max((bound.stop for bound in self.requests), default=0.0)

    @cached_property
    def below(self) -> frozenset[str]:
        """Inner tools that carry out or stop a request and are no outer name: only the gate may call them."""
        tools = [bound for bound in self.requests if bound.kind == "tool"]
        called = {bound.inner for bound in tools} | {bound.cancel.tool for bound in tools if bound.cancel}
        return frozenset(called - {bound.outer for bound in tools})

    def of(self, request: str) -> RequestBinding | None:
        """Return the binding of a request; None if it is not bound."""
        return next((bound for bound in self.requests if bound.request == request), None)

    def called(self, kind: BindingKind, outer: str) -> tuple[RequestBinding, ...]:
        """Return the bindings of an outer name of this kind, in the order of the file; `when` tells them apart."""
        return tuple(bound for bound in self.requests if bound.kind == kind and bound.outer == outer)

    def passes(self, outer: str) -> bool:
        """Return whether calls of this outer name, which is bound to no request, are passed on without a decision."""
        if outer in self.below:
            return False
        return self.gate.unbound == "pass" or any(matches(outer, pattern) for pattern in self.gate.passed)

    def watched_by(self, watch: str) -> tuple[RequestBinding, ...]:
        """Return the bindings of the requests whose end this watch reports."""
        return tuple(bound for bound in self.requests if bound.report.watch == watch)


def matches(outer: str, pattern: str) -> bool:
    """Return whether an outer name is one that a pattern of `pass` means, in which `*` and `?` stand for characters."""
    return fnmatchcase(outer, pattern.replace("[", "[[]"))
