"""Resolves constants: literals and names of consts, and their conversion to a bool, an int, a real or an enum."""

import math
from collections.abc import Mapping
from dataclasses import field, replace
from typing import assert_never

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.types import Bool, Enum, Int, Real, Type, Value, contains
from exover.model.wording import value_text
from exover.resolve.mistakes import Mistakes
from exover.source import Span
from exover.syntax import tree

MIN_INT, MAX_INT = -(2**63), 2**63 - 1


@dataclass(frozen=True, slots=True)
class Numeral:
    """A number whose type is not known yet.

    `text` is the literal with its sign, from which a double is made; `whole` is its integer, None for a literal with a
    fraction or an exponent. `folded`: it is the result of arithmetic, which must be used as an int.
    """

    text: str
    whole: int | None
    span: Span
    folded: bool = False


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name that can only be an enum value; the other side of a comparison, or the type, decides of which enum."""

    name: str
    span: Span


Constant = Numeral | Symbol | bool


@dataclass(frozen=True, slots=True)
class Constants:
    """The names of constants: the consts of the file (None: its mistake is noted) and all enum values.

    `others` are the names of top-level posters, latches and defines, which are no constants; `readings` says what else
    is read by a name in the clause that is resolved. Both serve messages only.
    """

    consts: Mapping[str, Constant | None]
    enum_values: frozenset[str]
    others: frozenset[str] = frozenset()
    readings: Mapping[str, str] = field(default_factory=dict)


def numeral(node: tree.Number) -> Numeral:
    """Return the number that a literal denotes."""
    text = f"-{node.text}" if node.negative else node.text
    return Numeral(text, int(text) if node.text.isdigit() else None, node.span)


def at(constant: Constant, span: Span) -> Constant:
    """Return the constant with the place `span`."""
    return constant if isinstance(constant, bool) else replace(constant, span=span)


def fits(number: int) -> bool:
    """Return whether an integer fits 64 bits."""
    return MIN_INT <= number <= MAX_INT


def count(node: tree.Number, mistakes: Mistakes) -> int | None:
    """Return the value of an INT of the grammar, or None with a mistake noted if it does not fit 64 bits."""
    return _whole(numeral(node), mistakes)


def real(constant: Numeral, mistakes: Mistakes) -> float | None:
    """Return the double nearest to a number; None with a mistake noted if it is infinite or a result of arithmetic."""
    if constant.folded:
        mistakes.add(
            "E302", "a sum or product of constants cannot stand for a real", constant.span, hint="write its value"
        )
        return None
    value = float(constant.text) + 0.0  # -0.0 becomes 0.0
    if math.isfinite(value):
        return value
    mistakes.add("E307", f"{quote(constant.text)} is larger than every finite double", constant.span)
    return None


def _whole(constant: Numeral, mistakes: Mistakes) -> int | None:
    if constant.whole is not None and fits(constant.whole):
        return constant.whole
    if constant.whole is not None:
        mistakes.add("E310", f"{quote(constant.text)} does not fit 64 bits", constant.span)
    return None


def integer(constant: Numeral, mistakes: Mistakes) -> int | None:
    """Return the value of a number as an int, or None with a mistake noted."""
    if constant.whole is None:
        message = f"an int is needed, {quote(constant.text)} is written as a real"
        mistakes.add("E308", message, constant.span)
    return _whole(constant, mistakes)


def describe(kind: Type) -> str:
    """Return a type in words, for messages."""
    match kind:
        case Bool():
            return "a bool"
        case Int():
            return "an int"
        case Real():
            return "a real"
        case Enum(values):
            return quote("{" + ", ".join(values) + "}")
        case _:
            assert_never(kind)


def constant_of(node: tree.Value, known: Constants) -> Constant | None:
    """Return the constant of a node; None for a const whose own mistake is noted."""
    match node:
        case tree.Number():
            return numeral(node)
        case tree.Truth(value):
            return value
        case tree.Word(name):
            if name.text in known.consts:
                constant = known.consts[name.text]
                return None if constant is None else at(constant, node.span)
            return Symbol(name.text, node.span)
        case _:
            assert_never(node)


def value(node: tree.Value, kind: Type | None, known: Constants, mistakes: Mistakes, label: str = "") -> Value | None:
    """Return a node as a value of type `kind`, in its range; None, with a mistake noted, if it is none.

    None also if `kind` is None, for a mistake. `label`: what the value is for, for messages.
    """
    constant = constant_of(node, known)
    if constant is None or kind is None:
        return None
    found = _converted(constant, kind, known, node.span, mistakes, label)
    if found is None or contains(kind, found):
        return found
    bounds = f"{value_text(kind.low)} .. {value_text(kind.high)}" if isinstance(kind, Int | Real) else describe(kind)
    mistakes.add("E307", f"{quote(mistakes.source.slice(node.span))} is not in {bounds}", node.span, label=label)
    return None


def _converted(
    constant: Constant, kind: Type, known: Constants, span: Span, mistakes: Mistakes, label: str
) -> Value | None:
    match constant, kind:
        case bool(), Bool():
            return constant
        case Numeral(), Int():
            return integer(constant, mistakes)
        case Numeral(), Real():
            return real(constant, mistakes)
        case Symbol(name), Enum(values) if name in values:
            return name
        case Symbol(), _ if constant.name not in known.enum_values:
            no_constant(constant, kind, known, mistakes)
        case _:
            what = f"a value of {describe(kind)}" if isinstance(kind, Enum) else describe(kind)
            mistakes.add("E308", f"{what} is needed, {quote(mistakes.source.slice(span))} is none", span, label=label)
    return None


def _may_be(constant: Constant | None, kind: Type | None, known: Constants) -> bool:
    """Return whether a constant may be a value of a type, as far as both are known; an unknown name may not."""
    match constant, kind:
        case Symbol(name), None:
            return name in known.enum_values
        case (None, _) | (_, None):
            return True
        case Symbol(name), Enum(values):
            return name in values
        case bool(), _:
            return isinstance(kind, Bool)
        case _:
            return isinstance(constant, Numeral) and isinstance(kind, Int | Real)


def no_constant(symbol: Symbol, kind: Type | None, known: Constants, mistakes: Mistakes) -> None:
    """Note that a name in the place of a constant is none."""
    if symbol.name in known.others:
        mistakes.add("E219", f"{quote(symbol.name)} is no constant", symbol.span, hint="a value is written here")
        return
    code, what = ("E209", "enum value") if isinstance(kind, Enum) else ("E201", "constant")
    values = kind.values if isinstance(kind, Enum) else ()
    mistakes.unknown(
        code,
        f"unknown {what} {quote(symbol.name)}",
        symbol.name,
        symbol.span,
        lambda: [
            *values,
            *(name for name, constant in known.consts.items() if _may_be(constant, kind, known)),
            *(("true", "false") if isinstance(kind, Bool) else ()),
        ],
        f"{quote(symbol.name)} is a {known.readings[symbol.name]}; a value is written out here"
        if symbol.name in known.readings
        else "",
    )
