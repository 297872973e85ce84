"""Terms of the closed loop as words of literals of an And-Inverter Graph.

An integer is an offset and an unsigned number. A real is a *position*: on which side of each constant it lies, and,
where reals are compared with each other, which of a few places between two constants it has. A Bool is one literal.
Equal terms are one object, as in `Terms`.
"""

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import field
from fractions import Fraction
from math import inf, nextafter

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit, Graph, Literal
from exover.loop.exact.term import Number, Sort, Term, Terms

Bits = tuple[Literal, ...]
"""An unsigned number, least significant bit first."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The positions of reals that are compared with these constants, increasing.

    Position `2 k + 1` is the k-th constant, `2 k` lies before it, each times `2 ** places`. Between two constants there
    are `2 ** places` positions.
    """

    constants: tuple[Fraction, ...]
    places: int = 0

    def position(self, value: Fraction) -> int:
        """Return the position of a constant; of another number the first one between its neighbours."""
        number = bisect_left(self.constants, value)
        here = number < len(self.constants) and self.constants[number] == value
        return (2 * number + here) << self.places

    @property
    def empty(self) -> tuple[int, ...]:
        """The cells, positions without their place, in which there is no double."""
        pairs = enumerate(zip(self.constants, self.constants[1:], strict=False), 1)
        return tuple(2 * k for k, (low, high) in pairs if nextafter(float(low), inf) == float(high))


@dataclass(frozen=True, slots=True, eq=False)
class Word(Term):
    """A term as literals: the value is `low` plus the number that they are, and at most `high`."""

    bits: Bits = ()
    low: int = 0
    high: int = 0
    grid: Grid | None = None
    """Of a real; its value is a position."""


