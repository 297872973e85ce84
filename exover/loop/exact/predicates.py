"""What conditions of the model and atoms of formulas say of a state, exactly: as `exover.model.evaluate` does."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import assert_never

from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.term import Term
from exover.model.evaluate import OPERATORS
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Used,
)
from exover.model.expression import Term as ModelTerm
from exover.model.model import Parameter, Rule
from exover.model.types import Bool, Type
from exover.ocrd.vector import OUTCOMES

Bound = Mapping[str, tuple[Type, Term]]
"""Parameters by name, each with its type and its value."""


@dataclass(frozen=True, slots=True)
class TermScope:
    """What names without a module stand for: `params` of the subject, `own` those of the clause's request."""

    params: Bound = field(default_factory=dict)
    own: Bound = field(default_factory=dict)


@dataclass(frozen=True)
class Predicates:
    """Conditions on the state with the variables of the layout; `once_stopped`: with the stopping slots as idle."""

    layout: Layout
    once_stopped: bool = False

    def truth(self, cond: Cond, scope: TermScope | None = None) -> Term:
        """Return where a condition is true."""
        terms, scope = self.layout.terms, scope or TermScope()
        match cond:
            case Compare():
                return self._compare(cond, scope)
            case Status(phase, name, where):
                return terms.either(
                    terms.both((guard, self._where(name, where, values, scope)))
                    for guard, values in self._held(phase, name)
                )
            case Past(name, where):
                memory, vars_ = self.layout.memories[name], self.layout.vars
                values = tuple(vars_[value] for value in memory.values)
                return terms.both((vars_[memory.known], self._where(name, where, values, scope)))
            case Last(name, outcome):
                last = self.layout.vars[self.layout.memories[name].last]
                return terms.equal(last, terms.constant(OUTCOMES.index(outcome), "Int"))
            case Not(part):
                return terms.negation(self.truth(part, scope))
            case And(parts):
                return terms.both(self.truth(part, scope) for part in parts)
            case Or(parts):
                return terms.either(self.truth(part, scope) for part in parts)
            case _:
                assert_never(cond)

    def broken(self, rule: Rule) -> Term:
        """Return where the F of a rule holds: of a rule for each slot of a request, for some active slot."""
        if rule.slot_of is None:
            return self.truth(rule.condition)
        params = self.layout.model.request[rule.slot_of].params
        return self.layout.terms.either(
            self.layout.terms.both((guard, self.truth(rule.condition, TermScope(bound(params, values)))))
            for guard, values in self._held("active", rule.slot_of)
        )

    def concerns(self, request: str, where: Cond | None, values: tuple[Term, ...]) -> Term:
        """Return where these arguments of a request satisfy a condition."""
        return self._where(request, where, values, TermScope())

    def _where(self, request: str, where: Cond | None, values: tuple[Term, ...], scope: TermScope) -> Term:
        if where is None:
            return self.layout.terms.true
        each = self.layout.model.request[request]
        return self.truth(where, TermScope(bound((*each.params, *each.results), values), scope.params))

    def _held(self, phase: str, name: str) -> Iterator[tuple[Term, tuple[Term, ...]]]:
        """Yield where each slot of the request is in this phase, or its place is taken, and what it holds."""
        terms, vars_ = self.layout.terms, self.layout.vars
        if phase == "waiting":
            place = self.layout.places[name]
            yield vars_[place.taken], tuple(vars_[value] for value in place.args)
            return
        for number in range(self.layout.model.request[name].instances):
            slot = self.layout.slots[name, number]
            active, stopping = vars_[slot.active], vars_[slot.stopping]
            running = terms.both((active, terms.negation(stopping)))
            idle = terms.false
            guard = {
                "active": running if self.once_stopped else active,
                "running": running,
                "stopping": idle if self.once_stopped else terms.both((active, stopping)),
            }[phase]
            yield guard, tuple(vars_[value] for value in slot.args)

    # ---- comparisons ----

    def _compare(self, cond: Compare, scope: TermScope) -> Term:
        terms, op = self.layout.terms, cond.operator
        if isinstance(cond.left, Const) and isinstance(cond.right, Const):
            return terms.truth(OPERATORS[op](cond.left.value, cond.right.value))
        kind = self._type(cond.left, scope) or self._type(cond.right, scope)
        left, right = self._value(cond.left, kind, scope), self._value(cond.right, kind, scope)
        match op:
            case "==":
                return terms.equal(left, right)
            case "!=":
                return terms.negation(terms.equal(left, right))
            case "<":
                return terms.less(left, right)
            case "<=":
                return terms.at_most(left, right)
            case ">":
                return terms.less(right, left)
            case ">=":
                return terms.at_most(right, left)
            case _:
                assert_never(op)

    def _type(self, term: ModelTerm, scope: TermScope) -> Type | None:
        """Return the type of what a name stands for; None of a constant and of an integer expression."""
        match term:
            case Param(name):
                return scope.params[name][0]
            case Own(name):
                return scope.own[name][0]
            case Reading(name):
                variable = self.layout.model.variable.get(name)
                return variable.type if variable else Bool()
            case _:
                return None

    def _value(self, term: ModelTerm, kind: Type | None, scope: TermScope) -> Term:
        terms = self.layout.terms
        match term:
            case Const(value):
                return terms.constant(int(value), "Int") if kind is None else self.layout.value(kind, value)
            case Param(name):
                return scope.params[name][1]
            case Own(name):
                return scope.own[name][1]
            case Reading(name):
                return self.layout.vars[name]
            case Level(resource):
                return self.layout.vars[level_name(resource)]
            case Used(resource):
                return terms.sum(0, self._shares(resource))
            case Count(requests):
                guards = [guard for name in requests for guard, _ in self._held("active", name)]
                return terms.sum(0, [(1, self._counted(guard)) for guard in guards])
            case Sum(constant, parts):
                return terms.sum(constant, [(factor, self._value(part, None, scope)) for factor, part in parts])
            case _:
                assert_never(term)

    def _shares(self, resource: str) -> Iterator[tuple[int, Term]]:
        for request in self.layout.model.requests:
            for share in request.shares:
                if share.resource == resource:
                    for guard, values in self._held("active", request.name):
                        counts = self.concerns(request.name, share.when, values)
                        yield share.amount, self._counted(self.layout.terms.both((guard, counts)))

    def _counted(self, guard: Term) -> Term:
        terms = self.layout.terms
        return terms.choose(guard, terms.constant(1, "Int"), terms.constant(0, "Int"))


def bound(parameters: tuple[Parameter, ...], values: tuple[Term, ...]) -> Bound:
    """Return the values by parameter name; values or parameters past the shorter list are left out."""
    return {p.name: (p.type, value) for p, value in zip(parameters, values, strict=False)}
