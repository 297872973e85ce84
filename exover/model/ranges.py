"""Comparisons that have the same truth value in every state.

The ranges decide them: `wind > 99` for a wind in 0 .. 60, `used(power) > 80` if all users together have 60, and
`wind in 5 .. 3`; or the values that are ever set: `place == cabin` for a module state that no clause sets to `cabin`,
and a latch whose condition is fixed; or both sides are one term: `side == side`, where `side == self.side` was meant.
"""

from collections.abc import Iterator, Mapping

from exover.dataclass import dataclass
from exover.model.evaluate import OPERATORS
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Level,
    ModelTerm,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
    atoms,
    leaves,
)
from exover.model.kleene import truth
from exover.model.model import Latch, Model, Parameter, Request, SetState
from exover.model.shares import most_held
from exover.model.types import Int, Real, Type, Value
from exover.model.wording import condition_text, term_text, value_text

Number = int | float
Types = Mapping[str, Type]


@dataclass(frozen=True, slots=True)
class FixedComparison:
    """A comparison that has the value `truth` in every state; `ranges` says in words why."""

    comparison: str
    truth: bool
    ranges: str

    def __str__(self) -> str:
        """Return a clause for messages that says what is decided and why."""
        return f"`{self.comparison}` is {str(self.truth).lower()} whatever happens: {self.ranges}"


def decided(model: Model, cond: Cond, params: tuple[Parameter, ...] = ()) -> Iterator[FixedComparison]:
    """Yield the empty ranges, then the comparisons of numbers that ranges decide, those of a state or a latch with a
    constant that the values decide which it can have, and those of a term with itself, in the order of the text,
    those inside `with` included.

    `params`: the parameters that the condition may read. Comparisons of two constants are not yielded, nor
    is the end of a range that is always kept where the other end is not: `hour in 0 .. 5`.
    """
    yield from _in_condition(model, cond, {param.name: param.type for param in params}, {})


def _in_condition(model: Model, cond: Cond, own: Types, outer: Types) -> Iterator[FixedComparison]:
    yield from _empty(cond)
    open_ends = _open_ends(model, cond, own, outer)
    for atom in atoms(cond):
        match atom:
            case Status(_, name, where) | Past(name, where) if where is not None:
                request = model.request[name]
                inner = {param.name: param.type for param in (*request.params, *request.results)}
                yield from _in_condition(model, where, inner, own)
            case Compare():
                found = _fixed(model, atom, own, outer)
                if found is not None and atom not in open_ends:
                    yield found
            case _:
                pass


def _fixed(model: Model, atom: Compare, own: Types, outer: Types) -> FixedComparison | None:
    return _of_one(atom, outer) or _of_state(model, atom) or _decided(model, atom, own, outer)


def _empty(cond: Cond) -> Iterator[FixedComparison]:
    for low, high in _ranges(cond):
        least, most = (end.right.value for end in (low, high) if isinstance(end.right, Const))
        if not isinstance(least, str) and not isinstance(most, str) and least > most:
            text = f"{term_text(low.left)} in {value_text(least)} .. {value_text(most)}"
            yield FixedComparison(text, False, "the bounds are swapped")


def _open_ends(model: Model, cond: Cond, own: Types, outer: Types) -> set[Compare]:
    """Return the ends of ranges that are always kept where the other end is not."""
    found = set[Compare]()
    for pair in _ranges(cond):
        fixed = {end: _fixed(model, end, own, outer) for end in pair}
        kept = {end for end, known in fixed.items() if known is not None and known.truth}
        found |= kept if len(kept) == 1 else set()
    return found


def _ranges(cond: Cond) -> Iterator[tuple[Compare, Compare]]:
    """Yield both ends of each range; the model spells out `x in 3 .. 5` as `x >= 3 and x <= 5`."""
    match cond:
        case And((Compare(">=", one, Const()) as low, Compare("<=", other, Const()) as high)) if one == other:
            yield low, high
        case Not(part):
            yield from _ranges(part)
        case And(parts) | Or(parts):
            for part in parts:
                yield from _ranges(part)
        case _:
            pass


def _of_one(atom: Compare, outer: Types) -> FixedComparison | None:
    """Return a comparison of a term with itself."""
    if atom.left != atom.right or isinstance(atom.left, Const):
        return None
    meant = isinstance(atom.left, Param) and atom.left.name in outer
    hint = f"; did you mean `self.{term_text(atom.left)}`?" if meant else ""
    return FixedComparison(condition_text(atom), OPERATORS[atom.operator](0, 0), f"both sides are the same{hint}")


