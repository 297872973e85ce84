"""Random formulas of CTL and LTL, and random assumptions, over what conditions of a properties file may read."""

from dataclasses import dataclass
from random import Random

from exover.model.expression import Compare, Cond, Const, Last, Operator, Outcome, Param, Past, Phase, Reading, Status
from exover.model.model import NOWHERE, Model, Parameter, Variable
from exover.model.property import (
    TRUE,
    Assumption,
    Atom,
    Conjunction,
    Disjunction,
    Form,
    Formula,
    Happened,
    Negation,
    Next,
    Occurrence,
    Properties,
    Property,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
)
from exover.model.types import Bool, Enum, Int, Real, Type

PHASES: tuple[Phase, ...] = ("active", "running", "stopping", "waiting")
OUTCOMES: tuple[Outcome, ...] = ("none", "ok", "failed", "interrupted")
OCCURRENCES: tuple[Occurrence, ...] = ("asked", "launched", "rejected", "killed", "ended")
ORDERS: tuple[Operator, ...] = ("==", "!=", "<", "<=", ">", ">=")


@dataclass
class Formulas:
    """Writes random formulas; equal generators give equal ones. `steps`: formulas may speak of the last step."""

    random: Random
    model: Model
    steps: bool = True

    # ---- atoms ----

    def atom(self) -> Formula:
        """Return a condition or a step predicate."""
        request = self.random.choice(self.model.requests)
        match self.random.randrange(8):
            case 0 | 1 if self.steps:
                return Happened(self.random.choice(OCCURRENCES), request.name, self._where(request.params))
            case 2 if self.model.variables:
                return Atom(self._reading(self.random.choice(self.model.variables)))
            case 3:
                return Atom(Past(request.name, self._where((*request.params, *request.results))))
            case 4:
                return Atom(Last(request.name, self.random.choice(OUTCOMES)))
            case 5 if self.model.latches:
                return Atom(Compare("==", Reading(self.random.choice(self.model.latches).name), Const(True)))
            case _:
                return Atom(Status(self.random.choice(PHASES), request.name, self._where(request.params)))

    def _reading(self, variable: Variable) -> Cond:
        others = [each for each in self.model.variables if each.type == variable.type and each != variable]
        if isinstance(variable.type, Bool | Real) or not others or self.random.random() < 0.5:
            return self._comparison(Reading(variable.name), variable.type)
        orders = ORDERS[:2] if isinstance(variable.type, Enum) else ORDERS
        return Compare(self.random.choice(orders), Reading(variable.name), Reading(self.random.choice(others).name))

    def _where(self, params: tuple[Parameter, ...]) -> Cond | None:
        if not params or self.random.random() < 0.6:
            return None
        param = self.random.choice(params)
        return self._comparison(Param(param.name), param.type)

    def _comparison(self, term: Param | Reading, kind: Type) -> Cond:
        match kind:
            case Bool():
                return Compare("==", term, Const(self.random.random() < 0.5))
            case Enum(values):
                return Compare(self.random.choice(ORDERS[:2]), term, Const(self.random.choice(values)))
            case Int(low, high):
                return Compare(self.random.choice(ORDERS), term, Const(self.random.randint(low, high)))
            case Real(low, high):
                ends = [end for end in (low, 0.5, high) if abs(end) < 1e9]
                return Compare(self.random.choice(ORDERS), term, Const(self.random.choice(ends)))

    # ---- formulas ----

    def condition(self, depth: int) -> Formula:
        """Return a formula without temporal operators."""
        if depth == 0 or self.random.random() < 0.3:
            return self.atom()
        match self.random.randrange(4):
            case 0:
                return Negation(self.condition(depth - 1))
            case 1:
                return Conjunction((self.condition(depth - 1), self.condition(depth - 1)))
            case 2:
                return Disjunction((self.condition(depth - 1), self.condition(depth - 1)))
            case _:
                return self.atom()

    def ctl(self, depth: int) -> Formula:
        """Return a formula of CTL."""
        if depth == 0:
            return self.condition(1)
        one = self.ctl(depth - 1)
        match self.random.randrange(8):
            case 0:
                return SomeNext(one)
            case 1:
                return SomeAlways(one)
            case 2:
                return SomeUntil(TRUE, one)
            case 3:
                return SomeUntil(one, self.ctl(depth - 1))
            case 4:
                return Conjunction((one, self.ctl(depth - 1)))
            case 5:
                return Disjunction((one, self.ctl(depth - 1)))
            case _:
                return Negation(one)

    def ltl(self, depth: int) -> Formula:
        """Return a formula of LTL."""
        if depth == 0:
            return self.condition(1)
        one = self.ltl(depth - 1)
        match self.random.randrange(7):
            case 0:
                return Next(one)
            case 1:
                return Until(TRUE, one)
            case 2:
                return Until(one, self.ltl(depth - 1))
            case 3:
                return Conjunction((one, self.ltl(depth - 1)))
            case 4:
                return Disjunction((one, self.ltl(depth - 1)))
            case _:
                return Negation(one)

    # ---- files ----

    def properties(self, number: int, depth: int) -> Properties:
        """Return a file of this many properties of CTL and as many of LTL, with no assumption or a few.

        The premise of a property is a condition that has nothing to do with it.
        """
        made: list[Property] = []
        for index in range(number):
            made.append(self._property(f"c{index}", "ctl", self.ctl(depth)))
            made.append(self._property(f"l{index}", "ltl", self.ltl(depth)))
        return Properties(tuple(made), self.assumptions(), self.random.random() < 0.5)

    def _property(self, name: str, form: Form, formula: Formula) -> Property:
        premise = self.condition(1) if self.random.random() < 0.5 else None
        return Property(name, None, form, formula, premise, NOWHERE)

    def assumptions(self) -> tuple[Assumption, ...]:
        """Return assumptions; most forbid two things at once and leave a step from every moment, a few demand one."""
        count = self.random.choice((0, 0, 1, 1, 2))
        return tuple(Assumption(self._assumed(), NOWHERE) for _ in range(count))

    def _assumed(self) -> Formula:
        if self.random.random() < 0.2:
            return self.atom()
        return Negation(Conjunction((self.atom(), self.atom())))
