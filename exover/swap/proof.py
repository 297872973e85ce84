"""Translates each rule of NEW to a condition on the states of OLD in which the rule would be broken.

The condition is an over-approximation: it holds in all states in which the rule is broken, perhaps in more, so a swap
may be refused without need. For a rule that no such condition can express, the result is None.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    AtomicCond,
    Compare,
    Cond,
    Const,
    Count,
    Last,
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
    operands,
    with_atoms,
)
from exover.model.model import Rule
from exover.model.property import Atom, Formula, Negation, Property, some_finally
from exover.model.reads import users
from exover.model.types import Enum, Type
from exover.swap import record
from exover.swap.carry import Carry
from exover.swap.folding import folded
from exover.swap.latching import Latching
from exover.swap.later import BrokenLater

Values = tuple[str, ...] | None
"""The values of OLD that a term may have if it is of an enum, else None."""


class Unsayable(Exception):
    """No condition on the states of OLD can express a rule of NEW."""


@dataclass(frozen=True)
class Obligations:
    """The properties that OLD must have for NEW to take over; `ended`: requests of OLD that are idle by then."""

    carry: Carry
    later: BrokenLater
    ended: frozenset[str]

    @cached_property
    def _latching(self) -> Latching:
        return Latching(self.carry.new.model)

    def properties(self, rules: Iterable[Rule]) -> Iterator[tuple[Rule, Property | None]]:
        """Yield each of these rules of NEW that may be broken, with the property of OLD that it never is; None if no
        property can express that.
        """
        for number, rule in enumerate(rules):
            try:
                bad = folded(Or((self._broken(rule), self._broken_later(rule))))
            except Unsayable:
                yield rule, None
                continue
            if bad != FALSE:
                yield rule, _never(f"{number}", Atom(And((bad, *self._idle()))), rule)

    def _idle(self) -> Iterator[Cond]:
        for name in sorted(self.ended):
            yield Not(Status("active", name))

    def about(self, rule: Rule) -> tuple[str, ...]:
        """Return the requests of OLD that are still active and that a rule depends on, in the order of the text."""
        model = self.carry.new.model
        conditions = (rule.condition, self.later.of(rule) or TRUE)
        named = {part for cond in conditions for atom in atoms(cond) for part in _requests(atom)}
        used = (term.resource for term in operands(rule.condition) if isinstance(term, Used))
        named |= {name for resource in used for name in users(model, resource)}
        named |= {rule.slot_of} if rule.slot_of else set()
        return tuple(r.name for r in self.carry.old.model.requests if r.name in named and r.name not in self.ended)

    # ---- rules ----

    def _broken(self, rule: Rule) -> Cond:
        """Return where a rule is broken before NEW looks at its latches, or after."""
        before, after = (self._breaks(rule, cond) for cond in (rule.condition, self._latching.latched(rule.condition)))
        return before if before == after else Or((before, after))

    def _broken_later(self, rule: Rule) -> Cond:
        """Return where later steps of NEW may break a rule."""
        found = self.later.of(rule)
        if found is None:
            raise Unsayable
        return self._cond(found, False)

    def _breaks(self, rule: Rule, condition: Cond) -> Cond:
        """Return where a rule is broken that has this condition."""
        once_stopped = self.later.questions.restored(rule)
        if rule.slot_of is None:
            return self._cond(condition, once_stopped)
        if self._gone(rule.slot_of):
            return FALSE
        parts = condition.parts if isinstance(condition, And) else (condition,)
        own = [part for part in parts if _of_arguments(part)]
        others = [part for part in parts if not _of_arguments(part)]
        if any(_mentions_arguments(part) for part in others):
            raise Unsayable
        where = self._arguments(And(tuple(own)), rule.slot_of) if own else None
        phase: Status = Status("running" if once_stopped else "active", rule.slot_of, where)
        return And((phase, *(self._cond(part, once_stopped) for part in others)))

    def _gone(self, request: str) -> bool:
        return request in self.ended or request not in self.carry.old.model.request

    # ---- conditions of NEW in the words of OLD ----

    def _cond(self, cond: Cond, once_stopped: bool) -> Cond:
        match cond:
            case And(parts):
                return And(tuple(self._cond(part, once_stopped) for part in parts))
            case Or(parts):
                return Or(tuple(self._cond(part, once_stopped) for part in parts))
            case Not(part):
                if once_stopped and any(map(_counts, operands(part))):
                    raise Unsayable
                return Not(self._cond(part, once_stopped))
            case Status(phase, request, where):
                if self._gone(request):
                    return FALSE
                inner = None if where is None else self._arguments(where, request)
                return Status("running" if once_stopped and phase == "active" else phase, request, inner)
            case Past(request, where):
                return self._past(request, None if where == TRUE else where)
            case Last(request, outcome):
                kept = self.carry.remembers(record.CarriedLast(request, True))
                return cond if kept else TRUE if outcome == "none" else FALSE
            case Compare():
                return self._compare(cond, once_stopped)
            case _:
                assert_never(cond)

    def _past(self, request: str, where: Cond | None) -> Cond:
        """Return the condition on a past of OLD for one of NEW, which NEW remembers as a flag."""
        flag = record.CarriedPast(request, where)
        if flag not in self.carry.after:
            raise Unsayable
        return Past(request, where) if self.carry.remembers(flag) else FALSE

    def _compare(self, cond: Compare, once_stopped: bool) -> Cond:
        if once_stopped and any(map(_counts, operands(cond))) and not _grows(cond):
            raise Unsayable
        return _valued(Compare(cond.operator, self._term(cond.left), self._term(cond.right)), self._values)

    def _term(self, term: ModelTerm) -> ModelTerm:
        match term:
            case Const() | Param() | Own():
                return term
            case Reading(name):
                return self._reading(name)
            case Level(resource):
                if self.carry.remembers(record.CarriedLevel(resource, True)):
                    return term
                return Const(self.carry.new.model.resource[resource].initial)
            case Count(requests):
                return Count(tuple(name for name in requests if not self._gone(name)))
            case Used(resource):
                return self._used(resource)
            case Sum(constant, terms):
                return Sum(constant, tuple((factor, self._term(part)) for factor, part in terms))
            case _:
                assert_never(term)

    def _reading(self, name: str) -> ModelTerm:
        ways = [
            number for number in self.carry.after if isinstance(number, record.CarriedReading) and number.name == name
        ]
        if any(number.how != "unread" and self.carry.remembers(number) for number in ways):
            return Reading(name)
        return Const(self.later.questions.start.readings[name])

    def _used(self, resource: str) -> ModelTerm:
        """Return the used share of a resource, counting for each active slot all shares that it may have."""
        terms: list[tuple[int, ModelTerm]] = []
        for request in self.carry.new.model.requests:
            shares = [share.amount for share in request.shares if share.resource == resource]
            if shares and not self._gone(request.name):
                terms.append((sum(shares), Count((request.name,))))
        return Sum(0, tuple(terms))

    # ---- arguments ----

    def _arguments(self, where: Cond, request: str) -> Cond:
        """Return a condition on arguments of NEW as one on those of OLD."""
        old = self.carry.old.model.request[request]
        types = {parameter.name: parameter.type for parameter in (*old.params, *old.results)}

        def values(term: ModelTerm) -> Values:
            return _enum_values(types[term.name]) if isinstance(term, Param) else _constant_value(term)

        def known(atom: AtomicCond) -> Cond:
            return _valued(atom, values) if isinstance(atom, Compare) else atom

        return folded(with_atoms(where, known))

    def _values(self, term: ModelTerm) -> Values:
        variables = self.carry.old.model.variable
        match term:
            case Reading(name) if name in variables:
                return _enum_values(variables[name].type)
            case _:
                return _constant_value(term)


def _valued(cond: Compare, values: Callable[[ModelTerm], Values]) -> Cond:
    """Return a comparison of NEW as one on terms of OLD: enums are compared by the names of the values that both have
    in OLD, since there they may be two types.
    """
    mine, other = values(cond.left), values(cond.right)
    if mine is None or other is None or mine == other:
        return cond
    both = [value for value in mine if value in other]
    same = Or(tuple(And((_is(cond.left, value), _is(cond.right, value))) for value in both))
    return same if cond.operator == "==" else Not(same)


def _is(term: ModelTerm, value: str) -> Cond:
    return TRUE if isinstance(term, Const) else Compare("==", term, Const(value))


def _enum_values(kind: Type) -> Values:
    return kind.values if isinstance(kind, Enum) else None


def _constant_value(term: ModelTerm) -> Values:
    return (term.value,) if isinstance(term, Const) and isinstance(term.value, str) else None


def _never(name: str, bad: Formula, rule: Rule) -> Property:
    return Property(name, None, "never", Negation(some_finally(bad)), None, rule.location)


def _requests(atom: Cond) -> Iterable[str]:
    match atom:
        case Status(_, request):
            return (request,)
        case Compare():
            return [name for term in operands(atom) if isinstance(term, Count) for name in term.requests]
        case _:
            return ()


def _of_arguments(cond: Cond) -> bool:
    """Return whether a condition reads only arguments of its slot."""
    return all(isinstance(atom, Compare) for atom in atoms(cond)) and all(
        isinstance(term, Const | Param) for term in operands(cond)
    )


def _mentions_arguments(cond: Cond) -> bool:
    found = any(isinstance(term, Param | Own) for term in operands(cond))
    inner = (atom.where for atom in atoms(cond) if isinstance(atom, Status | Past) and atom.where is not None)
    return found or any(isinstance(term, Own) for where in inner for term in operands(where))


def _grows(cond: Compare) -> bool:
    """Return whether a comparison is monotonic in the active slots: more of them never make it false."""
    return cond.operator in (">", ">=") and not any(map(_counts, operands(replace(cond, left=Const(0)))))


def _counts(term: ModelTerm) -> bool:
    """Return whether a term grows with the active slots; that of OLD is never less than that of NEW."""
    return isinstance(term, Used | Count)
