"""Resolves types of the tree to types of the model (docs/language.md section 2)."""

from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import TypeVar, assert_never

from exover.diagnostics import quote
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.resolve.mistakes import Mistakes, same_name
from exover.resolve.values import Constant, Constants, Numeral, Symbol, constant_of, integer, no_constant, real
from exover.source import Span
from exover.syntax import tree
from exover.syntax.hints import TYPES

N = TypeVar("N", int, float)
MAX_OWN_VALUES = 256
"""The most values of an int parameter p for which `self.p` can be read inside `with`."""


def enum_of(names: Iterable[tree.Name], mistakes: Mistakes) -> Enum:
    """Return the enum of the listed values, without duplicates, which are mistakes."""
    taken: dict[str, Span] = {}
    for name in names:
        first = same_name(taken, name.text, name.span)
        if first:
            mistakes.again(name.text, "enum value", name.span, first)
    return Enum(tuple(taken))


def type_of(node: tree.Type, enums: Mapping[str, Enum], known: Constants, mistakes: Mistakes) -> Type | None:
    """Return the type of a node, or None with a mistake noted."""
    match node:
        case tree.BoolType():
            return Bool()
        case tree.IntType(limits):
            ends = _ends(limits, integer, known, mistakes)
            return Int(*ends) if ends else None
        case tree.RealType(limits):
            bounds = _ends(limits, real, known, mistakes) if limits else (-inf, inf)
            return Real(*bounds) if bounds else None
        case tree.SetType(names):
            return enum_of(names, mistakes)
        case tree.NamedType(name):
            if name.text not in enums:
                message = f"unknown type {quote(name.text)}"
                types, hint = ("bool", "int", "real", *enums), TYPES.get(name.text.lower(), "")
                mistakes.unknown("E206", message, name.text, node.span, lambda: types, hint)
            return enums.get(name.text)
        case _:
            assert_never(node)


def _ends(
    limits: tree.Range, value: Callable[[Numeral, Mistakes], N | None], known: Constants, mistakes: Mistakes
) -> tuple[N, N] | None:
    """Return the two ends of a range, converted by `value`, or None with a mistake noted."""
    bounds = [_number(bound, known, mistakes) for bound in (limits.low, limits.high)]
    low, high = (None if bound is None else value(bound, mistakes) for bound in bounds)
    if low is None or high is None or _empty(low, high, limits, mistakes):
        return None
    return low, high


def _number(bound: tree.Bound, known: Constants, mistakes: Mistakes) -> Numeral | None:
    """Return the number of a bound, or None with a mistake noted."""
    constant: Constant | None = constant_of(bound, known)
    if isinstance(constant, Symbol) and constant.name not in known.enum_values:
        no_constant(constant, None, known, mistakes)
    elif isinstance(constant, Symbol | bool):
        mistakes.add("E308", "a bound of a range is a number", bound.span)
    return constant if isinstance(constant, Numeral) else None


def _empty(low: float, high: float, limits: tree.Range, mistakes: Mistakes) -> bool:
    """Return whether the range is empty, and if so, note it."""
    if low > high:
        mistakes.add("E306", "an empty range", limits.span, label="the lower bound is above the upper one")
    return low > high


def few_values(kind: Type) -> bool:
    """Return whether `self.p` of this type can be read inside `with`: a bool, an enum, an int of few values."""
    match kind:
        case Bool() | Enum():
            return True
        case Int(low, high):
            return high - low < MAX_OWN_VALUES
        case Real():
            return False
        case _:
            assert_never(kind)
