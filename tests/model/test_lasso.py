"""Lassos of any steps: what is left without some, and what their steps may make."""

from exover.model.lasso import Lasso, endings, moves, rearranged, related

LASSO = Lasso(("a1", "b1", "c1"), ("a2", "d1"))


def subject(step: str) -> str:
    """Return what a step speaks of."""
    return step[0]


def test_steps_are_dropped_from_where_they_are() -> None:
    assert LASSO.without({0, 3}) == Lasso(("b1", "c1"), ("d1",))
    assert LASSO.without({2}) == Lasso(("a1", "b1"), ("a2", "d1"))
    assert not LASSO.without({3, 4}).loop
    assert LASSO.without(()) == LASSO and LASSO.length == len(LASSO.steps) == 5


def test_what_speaks_of_the_same_is_related_and_any_two_steps_of_a_short_lasso() -> None:
    alone = [frozenset({number}) for number in range(5)]
    assert set(related(LASSO, subject, 4)) == {frozenset({0, 3}), frozenset({0, 1, 2, 3}), *alone}
    assert len(related(LASSO, subject, 5)) == 10 + 1 + len(alone)


def test_what_speaks_of_the_same_is_related_from_one_step_of_it_to_another() -> None:
    found = set(related(Lasso(("a1", "b1", "a2", "c1", "a3"), ("d1",)), subject, 0))
    assert {frozenset({0, 2}), frozenset({2, 4}), frozenset({0, 4}), frozenset({0, 2, 4})} <= found
    assert {frozenset({0, 1, 2}), frozenset({2, 3, 4}), frozenset({0, 1, 2, 3, 4})} <= found
    assert not found & {frozenset({1, 2}), frozenset({1, 3})}


def test_a_run_ends_by_reports_or_at_once_and_observes_for_ever() -> None:
    assert list(endings(("a1", "b1"), ("a2", "b2"), ["p", "q"])) == [
        Lasso(("a1", "b1"), ("p",)),
        Lasso(("a1", "b1", "a2", "b2"), ("p",)),
        Lasso(("a1", "b1"), ("q",)),
        Lasso(("a1", "b1", "a2", "b2"), ("q",)),
    ]


def test_a_step_takes_the_place_of_another() -> None:
    assert list(moves(("a", "b", "a"))) == [
        (1, 0, ("b", "a")),
        (0, 1, ("a", "a")),
        (2, 1, ("a", "a")),
        (1, 2, ("a", "b")),
    ]


def test_a_loop_gives_steps_and_takes_none() -> None:
    found = rearranged(LASSO, subject)
    assert Lasso(("c1", "b1"), ("a2", "d1")) in found
    assert Lasso(("a1", "d1", "c1"), ("a2",)) in found
    assert Lasso(("a1", "b1", "c1"), ("d1",)) in found
    assert not any("b1" in each.loop for each in found)
    assert all(each.loop and each.length < LASSO.length for each in found)
    assert len(set(found)) == len(found)


def test_a_loop_begins_earlier_with_any_of_its_steps_and_the_stem_may_be_like_it() -> None:
    found = rearranged(LASSO, subject)
    assert Lasso(("a1",), ("d1", "a2")) in found
    assert Lasso(("a2", "b1"), ("d1", "a2")) in found
    assert Lasso(("a1", "a2"), ("d1", "a2")) not in found, "only steps that speak of the same"
