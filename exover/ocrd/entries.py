"""The entries of the state vector that a forest needs: their elements, initial values, and the rules that read them."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.expression import Reading
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import ordinal
from exover.ocrd.forest import END, Branch, Forest
from exover.ocrd.forms import Numbers
from exover.ocrd.numbering import below
from exover.ocrd.tables import NONE, Entry
from exover.ocrd.vector import (
    LEFT,
    RIGHT,
    SAME,
    Arg,
    ArgRank,
    Element,
    HasPast,
    InPlace,
    LastOutcome,
    Order,
    PlaceValue,
    Quantity,
    Rank,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
    Vocabulary,
    rank,
)


@dataclass
class Entries:
    """The entries in the order of their numbers: first those that nodes test, as met, then the quantities of sums.

    A sum of counters that nothing else reads is counted as a whole: its quantities have no entries of their own.
    """

    numbers: Numbers
    chosen: list[int] = field(default_factory=list)
    """The number of its element, for each entry."""
    index: dict[int, int] = field(default_factory=dict)
    """The entry of each element, by number."""
    counted: list[int] = field(default_factory=list)
    """The elements of one quantity that are counted in the entry of their only sum and have no entry of their own."""

    @property
    def elements(self) -> list[Element]:
        """The elements of the entries."""
        return [self.numbers.elements[element] for element in self.chosen]

    def need(self, element: int) -> int:
        """Return the entry of an element, a new one if it has none yet."""
        if element not in self.index:
            self.index[element] = len(self.chosen)
            self.chosen.append(element)
        return self.index[element]

    def of(self, quantity: Quantity) -> int:
        """Return the entry in which a quantity is kept, its own or that of its only sum; `NONE` if nothing reads it."""
        number = self.numbers.find(quantity)
        return NONE if number is None else self.index.get(self._alone(number), NONE)

    def quantities(self) -> list[Quantity]:
        """Return the quantities that are kept: those with entries of their own, then those counted only in a sum."""
        kept = [*self.elements, *(self.numbers.elements[element] for element in self.counted)]
        return [element[0][1] for element in kept if is_plain(element)]

    def needed_by(self, forest: Forest, nodes: Iterable[int]) -> None:
        """Add the entries that these nodes test, and entries for quantities of their sums."""
        for number in nodes:
            node = forest.nodes[number]
            if isinstance(node, Branch):
                self.need(node.element)
        tested = list(self.chosen)
        parts = Counter(quantity for element in tested for _, quantity in self.numbers.terms[element])
        for element in tested:
            terms = self.numbers.terms[element]
            if all(parts[quantity] == 1 and self._counts_once(factor, quantity) for factor, quantity in terms):
                alone = [self._alone(quantity) for _, quantity in terms]
                self.counted += [part for part in alone if part != element]
                self.index |= dict.fromkeys(alone, self.index[element])
            else:
                for _, quantity in terms:
                    self.need(self._alone(quantity))

    def _counts_once(self, factor: int, quantity: int) -> bool:
        """Return whether each slot or waiting place adds exactly 1 or 0 to the sum through this quantity."""
        return factor == 1 and isinstance(self.numbers.quantities[quantity], Slots | InPlace)

    def _alone(self, quantity: int) -> int:
        return self.numbers.element({quantity: 1})[0]

    def rows(self, forest: Forest, rules: Sequence[int]) -> tuple[list[Entry], list[tuple[int, int]], list[int]]:
        """Return the records of the entries, the pairs (sum, factor) of sums that they are part of, and the lists of
        rules that read them; `rules` are the roots of the rules.
        """
        start = Reference(self.numbers.vocabulary.model).start()
        watched: list[list[int]] = [[] for _ in self.chosen]
        for rule, root in enumerate(rules):
            for element in _tested(forest, root):
                watched[self.index[element]].append(rule)
        parts: list[list[tuple[int, int]]] = [[] for _ in self.chosen]
        for number, element in enumerate(self.chosen):
            terms = self.numbers.terms[element]
            for factor, quantity in terms:
                part = self.index[self._alone(quantity)]
                if part != number:
                    parts[part].append((number, factor))
        rows: list[Entry] = []
        sums: list[tuple[int, int]] = []
        lists: list[int] = []
        vocabulary = self.numbers.vocabulary
        initials = [initial(vocabulary, quantity, start) for quantity in self.numbers.quantities]
        for number, element in enumerate(self.chosen):
            first = sum(factor * initials[quantity] for factor, quantity in self.numbers.terms[element])
            rows.append(
                Entry(
                    first,
                    len(lists),
                    len(lists) + len(watched[number]),
                    len(sums),
                    len(sums) + len(parts[number]),
                )
            )
            lists += watched[number]
            sums += parts[number]
        return rows, sums, lists


def initial(vocabulary: Vocabulary, quantity: Quantity, start: State) -> int:
    """Return the value of a quantity in the initial state."""
    match quantity:
        case VariableValue(name):
            return ordinal(vocabulary.reading_type(name), start.readings[name])
        case Rank(name):
            return rank(vocabulary.thresholds.get((None, name), ()), float(start.readings[name]))
        case Stock(resource):
            return start.levels[resource]
        case Order(None, Reading(left), Reading(right)):
            return compare(float(start.readings[left]), float(start.readings[right]))
        case HasPast() | LastOutcome() | Slots() | SlotValue() | InPlace() | PlaceValue():
            return 0
        case Arg() | ArgRank() | Order():
            return 0
        case _:
            assert_never(quantity)


def compare(left: float, right: float) -> int:
    """Return how two doubles compare, as the value of an `Order`."""
    if left == right:
        return SAME
    return LEFT if left < right else RIGHT


def is_plain(element: Element) -> bool:
    """Return whether an element has a single quantity."""
    return len(element) == 1


def _tested(forest: Forest, root: int) -> list[int]:
    """Return the elements that a diagram tests, without duplicates."""
    found: dict[int, None] = {}
    seen = {END}
    stack = [root]
    while stack:
        number = stack.pop()
        if number not in seen:
            seen.add(number)
            node = forest.nodes[number]
            if isinstance(node, Branch):
                found[node.element] = None
            stack += below(node)
    return list(found)
