"""What counts as a change of an answer, for the reference interpreters and the engine alike."""

from exover.diff.compare import differences
from exover.model.difference import AnswerChange
from tests.support.edits import loops_of
from tests.support.engines import model_of
from tests.support.small import compiled


def changes(old: str, new: str) -> dict[AnswerChange, int]:
    """Return the changes between two versions, each with the steps of its run; nothing is undecided."""
    shown, undecided = differences(loops_of(compiled(model_of(old)), compiled(model_of(new))), "", print)
    assert not undecided
    return {each.change: len(each.steps) for each in shown}


HOT = "spec s; poster hot: bool = false; module m { request r(); } forbid f: hot and active(m.r);"
ALONE = HOT.replace("module", "poster extra: bool = false; module")


def test_a_violation_that_stands_in_both_is_not_raised_anew_by_an_event_of_one_alone() -> None:
    assert not changes(HOT, ALONE)
    assert not changes(ALONE, HOT)


def test_a_violation_by_an_event_of_one_alone_is_told_where_none_stands_in_the_other() -> None:
    worse = ALONE.replace("hot and", "extra and")
    assert changes(HOT, worse)[AnswerChange(None, "violation")] == 2
    assert changes(worse, HOT)[AnswerChange(None, "violation", gone=True)] == 2


def test_a_newcomer_that_no_longer_supersedes_its_like_is_newly_rejected() -> None:
    old = """spec s; module m { request b(); request r() { interrupts self; wait until not active(m.b); } }"""
    new = old.replace("interrupts self; ", "")
    assert changes(old, new) == {AnswerChange("m.r", "rejected"): 2}
    assert changes(new, old)[AnswerChange("m.r", "waiting")] == 2
