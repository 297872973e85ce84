"""The elements that diagrams of the rules test, as the model has them: over exact states, without the tables."""

from collections.abc import Mapping
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.exact.layout import level_name
from exover.loop.exact.predicates import Predicates
from exover.loop.exact.table_encoding import LinearForm, Ordered, Ranked, TableEncoding, number_of
from exover.loop.exact.term import Term
from exover.model.expression import Cond, Param, Reading
from exover.ocrd import vector as v

Looked = Mapping[str, tuple[Term, ...]]
"""By request that may be looked at the values of its parameters and results."""


@dataclass(frozen=True)
class RuleEncoding:
    """What elements are in the states of a layout; `looked`: the arguments that decisions and predicates look at."""

    vector: TableEncoding
    looked: Looked

    @cached_property
    def _meaning(self) -> Predicates:
        return Predicates(self.vector.layout)

    @cached_property
    def _thresholds(self) -> dict[tuple[str | None, str], tuple[float, ...]]:
        return v.Vocabulary(self.vector.layout.model).thresholds

    def at_most(self, element: v.Element, bound: int) -> Term:
        """Return where an element is at most `bound`."""
        return self.vector.at_most(self.value(element), bound)

    def concerned(self, request: str, where: Cond | None) -> Term:
        """Return where the arguments of a request that are looked at satisfy a condition."""
        return self._meaning.concerns(request, where, self.looked[request])

    def value(self, element: v.Element) -> LinearForm | Ranked | Ordered:
        """Return what an element is; what is no number stands in it alone."""
        if len(element) == 1 and element[0][0] == 1:
            return self._quantity(element[0][1])
        numbers: list[tuple[int, Term]] = []
        flags: list[tuple[int, Term]] = []
        constant = 0
        for factor, quantity in element:
            part = self._quantity(quantity)
            assert isinstance(part, LinearForm), "ranks and orders are not summed"
            constant += factor * part.constant
            numbers += [(factor * inner, term) for inner, term in part.numbers]
            flags += [(factor * weight, flag) for weight, flag in part.flags]
        return LinearForm(constant, tuple(numbers), tuple(flags))

    def _quantity(self, quantity: v.Quantity) -> LinearForm | Ranked | Ordered:
        layout, vars_ = self.vector.layout, self.vector.layout.vars
        match quantity:
            case v.VariableValue(name):
                return number_of(vars_[name])
            case v.Rank(name):
                return Ranked(vars_[name], self._thresholds.get((None, name), ()))
            case v.Stock(resource):
                return number_of(vars_[level_name(resource)])
            case v.LastOutcome(request):
                return number_of(vars_[layout.memories[request].last])
            case v.HasPast(request, where):
                memory = layout.memories[request]
                return self._flag(request, where, vars_[memory.known], memory.values)
            case v.Slots(request, slot, where, phase):
                return self._slots(request, slot, where, running=phase == "running")
            case v.InPlace(request, where, phase):
                place = layout.places[request]
                clearing = vars_[place.clearing]
                waiting = self.vector.terms.both((vars_[place.taken], self.vector.terms.negation(clearing)))
                return self._flag(request, where, waiting if phase == "waiting" else clearing, place.args)
            case v.SlotValue(request, slot, param):
                return self._argument_in_slot(request, slot, param)
            case v.Arg(request, param):
                return number_of(self._looked(request, param))
            case v.ArgRank(request, param):
                return Ranked(self._looked(request, param), self._thresholds.get((request, param), ()))
            case v.Order(request, left, right):
                return Ordered(self._side(request, left), self._side(request, right))
            case _:
                assert_never(quantity)

    def _flag(self, request: str, where: Cond | None, guard: Term, held: tuple[str, ...]) -> LinearForm:
        values = tuple(self.vector.layout.vars[name] for name in held)
        concerned = self._meaning.concerns(request, where, values)
        return LinearForm(0, (), ((1, self.vector.terms.both((guard, concerned))),))

    def _slots(self, request: str, slot: int | None, where: Cond | None, running: bool) -> LinearForm:
        layout, terms = self.vector.layout, self.vector.terms
        numbers = range(layout.model.request[request].instances) if slot is None else (slot,)
        flags: list[tuple[int, Term]] = []
        for number in numbers:
            at = layout.slots[request, number]
            stopping = layout.vars[at.stopping]
            runs = terms.both((layout.vars[at.active], terms.negation(stopping)))
            flags += self._flag(request, where, runs if running else stopping, at.args).flags
        return LinearForm(0, (), tuple(flags))

    def _argument_in_slot(self, request: str, slot: int, param: str) -> LinearForm:
        layout, terms = self.vector.layout, self.vector.terms
        at = layout.slots[request, slot]
        names = [each.name for each in layout.model.request[request].params]
        active, value = layout.vars[at.active], layout.vars[at.args[names.index(param)]]
        if value.sort == "Bool":
            return LinearForm(0, (), ((1, terms.both((active, value))),))
        return number_of(terms.choose(active, value, terms.constant(0, "Int")))

    def _looked(self, request: str, param: str) -> Term:
        each = self.vector.layout.model.request[request]
        names = [parameter.name for parameter in (*each.params, *each.results)]
        return self.looked[request][names.index(param)]

    def _side(self, request: str | None, side: Param | Reading) -> Term:
        if isinstance(side, Reading):
            return self.vector.layout.vars[side.name]
        assert request is not None, "a parameter is one of a request"
        return self._looked(request, side.name)
