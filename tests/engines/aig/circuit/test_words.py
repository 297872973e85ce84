"""Words of literals are numbers: every operation gives what Python's integers, and its doubles, give."""

import operator
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations, product
from math import inf, nextafter

import pytest

from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.circuit.words import Grid, Word, Words, as_word, lit
from exover.engines.aig.encoding.state import AllocatedRange, Latches
from exover.engines.aig.simulation.evaluation import evaluator
from exover.loop.exact.term import Term

RANGES = [(0, 0), (0, 1), (0, 2), (-3, -3), (-3, 2), (-4, 3), (1, 5), (5, 7), (-9, -2), (7, 12)]


class Bench:
    """Words whose bits are inputs, and what terms are for every assignment to these, side by side."""

    def __init__(self) -> None:
        self.terms = Words()
        self.inputs: list[Literal] = []

    def bit(self) -> Word:
        self.inputs.append(self.terms.graph.input())
        return self.terms.bit(self.inputs[-1])

    def word(self, low: int, high: int, grid: Grid | None = None) -> Word:
        bits = [self.terms.graph.input() for _ in range((high - low).bit_length())]
        self.inputs += bits
        return self.terms.word(bits, low, high, grid)

    def rows(self, *terms: Term) -> Iterator[tuple[int, ...]]:
        """Yield the values of the terms for every assignment, terms that are inputs among them."""
        lanes = 1 << len(self.inputs)
        leaves = {
            literal >> 1: sum(1 << lane for lane in range(lanes) if lane >> place & 1)
            for place, literal in enumerate(self.inputs)
        }
        words = [as_word(term) for term in terms]
        circuit = self.terms.graph.circuit([], [bit for word in words for bit in word.bits])
        cone = evaluator(circuit, circuit.bad)
        values = cone.values(leaves)
        read = [[cone.read(values, bit, (1 << lanes) - 1) for bit in word.bits] for word in words]
        for lane in range(lanes):
            yield tuple(
                word.low + sum((each >> lane & 1) << k for k, each in enumerate(bits))
                for word, bits in zip(words, read, strict=True)
            )


def inside(values: Sequence[int], ranges: Sequence[tuple[int, int]]) -> bool:
    return all(low <= value <= high for value, (low, high) in zip(values, ranges, strict=True))


@pytest.mark.parametrize("one", RANGES)
def test_numbers_compare_as_integers_do(one: tuple[int, int]) -> None:
    for other in RANGES:
        bench = Bench()
        a, b = bench.word(*one), bench.word(*other)
        asked: list[tuple[Callable[[int, int], bool], Callable[[Term, Term], Term]]] = [
            (operator.eq, bench.terms.equal),
            (operator.le, bench.terms.at_most),
            (operator.lt, bench.terms.less),
        ]
        made = [build(a, b) for _, build in asked]
        for x, y, *found in bench.rows(a, b, *made):
            if inside((x, y), (one, other)):
                assert found == [op(x, y) for op, _ in asked], (other, x, y)


@pytest.mark.parametrize("one", RANGES)
@pytest.mark.parametrize("factors", [(1, 1), (1, -1), (-3, 2), (5, 0), (-1, -6)])
def test_sums_are_those_of_integers(one: tuple[int, int], factors: tuple[int, int]) -> None:
    for other in RANGES:
        bench = Bench()
        a, b = bench.word(*one), bench.word(*other)
        total = bench.terms.sum(-7, zip(factors, (a, b), strict=True))
        seen = set()
        for x, y, found in bench.rows(a, b, total):
            if inside((x, y), (one, other)):
                seen.add(found)
                assert found == -7 + factors[0] * x + factors[1] * y, (other, x, y)
        word = as_word(total)
        assert (word.low, word.high) == (min(seen), max(seen)), other


def test_a_sum_of_many_flags_counts_them() -> None:
    bench = Bench()
    flags = [bench.bit() for _ in range(7)]
    terms = bench.terms
    ones = [terms.choose(flag, terms.constant(1, "Int"), terms.constant(0, "Int")) for flag in flags]
    total = terms.sum(0, [(weight, one) for weight, one in zip((1, 2, 3, -4, 1, 1, -5), ones, strict=True)])
    for *bits, found in bench.rows(*flags, total):
        assert found == sum(w * bit for w, bit in zip((1, 2, 3, -4, 1, 1, -5), bits, strict=True))


@pytest.mark.parametrize("one", RANGES)
def test_chosen_is_one_of_two(one: tuple[int, int]) -> None:
    for other in RANGES:
        bench = Bench()
        guard, a, b = bench.bit(), bench.word(*one), bench.word(*other)
        for g, x, y, found in bench.rows(guard, a, b, bench.terms.choose(guard, a, b)):
            if inside((x, y), (one, other)):
                assert found == (x if g else y), (other, x, y)


@pytest.mark.parametrize("ranges", [((0, 2), (-3, 1), (4, 5)), ((0, 0), (-1, 0), (-2, 3)), ((5, 6), (5, 6), (0, 1))])
def test_selected_is_the_case_that_is_true(ranges: tuple[tuple[int, int], ...]) -> None:
    bench = Bench()
    guards = [bench.bit() for _ in ranges[1:]]
    otherwise, *words = [bench.word(*each) for each in ranges]
    cases = list(zip(guards, words, strict=True))
    chosen = bench.terms.selected([*cases, cases[0]], otherwise)
    for *row, found in bench.rows(*guards, otherwise, *words, chosen):
        true, values = row[: len(guards)], row[len(guards) :]
        if sum(true) <= 1 and inside(values, ranges):
            assert found == (values[1 + true.index(1)] if 1 in true else values[0])


