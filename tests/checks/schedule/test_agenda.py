"""In which order questions are asked, and how much time each gets."""

from exover.checks.schedule.agenda import GROWTH, LEAST, LONGEST, MOST, Agenda, Lot, Turn
from tests.checks.schedule.spreading import lots


def one(number: int, seconds: float) -> Turn:
    return Turn((number,), seconds, seconds)


def test_without_a_limit_all_are_asked_in_order() -> None:
    agenda = Agenda(lots("a", "b", "a"))
    assert [agenda.next(float("inf")) for _ in range(4)] == [*(one(n, float("inf")) for n in (0, 2, 1)), None]


def test_what_weighs_more_is_asked_first() -> None:
    agenda = Agenda([Lot((0, 1), 1), Lot((2,), 2), Lot((3,), 0)])
    assert [turn.numbers for _ in range(4) if (turn := agenda.next(9.0))] == [(3,), (0,), (1,), (2,)]


def test_every_question_gets_a_slice_before_any_gets_a_second() -> None:
    agenda = Agenda(lots("slow", "slow", "quick", "dull"), 120.0)
    assert agenda.next(120.0) == one(0, MOST)
    agenda.late((0,))
    assert agenda.next(119.0) == one(2, MOST)
    agenda.answered(2, in_vain=False)
    assert agenda.next(119.0) == one(3, MOST)
    agenda.late((3,))
    # The next round: what was never asked, then what was.
    assert agenda.next(100.0) == one(1, 4 * MOST)
    agenda.answered(1, in_vain=False)
    assert agenda.next(99.0) == one(0, 4 * MOST)
    agenda.late((0,))
    assert agenda.next(90.0) == one(3, 4 * MOST)
    agenda.late((3,))
    assert agenda.next(80.0) == one(0, 16 * MOST)
    agenda.late((0,))
    assert agenda.next(5.0) == one(3, 5.0)
    agenda.answered(3, in_vain=False)
    agenda.answered(0, in_vain=True)
    assert not agenda.waits
    assert agenda.next(1.0) is None


def test_what_was_never_asked_comes_before_what_was() -> None:
    agenda = Agenda(lots("slow", "dull", "dull"), 120.0)
    assert agenda.next(120.0) == one(0, MOST)
    agenda.late((0,))
    assert agenda.next(119.0) == one(1, MOST)
    agenda.late((1,))
    assert agenda.next(118.0) == one(2, 4 * MOST)
    assert agenda.next(118.0) == one(0, 4 * MOST)


def test_every_question_gets_the_time_that_a_process_needs_to_begin() -> None:
    assert Agenda(lots("a", "b"), 0.5).next(0.5) == one(0, LEAST)
    assert Agenda(lots("a", "b"), 0.5).next(0.1) == one(0, 0.1)


def test_a_question_that_is_asked_instead_waits_for_its_turn() -> None:
    agenda = Agenda(lots("a", "b", "z a", "z b"), instead={0: 2, 1: 3})
    assert agenda.next(9.0) == one(0, 9.0)
    assert agenda.answered(0, in_vain=True) == (0,)
    assert agenda.next(7.0) == one(1, 7.0)
    assert agenda.answered(1, in_vain=False) == (1, 3)
    assert agenda.next(7.0) == one(2, 7.0)
    assert agenda.answered(2, in_vain=True) == (2,)
    assert agenda.next(6.0) is None
    assert agenda.over == {0, 1, 2, 3}


def test_any_answer_ends_the_question_for_all() -> None:
    for who in (0, 1, 2):
        agenda = Agenda(lots("a", "y", "z"), 80.0, {0: 1, 1: 2})
        assert agenda.next(80.0) == one(0, MOST)
        agenda.late((0,))
        assert agenda.next(79.0) == one(1, MOST)
        agenda.late((1,))
        assert agenda.next(78.0) == one(2, MOST)
        assert agenda.answered(who, in_vain=False) == (0, 1, 2)
        assert agenda.next(70.0) is None


def test_what_is_asked_at_once_waits_for_all_of_it() -> None:
    agenda = Agenda([Lot((0, 1)), Lot((2, 3), together=True)], instead={0: 2, 1: 3})
    assert agenda.next(9.0) == one(0, 9.0)
    agenda.answered(0, in_vain=True)
    assert agenda.next(9.0) == one(1, 9.0)
    assert agenda.next(9.0) is None
    agenda.answered(1, in_vain=True)
    assert agenda.next(9.0) == Turn((2, 3), 9.0, 9.0, together=True)


def test_what_is_asked_at_once_takes_turns_with_all_the_others() -> None:
    agenda = Agenda([Lot((0, 1), together=True), *(Lot((number,)) for number in range(2, 9))], 600.0)
    assert agenda.next(600.0) == Turn((0, 1), LONGEST, 300.0, together=True)
    agenda.late((0, 1))
    assert agenda.next(570.0) == one(2, MOST)
    agenda.answered(2, in_vain=False)
    assert agenda.next(560.0) == one(3, MOST)
    agenda.late((3,))
    assert agenda.next(540.0) == Turn((0, 1), GROWTH * LONGEST, 270.0, together=True)
    agenda.answered(0, in_vain=False)
    agenda.late((1,))
    assert agenda.next(450.0) == one(4, MOST)
    agenda.late((4,))
    assert agenda.next(300.0) == Turn((1,), 150.0, 150.0, together=True)
    agenda.late((1,))
    assert agenda.next(150.0) == one(5, MOST)
    agenda.late((5,))
    assert agenda.next(100.0) == one(6, MOST)
    agenda.late((6,))
    assert agenda.next(50.0) == Turn((1,), LONGEST, LONGEST, together=True)


def test_what_is_asked_at_once_first_gets_a_quarter_of_the_time() -> None:
    """So that in a time limit of seconds others are asked, too, and none does again what is all but done."""
    for seconds, stretch in ((1.0, 0.25), (20.0, 5.0), (60.0, 15.0)):
        turn = Agenda([Lot((0,), together=True), Lot((1,))], seconds, {0: 1}).next(seconds)
        assert turn == Turn((0,), stretch, seconds / 2, together=True)


def test_others_try_errors_first_of_what_takes_long_at_once() -> None:
    lots = [Lot(range(3), together=True), Lot((3,), 1), Lot((4, 5), 0)]
    agenda = Agenda(lots, 60.0, {n: n + 3 for n in range(3)})
    assert agenda.next(60.0) == Turn((0, 1, 2), 15.0, 30.0, together=True)
    assert agenda.next(60.0) is None
    agenda.answered(2, in_vain=True)
    assert agenda.next(60.0) == one(5, MOST)
    agenda.call((0, 1))
    assert agenda.next(59.0) == one(4, MOST)
    assert agenda.next(59.0) == one(3, MOST)
