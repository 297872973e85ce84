"""Resolves terms and comparisons, by the typing rules of docs/language.md section 2."""

from typing import assert_never

from exover.diagnostics import quote
from exover.model.evaluate import OPERATORS
from exover.model.expression import FALSE, TRUE, Compare, Cond, Const, ModelTerm, Operator, Sum
from exover.model.types import Bool, Enum, Int, Real, Type
from exover.resolve.scope import Defined, NameScope, Typed
from exover.resolve.values import Numeral, Symbol, describe, fits, numeral, real
from exover.source import Span
from exover.syntax import tree

Operand = Typed | Numeral | Symbol
"""A term whose type may still depend on the other side of its comparison."""


def operand(scope: NameScope, node: tree.Term) -> Operand | None:
    """Return the operand of a term, or None with a mistake noted; a define is a mistake."""
    found = unit(scope, node) if not isinstance(node, tree.Product | tree.Sum) else _sum(scope, node)
    if isinstance(found, Defined):
        scope.mistakes.add("E219", f"define {quote(found.name)} is a condition, a value is needed here", found.span)
        return None
    return found


def unit(scope: NameScope, node: tree.Unit) -> Operand | Defined | None:
    """Return the operand or the define of a term without arithmetic, or None with a mistake noted."""
    match node:
        case tree.Number():
            return numeral(node)
        case tree.Truth(value):
            return Typed(Bool(), Const(value), "constant", node.span)
        case tree.NameUse():
            found = scope.lookup(node)
            if isinstance(found, bool):
                return Typed(Bool(), Const(found), "constant", node.span)
            return found
        case tree.SelfName():
            return scope.own(node)
        case _:
            assert_never(node)


# ---- integer arithmetic ----


def _sum(scope: NameScope, node: tree.Product | tree.Sum) -> Operand | None:
    """Return an integer sum in normal form: like terms are collected in the order of the text, no factor is 0."""
    parts: list[tuple[int, tree.Unit | tree.Product]]
    if isinstance(node, tree.Product):
        parts = [(1, node)]
    else:
        parts = [(1, node.first), *((-1 if addend.negative else 1, addend.term) for addend in node.rest)]
    products = [_product(scope, sign, part, node.span) for sign, part in parts]
    if not all(products):
        return None
    constant = 0
    factors: dict[ModelTerm, int] = {}
    ranges: dict[ModelTerm, Int] = {}
    for factor, typed in (product for product in products if product):
        if typed is None:
            constant += factor
        else:
            factors[typed.term] = factors.get(typed.term, 0) + factor
            assert isinstance(typed.type, Int), "_product refuses the others"
            ranges[typed.term] = typed.type
    return _normal(scope, constant, {term: factor for term, factor in factors.items() if factor}, ranges, node.span)


def _normal(
    scope: NameScope, constant: int, factors: dict[ModelTerm, int], ranges: dict[ModelTerm, Int], span: Span
) -> Operand | None:
    """Return `constant + sum(factor * term)` if all partial sums fit 64 bits, with and without the constant; else None
    with a mistake noted.
    """
    low = high = constant
    in_range = fits(constant)
    for term, factor in factors.items():
        ends = (factor * ranges[term].low, factor * ranges[term].high)
        low, high = low + min(ends), high + max(ends)
        in_range = in_range and all(map(fits, (factor, *ends, low, high, low - constant, high - constant)))
    if not in_range:
        scope.mistakes.add("E310", "the value of this sum may not fit 64 bits", span)
        return None
    if not factors:
        return Numeral(str(constant), constant, span, folded=True)
    terms = tuple((factor, term) for term, factor in factors.items())
    plain = constant == 0 and len(terms) == 1 and terms[0][0] == 1
    return Typed(Int(low, high), terms[0][1] if plain else Sum(constant, terms), "sum", span)


def _product(
    scope: NameScope, sign: int, node: tree.Unit | tree.Product, whole: Span
) -> tuple[int, Typed | None] | None:
    """Return a factor and the one term that it multiplies (None: a constant), or None with a mistake noted.

    `whole` is the span of the sum; several operands of a wrong type are one mistake there.
    """
    factor, variable, right = sign, None, True
    for part in node.factors if isinstance(node, tree.Product) else (node,):
        found = operand(scope, part)
        match found:
            case None:
                right = False
            case Numeral(whole=int(number)):
                factor *= number
            case Typed(Int()) if variable is None:
                variable = found
            case Typed(Int()):
                message = "a product of two variables"
                scope.mistakes.add("E309", message, node.span, hint="all factors but one are constants")
                right = False
            case _:
                right = _no_summand(scope, found, whole)
    return (factor, variable) if right else None


def _no_summand(scope: NameScope, found: Operand, whole: Span) -> bool:
    """Note why an operand is not allowed in a sum or product; return False."""
    match found:
        case Symbol(name) if name not in scope.names.constants.enum_values:
            scope.unknown(found)
        case Numeral() | Typed(Real()):
            scope.mistakes.add("E302", "sums and products are of ints, not of reals", whole)
        case _:
            scope.mistakes.add("E303", "sums and products are of ints, not of bools or enum values", whole)
    return False


# ---- comparison ----


