"""Terms and conditions: the closed core that every engine reads.

Groups, defines, `implies`, `in` and lists of requests are gone here; what is left is comparison, the predicates on one
request, and the three connectives. Modelled on Copilot's `Core/Expr` (Perez, Dedden, Goodloe 2020).
"""

from collections.abc import Callable, Iterator
from typing import Literal, assert_never

from exover.dataclass import dataclass
from exover.model.types import Value

Operator = Literal["==", "!=", "<", "<=", ">", ">="]
Phase = Literal["active", "running", "stopping", "waiting"]
Outcome = Literal["none", "ok", "failed", "interrupted"]
_MIRRORED: dict[Operator, Operator] = {"==": "==", "!=": "!=", "<": ">", "<=": ">=", ">": "<", ">=": "<="}


def mirrored(operator: Operator) -> Operator:
    """Return the operator that compares the sides the other way round: `a < b` iff `b > a`."""
    return _MIRRORED[operator]


@dataclass(frozen=True, slots=True)
class Const:
    """A constant; compared with a real, it is already the double nearest to the literal."""

    value: Value


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter: inside `where` of the request that the predicate names, elsewhere of the clause's own request.

    In `Past.where` it may also be a returned value.
    """

    name: str


@dataclass(frozen=True, slots=True)
class Own:
    """`self.p` inside `where`: the parameter p of the request whose clause this is."""

    name: str


@dataclass(frozen=True, slots=True)
class Reading:
    """The present value of the poster, module state or latch of this full name (`battery`, `nd.speed`)."""

    name: str


@dataclass(frozen=True, slots=True)
class Used:
    """The sum of the shares of a renewable resource that the active slots hold."""

    resource: str


@dataclass(frozen=True, slots=True)
class Level:
    """The present level of a consumable resource."""

    resource: str


@dataclass(frozen=True, slots=True)
class Count:
    """The number of active slots of all the listed requests together."""

    requests: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Sum:
    """`constant + sum(factor * term)` over the integers, exact."""

    constant: int
    terms: tuple[tuple[int, "ModelTerm"], ...]


ModelTerm = Const | Param | Own | Reading | Used | Level | Count | Sum


@dataclass(frozen=True, slots=True)
class Compare:
    """`left operator right`, both of one type; bools and enums have only `==` and `!=`."""

    operator: Operator
    left: ModelTerm
    right: ModelTerm


@dataclass(frozen=True, slots=True)
class Status:
    """Some slot of the request is in this phase, or its waiting place is taken, with arguments that satisfy `where`."""

    phase: Phase
    request: str
    where: "Cond | None" = None


@dataclass(frozen=True, slots=True)
class Past:
    """The request has a past, and its arguments and returned values satisfy `where`."""

    request: str
    where: "Cond | None" = None


@dataclass(frozen=True, slots=True)
class Last:
    """The last instance of the request ended with this outcome (`none`: no instance has ended yet)."""

    request: str
    outcome: Outcome


@dataclass(frozen=True, slots=True)
class Not:
    """The negation of `part`."""

    part: "Cond"


@dataclass(frozen=True, slots=True)
class And:
    """The conjunction; the empty one is true."""

    parts: tuple["Cond", ...]


@dataclass(frozen=True, slots=True)
class Or:
    """The disjunction; the empty one is false."""

    parts: tuple["Cond", ...]


AtomicCond = Compare | Status | Past | Last
Cond = AtomicCond | Not | And | Or

TRUE = And(())
FALSE = Or(())


def atoms(cond: Cond) -> Iterator[AtomicCond]:
    """Yield the atoms of a condition in the order of the text, without those inside a `where`."""
    left = [cond]
    while left:
        part = left.pop()
        match part:
            case Compare() | Status() | Past() | Last():
                yield part
            case Not(inner):
                left.append(inner)
            case And(parts) | Or(parts):
                left += reversed(parts)
            case _:
                assert_never(part)


def with_atoms(cond: Cond, meaning: Callable[[AtomicCond], Cond]) -> Cond:
    """Return the condition in which what a function says stands for each atom, without those inside a `where`."""
    match cond:
        case And(parts):
            return And(tuple(with_atoms(part, meaning) for part in parts))
        case Or(parts):
            return Or(tuple(with_atoms(part, meaning) for part in parts))
        case Not(part):
            return Not(with_atoms(part, meaning))
        case _:
            return meaning(cond)


def leaves(term: ModelTerm) -> Iterator[ModelTerm]:
    """Yield the summands of a sum, nested ones included; of any other term, the term itself."""
    match term:
        case Sum(_, parts):
            for _, part in parts:
                yield from leaves(part)
        case _:
            yield term


def operands(cond: Cond) -> Iterator[ModelTerm]:
    """Yield every leaf term of the comparisons of a condition, without those inside a `where`."""
    for atom in atoms(cond):
        if isinstance(atom, Compare):
            yield from leaves(atom.left)
            yield from leaves(atom.right)
