"""The lower half of the syntax tree: names, values, types, terms and conditions; read it through tree.py."""

from dataclasses import field
from typing import Literal, TypeAlias, get_args

from exover.dataclass import dataclass
from exover.source import Span

Relation: TypeAlias = Literal["==", "!=", "<", "<=", ">", ">="]
StateKind: TypeAlias = Literal["active", "running", "stopping", "waiting", "past"]
StepKind: TypeAlias = Literal["asked", "launched", "rejected", "killed", "ended"]
PredicateKind: TypeAlias = StateKind | StepKind
STEPS: frozenset[str] = frozenset(get_args(StepKind))
"""The predicates on what a step did, of a properties file alone."""
PREDICATES: frozenset[str] = frozenset({*get_args(StateKind), "last", "used", "level"})
"""The words with brackets in any condition."""
Outcome: TypeAlias = Literal["none", "ok", "failed", "interrupted"]

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

    It has at most 1000 characters and an exponent of at most four digits. For an INT of the grammar it is digits only
    and not negative.
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
    """A name in the place of a value: an enum value or a const."""

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
    """A summand after the first one, with the sign before it."""

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
    """``left implies right``; it is right-associative."""

    left: "Cond"
    right: "Cond"
    span: Span = field(compare=False)


Cond: TypeAlias = Implies | Or | And | Not | Predicate | Last | Used | Level | Compare | InRange | InSet | Term
"""A bare term is a bool, or the name of a define."""
