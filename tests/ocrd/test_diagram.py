"""Diagrams: one node for each function, whatever way it is built and under whatever order."""

from collections.abc import Iterator
from itertools import product

from hypothesis import given, settings
from hypothesis import strategies as st

from exover.ocrd import diagram
from exover.ocrd.diagram import NO, YES, Act, Manager
from exover.ocrd.order import Sifting, sift, support

ENTRIES, VALUES = 3, 4
"""Every diagram here is one over three entries that lie in 0 .. 3."""
Assignment = tuple[int, ...]
Expression = tuple[object, ...]
"""`("atom", entry, bound)`, `("not", e)`, `("and", e, e)`, `("or", e, e)` or `("ite", e, e, e)`."""


def assignments() -> list[Assignment]:
    return list(product(range(VALUES), repeat=ENTRIES))


def truth(expression: Expression, values: Assignment) -> bool:
    match expression:
        case ("atom", int(entry), int(bound)):
            return values[entry] <= bound
        case ("not", tuple(part)):
            return not truth(part, values)
        case ("and", tuple(left), tuple(right)):
            return truth(left, values) and truth(right, values)
        case ("or", tuple(left), tuple(right)):
            return truth(left, values) or truth(right, values)
        case ("ite", tuple(which), tuple(then), tuple(otherwise)):
            return truth(then, values) if truth(which, values) else truth(otherwise, values)
    raise AssertionError(expression)


def built(manager: Manager, expression: Expression) -> int:
    match expression:
        case ("atom", int(entry), int(bound)):
            return manager.at_most(entry, bound, 0, VALUES - 1)
        case ("not", tuple(part)):
            return manager.negate(built(manager, part))
        case ("and", tuple(left), tuple(right)):
            return manager.both(built(manager, left), built(manager, right))
        case ("or", tuple(left), tuple(right)):
            return manager.either(built(manager, left), built(manager, right))
        case ("ite", tuple(which), tuple(then), tuple(otherwise)):
            return manager.ite(built(manager, which), built(manager, then), built(manager, otherwise))
    raise AssertionError(expression)


def value(manager: Manager, number: int, values: Assignment) -> tuple[bool, list[object]]:
    """Return whether the path of these values ends in `YES`, and the actions on it."""
    actions: list[object] = []
    while True:
        match manager.node(number):
            case diagram.Test(level, cuts, below):
                entry = values[manager.entries[level]]
                number = below[sum(entry > cut for cut in cuts)]
            case Act(action, child):
                actions.append(action)
                number = child
            case None:
                return number == YES, actions


def table(manager: Manager, number: int) -> list[bool]:
    return [value(manager, number, values)[0] for values in assignments()]


atoms = st.tuples(st.just("atom"), st.integers(0, ENTRIES - 1), st.integers(-1, VALUES))
expressions = st.recursive(
    atoms,
    lambda parts: st.one_of(
        st.tuples(st.just("not"), parts),
        st.tuples(st.sampled_from(["and", "or"]), parts, parts),
        st.tuples(st.just("ite"), parts, parts, parts),
    ),
    max_leaves=12,
)
orders = st.permutations(range(ENTRIES))


@given(expressions, orders)
def test_a_diagram_is_the_function_that_it_was_built_as(expression: Expression, order: list[int]) -> None:
    manager = Manager(order)
    assert table(manager, built(manager, expression)) == [truth(expression, values) for values in assignments()]


@given(expressions, expressions, orders)
def test_two_diagrams_are_one_node_iff_they_are_one_function(
    first: Expression, second: Expression, order: list[int]
) -> None:
    manager = Manager(order)
    same = [truth(first, values) for values in assignments()] == [truth(second, values) for values in assignments()]
    assert (built(manager, first) == built(manager, second)) == same


@given(expressions, expressions, expressions)
def test_laws(f: Expression, g: Expression, h: Expression) -> None:
    manager = Manager()
    a, b, c = (built(manager, part) for part in (f, g, h))
    negate, both, either, ite = manager.negate, manager.both, manager.either, manager.ite
    assert negate(negate(a)) == a
    assert negate(both(a, b)) == either(negate(a), negate(b))
    assert both(a, either(b, c)) == either(both(a, b), both(a, c))
    assert either(a, negate(a)) == YES and both(a, negate(a)) == NO
    assert ite(a, b, c) == either(both(a, b), both(negate(a), c)) == ite(negate(a), c, b)
    assert negate(ite(a, b, c)) == ite(a, negate(b), negate(c))


