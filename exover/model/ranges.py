"""Comparisons that have the same truth value in every state.

The ranges decide them: `wind > 99` for a wind in 0 .. 60, `used(power) > 80` if all users together have 60, and
`wind in 5 .. 3`; or the values that are ever set: `place == cabin` for a module state that no clause sets to `cabin`,
and a latch whose condition is fixed; or both sides are one term: `side == side`, where `side == self.side` was meant.
"""

from collections.abc import Iterator, Mapping
from dataclasses import field
from functools import cached_property

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
    latches: int = 0
    """Through how many latches, each of which reads the next, a range decides it."""

    def __str__(self) -> str:
        """Return a clause for messages that says what is decided and why."""
        return f"`{self.comparison}` is {str(self.truth).lower()} whatever happens: {self.ranges}"


@dataclass(frozen=True)
class Ranges:
    """What the ranges and values of a model decide."""

    model: Model
    _latches: dict[str, tuple[tuple[Value, ...], str, int]] = field(default_factory=dict)

    def decided(self, cond: Cond, params: tuple[Parameter, ...] = ()) -> Iterator[FixedComparison]:
        """Yield the empty ranges, then the comparisons of numbers that ranges decide, those of a state or a latch with
        a constant that the values decide which it can have, and those of a term with itself, in the order of the text,
        those inside `with` included.

        `params`: the parameters that the condition may read. Comparisons of two constants are not yielded, nor
        is the end of a range that is always kept where the other end is not: `hour in 0 .. 5`.
        """
        yield from self._in_condition(cond, {param.name: param.type for param in params}, {})

    def _in_condition(self, cond: Cond, own: Types, outer: Types) -> Iterator[FixedComparison]:
        yield from _empty(cond)
        open_ends = self._open_ends(cond, own, outer)
        for atom in atoms(cond):
            match atom:
                case Status(_, name, where) | Past(name, where) if where is not None:
                    request = self.model.request[name]
                    inner = {param.name: param.type for param in (*request.params, *request.results)}
                    yield from self._in_condition(where, inner, own)
                case Compare():
                    found = self._fixed(atom, own, outer)
                    if found is not None and atom not in open_ends:
                        yield found
                case _:
                    pass

    def _fixed(self, atom: Compare, own: Types, outer: Types) -> FixedComparison | None:
        return _of_one(atom, outer) or self._of_state(atom) or self._decided(atom, own, outer)

    def _open_ends(self, cond: Cond, own: Types, outer: Types) -> set[Compare]:
        """Return the ends of ranges that are always kept where the other end is not."""
        found = set[Compare]()
        for pair in _ranges(cond):
            fixed = {end: self._fixed(end, own, outer) for end in pair}
            kept = {end for end, known in fixed.items() if known is not None and known.truth}
            found |= kept if len(kept) == 1 else set()
        return found

    def _of_state(self, atom: Compare) -> FixedComparison | None:
        """Return a comparison of a module state or a latch with a constant if all its values decide it alike."""
        match atom.left, atom.right:
            case (Reading(name), Const(value)) | (Const(value), Reading(name)):
                values, why, latches = self._values_of(name)
            case _:
                return None
        pairs = ((each, value) if isinstance(atom.left, Reading) else (value, each) for each in values)
        truths = {OPERATORS[atom.operator](*pair) for pair in pairs}
        return FixedComparison(condition_text(atom), truths.pop(), why, latches) if len(truths) == 1 else None

    def _values_of(self, name: str) -> tuple[tuple[Value, ...], str, int]:
        """Return the values that a module state or a latch can have, and in words why, through so many latches; none if
        that is not known.

        Those of a state are its initial value and those that `on` clauses set; a latch has one if its condition is
        fixed.
        """
        variable = self.model.variable.get(name)
        if variable is None:
            return self._latch(name)
        if variable.kind != "state":
            return (), "", 0
        values = self._values_of_states[name]
        return values, f"{name} is {' or '.join(map(value_text, values))}", 0

    @cached_property
    def _values_of_states(self) -> dict[str, tuple[Value, ...]]:
        found = {each.name: {each.initial: None} for each in self.model.variables if each.kind == "state"}
        for effect in (each for request in self.model.requests for each in request.effects):
            if isinstance(effect, SetState):
                found[effect.state][effect.value] = None
        return {name: tuple(values) for name, values in found.items()}

    def _latch(self, name: str) -> tuple[tuple[Value, ...], str, int]:
        """Return the values of a latch, and why; each is found after those before it, which alone it may read."""
        for latch in self.model.latches[len(self._latches) :]:
            if name in self._latches:
                break
            self._latches[latch.name] = self._values_of_latch(latch)
        return self._latches[name]

    def _values_of_latch(self, latch: Latch) -> tuple[tuple[Value, ...], str, int]:
        fixed = truth(latch.condition, self._known)
        if fixed is None:
            return (), "", 0
        found = tuple(dict.fromkeys(self.decided(latch.condition)))
        why = "; ".join(map(_reason, found)) or "its condition is constant"
        return (fixed,), why, 1 + max((each.latches for each in found), default=0)

    def _known(self, part: Cond) -> bool | None:
        found = self._fixed(part, {}, {}) if isinstance(part, Compare) else None
        return None if found is None else found.truth

    def _decided(self, atom: Compare, own: Types, outer: Types) -> FixedComparison | None:
        ranges: dict[ModelTerm, tuple[Number, Number]] = {}
        for leaf in (*leaves(atom.left), *leaves(atom.right)):
            if not isinstance(leaf, Const):
                span = self._span(leaf, own, outer)
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

    def _span(self, leaf: ModelTerm, own: Types, outer: Types) -> tuple[Number, Number] | None:
        """Return the least and the greatest value of a term, infinities of a real without bounds; None if none."""
        match leaf:
            case Reading(name):
                kind = self.model.variable[name].type if name in self.model.variable else None
            case Level(name):
                return 0, self.model.resource[name].capacity
            case Used(name):
                return 0, sum(_slots(each) * most_held(self.model, each, name) for each in self.model.requests)
            case Count(names):
                return 0, sum(_slots(self.model.request[each]) for each in names)
            case Param(name):
                kind = own.get(name)
            case Own(name):
                kind = outer.get(name)
            case _:
                kind = None
        return (kind.low, kind.high) if isinstance(kind, Int | Real) else None


def _reason(fixed: FixedComparison) -> str:
    """Return a comparison with its value, and why; a reason that lies behind a second latch is left to that."""
    text = f"`{fixed.comparison}` is {value_text(fixed.truth)}"
    return f"{text}, {fixed.ranges}" if fixed.latches < 2 else text


def _empty(cond: Cond) -> Iterator[FixedComparison]:
    for low, high in _ranges(cond):
        least, most = (end.right.value for end in (low, high) if isinstance(end.right, Const))
        if not isinstance(least, str) and not isinstance(most, str) and least > most:
            text = f"{term_text(low.left)} in {value_text(least)} .. {value_text(most)}"
            yield FixedComparison(text, False, "the bounds are swapped")


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


def _slots(request: Request) -> int:
    """Return how many slots of a request may count as active: one more if a newcomer may interrupt its own request."""
    return request.instances + request.interrupts_self


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