def relate(
    scope: NameScope, relation: Operator, left: Operand | None, right: Operand | None, span: Span
) -> Cond | None:
    """Return `left relation right`, or None with a mistake noted; a comparison of constants is folded."""
    if left is None or right is None:
        return None
    if isinstance(left, Symbol) and isinstance(right, Symbol):
        _two_symbols(scope, left, right)
        return None
    settled = (_settle(scope, left, right), _settle(scope, right, left))
    match settled:
        case (Numeral() as first, Numeral() as second):
            return _fold(scope, relation, first, second)
        case (Typed() as first, Numeral() as second):
            constant = _opposite(scope, second, first, span)
            return Compare(relation, first.term, constant) if constant else None
        case (Numeral() as first, Typed() as second):
            constant = _opposite(scope, first, second, span)
            return Compare(relation, constant, second.term) if constant else None
        case (Typed() as first, Typed() as second):
            return _typed(scope, relation, first, second, span)
        case _:
            return None


def _two_symbols(scope: NameScope, left: Symbol, right: Symbol) -> None:
    unknown = [symbol for symbol in (left, right) if symbol.name not in scope.names.constants.enum_values]
    for symbol in unknown:
        scope.unknown(symbol)
    if not unknown:
        message = f"{quote(left.name)} and {quote(right.name)} are both enum values"
        scope.mistakes.add("E218", message, left.span, hint="one side is a term of the enum")


def _settle(scope: NameScope, this: Operand, other: Operand) -> Typed | Numeral | None:
    """Return one side of a comparison, a Symbol as a value of the other side's enum, or None with a mistake noted."""
    if not isinstance(this, Symbol):
        return this
    known = this.name in scope.names.constants.enum_values
    match other:
        case Typed(Enum(values) as kind) if this.name in values:
            return Typed(kind, Const(this.name), "constant", this.span)
        case Typed(Enum(values) as kind) if known:
            message = f"{quote(this.name)} is no value of {describe(kind)}"
            scope.mistakes.add("E218", message, this.span)
        case Typed(Enum(values)):
            message = f"unknown enum value {quote(this.name)}"
            scope.mistakes.unknown(
                "E209", message, this.name, this.span, lambda: values, scope.parameter_hint(this.name)
            )
        case _ if known:
            message = f"the enum value {quote(this.name)} does not stand opposite a term of its enum"
            scope.mistakes.add("E218", message, this.span)
        case _:
            scope.unknown(this)
    return None


def _fold(scope: NameScope, relation: Operator, left: Numeral, right: Numeral) -> Cond | None:
    """Return TRUE or FALSE, or None with a mistake noted: two ints compare as ints, otherwise both as doubles."""
    if left.whole is not None and right.whole is not None:
        return TRUE if OPERATORS[relation](left.whole, right.whole) else FALSE
    values = real(left, scope.mistakes), real(right, scope.mistakes)
    if values[0] is None or values[1] is None:
        return None
    return TRUE if OPERATORS[relation](*values) else FALSE


def _opposite(scope: NameScope, constant: Numeral, other: Typed, span: Span) -> Const | None:
    """Return a number as a constant of the type of the term that it is compared with: an int, or the nearest double.

    None with a mistake noted if that is impossible.
    """
    match other.type:
        case Int() if constant.whole is not None:
            if fits(constant.whole):
                return Const(constant.whole)
            scope.mistakes.add("E310", f"{quote(constant.text)} does not fit 64 bits", constant.span)
        case Real():
            value = real(constant, scope.mistakes)
            return None if value is None else Const(value)
        case Int():
            hint = f"{quote(constant.text)} is written as a real: write a whole number"
            _differ(scope, "an int", "a real", span, hint)
        case _:
            _differ(scope, describe(other.type), "a number", span)
    return None


def _differ(scope: NameScope, left: str, right: str, span: Span, hint: str = "") -> None:
    scope.mistakes.add("E301", f"{left} is compared with {right}", span, hint=hint)


def _typed(scope: NameScope, relation: Operator, left: Typed, right: Typed, span: Span) -> Cond | None:
    match left.type, right.type:
        case (Bool(), Bool()) | (Enum(), Enum()) if left.type == right.type:
            if relation not in ("==", "!="):
                no_order(scope, left.type, span)
                return None
        case Int() as one, Int() as other:
            if not _difference_fits(left, one, right, other):
                scope.mistakes.add("E310", "the difference of the two sides may not fit 64 bits", span)
                return None
        case Real(), Real():
            if not _reals(scope, left, right, span):
                return None
        case _:
            _differ(scope, describe(left.type), describe(right.type), span)
            return None
    if isinstance(left.term, Const) and isinstance(right.term, Const):
        return TRUE if OPERATORS[relation](left.term.value, right.term.value) else FALSE
    return Compare(relation, left.term, right.term)


def _difference_fits(left: Typed, one: Int, right: Typed, other: Int) -> bool:
    """Return whether the difference of two sides without their constants fits 64 bits: tables test that difference."""
    first, second = (side.term.constant if isinstance(side.term, Sum) else 0 for side in (left, right))
    low, high = one.low - first - (other.high - second), one.high - first - (other.low - second)
    return fits(low) and fits(high)


def no_order(scope: NameScope, kind: Type, span: Span) -> None:
    """Note that values of this type are not ordered."""
    scope.mistakes.add("E303", f"{describe(kind)} has no order", span, hint="it has `==`, `!=` and `in { … }`")


def _reals(scope: NameScope, left: Typed, right: Typed, span: Span) -> bool:
    """Return whether two reals may be compared: both are parameters, or the scope allows a real poster here.

    If not, note a mistake.
    """
    if left.term == right.term:
        scope.mistakes.add("E302", "a real is compared with itself", span)
        return False
    posters = [side for side in (left, right) if side.origin == "reading"]
    return not posters or scope.read("pair", quote(scope.mistakes.source.slice(posters[0].span)), span)
