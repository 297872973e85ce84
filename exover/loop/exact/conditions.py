"""Diagrams of the rules (`exover.ocrd.demand`) as terms over the current values of a symbolic state.

An element that has an entry in the tables is read from there; any other, which a model without some of its rules may
test, is computed from the model.
"""

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.loop.exact.quantity_terms import QuantityTerms
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import LinearForm, Ordered, Ranked, RequestArguments, TableEncoding
from exover.loop.exact.term import Term
from exover.ocrd.diagram import NO, YES, Manager, Test
from exover.ocrd.forms import Numbers
from exover.ocrd.vector import Element


@dataclass
class Conditions:
    """Conditions at one point of a step: on the values of a symbolic state, and on the arguments looked at."""

    vector: TableEncoding
    numbers: Numbers
    """The numbers of the elements that the diagrams test."""
    entries: Mapping[Element, int]
    """Maps an element to the entry of the tables that counts it."""
    frame: SymbolicState
    looked: RequestArguments | None = None
    _elements: dict[int, LinearForm | Ranked | Ordered] = field(default_factory=dict)
    _tests: dict[tuple[int, int], Term] = field(default_factory=dict)

    def truths(self, manager: Manager, roots: Iterable[int]) -> dict[int, Term]:
        """Return the terms of the conditions with these roots, and of all nodes below them, by number."""
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
        named = self.numbers.elements[element]
        if named in self.entries:
            return self.vector.entry(self.frame, self.looked, self.entries[named])
        return self._quantities.element(named)

    @cached_property
    def _quantities(self) -> QuantityTerms:
        layout, looked = copy(self.vector.layout), self.looked
        layout.vars = self.frame.values
        values = {layout.model.requests[looked.request].name: looked.values} if looked else {}
        return QuantityTerms(layout, values, self.numbers.vocabulary)
