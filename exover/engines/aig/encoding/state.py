"""The state of the closed loop as latches, and what comes with an event as inputs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from itertools import combinations

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, TRUE, Literal
from exover.engines.aig.circuit.words import Grid, Word, Words, as_word, lit
from exover.engines.aig.encoding.range_allocation import Family, RangeAllocation, fraction
from exover.loop.exact.events import Kind
from exover.loop.exact.layout import Layout
from exover.loop.exact.term import Term
from exover.model.model import Parameter
from exover.model.types import Bool, Enum, Int, Real, Type, Value, ordinal


@dataclass(frozen=True, slots=True)
class AllocatedRange:
    """The numbers, or positions on a grid, that stand for the values of a type."""

    low: int
    high: int
    grid: Grid | None = None


def family_of(kind: Kind, parameter: Parameter) -> Family:
    """Return the family of a value that an event of a kind brings."""
    return (kind.name, parameter.name) if kind.verb in ("ask", "report") else (None, kind.name)


def number(kind: Type, span: AllocatedRange, value: Value) -> int:
    """Return the number, or the position, that stands for a value of a type."""
    if span.grid is not None:
        return span.grid.position(fraction(value))
    return ordinal(kind, value)


@dataclass
class Latches(Layout):
    """The variables of a state, each as latches of a graph."""

    terms: Words
    grids: RangeAllocation = field(kw_only=True)
    literals: dict[str, tuple[Literal, ...]] = field(default_factory=dict)
    """By variable its latches, the least significant first."""
    spans: dict[str, AllocatedRange] = field(default_factory=dict)
    shared: Mapping[str, tuple[Literal, ...]] = field(default_factory=dict)
    """By variable its latches, where those of another version are taken, whose values at the start are the same."""

    def span(self, kind: Type, family: Family) -> AllocatedRange:
        """Return the numbers that stand for the values of a type in a family."""
        match kind:
            case Bool():
                return AllocatedRange(0, 1)
            case Enum(values):
                return AllocatedRange(0, len(values) - 1)
            case Int(low, high):
                return AllocatedRange(low, high)
            case Real(low, high):
                grid = self.grids.grid(family)
                ends = (max(low, float(grid.constants[0])), min(high, float(grid.constants[-1])))
                first, last = (number(kind, AllocatedRange(0, 0, grid), end) for end in ends)
                return AllocatedRange(first, last, grid)

    def _hold(self, name: str, kind: Type, initial: Value) -> None:
        span = self.span(kind, self.family(name))
        start = number(kind, span, initial) - span.low
        bits = self.shared.get(name)
        if bits is None:
            wide = (span.high - span.low).bit_length()
            bits = tuple(self.terms.graph.latch(bool(start >> k & 1)) for k in range(wide))
        self.vars[name] = self.terms.bit(bits[0]) if isinstance(kind, Bool) else self.made(bits, span)
        self.literals[name], self.spans[name] = bits, span
        self.initial[name], self.types[name] = self.value(kind, initial), kind

    def made(self, bits: tuple[Literal, ...], span: AllocatedRange) -> Word:
        """Return the number or position that literals encode."""
        return self.terms.word(bits, span.low, span.high, span.grid)

    def family(self, name: str) -> Family:
        """Return the family of the values of a variable."""
        return self.held.get(name, (None, name))

    def span_given(self, kind: Kind, parameter: Parameter) -> AllocatedRange:
        """Return the numbers that stand for the values that an event of a kind brings."""
        return self.span(parameter.type, family_of(kind, parameter))

    def value_given(self, kind: Type, bits: tuple[Literal, ...], span: AllocatedRange) -> Word:
        """Return the value of a type that comes with an event as these inputs."""
        return self.terms.bit(bits[0]) if isinstance(kind, Bool) else self.given(bits, span)

    def values_given(self, kind: Kind, named: Iterable[Parameter], pool: list[Literal]) -> Iterator["Given"]:
        """Yield the values that come with an event of a kind; all kinds of events share the inputs of the pool."""
        used = 0
        for parameter in named:
            span = self.span_given(kind, parameter)
            bits = tuple(self.terms.graph.pooled(pool, used, (span.high - span.low).bit_length()))
            used += len(bits)
            yield Given(parameter, bits, span, self.value_given(parameter.type, bits, span))

    def given(self, bits: tuple[Literal, ...], span: AllocatedRange) -> Word:
        """Return a number of the span, of a real a position that some double has, for every value of the bits.

        Bits beyond the span have their highest one cleared; every number of the span is that of some bits.
        """
        if span.grid is None:
            return self.terms.word(self._limited(bits, span.high - span.low), span.low, span.high)
        places = span.grid.places
        cell = list(self._limited(bits[places:], (span.high - span.low) >> places))
        if cell:
            # The lowest cell is a constant, so that even ones are; a cell without doubles gives way to that before it.
            low = span.low >> places
            wide = self.terms.word(cell, low, low + (1 << len(cell)) - 1)
            none = [self.terms.equal(wide, self.terms.constant(empty, "Int")) for empty in span.grid.empty]
            cell[0] = self.terms.graph.all((cell[0], *(as_word(each).bits[0] ^ 1 for each in none)))
        place = [self.terms.graph.conjunction(bit, cell[0] if cell else FALSE) for bit in bits[:places]]
        return self.terms.word((*place, *cell), span.low, span.high, span.grid)

    def legal(self, word: Word, span: AllocatedRange) -> Literal:
        """Return where the bits of a word are a number of the span, of a real a position."""
        is_one = TRUE if span.grid is None else self.is_position(word, span.grid)
        return self.terms.graph.conjunction(is_one, self._at_most(word.bits, span.high - span.low))

    def _limited(self, bits: tuple[Literal, ...], most: int) -> tuple[Literal, ...]:
        if not bits:
            return bits
        return (*bits[:-1], self.terms.graph.conjunction(bits[-1], self._at_most(bits, most)))

    def _at_most(self, bits: tuple[Literal, ...], most: int) -> Literal:
        """Return where the number that literals are is at most so large."""
        return lit(self.terms.at_most(self.terms.word(bits, 0, (1 << len(bits)) - 1), self.terms.constant(most, "Int")))

    def is_position(self, word: Word, grid: Grid) -> Literal:
        """Return where a word is a position that some double has: on a constant the place is 0."""
        graph, places = self.terms.graph, grid.places
        bits = self.terms.offset_bits(word, 0)
        odd = bits[places] if len(bits) > places else FALSE
        return graph.conjunction(odd, graph.any(bits[:places])) ^ 1


@dataclass(frozen=True, slots=True)
class Given:
    """A value that comes with an event: its inputs, the numbers that it can be, and the one that it is."""

    parameter: Parameter
    bits: tuple[Literal, ...]
    span: AllocatedRange
    term: Word


@dataclass
class Reembedding:
    """Reals that are compared with each other may move between two constants, as long as they compare as before.

    Doubles are taken as dense, positions are few; so before each step the places between two constants are dealt out
    anew: to every order of reals that can be, there are positions that have it, with room for one more anywhere.
    """

    latches: Latches
    shared: Mapping[str, list[Literal]] = field(default_factory=dict)
    """By variable the shifts of another version that holds the same."""
    shifts: dict[str, list[Literal]] = field(default_factory=dict)
    moved: dict[str, Word] = field(default_factory=dict)
    """By variable the position that it has from now on."""
    inputs: list[int] = field(default_factory=list)
    """The nodes of the inputs that move them; where all are false everything stays."""
    legal: Literal = TRUE

    def __post_init__(self) -> None:
        groups: dict[Family, list[str]] = {}
        for name, span in self.latches.spans.items():
            if span.grid is not None and span.grid.places:
                groups.setdefault(self.latches.grids.first(self.latches.family(name)), []).append(name)
        kept = [TRUE]
        for names in groups.values():
            for name in names:
                kept.append(self._move(name))
            for one, other in combinations(names, 2):
                kept += self._as_before(one, other)
        self.legal = self.latches.terms.graph.all(kept)

    def _move(self, name: str) -> Literal:
        """Give a variable another place in its cell, as inputs say, and return where that is a position."""
        latches, span = self.latches, self.latches.spans[name]
        assert span.grid is not None
        graph, places = latches.terms.graph, span.grid.places
        old = as_word(latches.vars[name])
        bits = latches.terms.padded(old.bits, latches.literals[name])[0]
        shifts = self.shifts[name] = self.shared.get(name) or [graph.input() for _ in range(places)]
        self.inputs += [shift >> 1 for shift in shifts]
        moved = [*map(graph.differ, bits, shifts), *bits[places:]]
        self.moved[name] = latches.terms.word(moved, span.low, span.high, span.grid)
        return latches.is_position(self.moved[name], span.grid)

    def _as_before(self, one: str, other: str) -> list[Literal]:
        terms, vars_ = self.latches.terms, self.latches.vars
        pairs: list[tuple[Term, Term]] = [(vars_[one], vars_[other]), (self.moved[one], self.moved[other])]
        return [
            as_word(terms.equal(terms.at_most(*pairs[0]), terms.at_most(*pairs[1]))).bits[0],
            as_word(terms.equal(terms.at_most(*pairs[0][::-1]), terms.at_most(*pairs[1][::-1]))).bits[0],
        ]
