"""The model of a spec: what the text means, with all names and types resolved and all shorthand spelled out.

Everything stands in the order of the text. `place` numbers guards, consumptions and rules of the whole file in that
order; the order of demands in a decision is the order of places (docs/language.md section 4).
"""

from collections.abc import Container, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property
from operator import itemgetter
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.expression import Cond
from exover.model.types import Int, Type, Value


@dataclass(frozen=True, slots=True)
class Location:
    """Where a thing was declared: file name, line and column, both from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        """Return `file:line:column`, as messages write it."""
        return f"{self.file}:{self.line}:{self.column}"


NOWHERE = Location("", 0, 0)


@dataclass(frozen=True, slots=True)
class Reject:
    """Refuse the newcomer."""


@dataclass(frozen=True, slots=True)
class Wait:
    """Let the newcomer wait."""


@dataclass(frozen=True, slots=True)
class Kill:
    """Kill the running slots of the listed requests, in the order of the list."""

    requests: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class KillSlot:
    """Kill the slot that the copy of the rule is for (`fail when`)."""


KillRemedy = Kill | KillSlot
Remedy = Reject | Wait | KillRemedy


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter or a returned value of a request."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class Variable:
    """A poster or a module state, by its full name; `fallback`: what replaces a broken reading of a poster."""

    name: str
    kind: Literal["poster", "state"]
    type: Type
    initial: Value
    fallback: Value | None = None
    location: Location = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Latch:
    """A bool that its condition sets and the report `ok` of a request in `resets` clears."""

    name: str
    condition: Cond
    resets: tuple[str, ...]
    location: Location = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Resource:
    """A resource. A renewable one also stands among the rules, under its own name; `remedies` default to reject."""

    name: str
    capacity: int
    consumable: bool
    initial: int
    remedies: tuple[Remedy, ...]
    because: str | None = None
    location: Location = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Share:
    """`uses` or `produces`: an amount of a resource, counted iff the arguments satisfy `when`."""

    resource: str
    amount: int
    when: Cond | None = None


@dataclass(frozen=True, slots=True)
class Consumption:
    """`consumes`: taken at launch; a shortage is a demand at this place."""

    resource: str
    amount: int
    when: Cond | None
    because: str | None
    place: int
    location: Location = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class Guard:
    """`check`, `wait until` or `settle until`; `after` and `before` become checks."""

    kind: Literal["check", "wait", "settle"]
    name: str
    condition: Cond
    because: str | None
    place: int
    location: Location = field(default=NOWHERE, compare=False)

    @property
    def objection(self) -> Literal["reject", "wait", "settle"]:
        """The verdict on a newcomer if the condition of the guard is false."""
        return "reject" if self.kind == "check" else self.kind


@dataclass(frozen=True, slots=True)
class SetState:
    """Give a module state a value."""

    state: str
    value: Value


@dataclass(frozen=True, slots=True)
class Forget:
    """Empty the past of the listed requests."""

    requests: tuple[str, ...]


Effect = SetState | Forget


@dataclass(frozen=True, slots=True)
class Request:
    """A request of a module, by its full name `module.request`, with all its clauses in the order of the text."""

    name: str
    params: tuple[Parameter, ...] = ()
    results: tuple[Parameter, ...] = ()
    statuses: tuple[str, ...] = ()
    instances: int = 1
    interrupts_self: bool = False
    guards: tuple[Guard, ...] = ()
    shares: tuple[Share, ...] = ()
    consumptions: tuple[Consumption, ...] = ()
    productions: tuple[Share, ...] = ()
    on_launch: tuple[Effect, ...] = ()
    on_ok: tuple[Effect, ...] = ()
    on_failed: tuple[Effect, ...] = ()
    on_interrupted: tuple[Effect, ...] = ()
    location: Location = field(default=NOWHERE, compare=False)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects of its launch and of its reports, in this order."""
        return (*self.on_launch, *self.on_ok, *self.on_failed, *self.on_interrupted)

    def without_rules(self, names: Container[str]) -> "Request":
        """Return the request without the rules of these names: `interrupts_self` is unset if its rule is among them."""
        itself = self.interrupts_self and interruption(self.name, self.name) in names
        return replace(self, interrupts_self=False) if itself else self


def interruption(owner: str, target: str) -> str:
    """Return the name of the rule by which a request interrupts another one, or itself."""
    return f"{owner}.interrupts.{'self' if target == owner else target}"


@dataclass(frozen=True, slots=True)
class Rule:
    """`forbid condition by remedies`, the form to which every rule is reduced.

    With `slot_of`, one rule for each slot of that request: its F is that the slot is active and `condition` holds of
    its arguments, which `Param` reads. Rules of one name (the pairs of a mutex) are one subject of the checks.
    """

    name: str
    kind: Literal["mutex", "over", "limit", "forbid", "fail", "interrupts", "resource"]
    condition: Cond
    remedies: tuple[Remedy, ...]
    because: str | None
    place: int
    slot_of: str | None = None
    location: Location = field(default=NOWHERE, compare=False)

    @property
    def kills(self) -> list[KillRemedy]:
        """Its remedies that kill, in their order."""
        return [each for each in self.remedies if isinstance(each, KillRemedy)]