@dataclass
class Words(Terms):
    """Makes terms of literals. Every operation of `Terms` is one on literals here."""

    graph: Graph = field(default_factory=Graph)
    sums: list[Literal] = field(default_factory=list)
    """The bits of all sums that were made."""
    _words: dict[tuple[object, ...], Word] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.true, self.false = self.bit(TRUE), self.bit(FALSE)

    # ---- making ----

    def bit(self, literal: Literal) -> Word:
        """Return a literal as a Bool."""
        known = self._words.get((literal,))
        if known is None:
            kind = "constant" if literal <= TRUE else "var"
            known = self._words[literal,] = Word(kind, "Bool", (), literal == TRUE, (literal,), 0, 1)  # type: ignore[arg-type]
        return known

    def word(self, bits: Sequence[Literal], low: int, high: int, grid: Grid | None = None) -> Word:
        """Return the number `low + bits`, which is at most `high`: an Int, or with a grid a Real."""
        kept = tuple(bits[: (high - low).bit_length()])
        if all(bit <= TRUE for bit in kept):
            low = high = low + sum(bit << k for k, bit in enumerate(kept))
            kept = ()
        key = (kept, low, high, grid)
        known = self._words.get(key)
        if known is None:
            sort: Sort = "Int" if grid is None else "Real"
            constant = not kept and grid is None
            known = Word("constant" if constant else "var", sort, (), low if constant else False, kept, low, high, grid)
            self._words[key] = known
        return known

    def constant(self, value: Number, sort: Sort) -> Term:
        """Return a number; a real becomes a position when it meets one that has a grid."""
        return super().constant(value, sort) if sort == "Real" else self.word((), int(value), int(value))

    def truth(self, value: bool) -> Term:
        """Return `true` or `false`."""
        return self.true if value else self.false

    def alike(self, word: Word, bits: Sequence[Literal]) -> Word:
        """Return a word that differs from another by its bits at most."""
        return self.bit(bits[0]) if word.sort == "Bool" else self.word(bits, word.low, word.high, word.grid)

    def replace(self, circuit: Circuit) -> None:
        """Replace the graph by a circuit with the same inputs and latches; words with other literals are forgotten."""
        self.graph.replace(circuit)
        leaves = {0, *circuit.inputs, *(latch.node for latch in circuit.latches)}
        self._words = {k: word for k, word in self._words.items() if all(bit >> 1 in leaves for bit in word.bits)}

    # ---- connectives ----

    def negation(self, term: Term) -> Term:
        """Return `not term`."""
        return self.bit(lit(term) ^ 1)

    def both(self, terms: Iterable[Term]) -> Term:
        """Return the conjunction."""
        return self.bit(self.graph.all(map(lit, terms)))

    def either(self, terms: Iterable[Term]) -> Term:
        """Return the disjunction."""
        return self.bit(self.graph.any(map(lit, terms)))

    def choose(self, condition: Term, then: Term, otherwise: Term) -> Term:
        """Return `ite condition then otherwise`."""
        guard = lit(condition)
        if guard <= TRUE or then is otherwise:
            return then if guard != FALSE else otherwise
        if then.sort == "Bool":
            return self.bit(self.graph.choose(guard, lit(then), lit(otherwise)))
        one, other = self._alike(then, otherwise)
        low, high = min(one.low, other.low), max(one.high, other.high)
        pairs = zip(*self.padded(self.offset_bits(one, low), self.offset_bits(other, low)), strict=True)
        return self.word([self.graph.choose(guard, a, b) for a, b in pairs], low, high, one.grid)

    def selected(self, cases: Sequence[tuple[Term, Term]], otherwise: Term) -> Term:
        """Return the term of the case that is true, `otherwise` if none is; at most one case may be true."""
        guards: dict[Term, list[Term]] = {}
        for guard, value in cases:
            guards.setdefault(value, []).append(guard)
        alternatives = [(self.either(found), value) for value, found in guards.items()]
        rest = self.negation(self.either(guard for guard, _ in alternatives))
        alternatives.append((rest, otherwise))
        graph = self.graph
        if otherwise.sort == "Bool":
            return self.bit(graph.any(graph.conjunction(lit(g), lit(v)) for g, v in alternatives))
        words = [self._alike(value, otherwise)[0] for _, value in alternatives]
        low, high = min(w.low for w in words), max(w.high for w in words)
        rows = [self.offset_bits(word, low) for word in words]
        wide = max(map(len, rows))
        rows = [(*row, *[FALSE] * (wide - len(row))) for row in rows]
        chosen = [
            graph.any(graph.conjunction(lit(g), row[k]) for (g, _), row in zip(alternatives, rows, strict=True))
            for k in range(wide)
        ]
        return self.word(chosen, low, high, words[0].grid)

    # ---- numbers ----

    def sum(self, constant: Number, parts: Iterable[tuple[Number, Term]], sort: Sort = "Int") -> Term:
        """Return `constant + sum(factor * term)` of integers."""
        assert sort == "Int", "reals are not summed"
        low = int(constant)
        rows: list[tuple[Bits, int]] = []
        for factor, term in parts:
            word = as_word(term)
            most = abs(int(factor)) * (word.high - word.low)
            low += min(int(factor) * word.low, int(factor) * word.high)
            bits = word.bits if factor > 0 else self._subtracted(_number(word.high - word.low), word.bits)
            rows.append((self._multiple(bits, abs(int(factor))), most))
        bits, most = self._balanced(rows)
        return self.word(bits, low, low + most)

    def _multiple(self, bits: Bits, factor: int) -> Bits:
        """Return `factor * bits`."""
        if len(bits) == 1:
            return tuple(bits[0] if bit else FALSE for bit in _number(factor))
        total: Bits = ()
        for k, bit in enumerate(_number(factor)):
            if bit:
                total = self._added((*[FALSE] * k, *bits), total)
        return total

    def _balanced(self, rows: Sequence[tuple[Bits, int]]) -> tuple[Bits, int]:
        """Return the sum of numbers that are at most so large, as a balanced tree.

        If one of them is replaced, only one branch of the tree changes.
        """
        level = [*rows] or [((), 0)]
        while len(level) > 1:
            pairs = zip(level[::2], level[1::2], strict=False)
            odd = level[len(level) & ~1 :]
            level = [
                (self._added(one, other)[: (most + more).bit_length()], most + more)
                for (one, most), (other, more) in pairs
            ]
            level += odd
        return level[0]

    def _compare(self, kind: str, left: Term, right: Term) -> Term:
        one, other = self._alike(left, right)
        if one.low > other.high or (kind == "=" and one.high < other.low):
            return self.false
        if kind == "<=" and one.high <= other.low:
            return self.true
        low, graph = min(one.low, other.low), self.graph
        pairs = list(zip(*self.padded(self.offset_bits(one, low), self.offset_bits(other, low)), strict=True))
        if kind == "=":
            return self.bit(graph.all(graph.differ(a, b) ^ 1 for a, b in pairs))
        least = TRUE
        for a, b in pairs:
            least = graph.choose(graph.differ(a, b), b, least)
        return self.bit(least)

    def narrowed(self, term: Term, low: int, high: int) -> tuple[Word, Literal]:
        """Return a number as a word of `low .. high`, and a literal: it lies outside."""
        word = as_word(term)
        if low <= word.low and word.high <= high:
            return word, FALSE
        first, last = self.constant(low, "Int"), self.constant(high, "Int")
        outside = lit(self.either((self.less(word, first), self.less(last, word))))
        base = min(word.low, low)
        shifted = self._subtracted(self.offset_bits(word, base), _number(low - base))
        return self.word((*shifted, *[FALSE] * (high - low).bit_length()), low, high), outside

    # ---- bits ----

    def _alike(self, one: Term, other: Term) -> tuple[Word, Word]:
        """Return two numbers as words; a real constant as its position on the grid of the other."""
        if isinstance(one, Word) and isinstance(other, Word):
            assert one.grid == other.grid, "reals of different grids do not meet"
            return one, other
        grid = one.grid if isinstance(one, Word) else other.grid if isinstance(other, Word) else None
        if grid is None:
            grid = Grid(tuple(sorted({Fraction(one.number), Fraction(other.number)})))
        return self._on(grid, one), self._on(grid, other)

    def _on(self, grid: Grid, term: Term) -> Word:
        """Return a real as a position on a grid."""
        if isinstance(term, Word):
            return term
        position = grid.position(Fraction(term.number))
        return self.word((), position, position, grid)

    def offset_bits(self, word: Word, low: int) -> Bits:
        """Return the bits of `word - low`; `low` is at most `word.low`."""
        return self._added(word.bits, _number(word.low - low))

    def padded(self, one: Bits, other: Bits) -> tuple[Bits, Bits]:
        """Return two numbers with the bits of the longer one."""
        wide = max(len(one), len(other))
        return (*one, *[FALSE] * (wide - len(one))), (*other, *[FALSE] * (wide - len(other)))

    def _added(self, one: Bits, other: Bits) -> Bits:
        if not one or not other:
            return one or other
        carry, found = FALSE, []
        for a, b in zip(*self.padded(one, other), strict=True):
            found.append(self.graph.differ(self.graph.differ(a, b), carry))
            carry = self._majority(a, b, carry)
        found += [carry] if carry != FALSE else []
        self.sums += found
        return tuple(found)

    def _subtracted(self, one: Bits, other: Bits) -> Bits:
        """Return `one - other`, modulo a power of two that holds both."""
        carry, found = TRUE, []
        for a, b in zip(*self.padded(one, other), strict=True):
            found.append(self.graph.differ(self.graph.differ(a, b ^ 1), carry))
            carry = self._majority(a, b ^ 1, carry)
        return tuple(found)

    def _majority(self, a: Literal, b: Literal, c: Literal) -> Literal:
        both = self.graph.conjunction
        return self.graph.any((both(a, b), both(c, self.graph.any((a, b)))))


def lit(term: Term) -> Literal:
    """Return the literal of a Bool."""
    assert isinstance(term, Word) and term.sort == "Bool"
    return term.bits[0]


def as_word(term: Term) -> Word:
    """Return a number as a word."""
    assert isinstance(term, Word)
    return term


def _number(value: int) -> Bits:
    return tuple(value >> k & 1 for k in range(value.bit_length()))