def minterms(function: int) -> Iterator[tuple[bool, ...]]:
    """Yield where a function of three atoms is true; bit k of `function` is its value in row k of the truth table."""
    for row, values in enumerate(product((False, True), repeat=3)):
        if function >> row & 1:
            yield values


@given(expressions, orders, st.dictionaries(st.integers(0, ENTRIES - 1), st.integers(0, VALUES - 1)))
def test_a_cofactor_is_the_function_where_entries_have_values(
    expression: Expression, order: list[int], known: dict[int, int]
) -> None:
    manager = Manager(order)
    found = manager.cofactor(built(manager, expression), known)
    assert known.keys().isdisjoint(support(manager, [found]))
    given = [tuple(known.get(entry, other) for entry, other in enumerate(values)) for values in assignments()]
    assert table(manager, found) == [truth(expression, values) for values in given]


def test_every_function_of_three_atoms_is_one_node() -> None:
    manager = Manager()
    atom = [manager.at_most(entry, 1, 0, VALUES - 1) for entry in range(3)]

    def corner(values: tuple[bool, ...], joined: bool) -> int:
        parts = [a if positive == joined else manager.negate(a) for a, positive in zip(atom, values, strict=True)]
        found = parts[0]
        for part in parts[1:]:
            found = manager.both(found, part) if joined else manager.either(found, part)
        return found

    found = set()
    for function in range(256):
        disjunction, conjunction = NO, YES
        for values in minterms(function):
            disjunction = manager.either(disjunction, corner(values, True))
        for values in minterms(255 - function):
            conjunction = manager.both(conjunction, corner(values, False))
        assert disjunction == conjunction, f"function {function:08b}: {list(minterms(function))}"
        found.add(disjunction)
    assert len(found) == 256


# ---- actions ----

diagrams = st.lists(st.tuples(expressions, st.integers(1, 3)), max_size=4)
"""Decisions: the conditions asked in turn, and the action where one holds first; 0 where none does."""


def decided(manager: Manager, cases: list[tuple[Expression, int]]) -> int:
    result = manager.act(0, NO)
    for condition, action in reversed(cases):
        result = manager.ite(built(manager, condition), manager.act(action, manager.act("then", NO)), result)
    return result


def expected(cases: list[tuple[Expression, int]], values: Assignment) -> list[object]:
    first = next((action for condition, action in cases if truth(condition, values)), 0)
    return [first, "then"] if first else [0]


def assert_decides(manager: Manager, root: int, cases: list[tuple[Expression, int]]) -> None:
    for values in assignments():
        assert value(manager, root, values) == (False, expected(cases, values)), values


@given(diagrams)
def test_actions_are_done_in_order_below_the_tests_that_decide_them(cases: list[tuple[Expression, int]]) -> None:
    manager = Manager()
    assert_decides(manager, decided(manager, cases), cases)


@given(diagrams, orders)
def test_a_copy_under_another_order_decides_the_same(cases: list[tuple[Expression, int]], order: list[int]) -> None:
    source, target = Manager(), Manager(order)
    assert_decides(target, source.copy(decided(source, cases), target), cases)


@given(diagrams, orders)
def test_sifting_changes_the_order_and_nothing_else(cases: list[tuple[Expression, int]], order: list[int]) -> None:
    manager = Manager(order)
    root = decided(manager, cases)
    size = Sifting(manager, root).size
    sifted, moved = sift(manager, root)
    assert_decides(sifted, moved, cases)
    assert Sifting(sifted, moved).size <= size


@given(diagrams, st.lists(st.integers(0, 1), max_size=6))
@settings(max_examples=50)
def test_every_swap_of_neighbours_keeps_the_function(cases: list[tuple[Expression, int]], swaps: list[int]) -> None:
    manager = Manager(range(ENTRIES))
    root = decided(manager, cases)
    sifting = Sifting(manager, root)
    for place in swaps:
        if place + 1 < len(sifting.order):
            sifting.swap(place)
    swapped, moved = sifting.result()
    assert_decides(swapped, moved, cases)


def test_sifting_finds_the_order_that_keeps_pairs_together() -> None:
    manager = Manager(range(8))  # x0 y0 or x1 y1 or …, all x before all y: exponential so, linear in pairs
    root = NO
    for index in range(4):
        pair = manager.both(manager.at_most(index, 0, 0, 1), manager.at_most(index + 4, 0, 0, 1))
        root = manager.either(root, pair)
    sifted, moved = sift(manager, root)
    assert Sifting(manager, root).size == 30
    assert Sifting(sifted, moved).size == 8
    assert sorted(support(sifted, [moved])) == list(range(8))
