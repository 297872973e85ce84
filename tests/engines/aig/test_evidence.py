"""What is said of a claim, of what is known of its questions."""

import pytest

from exover.engines.aig.encoding.questions import (
    Beyond,
    CutOff,
    Either,
    KnownAtStart,
    LassoQuestion,
    Leaf,
    OppositeQuestion,
    Reach,
    RunQuestion,
)
from exover.engines.aig.evidence import INITIAL, NOT_PROVED, PROVED, STRANDED, WITNESS, Evidence, Found, unproved
from exover.loop.claim import NO_FORMULA, Claim, Opinion
from exover.loop.formula_classes import ExistsUntil, Stuck
from exover.model.property import TRUE
from exover.model.trace import Trace

MOMENT, OTHER, LASSO, WAY = (
    Reach(2),
    Reach(4),
    LassoQuestion(TRUE, False),
    CutOff(Stuck(TRUE, ExistsUntil(TRUE, TRUE, strict=False), TRUE)),
)
RUN = Trace(())
SEEN, NONE, LEFT = Found(True, WITNESS, RUN), Found(False, PROVED), Found(None, reason="too hard")


def evidence(found: dict[Leaf, Found], settled: bool | None = True, goes_on: bool = True) -> Evidence:
    known = Evidence(lambda fair: goes_on, lambda: False, settled)
    known.found |= found
    return known


@pytest.mark.parametrize("settled", [None, False, True])
@pytest.mark.parametrize("leaf", [MOMENT, LASSO])
def test_a_run_shows_it_and_all_else_rests_on_the_passes(leaf: Leaf, settled: bool | None) -> None:
    assert evidence({leaf: SEEN}, settled).answer(leaf, fair=False) == SEEN
    assert evidence({leaf: NONE}, settled).answer(leaf, fair=False) == (
        NONE if settled else Found(None, reason=NOT_PROVED)
    )


@pytest.mark.parametrize("found", [SEEN, NONE])
def test_what_is_said_of_ways_rests_on_the_passes(found: Found) -> None:
    """Also that there is none: a run shows the moment, and not that nothing leads on."""
    assert evidence({WAY: found}).answer(WAY, fair=False) == found
    assert evidence({WAY: found}, settled=False).answer(WAY, fair=False).reason == NOT_PROVED


def test_of_fair_runs_is_known_what_was_asked_of_them_or_of_all_that_go_on() -> None:
    known = evidence({MOMENT: SEEN, OTHER: NONE, LASSO: SEEN, WAY: NONE}, goes_on=False)
    answers = [known.answer(leaf, fair=True) for leaf in (MOMENT, OTHER, LASSO, WAY)]
    stranded = Found(None, reason=STRANDED)
    assert answers == [stranded, NONE, SEEN, stranded]


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        (OppositeQuestion(MOMENT), Found(False, WITNESS, RUN)),
        (OppositeQuestion(OppositeQuestion(OTHER)), NONE),
        (Either((OTHER, MOMENT)), SEEN),
        (Either((OTHER, LASSO)), Found(None, reason="too hard")),
        (Either((LASSO, MOMENT)), SEEN),
        (Either((KnownAtStart(False), OTHER)), NONE),
        (Either((KnownAtStart(False),)), Found(False, INITIAL, Trace(()))),
        (KnownAtStart(True), Found(True, INITIAL, Trace(()))),
        (Beyond(), Found(None)),
    ],
)
def test_answers_are_made_of_those_to_parts(question: RunQuestion, answer: Found) -> None:
    assert evidence({MOMENT: SEEN, OTHER: NONE, LASSO: LEFT}).answer(question, fair=False) == answer


def test_a_question_is_complete_once_all_its_parts_were_looked_into() -> None:
    both = Either((MOMENT, OppositeQuestion(LASSO)))
    assert not evidence({MOMENT: LEFT}).is_complete(both)
    assert not evidence({MOMENT: LEFT, LASSO: LEFT}, settled=None).is_complete(both)
    assert evidence({MOMENT: LEFT, LASSO: LEFT}).is_complete(both)


@pytest.mark.parametrize(
    ("goes_on", "fair_run", "fair", "holds"),
    [
        ((True, True), False, True, True),
        ((True, False), True, True, True),
        ((True, False), False, True, False),
        ((False, False), True, True, False),
        ((True, False), False, False, True),
        ((False, False), True, False, False),
    ],
)
def test_assumptions_are_coherent_if_all_runs_go_on_and_one_does_fairly(
    goes_on: tuple[bool, bool], fair_run: bool, fair: bool, holds: bool
) -> None:
    known = Evidence(goes_on.__getitem__, lambda: fair_run, True)
    known.found[MOMENT] = NONE
    opinion = known.opinion(OppositeQuestion(MOMENT), Claim("property", "s", TRUE, coherent=True, fair=fair))
    assert opinion == (Opinion("holds", PROVED) if holds else Opinion("unknown", "", STRANDED))


def test_runs_are_told_where_they_are_part_of_the_finding() -> None:
    known = evidence({MOMENT: SEEN, LASSO: LEFT})
    told = {check: known.opinion(MOMENT, Claim(check, "s", TRUE)) for check in ("reachability", "rule-use")}
    assert told["reachability"] == Opinion("holds", WITNESS, trace=RUN)
    assert told["rule-use"] == Opinion("holds", WITNESS)
    assert known.opinion(OppositeQuestion(MOMENT), Claim("safety", "s", TRUE)) == Opinion(
        "violated", WITNESS, trace=RUN
    )
    assert known.opinion(LASSO, Claim("starvation", "s", TRUE)) == Opinion("unknown", "", "too hard")
    assert known.opinion(Beyond(), Claim("starvation", "s", TRUE)) == Opinion("unknown", "", NO_FORMULA)


def test_without_the_passes_runs_are_left() -> None:
    shown, proved, unknown = Opinion("holds", WITNESS), Opinion("holds", PROVED), Opinion("unknown", "", "why")
    assert [unproved(each) for each in (shown, proved, unknown)] == [shown, Opinion("unknown", "", NOT_PROVED), unknown]
