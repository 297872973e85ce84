"""Boolean expressions of SMV over symbols with finitely many values, simplified as they are made."""

from collections.abc import Iterable, Sequence
from dataclasses import field
from functools import cache
from typing import assert_never

from exover.dataclass import dataclass

Cases = tuple[tuple["Expr", int], ...]
"""A number for each of several disjoint conditions, 0 elsewhere."""


@dataclass(frozen=True, slots=True)
class SmvSymbol:
    """A name of the text, or a literal, whose value is one of `literals`; those are all numbers, or none is.

    Where the value is known, `known` is its number among them.
    """

    text: str
    literals: tuple[str, ...] = field(hash=False)
    known: int | None = None

    @property
    def boolean(self) -> bool:
        """Whether it is FALSE or TRUE."""
        return self.literals == BOOLEANS

    @property
    def numeric(self) -> bool:
        """Whether it is a number."""
        return self.literals[0].isdigit() or self.literals[0][0] == "-"


@dataclass(frozen=True, slots=True)
class NumberSum:
    """A sum of numbers by cases; `totals`: the values that it can have."""

    parts: tuple[Cases, ...]
    totals: tuple[int, ...] = field(hash=False)


BOOLEANS = ("FALSE", "TRUE")


class Combined:
    """The operators that expressions have in common with sets of states."""

    def __and__(self, other: "Expr") -> "Expr":
        """Return the conjunction."""
        return conjunction((self, other))  # type: ignore[arg-type]

    def __or__(self, other: "Expr") -> "Expr":
        """Return the disjunction."""
        return disjunction((self, other))  # type: ignore[arg-type]

    def __invert__(self) -> "Expr":
        """Return the negation."""
        return negation(self)  # type: ignore[arg-type]


@dataclass(frozen=True)
class BooleanConstant(Combined):
    """TRUE or FALSE."""

    value: bool


@dataclass(frozen=True)
class Among(Combined):
    """A symbol or sum has one of these of its values, given by their numbers; neither none nor all."""

    what: SmvSymbol | NumberSum
    values: frozenset[int]


@dataclass(frozen=True)
class DefinedName(Combined):
    """A boolean DEFINE, or a variable."""

    name: str


@dataclass(frozen=True)
class Negated(Combined):
    """Not `part`."""

    part: "Expr"


@dataclass(frozen=True)
class All(Combined):
    """All of `parts`, two or more."""

    parts: tuple["Expr", ...]


@dataclass(frozen=True)
class Any(Combined):
    """One of `parts`, two or more."""

    parts: tuple["Expr", ...]


Expr = BooleanConstant | Among | DefinedName | Negated | All | Any
TRUE, FALSE = BooleanConstant(True), BooleanConstant(False)


def among(what: SmvSymbol | NumberSum, values: Iterable[int]) -> Expr:
    """Return that a symbol or sum has one of its values with these numbers."""
    those = frozenset(values)
    if isinstance(what, SmvSymbol) and what.known is not None:
        return BooleanConstant(what.known in those)
    every = _every(what)
    those &= every
    return BooleanConstant(bool(those)) if len(those) in (0, len(every)) else Among(what, those)


def negation(part: Expr) -> Expr:
    """Return `!part`."""
    match part:
        case BooleanConstant(value):
            return BooleanConstant(not value)
        case Negated(inner):
            return inner
        case Among(what, values):
            return Among(what, _every(what) - values)
        case _:
            return Negated(part)


def _every(what: SmvSymbol | NumberSum) -> frozenset[int]:
    """Return the numbers of all values that a symbol or sum can have."""
    return _below(len(what.literals if isinstance(what, SmvSymbol) else what.totals))


@cache
def _below(count: int) -> frozenset[int]:
    return frozenset(range(count))


def conjunction(parts: Iterable[Expr]) -> Expr:
    """Return `a & b & …`, conditions on one symbol taken together."""
    return _joined(parts, All)


def disjunction(parts: Iterable[Expr]) -> Expr:
    """Return `a | b | …`, conditions on one symbol taken together."""
    return _joined(parts, Any)


def _joined(parts: Iterable[Expr], kind: type[All] | type[Any]) -> Expr:
    found: dict[object, Expr] = {}
    for part in parts:
        for each in part.parts if isinstance(part, kind) else (part,):
            if isinstance(each, BooleanConstant):
                if each.value is (kind is Any):
                    return each
                continue
            if not isinstance(each, Among):
                found[each] = each
                continue
            known = found.get(each.what)
            if isinstance(known, Among):
                values = known.values & each.values if kind is All else known.values | each.values
                joined = among(each.what, values)
                if isinstance(joined, BooleanConstant):
                    return joined
                found[each.what] = joined
            else:
                found[each.what] = each
    left = tuple(found.values())
    if not left:
        return BooleanConstant(kind is All)
    if any(negation(each) in found for each in left if isinstance(each, DefinedName | Negated)):
        return BooleanConstant(kind is Any)
    return left[0] if len(left) == 1 else kind(left)