def _of_state(model: Model, atom: Compare) -> FixedComparison | None:
    """Return a comparison of a module state or a latch with a constant if all values it can have decide it alike."""
    match atom.left, atom.right:
        case (Reading(name), Const(value)) | (Const(value), Reading(name)):
            values, why = _values_of(model, name)
        case _:
            return None
    pairs = ((each, value) if isinstance(atom.left, Reading) else (value, each) for each in values)
    truths = {OPERATORS[atom.operator](*pair) for pair in pairs}
    return FixedComparison(condition_text(atom), truths.pop(), why) if len(truths) == 1 else None


def _values_of(model: Model, name: str) -> tuple[tuple[Value, ...], str]:
    """Return the values that a module state or a latch can have, and in words why; none if that is not known.

    Those of a state are its initial value and those that `on` clauses set; a latch has one if its condition is fixed.
    """
    variable = model.variable.get(name)
    if variable is None:
        return _values_of_latch(model, next(latch for latch in model.latches if latch.name == name))
    if variable.kind != "state":
        return (), ""
    effects = (each for request in model.requests for each in request.effects)
    set_to = (each.value for each in effects if isinstance(each, SetState) and each.state == name)
    values = tuple(dict.fromkeys((variable.initial, *set_to)))
    return values, f"{name} is {' or '.join(map(value_text, values))}"


def _values_of_latch(model: Model, latch: Latch) -> tuple[tuple[Value, ...], str]:
    fixed = truth(latch.condition, lambda part: _known(model, part))
    why = (
        f"`{each.comparison}` is {value_text(each.truth)}, {each.ranges}" for each in decided(model, latch.condition)
    )
    return ((), "") if fixed is None else ((fixed,), "; ".join(dict.fromkeys(why)))


def _known(model: Model, part: Cond) -> bool | None:
    found = _fixed(model, part, {}, {}) if isinstance(part, Compare) else None
    return None if found is None else found.truth


def _decided(model: Model, atom: Compare, own: Types, outer: Types) -> FixedComparison | None:
    ranges: dict[ModelTerm, tuple[Number, Number]] = {}
    for leaf in (*leaves(atom.left), *leaves(atom.right)):
        if not isinstance(leaf, Const):
            span = _span(model, leaf, own, outer)
            if span is None:
                return None
            ranges[leaf] = span
    ends = _ends(atom.left, ranges), _ends(atom.right, ranges)
    if not ranges or ends[0] is None or ends[1] is None:
        return None
    truth = _truth(atom.operator, ends[0], ends[1])
    if truth is None:
        return None
    words = " and ".join(
        f"{term_text(leaf)} lies in {value_text(low)} .. {value_text(high)}" for leaf, (low, high) in ranges.items()
    )
    return FixedComparison(condition_text(atom), truth, words)


def _slots(request: Request) -> int:
    """Return how many slots of a request may count as active: one more if a newcomer may interrupt its own request."""
    return request.instances + request.interrupts_self


def _span(model: Model, leaf: ModelTerm, own: Types, outer: Types) -> tuple[Number, Number] | None:
    """Return the least and the greatest value of a term, for a real without bounds infinities; None for no number."""
    match leaf:
        case Reading(name):
            kind = model.variable[name].type if name in model.variable else None
        case Level(name):
            return 0, model.resource[name].capacity
        case Used(name):
            return 0, sum(_slots(each) * most_held(model, each, name) for each in model.requests)
        case Count(names):
            return 0, sum(_slots(model.request[each]) for each in names)
        case Param(name):
            kind = own.get(name)
        case Own(name):
            kind = outer.get(name)
        case _:
            kind = None
    return (kind.low, kind.high) if isinstance(kind, Int | Real) else None


def _ends(term: ModelTerm, ranges: Mapping[ModelTerm, tuple[Number, Number]]) -> tuple[Number, Number] | None:
    match term:
        case Const(bool() | str()):
            return None
        case Const(int() | float() as value):
            return value, value
        case Sum(constant, parts):
            low: Number = constant
            high: Number = constant
            for factor, part in parts:
                ends = _ends(part, ranges)
                if ends is None:
                    return None
                one, other = factor * ends[0], factor * ends[1]
                low, high = low + min(one, other), high + max(one, other)
            return low, high
        case _:
            return ranges[term]


def _truth(operator: str, left: tuple[Number, Number], right: tuple[Number, Number]) -> bool | None:
    """Return the truth value that a comparison has for all numbers of two ranges, None if not all agree.

    Equality of two ranges of one same number is not decided: None.
    """
    (low, high), (least, most) = left, right
    apart = high < least or most < low
    match operator:
        case "==" | "!=":
            return operator == "!=" if apart else None
        case _:
            outcomes = {OPERATORS[operator](low, most), OPERATORS[operator](high, least)}
            return outcomes.pop() if len(outcomes) == 1 else None
