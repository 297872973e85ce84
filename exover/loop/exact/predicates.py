"""Conditions of the model and atoms of formulas as terms over exact states."""

from collections.abc import Iterable, Iterator, Sequence
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.exact.condition_formulas import ConditionFormulas, FormulaScope, TypedValues, bound
from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.symbolic_state import Note
from exover.loop.exact.term import Term
from exover.model.evaluate import OPERATORS
from exover.model.expression import Compare, Cond, Const, Operator, Phase
from exover.model.model import Model
from exover.model.property import Happened
from exover.model.types import Bool, Type, Value


@dataclass(frozen=True)
class Predicates(ConditionFormulas[Term]):
    """Conditions on the state with the variables of the layout; `once_stopped`: with the stopping slots as idle."""

    layout: Layout
    once_stopped: bool = False

    @property
    def model(self) -> Model:
        """The model."""
        return self.layout.model

    def both(self, parts: Iterable[Term]) -> Term:
        """Return the conjunction."""
        return self.layout.terms.both(parts)

    def either(self, parts: Iterable[Term]) -> Term:
        """Return the disjunction."""
        return self.layout.terms.either(parts)

    def negation(self, part: Term) -> Term:
        """Return the negation."""
        return self.layout.terms.negation(part)

    def concerns(self, request: str, where: Cond | None, values: tuple[Term, ...]) -> Term:
        """Return the condition that these arguments of a request satisfy `where`."""
        return self.both(self._where(where, self._bound(request, values), FormulaScope()))

    def happened(self, notes: Iterable[Note], atom: Happened) -> Term:
        """Return where one of the notes of a step is of an occurrence, with such arguments."""
        mine = (note for note in notes if (note.occurrence, note.request) == (atom.occurrence, atom.request))
        return self.either(self.both((note.guard, self.concerns(note.request, atom.where, note.args))) for note in mine)

    def held(self, phase: Phase, request: str) -> Iterator[tuple[Term, TypedValues[Term]]]:
        """Yield for each slot (or the waiting place) the condition that it is in this phase, and what it holds."""
        terms, vars_ = self.layout.terms, self.layout.vars
        if phase == "waiting":
            place = self.layout.places[request]
            yield vars_[place.taken], self._bound(request, (vars_[value] for value in place.args))
            return
        for number in range(self.model.request[request].instances):
            slot = self.layout.slots[request, number]
            active, running = vars_[slot.active], self.layout.running(slot, vars_)
            guard = {
                "active": running if self.once_stopped else active,
                "running": running,
                "stopping": terms.false if self.once_stopped else terms.both((active, vars_[slot.stopping])),
            }[phase]
            yield guard, self._bound(request, (vars_[value] for value in slot.args))

    def past(self, request: str) -> tuple[Term, TypedValues[Term]]:
        """Return the condition that a request has a past, and the arguments and results of that."""
        memory, vars_ = self.layout.memories[request], self.layout.vars
        return vars_[memory.known], self._bound(request, (vars_[value] for value in memory.values))

    def _bound(self, request: str, values: Iterable[Term]) -> TypedValues[Term]:
        each = self.model.request[request]
        return bound((*each.params, *each.results), values)

    def ended(self, request: str, outcome: int) -> Term:
        """Return the condition that the last instance of a request ended with the outcome of this number."""
        terms = self.layout.terms
        return terms.equal(self.layout.vars[self.layout.memories[request].last], terms.constant(outcome, "Int"))

    # ---- comparisons ----

    def comparison(self, cond: Compare, scope: FormulaScope[Term]) -> Term:
        """Return where a comparison is true; one of constants is decided."""
        if isinstance(cond.left, Const) and isinstance(cond.right, Const):
            return self.layout.terms.truth(OPERATORS[cond.operator](cond.left.value, cond.right.value))
        return super().comparison(cond, scope)

    def compared(self, left: Term, operator: Operator, right: Term) -> Term:
        """Return the comparison of two values."""
        terms = self.layout.terms
        match operator:
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
                assert_never(operator)

    def constant(self, kind: Type | None, value: Value) -> Term:
        """Return a value of a type; None: an integer."""
        return self.layout.terms.constant(int(value), "Int") if kind is None else self.layout.value(kind, value)

    def reading(self, name: str) -> tuple[Type, Term]:
        """Return the type and the value of a poster, state or latch."""
        variable = self.model.variable.get(name)
        return variable.type if variable else Bool(), self.layout.vars[name]

    def level(self, resource: str) -> Term:
        """Return the level of a consumable."""
        return self.layout.vars[level_name(resource)]

    def counted(self, amounts: Sequence[tuple[int, Term]]) -> Term:
        """Return the sum of the amounts whose conditions are true."""
        terms = self.layout.terms
        one, none = terms.constant(1, "Int"), terms.constant(0, "Int")
        return terms.sum(0, [(amount, terms.choose(guard, one, none)) for amount, guard in amounts])

    def sum(self, constant: int, parts: Sequence[tuple[int, Term]]) -> Term:
        """Return `constant + sum(factor * value)`."""
        return self.layout.terms.sum(constant, parts)
