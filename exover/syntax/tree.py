"""The syntax tree: one class for each rule of the grammar (docs/language.md section 2), no meaning attached.

Every node has a ``span``, which equality ignores. Numbers keep the text they were written with, so that nothing of
a literal is lost before its type is known. Parentheses leave no node; the shape of the tree says where they stood.
Lists of operands are flat (``a or b or c`` is one Or of three), so depth grows with brackets, `not` and `implies`
alone, and the parser bounds it.
"""

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from exover.source import Span

Relation: TypeAlias = Literal["==", "!=", "<", "<=", ">", ">="]
PredicateKind: TypeAlias = Literal["active", "running", "stopping", "waiting", "past"]
Outcome: TypeAlias = Literal["none", "ok", "failed", "interrupted"]
Moment: TypeAlias = Literal["launch", "ok", "failed", "interrupted"]

# Names and lists of requests


@dataclass(frozen=True, slots=True)
class Name:
    """An identifier."""

    text: str
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Ref:
    """``module.request``."""

    module: Name
    request: Name
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class ModuleAll:
    """``module.*``: all requests of the module."""

    module: Name
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class GroupName:
    """The name of a group, in a list of requests."""

    name: Name
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class SelfTarget:
    """``self`` among the targets of `interrupts`."""

    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class AllTarget:
    """``all`` as the one target of `interrupts`: every other request of the module."""

    span: Span = field(compare=False)


Listed: TypeAlias = Ref | ModuleAll | GroupName
Target: TypeAlias = Listed | SelfTarget | AllTarget

# Values and types


@dataclass(frozen=True, slots=True)
class Number:
    """``text`` is the literal without its sign: digits, perhaps a fraction, perhaps an exponent.

    It has at most 1000 characters and an exponent of at most four digits. Where the grammar says INT it is digits
    alone and not negative.
    """

    text: str
    negative: bool
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Truth:
    """``true`` or ``false``."""

    value: bool
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Word:
    """A name where a value is due: an enum value or a const."""

    name: Name
    span: Span = field(compare=False)


Value: TypeAlias = Number | Truth | Word
Bound: TypeAlias = Number | Word


@dataclass(frozen=True, slots=True)
class Range:
    """``low .. high``, both ends included."""

    low: Bound
    high: Bound
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class BoolType:
    """``bool``."""

    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class IntType:
    """``int in low .. high``."""

    range: Range
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class RealType:
    """``real`` or ``real in low .. high``."""

    range: Range | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class NamedType:
    """The name of an enum, as a type."""

    name: Name
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class SetType:
    """``{a, b, c}``: an enum without a name."""

    values: tuple[Name, ...]
    span: Span = field(compare=False)


Type: TypeAlias = BoolType | IntType | RealType | NamedType | SetType

# Terms


@dataclass(frozen=True, slots=True)
class NameUse:
    """``name`` (module is None) or ``module.name``."""

    module: Name | None
    name: Name
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class SelfName:
    """``self.name``: a parameter of the request of the clause, read inside `with`."""

    name: Name
    span: Span = field(compare=False)


Unit: TypeAlias = Number | Truth | NameUse | SelfName


@dataclass(frozen=True, slots=True)
class Product:
    """The product of at least two factors."""

    factors: tuple[Unit, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Addend:
    """One summand behind the first, with the sign that stands before it."""

    negative: bool
    term: Unit | Product
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Sum:
    """``first`` plus or minus each of ``rest``, at least one."""

    first: Unit | Product
    rest: tuple[Addend, ...]
    span: Span = field(compare=False)


Term: TypeAlias = Unit | Product | Sum

# Conditions


@dataclass(frozen=True, slots=True)
class Compare:
    """``left relation right``."""

    left: Term
    relation: Relation
    right: Term
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class InRange:
    """``term in low .. high``."""

    term: Term
    low: Term
    high: Term
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class InSet:
    """``term in {members}``."""

    term: Term
    members: tuple[Term, ...]
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Predicate:
    """``kind(requests)``; with a ``condition``, ``kind(ref with condition)`` and requests is that one Ref."""

    kind: PredicateKind
    requests: tuple[Listed, ...]
    condition: "Cond | None"
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Last:
    """``last(request) == outcome``, or ``!=`` if not ``equal``."""

    request: Ref
    equal: bool
    outcome: Outcome
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Used:
    """``used(resource) relation amount``."""

    resource: Name
    relation: Relation
    amount: Number
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Level:
    """``level(resource) relation amount``."""

    resource: Name
    relation: Relation
    amount: Number
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Not:
    """``not operand``."""

    operand: "Cond"
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class And:
    """The conjunction of at least two parts."""

    parts: "tuple[Cond, ...]"
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Or:
    """The disjunction of at least two parts."""

    parts: "tuple[Cond, ...]"
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class Implies:
    """``left implies right``; it groups to the right."""

    left: "Cond"
    right: "Cond"
    span: Span = field(compare=False)


Cond: TypeAlias = Implies | Or | And | Not | Predicate | Last | Used | Level | Compare | InRange | InSet | Term
"""A bare term is a bool, or the name of a define."""

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
"""A list of remedies is empty where the text has none."""

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
    """``on moment set state = value because …;``."""

    moment: Moment
    state: NameUse
    value: Value
    because: str | None
    span: Span = field(compare=False)


@dataclass(frozen=True, slots=True)
class OnForget:
    """``on moment forget requests because …;``."""

    moment: Moment
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
Item: TypeAlias = Enum | Const | Define | Group | Module | Poster | Latch | Resource | Context | Rule


@dataclass(frozen=True, slots=True)
class Spec:
    """``spec name;`` and the items of the file, in the order of the text."""

    name: Name
    items: tuple[Item, ...]
    span: Span = field(compare=False)