def total(parts: Iterable[Cases]) -> dict[int, Expr]:
    """Return for each value of a sum the condition that the sum has it."""
    constant, kept = _without_constants(parts)
    if not kept:
        return {constant: TRUE}
    if len(kept) == 1:
        (part,) = kept
        found: dict[int, Expr] = {}
        for when, number in (*part, (negation(disjunction(when for when, _ in part)), 0)):
            found[number + constant] = found.get(number + constant, FALSE) | when
        return found
    sum_ = _sum_of(kept)
    return {value + constant: among(sum_, (number,)) for number, value in enumerate(sum_.totals)}


def at_most(parts: Sequence[Cases], bound: int) -> Expr:
    """Return the condition that a sum is at most `bound`, without an expression for each of its values."""
    constant, kept = _without_constants(parts)
    if len(kept) > 1:
        sum_ = _sum_of(kept)
        return among(sum_, (number for number, value in enumerate(sum_.totals) if value + constant <= bound))
    return disjunction(when for value, when in total(parts).items() if value <= bound)


def _without_constants(parts: Iterable[Cases]) -> tuple[int, list[Cases]]:
    """Return the sum of the parts that are numbers, and the others without cases that add nothing."""
    kept = []
    for part in parts:
        cases = tuple((when, number) for when, number in part if number and when != FALSE)
        if cases:
            kept.append(cases)
    constant = sum(part[0][1] for part in kept if part[0][0] == TRUE)
    return constant, [part for part in kept if part[0][0] != TRUE]


def _sum_of(parts: Sequence[Cases]) -> NumberSum:
    return NumberSum(tuple(parts), _totals(tuple(tuple(number for _, number in part) for part in parts)))


@cache
def _totals(parts: tuple[tuple[int, ...], ...]) -> tuple[int, ...]:
    """Return what sums of one of the numbers of each part, or of 0 instead, can be."""
    totals = {0}
    for numbers in parts:
        totals = {total + number for total in totals for number in (0, *numbers)}
    return tuple(sorted(totals))


# ---- text ----


def text(expr: Expr, inside: bool = False) -> str:
    """Return an expression as SMV has it; `inside` another one, with parentheses if it needs them."""
    match expr:
        case BooleanConstant(value):
            return BOOLEANS[value]
        case DefinedName(name):
            return name
        case Negated(part):
            return f"!{text(part, inside=True)}"
        case Among(what, values):
            return _symbol(what, values, inside) if isinstance(what, SmvSymbol) else _sum(what, values, inside)
        case All(parts):
            return _inside(" & ".join(text(part, inside=True) for part in parts), inside)
        case Any(parts):
            return _inside(" | ".join(text(part, inside=True) for part in parts), inside)
        case _:
            assert_never(expr)


def _inside(found: str, inside: bool) -> str:
    return f"({found})" if inside else found


def _symbol(symbol: SmvSymbol, values: frozenset[int], inside: bool) -> str:
    if symbol.boolean:
        return symbol.text if 1 in values else f"!{symbol.text}"
    left = sorted(values)
    last = len(symbol.literals) - 1
    if len(left) == 1:
        found = f"{symbol.text} = {symbol.literals[left[0]]}"
    elif len(left) == last:
        (missing,) = set(range(last + 1)) - values
        found = f"{symbol.text} != {symbol.literals[missing]}"
    elif symbol.numeric and left == list(range(len(left))):
        found = f"{symbol.text} <= {symbol.literals[left[-1]]}"
    elif symbol.numeric and left == list(range(left[0], last + 1)):
        found = f"{symbol.text} >= {symbol.literals[left[0]]}"
    else:
        found = f"{symbol.text} in {{{', '.join(symbol.literals[value] for value in left)}}}"
    return _inside(found, inside)


def _sum(sum_: NumberSum, values: frozenset[int], inside: bool) -> str:
    zero = sum_.totals.index(0) if sum_.totals[0] == 0 else None
    if zero is not None and (values == {zero} or (zero not in values and len(values) == len(sum_.totals) - 1)):
        some = text(disjunction(when for part in sum_.parts for when, _ in part), inside=True)
        return f"!{some}" if values == {zero} else some
    written = " + ".join(_number(part) for part in sum_.parts)
    return _symbol(SmvSymbol(f"({written})", tuple(str(value) for value in sum_.totals)), values, inside)


def _number(cases: Cases) -> str:
    symbol = cases[0][0].what if isinstance(cases[0][0], Among) else None
    if isinstance(symbol, SmvSymbol) and symbol.numeric:
        values = [(number, int(literal)) for number, literal in enumerate(symbol.literals)]
        if set(cases) == {(among(symbol, (number,)), value) for number, value in values if value}:
            return symbol.text
    if len(cases) == 1:
        ((when, number),) = cases
        return f"{f'{number} * ' if number != 1 else ''}toint({text(when)})"
    return choice([(when, str(number)) for when, number in cases], "0")


def choice(cases: Iterable[tuple[Expr, str]], otherwise: str) -> str:
    """Return the value of the first condition that is true, else `otherwise`: `case … esac` where it takes that."""
    written = [(text(when), value) for when, value in cases]
    match written:
        case []:
            return otherwise
        case [(when, "TRUE")] if otherwise == "FALSE":
            return when
        case _:
            return f"case {' '.join(f'{when} : {value};' for when, value in written)} TRUE : {otherwise}; esac"