def test_bools_are_chosen_and_selected_too() -> None:
    bench = Bench()
    guard, other, a, b = (bench.bit() for _ in range(4))
    terms = bench.terms
    made = terms.choose(guard, a, b), terms.selected([(guard, a), (other, b)], terms.negation(a))
    for g, o, x, y, chosen, selected in bench.rows(guard, other, a, b, *made):
        assert chosen == (x if g else y)
        if not (g and o):
            assert selected == (x if g else y if o else 1 - x)


@pytest.mark.parametrize("wide", RANGES)
def test_narrowed_numbers_stay_and_others_are_told(wide: tuple[int, int]) -> None:
    for narrow in RANGES:
        bench = Bench()
        word = bench.word(*wide)
        found, outside = bench.terms.narrowed(word, *narrow)
        assert len(found.bits) <= (narrow[1] - narrow[0]).bit_length(), narrow
        for x, y, out in bench.rows(word, found, bench.terms.bit(outside)):
            if inside((x,), (wide,)):
                assert out == (not narrow[0] <= x <= narrow[1]), (narrow, x)
                if not out:
                    assert y == x, narrow


@pytest.mark.parametrize(("low", "high"), RANGES)
def test_constants_are_numbers_without_bits(low: int, high: int) -> None:
    terms = Words()
    for value in range(low, high + 1):
        word = as_word(terms.constant(value, "Int"))
        assert (word.bits, word.low, word.high, word.number) == ((), value, value, value)
        assert terms.word((), value, value) is word
        assert terms.equal(word, terms.constant(value, "Int")) is terms.true


# ---- reals ----

NEAR = (0.0, 5e-324, 0.1, nextafter(0.1, inf), 0.2, nextafter(nextafter(0.2, inf), inf), 1.0)
"""Constants, some of them neighbours among doubles."""
SOME = sorted({each for c in NEAR for each in (nextafter(c, -inf), c, nextafter(c, inf))} | {-1.0, 0.15, 2.0, -1e300})


@pytest.mark.parametrize("places", [0, 2])
def test_positions_compare_with_constants_as_doubles_do(places: int) -> None:
    grid = Grid(tuple(map(Fraction, NEAR)), places)
    terms = Words()
    for value in SOME:
        position = grid.position(Fraction(value))
        word = terms.word((), position, position, grid)
        for constant in NEAR:
            other = terms.constant(Fraction(constant), "Real")
            assert (terms.at_most(word, other) is terms.true) == (value <= constant), (value, constant)
            assert (terms.less(word, other) is terms.true) == (value < constant), (value, constant)
            assert (terms.at_most(other, word) is terms.true) == (constant <= value), (value, constant)
            assert (terms.less(other, word) is terms.true) == (constant < value), (value, constant)
            assert (terms.equal(word, other) is terms.true) == (value == constant), (value, constant)


def test_constants_compare_with_each_other_as_doubles_do() -> None:
    terms = Words()
    for one, other in product(NEAR, NEAR):
        a, b = terms.constant(Fraction(one), "Real"), terms.constant(Fraction(other), "Real")
        assert (terms.at_most(a, b) is terms.true) == (one <= other)
        assert (terms.equal(a, b) is terms.true) == (one == other)


def test_cells_without_doubles_are_those_between_neighbours() -> None:
    for constants in combinations(NEAR, 3):
        grid = Grid(tuple(map(Fraction, constants)))
        empty = {2 * k for k in (1, 2) if nextafter(constants[k - 1], inf) == constants[k]}
        assert set(grid.empty) == empty
        assert {grid.position(Fraction(each)) for each in SOME} & empty == set()


@pytest.mark.parametrize("places", [0, 1, 2])
@pytest.mark.parametrize("ends", [*combinations(NEAR, 2), (0.0, 0.0)])
def test_given_reals_have_the_positions_that_doubles_have(ends: tuple[float, float], places: int) -> None:
    """Every bit pattern is such a position, every such position that of some bits, and others are not legal."""
    grid = Grid(tuple(map(Fraction, NEAR)), places)
    span = AllocatedRange(*(grid.position(Fraction(end)) for end in ends), grid)
    bench = Bench()
    layout = Latches.__new__(Latches)
    layout.terms = bench.terms
    bits = tuple(bench.word(span.low, span.high).bits) if span.low != span.high else ()
    found = {row[0] for row in bench.rows(layout.given(bits, span))}
    doubles = [each for each in SOME if ends[0] <= each <= ends[1]]
    wanted = set()
    for each in doubles:
        cell = grid.position(Fraction(each))
        wanted |= {cell} if cell >> places & 1 else set(range(cell, cell + (1 << places)))
    assert found == wanted
    free = layout.made(bits, span)
    for position, legal in bench.rows(free, bench.terms.bit(layout.legal(free, span))):
        constant = bool(position >> places & 1)
        odd = constant and position & ((1 << places) - 1)
        assert legal == (not odd and position <= span.high), position


@pytest.mark.parametrize(("low", "high"), RANGES)
def test_given_numbers_are_all_of_the_range_and_no_other(low: int, high: int) -> None:
    bench = Bench()
    layout = Latches.__new__(Latches)
    layout.terms = bench.terms
    bits = tuple(bench.word(low, high).bits)
    given = layout.given(bits, AllocatedRange(low, high))
    assert {row[0] for row in bench.rows(given)} == set(range(low, high + 1))
    word = layout.made(bits, AllocatedRange(low, high))
    for value, legal in bench.rows(word, bench.terms.bit(layout.legal(word, AllocatedRange(low, high)))):
        assert legal == (value <= high)


def test_bits_and_words_are_told_apart() -> None:
    bench = Bench()
    flag = bench.bit()
    assert lit(flag) == as_word(flag).bits[0]
    with pytest.raises(AssertionError):
        lit(bench.word(0, 3))
