"""Conditions of the model as formulas over exact states, of any kind: terms, or the text of certificates.

It mirrors `exover.model.evaluate`, which decides them in one state. Decision diagrams read conditions on argument
classes instead (`exover.loop.finite.predicates`).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Generic, TypeVar, assert_never

from exover.dataclass import dataclass
from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    ModelTerm,
    Not,
    Operator,
    Or,
    Own,
    Param,
    Past,
    Phase,
    Reading,
    Status,
    Sum,
    Used,
)
from exover.model.model import Model, Parameter, Rule
from exover.model.types import Real, Type, Value
from exover.ocrd.vector import OUTCOMES

T = TypeVar("T")
"""A formula or a number."""
TypedValues = Mapping[str, tuple[Type, T]]
"""Parameters by name, each with its type and its value."""


@dataclass(frozen=True, slots=True)
class FormulaScope(Generic[T]):
    """The values of names without a module: `params` of the subject, `own` of the request whose clause it is."""

    params: TypedValues[T] = field(default_factory=dict)
    own: TypedValues[T] = field(default_factory=dict)


class ConditionFormulas(ABC, Generic[T]):
    """Makes formulas over the variables of one state; `once_stopped`: with the stopping slots as idle."""

    @property
    @abstractmethod
    def model(self) -> Model:
        """The model."""

    @abstractmethod
    def both(self, parts: Iterable[T]) -> T:
        """Return the conjunction."""

    @abstractmethod
    def either(self, parts: Iterable[T]) -> T:
        """Return the disjunction."""

    @abstractmethod
    def negation(self, part: T) -> T:
        """Return the negation."""

    @abstractmethod
    def held(self, phase: Phase, request: str) -> Iterator[tuple[T, TypedValues[T]]]:
        """Yield for each slot (or the waiting place) the condition that it is in this phase, and what it holds."""

    @abstractmethod
    def past(self, request: str) -> tuple[T, TypedValues[T]]:
        """Return the condition that a request has a past, and the arguments and results of that."""

    @abstractmethod
    def ended(self, request: str, outcome: int) -> T:
        """Return the condition that the last instance of a request ended with the outcome of this number."""

    @abstractmethod
    def compared(self, left: T, operator: Operator, right: T) -> T:
        """Return the comparison of two values."""

    @abstractmethod
    def constant(self, kind: Type | None, value: Value) -> T:
        """Return a value of a type; None: an integer."""

    @abstractmethod
    def reading(self, name: str) -> tuple[Type, T]:
        """Return the type and the value of a poster, state or latch."""

    @abstractmethod
    def level(self, resource: str) -> T:
        """Return the level of a consumable."""

    @abstractmethod
    def counted(self, amounts: Sequence[tuple[int, T]]) -> T:
        """Return the sum of the amounts whose conditions are true."""

    @abstractmethod
    def sum(self, constant: int, parts: Sequence[tuple[int, T]]) -> T:
        """Return `constant + sum(factor * value)`."""

    # ---- conditions ----

    def truth(self, cond: Cond, scope: FormulaScope[T] | None = None) -> T:
        """Return the formula of a condition."""
        scope = scope or FormulaScope()
        match cond:
            case Compare():
                return self.comparison(cond, scope)
            case Status(phase, name, where):
                return self.either(self._held(phase, name, where, scope))
            case Past(name, where):
                known, values = self.past(name)
                return self.both([known, *self._where(where, values, scope)])
            case Last(name, outcome):
                return self.ended(name, OUTCOMES.index(outcome))
            case Not(part):
                return self.negation(self.truth(part, scope))
            case And(parts):
                return self.both(self.truth(part, scope) for part in parts)
            case Or(parts):
                return self.either(self.truth(part, scope) for part in parts)
            case _:
                assert_never(cond)

    def broken(self, rule: Rule) -> T:
        """Return the formula of a rule's F; if the rule stands for each slot of a request, for some active slot."""
        if rule.slot_of is None:
            return self.truth(rule.condition)
        held = self.held("active", rule.slot_of)
        return self.either(
            self.both([guard, self.truth(rule.condition, FormulaScope(values))]) for guard, values in held
        )

    def _held(self, phase: Phase, name: str, where: Cond | None, scope: FormulaScope[T]) -> Iterator[T]:
        for guard, values in self.held(phase, name):
            yield self.both([guard, *self._where(where, values, scope)])

    def _where(self, where: Cond | None, values: TypedValues[T], scope: FormulaScope[T]) -> list[T]:
        """Return at most one formula: that the values satisfy the condition, if there is one."""
        return [] if where is None else [self.truth(where, FormulaScope(values, scope.params))]

    # ---- comparisons ----

    def comparison(self, cond: Compare, scope: FormulaScope[T]) -> T:
        """Return where a comparison is true."""
        kind = self._type(cond.left, scope) or self._type(cond.right, scope)
        left, right = self._value(cond.left, kind, scope), self._value(cond.right, kind, scope)
        return self.compared(left, cond.operator, right)

    def _type(self, term: ModelTerm, scope: FormulaScope[T]) -> Type | None:
        """Return the type of a name's value; None for an integer expression."""
        match term:
            case Param(name):
                return scope.params[name][0]
            case Own(name):
                return scope.own[name][0]
            case Reading(name):
                return self.reading(name)[0]
            case Const(float()):
                return Real()
            case _:
                return None

    def _value(self, term: ModelTerm, kind: Type | None, scope: FormulaScope[T]) -> T:
        match term:
            case Const(value):
                return self.constant(kind, value)
            case Param(name):
                return scope.params[name][1]
            case Own(name):
                return scope.own[name][1]
            case Reading(name):
                return self.reading(name)[1]
            case Level(resource):
                return self.level(resource)
            case Used(resource):
                return self.counted(list(self._shares(resource)))
            case Count(requests):
                return self.counted([(1, guard) for name in requests for guard, _ in self.held("active", name)])
            case Sum(constant, parts):
                return self.sum(constant, [(factor, self._value(part, None, scope)) for factor, part in parts])
            case _:
                assert_never(term)

    def _shares(self, resource: str) -> Iterator[tuple[int, T]]:
        for request in self.model.requests:
            for share in request.shares:
                if share.resource == resource:
                    for guard in self._held("active", request.name, share.when, FormulaScope()):
                        yield share.amount, guard


def bound(parameters: tuple[Parameter, ...], values: Iterable[T]) -> TypedValues[T]:
    """Return the values by parameter name; values or parameters past the shorter list are left out."""
    return {p.name: (p.type, value) for p, value in zip(parameters, values, strict=False)}
