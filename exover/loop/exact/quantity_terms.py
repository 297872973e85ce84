"""Quantities and elements of the state vector as terms over exact states, computed from the model alone."""

from collections.abc import Mapping
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.predicates import Predicates
from exover.loop.exact.table_encoding import LinearForm, Ordered, Ranked, number_of
from exover.loop.exact.term import Term
from exover.model.expression import Cond, Param, Reading
from exover.ocrd import vector as v


@dataclass(frozen=True)
class QuantityTerms:
    """The values of quantities as terms over the variables of a layout."""

    layout: Layout
    looked: Mapping[str, tuple[Term, ...]]
    """The arguments and results that quantities may read, by request."""
    vocabulary: v.Vocabulary

    @cached_property
    def _meaning(self) -> Predicates:
        return Predicates(self.layout)

    def concerned(self, request: str, where: Cond | None) -> Term:
        """Return the condition that the arguments in `looked` of a request satisfy `where`."""
        return self._meaning.concerns(request, where, self.looked[request])

    def element(self, element: v.Element) -> LinearForm | Ranked | Ordered:
        """Return the value of an element; a rank or an order is an element of its own, never part of a sum."""
        if len(element) == 1 and element[0][0] == 1:
            return self._quantity(element[0][1])
        numbers: list[tuple[int, Term]] = []
        flags: list[tuple[int, Term]] = []
        for factor, quantity in element:
            part = self._quantity(quantity)
            assert isinstance(part, LinearForm) and not part.constant, "ranks and orders are not summed"
            numbers += [(factor * inner, term) for inner, term in part.numbers]
            flags += [(factor * weight, flag) for weight, flag in part.flags]
        return LinearForm(0, tuple(numbers), tuple(flags))

    def _quantity(self, quantity: v.Quantity) -> LinearForm | Ranked | Ordered:
        layout, vars_ = self.layout, self.layout.vars
        match quantity:
            case v.VariableValue(name):
                return number_of(vars_[name])
            case v.Rank(name):
                return Ranked(vars_[name], self.vocabulary.thresholds.get((None, name), ()))
            case v.Stock(resource):
                return number_of(vars_[level_name(resource)])
            case v.LastOutcome(request):
                return number_of(vars_[layout.memories[request].last])
            case v.HasPast(request, where):
                memory = layout.memories[request]
                return number_of(self._counts(request, where, vars_[memory.known], memory.values))
            case v.Slots(request, slot, where, phase):
                return self._slots(request, slot, where, running=phase == "running")
            case v.InPlace(request, where, phase):
                place = layout.places[request]
                guard = layout.waiting(place, vars_) if phase == "waiting" else vars_[place.clearing]
                return number_of(self._counts(request, where, guard, place.args))
            case v.SlotValue(request, slot, param):
                at = layout.slots[request, slot]
                return self._argument_held(request, param, vars_[at.active], at.args)
            case v.PlaceValue(request, param):
                place = layout.places[request]
                return self._argument_held(request, param, vars_[place.taken], place.args)
            case v.Arg(request, param):
                return number_of(self._argument(request, param))
            case v.ArgRank(request, param):
                return Ranked(self._argument(request, param), self.vocabulary.thresholds.get((request, param), ()))
            case v.Order(request, left, right):
                return Ordered(self._side(request, left), self._side(request, right))
            case _:
                assert_never(quantity)

    def _counts(self, request: str, where: Cond | None, guard: Term, held: tuple[str, ...]) -> Term:
        """Return the condition that the guard holds and the values of these variables satisfy `where`."""
        values = tuple(self.layout.vars[name] for name in held)
        return self.layout.terms.both((guard, self._meaning.concerns(request, where, values)))

    def _slots(self, request: str, slot: int | None, where: Cond | None, running: bool) -> LinearForm:
        layout = self.layout
        flags: list[tuple[int, Term]] = []
        for number in range(layout.model.request[request].instances) if slot is None else (slot,):
            at = layout.slots[request, number]
            guard = layout.running(at, layout.vars) if running else layout.vars[at.stopping]
            flags.append((1, self._counts(request, where, guard, at.args)))
        return LinearForm(0, (), tuple(flags))

    def _argument_held(self, request: str, param: str, there: Term, held: tuple[str, ...]) -> LinearForm:
        """Return the argument that is held in one of these variables if the condition `there` is true, else 0."""
        layout, terms = self.layout, self.layout.terms
        names = [each.name for each in layout.model.request[request].params]
        value = layout.vars[held[names.index(param)]]
        if value.sort == "Bool":
            return number_of(terms.both((there, value)))
        return number_of(terms.choose(there, value, terms.constant(0, "Int")))

    def _argument(self, request: str, param: str) -> Term:
        each = self.layout.model.request[request]
        names = [parameter.name for parameter in (*each.params, *each.results)]
        return self.looked[request][names.index(param)]

    def _side(self, request: str | None, side: Param | Reading) -> Term:
        if isinstance(side, Reading):
            return self.layout.vars[side.name]
        assert request is not None, "a parameter is one of a request"
        return self._argument(request, side.name)
