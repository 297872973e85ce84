"""Bound propagation: known ranges of some elements of the state vector bound others, in every consistent state.

Bounds are propagated to a fixpoint (Harvey and Schimpf 2002), through the linear forms of elements, and from a counter
to those that count no less. The compiler leaves out tests for such reasons; the comparison of its tables with the rules
finds these reasons again, independently of the compiler.
"""

from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.ocrd.forms import Numbers, Range, span
from exover.ocrd.vector import HasPast, InPlace, Quantity, Slots

KnownRanges = tuple[tuple[int, Range], ...]
"""Numbers of elements with the range in which each lies, ordered by number."""
EMPTY: Range = (1, 0)
PASSES = 8
"""The greatest number of rounds of propagation; stopping early is sound, but bounds may be less tight."""


@dataclass
class BoundPropagation:
    """Computes ranges of elements from known ranges of others."""

    numbers: Numbers
    _greater: dict[int, tuple[int, ...]] = field(default_factory=dict)
    _about: dict[int, frozenset[int]] = field(default_factory=dict)
    _ranges: dict[tuple[int, KnownRanges], Range] = field(default_factory=dict)

    def about(self, element: int) -> frozenset[int]:
        """Return the quantities of an element, and those that are never less than one of them."""
        if element not in self._about:
            own = [quantity for _, quantity in self.numbers.terms[element]]
            self._about[element] = frozenset(each for quantity in own for each in (quantity, *self.greater(quantity)))
        return self._about[element]

    def greater(self, quantity: int) -> tuple[int, ...]:
        """Return the quantities that are never less than this one."""
        if quantity not in self._greater:
            found = greater(self.numbers.quantities[quantity])
            self._greater[quantity] = tuple(self.numbers.quantity(each) for each in found)
        return self._greater[quantity]

    def range(self, element: int, known: KnownRanges) -> Range:
        """Return a range of an element in all states in which `known` holds; `EMPTY` only if there is no such state."""
        mine = self.about(element)
        about = tuple(item for item in known if not mine.isdisjoint(self.about(item[0])))
        if not about:
            return self.numbers.spans[element]
        key = (element, about)
        if key not in self._ranges:
            self._ranges[key] = self._propagated(element, about)
        return self._ranges[key]

    def _propagated(self, element: int, known: KnownRanges) -> Range:
        terms = self.numbers.terms
        low, high = dict(known).get(element, self.numbers.spans[element])
        bounds = {q: self.numbers.ranges[q] for each in (element, *(k for k, _ in known)) for q in self.about(each)}
        for _ in range(PASSES):
            before = dict(bounds)
            for other, found in known:
                self._tighten(terms[other], found, bounds)
            for quantity in bounds:
                for above in self.greater(quantity):
                    if above in bounds:
                        least, most = bounds[quantity][0], bounds[above][1]
                        bounds[above] = (max(bounds[above][0], least), most)
                        bounds[quantity] = (least, min(bounds[quantity][1], most))
            if any(least > most for least, most in bounds.values()):
                return EMPTY
            if bounds == before:
                break
        least, most = span(terms[element], bounds)
        low, high = max(low, least), min(high, most)
        return (low, high) if low <= high else EMPTY

    def _tighten(self, terms: tuple[tuple[int, int], ...], found: Range, bounds: dict[int, Range]) -> None:
        """Tighten the bounds of each quantity of a sum, given that the sum lies in the range `found`."""
        least, most = span(terms, bounds)
        for factor, quantity in terms:
            low, high = bounds[quantity]
            ends = (factor * low, factor * high) if factor > 0 else (factor * high, factor * low)
            lower, upper = found[0] - (most - ends[1]), found[1] - (least - ends[0])
            if factor < 0:
                lower, upper = upper, lower
            bounds[quantity] = max(low, -(-lower // factor)), min(high, upper // factor)


def greater(quantity: Quantity) -> list[Quantity]:
    """Return the counters that count everything that this one counts."""
    match quantity:
        case Slots(_, slot, where, _):
            found: list[Quantity] = [replace(quantity, where=None)] if where is not None else []
            if slot is not None:
                found.append(replace(quantity, slot=None))
                found += [replace(quantity, slot=None, where=None)] if where is not None else []
            return found
        case HasPast(_, where) | InPlace(_, where, _) if where is not None:
            return [replace(quantity, where=None)]
        case _:
            return []


def learned(known: KnownRanges, element: int, found: Range) -> KnownRanges:
    """Return `known` with the range of an element added."""
    return tuple(sorted([item for item in known if item[0] != element] + [(element, found)]))
