"""The upper half of the syntax tree: remedies, clauses, declarations, rules and the file; read it through tree.py."""

from dataclasses import field
from typing import Literal, TypeAlias

from exover.dataclass import dataclass
from exover.source import Span
from exover.syntax.conditions import Cond, Listed, Name, NameUse, Number, Ref, Target, Type, Value

Occasion: TypeAlias = Literal["launch", "ok", "failed", "interrupted"]

# Remedies


@dataclass(frozen=True, slots=True)
class Reject:
    """``reject``."""

    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Wait:
    """``wait``."""

    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Kill:
    """``kill requests``."""

    requests: tuple[Listed, ...]
    span: Span = field(compare=False)


Remedy: TypeAlias = Reject | Wait | Kill
"""A list of remedies is empty if the text has none."""

# Clauses of a request


@dataclass(frozen=True, slots=True)
class Check:
    """``check label: condition because …;``."""

    label: Name | None
    condition: Cond
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class WaitUntil:
    """``wait label: until condition because …;``."""

    label: Name | None
    condition: Cond
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class SettleUntil:
    """``settle label: until condition because …;``."""

    label: Name | None
    condition: Cond
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class FailWhen:
    """``fail label: when condition else wait because …;``."""

    label: Name | None
    condition: Cond
    else_wait: bool
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class After:
    """``after requests because …;``."""

    requests: tuple[Listed, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Before:
    """``before requests because …;``."""

    requests: tuple[Listed, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Interrupts:
    """``interrupts targets else wait because …;``; an AllTarget stands alone."""

    targets: tuple[Target, ...]
    else_wait: bool
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Uses:
    """``uses resource amount when condition because …;``."""

    resource: Name
    amount: Number
    condition: Cond | None
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Consumes:
    """``consumes resource amount when condition because …;``."""

    resource: Name
    amount: Number
    condition: Cond | None
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Produces:
    """``produces resource amount when condition because …;``."""

    resource: Name
    amount: Number
    condition: Cond | None
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class OnSet:
    """``on occasion set state = value because …;``."""

    occasion: Occasion
    state: NameUse
    value: Value
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class OnForget:
    """``on occasion forget requests because …;``."""

    occasion: Occasion
    requests: tuple[Listed, ...]
    because: str | None
    span: Span = field(compare=False)


Clause: TypeAlias = (
    Check
    | WaitUntil
    | SettleUntil
    | FailWhen
    | After
    | Before
    | Interrupts
    | Uses
    | Consumes
    | Produces
    | OnSet
    | OnForget
)

# Declarations


@dataclass(frozen=True, slots=True)
class Enum:
    """``enum name { values }``."""

    name: Name
    values: tuple[Name, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Const:
    """``const name = value;``."""

    name: Name
    value: Value
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Define:
    """``define name = condition;``."""

    name: Name
    condition: Cond
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Group:
    """``group name = requests;``."""

    name: Name
    requests: tuple[Listed, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Param:
    """``name: type``, a parameter or a result of a request."""

    name: Name
    type: Type
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Request:
    """``request name(params) returns (results) fails (statuses) instances n { clauses }``."""

    name: Name
    params: tuple[Param, ...]
    results: tuple[Param, ...]
    statuses: tuple[Name, ...]
    instances: Number | None
    clauses: tuple[Clause, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Poster:
    """``poster name: type = initial else otherwise;``, of a module or at the top level."""

    name: Name
    type: Type
    initial: Value
    otherwise: Value | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class State:
    """``state name: type = initial;``."""

    name: Name
    type: Type
    initial: Value
    span: Span = field(compare=False)


Member: TypeAlias = Request | Poster | State


@dataclass(frozen=True, slots=True)
class Module:
    """``module name "title" { members }``."""

    name: Name
    title: str | None
    members: tuple[Member, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Latch:
    """``latch name: when condition until requests;``."""

    name: Name
    condition: Cond
    until: tuple[Listed, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Resource:
    """``resource name: capacity consumable = initial by remedies because …;``; initial only if consumable."""

    name: Name
    capacity: Number
    consumable: bool
    initial: Number | None
    remedies: tuple[Remedy, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Context:
    """``context request { clauses }``."""

    request: Ref
    clauses: tuple[Clause, ...]
    span: Span = field(compare=False)


# Rules


@dataclass(frozen=True, slots=True)
class Mutex:
    """``mutex label: requests by remedies because …;``."""

    label: Name | None
    requests: tuple[Listed, ...]
    remedies: tuple[Remedy, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class MutexOver:
    """``mutex label: winners over losers else wait because …;``."""

    label: Name | None
    winners: tuple[Listed, ...]
    losers: tuple[Listed, ...]
    else_wait: bool
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Limit:
    """``limit label: at most most of requests by remedies because …;``."""

    label: Name | None
    most: Number
    requests: tuple[Listed, ...]
    remedies: tuple[Remedy, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Forbid:
    """``forbid label: condition by remedies because …;``."""

    label: Name | None
    condition: Cond
    remedies: tuple[Remedy, ...]
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Launch:
    """``launch label: request(arguments) when condition because …;``."""

    label: Name | None
    request: Ref
    arguments: tuple[Value, ...]
    condition: Cond
    because: str | None
    span: Span = field(compare=False)


Rule: TypeAlias = Mutex | MutexOver | Limit | Forbid | Launch


@dataclass(frozen=True, slots=True)
class Include:
    """``include "path";``: the items of another file."""

    path: str
    span: Span = field(compare=False)


Item: TypeAlias = Enum | Const | Define | Group | Module | Poster | Latch | Resource | Context | Include | Rule


@dataclass(frozen=True, slots=True)
class Spec:
    """``spec name;`` and the items of the file in order; after `gather`, those of its parts replace the includes."""

    name: Name
    items: tuple[Item, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Part:
    """``part name;`` and the items of the file, which a spec may include."""

    name: Name
    items: tuple[Item, ...]
    span: Span = field(compare=False)
