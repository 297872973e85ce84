"""Numbers of quantities and elements, so that diagrams and forests compare and look up integers only.

Numbers are given in the order of first use and are valid within one compilation.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.expression import Cond, Count, Used
from exover.ocrd.vector import Element, Quantity, Vocabulary
from exover.ocrd.view import Phases

Factors = dict[int, int]
"""A linear form `sum(factor * quantity)`: factors by the numbers of the quantities."""
Case = tuple[int, Factors, int]
"""A condition, a form and a constant: the value of a term is `form + constant` where the condition holds.

The conditions of the cases of one term are disjoint.
"""
Range = tuple[int, int]
"""The least and the greatest value."""


@dataclass(frozen=True)
class Numbers:
    """The quantities and elements so far, by number, and their ranges."""

    vocabulary: Vocabulary
    quantities: list[Quantity] = field(default_factory=list)
    ranges: list[Range] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    terms: list[tuple[tuple[int, int], ...]] = field(default_factory=list)
    """For each element, its pairs of a factor and the number of a quantity."""
    spans: list[Range] = field(default_factory=list)
    counters: dict[tuple[str, int | None, Cond | None, Phases], Factors] = field(default_factory=dict)
    """The form that counts the slots of a request, or one slot, in these phases whose arguments satisfy a condition."""
    totals: dict[tuple[Used | Count, bool], Factors] = field(default_factory=dict)
    """The form of a `Used` or `Count` over all active slots; with True, over the running ones only."""
    _texts: list[str] = field(default_factory=list)
    """The `repr` of each quantity, by which the terms of an element are sorted: renaming a class changes the tables."""
    _quantity: dict[Quantity, int] = field(default_factory=dict)
    _element: dict[tuple[tuple[int, int], ...], int] = field(default_factory=dict)
    _form: dict[tuple[tuple[int, int], ...], tuple[int, int]] = field(default_factory=dict)

    def quantity(self, quantity: Quantity) -> int:
        """Return the number of a quantity."""
        number = self._quantity.setdefault(quantity, len(self.quantities))
        if number == len(self.quantities):
            self.quantities.append(quantity)
            self.ranges.append(self.vocabulary.range(quantity))
            self._texts.append(repr(quantity))
        return number

    def find(self, quantity: Quantity) -> int | None:
        """Return the number of a quantity; None if it has none yet."""
        return self._quantity.get(quantity)

    def element(self, form: Factors) -> tuple[int, int]:
        """Return `(number, factor)` with `form = factor * element`; some factor of the form must not be 0."""
        key = tuple(form.items())
        if key not in self._form:
            self._form[key] = self._reduced(form)
        return self._form[key]

    def _reduced(self, form: Factors) -> tuple[int, int]:
        found = sorted((quantity for quantity, factor in form.items() if factor), key=self._texts.__getitem__)
        divisor = math.gcd(*(form[quantity] for quantity in found))
        if form[found[0]] < 0:
            divisor = -divisor
        terms = tuple((form[quantity] // divisor, quantity) for quantity in found)
        number = self._element.setdefault(terms, len(self.elements))
        if number == len(self.elements):
            self.elements.append(tuple((factor, self.quantities[quantity]) for factor, quantity in terms))
            self.terms.append(terms)
            self.spans.append(span(terms, self.ranges))
        return number, divisor


def span(terms: tuple[tuple[int, int], ...], ranges: Mapping[int, Range] | Sequence[Range]) -> Range:
    """Return the least and the greatest value of a sum whose quantities lie in these ranges."""
    low = high = 0
    for factor, quantity in terms:
        least, greatest = ranges[quantity]
        low += factor * (least if factor > 0 else greatest)
        high += factor * (greatest if factor > 0 else least)
    return low, high


def plus(case: Case, other: Case) -> Case:
    """Return the sum of two cases, with the condition of the first."""
    longer, shorter = (case[1], other[1]) if len(case[1]) > len(other[1]) else (other[1], case[1])
    return case[0], add(dict(longer), shorter), case[2] + other[2]


def add(form: Factors, other: Factors, factor: int = 1) -> Factors:
    """Add `factor * other` to a form and return it."""
    if not form and factor == 1:
        form.update(other)
        return form
    for quantity, count in other.items():
        form[quantity] = form.get(quantity, 0) + factor * count
    return form


def scale(cases: list[Case], factor: int) -> list[Case]:
    """Return `factor` times a term given by cases."""
    return [(guard, {q: f * factor for q, f in form.items()}, constant * factor) for guard, form, constant in cases]