@dataclass(frozen=True, slots=True)
class Launch:
    """`launch request(args) when condition`: a required launch."""

    name: str
    request: str
    args: tuple[Value, ...]
    condition: Cond
    because: str | None
    location: Location = field(default=NOWHERE, compare=False)


@dataclass(frozen=True, slots=True)
class SourceNames:
    """Names of the spec that the rest of the model no longer has, kept because properties files may use them.

    A const is an int iff it is written as one; an enum value is its name. `enum_values`: the values of all enums;
    `enums`: those of the named ones; `modules`: all modules, those without requests included.
    """

    consts: dict[str, Value] = field(default_factory=dict)
    defines: dict[str, Cond] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    enum_values: frozenset[str] = frozenset()
    enums: dict[str, tuple[str, ...]] = field(default_factory=dict)
    modules: tuple[str, ...] = ()


@dataclass(frozen=True)
class Model:
    """A checked spec. Names are unique, every name that is referred to exists, and `rules` are in the order of places.

    `vocabulary` holds the names that only properties files use.
    """

    name: str
    requests: tuple[Request, ...]
    variables: tuple[Variable, ...]
    latches: tuple[Latch, ...]
    resources: tuple[Resource, ...]
    rules: tuple[Rule, ...]
    launches: tuple[Launch, ...]
    vocabulary: SourceNames = field(default=SourceNames(), compare=False)

    @cached_property
    def request(self) -> dict[str, Request]:
        """The requests by name."""
        return {request.name: request for request in self.requests}

    @cached_property
    def variable(self) -> dict[str, Variable]:
        """The posters and states by full name."""
        return {variable.name: variable for variable in self.variables}

    @cached_property
    def resource(self) -> dict[str, Resource]:
        """The resources by name."""
        return {resource.name: resource for resource in self.resources}

    @cached_property
    def observable(self) -> dict[str, Type]:
        """The types of what can be observed, by name: of the posters, then of the levels of consumable resources."""
        posters = {variable.name: variable.type for variable in self.variables if variable.kind == "poster"}
        return posters | {each.name: Int(0, each.capacity) for each in self.resources if each.consumable}

    def rules_named(self, name: str) -> Sequence[Rule]:
        """Return the rules of a name, in the order of the text."""
        return self._rules.get(name, ())

    @cached_property
    def _rules(self) -> dict[str, list[Rule]]:
        found: dict[str, list[Rule]] = {}
        for rule in self.rules:
            found.setdefault(rule.name, []).append(rule)
        return found

    @cached_property
    def texts(self) -> dict[str, str | None]:
        """The `because` text of every rule, guard and launch by name."""
        guards = [guard for request in self.requests for guard in request.guards]
        named: tuple[Rule | Guard | Launch, ...] = (*self.rules, *guards, *self.launches)
        return {item.name: item.because for item in named}

    def text(self, clause: Consumption) -> str | None:
        """Return the `because` text of a `consumes` clause: its own, which may be empty, else that of its resource."""
        return self.resource[clause.resource].because if clause.because is None else clause.because

    @cached_property
    def demands(self) -> dict[str, tuple[tuple[str, ...], Location]]:
        """The guards and the remedies of rules, in the order of the text, then the remedies of consumables: by name the
        mark of the steps that they decide, and their location.

        The remedies of the rule `drive` are called `drive.reject`, `drive.wait` and, for each request that it kills,
        `drive.kill nd.goto`; rules of the same name share their remedies.
        """
        guards = [guard for request in self.requests for guard in request.guards]
        found: list[tuple[int, str, tuple[str, ...], Location]]
        found = [(guard.place, guard.name, (guard.objection, guard.name), guard.location) for guard in guards]
        for rule in self.rules:
            marks = marks_of(rule.name, rule.remedies, rule.slot_of)
            found += [(rule.place, name, mark, rule.location) for name, mark in marks]
        by_name: dict[str, tuple[tuple[str, ...], Location]] = {}
        for _, name, mark, location in sorted(found, key=itemgetter(0)):
            by_name.setdefault(name, (mark, location))
        for resource in (each for each in self.resources if each.consumable):
            marks = marks_of(resource.name, resource.remedies, None)
            by_name |= {name: (mark, resource.location) for name, mark in marks}
        return by_name


def marks_of(rule: str, remedies: tuple[Remedy, ...], slot_of: str | None) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield by name the marks of the steps that the remedies of a rule decide, in their order."""
    for remedy in remedies:
        match remedy:
            case Reject():
                yield f"{rule}.reject", ("reject", rule)
            case Wait():
                yield f"{rule}.wait", ("wait", rule)
            case Kill(requests):
                yield from ((f"{rule}.kill {request}", ("kill", rule, request)) for request in requests)
            case KillSlot():
                assert slot_of is not None
                yield f"{rule}.kill {slot_of}", ("kill", rule, slot_of)
            case _:
                assert_never(remedy)
