"""Quantities and elements by number, so that diagrams and forests compare and look up nothing but integers.

Numbers are given in the order in which things are first met, and mean nothing outside of one compilation.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.expression import Cond, Count, Used
from exover.ocrd.vector import Element, Quantity, Vocabulary
from exover.ocrd.view import Phases

Factors = dict[int, int]
"""`sum(factor * quantity)`, factors by the numbers of quantities."""
Case = tuple[int, Factors, int]
"""Where the condition holds, a term has the value `form + constant`. No two cases of a term can be together."""
Range = tuple[int, int]
"""The least and the greatest value."""


@dataclass(frozen=True)
class Numbers:
    """The quantities and elements that were met so far, each in its place, and their ranges."""

    vocabulary: Vocabulary
    quantities: list[Quantity] = field(default_factory=list)
    ranges: list[Range] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    terms: list[tuple[tuple[int, int], ...]] = field(default_factory=list)
    """By element, its factors and quantities."""
    spans: list[Range] = field(default_factory=list)
    counters: dict[tuple[str, int | None, Cond | None, Phases], Factors] = field(default_factory=dict)
    """How many slots of a request, or only this one, are in one of the phases with such arguments."""
    totals: dict[tuple[Used | Count, bool], Factors] = field(default_factory=dict)
    """What all active slots count for together; with True, all that run."""
    _texts: list[str] = field(default_factory=list)
    """By these terms are sorted: what classes of quantities are called decides the order of entries in the tables."""
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
        """Return the number of a quantity; None if it was not met."""
        return self._quantity.get(quantity)

    def element(self, form: Factors) -> tuple[int, int]:
        """Return the number of the element, and the factor, of which a form is the product; some factor is not 0."""
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
    """Return the sum of two terms where the first case holds."""
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
    """Return `factor` times a term."""
    return [(guard, {q: f * factor for q, f in form.items()}, constant * factor) for guard, form, constant in cases]
