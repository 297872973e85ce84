"""Conditions that are diagrams of the rules (`exover.ocrd.demand`), as terms over what a symbolic state holds by now.

An element that the tables count is what they count; any other, which a model without some of its rules may test, is
read from the model.
"""

from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import field
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.exact.layout import level_name
from exover.loop.exact.predicates import Predicates
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import LinearForm, Ordered, Ranked, RequestArguments, TableEncoding, number_of
from exover.loop.exact.term import Term
from exover.model.expression import Param, Reading
from exover.ocrd.diagram import NO, YES, Manager, Test
from exover.ocrd.forms import Numbers
from exover.ocrd.vector import (
    Arg,
    ArgRank,
    Element,
    HasPast,
    InPlace,
    LastOutcome,
    Order,
    Rank,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
)
from exover.ocrd.vector import Quantity as Named


@dataclass
class Conditions:
    """What diagrams say at one moment: of the values of a symbolic state, and of the arguments that are looked at."""

    vector: TableEncoding
    numbers: Numbers
    """Of the elements that the diagrams test."""
    entries: Mapping[Element, int]
    """By element the entry of the tables that counts it."""
    frame: SymbolicState
    looked: RequestArguments | None = None
    _elements: dict[int, LinearForm | Ranked | Ordered] = field(default_factory=dict)
    _tests: dict[tuple[int, int], Term] = field(default_factory=dict)

    def truths(self, manager: Manager, roots: Iterable[int]) -> dict[int, Term]:
        """Return by number where the conditions with these roots, and all below them, are true."""
        terms = self.frame.terms
        known = {NO: terms.false, YES: terms.true}
        for number in manager.below(roots):
            node = manager.node(number)
            assert isinstance(node, Test), "a condition has no actions"
            found = known[node.children[-1]]
            for cut, child in zip(reversed(node.cuts), reversed(node.children[:-1]), strict=True):
                found = terms.choose(self._test(manager.entries[node.level], cut), known[child], found)
            known[number] = found
        return known

    def _test(self, element: int, bound: int) -> Term:
        """Return where the element of this number is at most `bound`."""
        key = (element, bound)
        if key not in self._tests:
            if element not in self._elements:
                self._elements[element] = self._element(element)
            self._tests[key] = self.vector.at_most(self._elements[element], bound)
        return self._tests[key]

    def _element(self, element: int) -> LinearForm | Ranked | Ordered:
        elements = self.numbers.elements
        if elements[element] in self.entries:
            return self.vector.entry(self.frame, self.looked, self.entries[elements[element]])
        parts = [(factor, self._quantity(quantity)) for factor, quantity in elements[element]]
        if len(parts) == 1 and not isinstance(parts[0][1], LinearForm):
            return parts[0][1]
        numbers: list[tuple[int, Term]] = []
        flags: list[tuple[int, Term]] = []
        for factor, part in parts:
            assert isinstance(part, LinearForm), "ranks are not summed"
            numbers += [(factor * inner, term) for inner, term in part.numbers]
            flags += [(factor * weight, flag) for weight, flag in part.flags]
        return LinearForm(0, tuple(numbers), tuple(flags))

    def _quantity(self, quantity: Named) -> LinearForm | Ranked | Ordered:
        frame, layout = self.frame, self.vector.layout
        match quantity:
            case VariableValue(name):
                return number_of(frame[name])
            case Rank(name):
                return Ranked(frame[name], self._cuts(None, name))
            case Stock(resource):
                return number_of(frame[level_name(resource)])
            case LastOutcome(request):
                return number_of(frame[layout.memories[request].last])
            case HasPast(request, where):
                memory = layout.memories[request]
                concerns = self._predicates.concerns(request, where, frame.all(memory.values))
                return number_of(frame.terms.both((frame[memory.known], concerns)))
            case Slots():
                return LinearForm(0, (), tuple((1, flag) for flag in self._slots(quantity)))
            case SlotValue(request, number, param):
                return self._held(request, number, param)
            case InPlace(request, where, phase):
                place = layout.places[request]
                clearing = frame[place.clearing]
                here = clearing if phase == "clearing" else frame.terms.negation(clearing)
                concerns = self._predicates.concerns(request, where, frame.all(place.args))
                return number_of(frame.terms.both((frame[place.taken], here, concerns)))
            case Arg(_, param):
                return number_of(self._argument(param))
            case ArgRank(request, param):
                return Ranked(self._argument(param), self._cuts(request, param))
            case Order(_, left, right):
                return Ordered(self._side(left), self._side(right))
            case _:
                assert_never(quantity)

    def _cuts(self, request: str | None, name: str) -> tuple[float, ...]:
        return self.numbers.vocabulary.thresholds.get((request, name), ())

    def _slots(self, quantity: Slots) -> Iterator[Term]:
        """Yield where each of the slots counts."""
        frame, terms, layout = self.frame, self.frame.terms, self.vector.layout
        request = layout.model.request[quantity.request]
        for number in range(request.instances):
            if quantity.slot in (None, number):
                slot = layout.slots[request.name, number]
                stopping = frame[slot.stopping]
                phase = stopping if quantity.phase == "stopping" else terms.negation(stopping)
                concerns = self._predicates.concerns(request.name, quantity.where, frame.all(slot.args))
                yield terms.both((frame[slot.active], phase, concerns))

    def _held(self, request: str, number: int, param: str) -> LinearForm:
        """Return the argument of a slot that is active; 0 of an idle one."""
        layout, terms = self.vector.layout, self.frame.terms
        slot = layout.slots[request, number]
        names = [each.name for each in layout.model.request[request].params]
        value, active = self.frame[slot.args[names.index(param)]], self.frame[slot.active]
        none = terms.false if value.sort == "Bool" else terms.constant(0, "Int")
        return number_of(terms.choose(active, value, none))

    def _argument(self, param: str) -> Term:
        assert self.looked is not None, "arguments are tested of what is looked at"
        request = self.vector.layout.model.requests[self.looked.request]
        names = [each.name for each in (*request.params, *request.results)]
        return self.looked.values[names.index(param)]

    def _side(self, side: Param | Reading) -> Term:
        return self._argument(side.name) if isinstance(side, Param) else self.frame[side.name]

    @cached_property
    def _predicates(self) -> Predicates:
        layout = copy(self.vector.layout)
        layout.vars = self.frame.values
        return Predicates(layout)
