"""Reference interpreter, tables and compiled C give the same answers on random specs and random events."""

import pytest

from tests.support.constructs import seldom
from tests.support.engines import agree, agree_at_random, disagreement, model_of
from tests.support.events import Stream
from tests.support.fuzz import VARIED, spec_of
from tests.support.seldom import SELDOM, lines
from tests.support.shrink import shrink, smallest
from tests.support.vectors import NAMES
from tests.support.vectors import model_of as vectors_model

EVENTS = 200
MANY = range(110)
FEW = (4, 11, 14, 20, 34, 40, 43, 44, 49, 52, 54, 56, 59, 62, 63, 66, 69, 70, 72, 73, 74, 85, 87, 89, 90, 94)
"""Random specs of which five have each construct of the many, or as many as there are; `make fuzz` takes more."""
IN_C = (101, 106)
"""Those that are compiled; with those of tests/vectors they have every construct of ten."""


@pytest.mark.parametrize("seed", FEW)
def test_tables_answer_as_the_reference_does(seed: int) -> None:
    agree_at_random(spec_of(seed), seed, EVENTS)


@pytest.mark.parametrize("seed", IN_C)
def test_the_compiled_c_answers_as_the_others_do(seed: int) -> None:
    agree_at_random(spec_of(seed), seed, 2 * EVENTS, native=True)


# ---- what the others rest on ----


def test_a_seed_gives_the_same_spec_and_the_same_events_again() -> None:
    for seed in range(8):
        spec = spec_of(seed)
        model = model_of(spec)
        assert spec == spec_of(seed)
        assert list(Stream(model, seed).lines(50)) == list(Stream(model, seed).lines(50))


def test_every_random_spec_is_valid_and_few_have_every_construct() -> None:
    made = {seed: model_of(spec_of(seed)) for seed in MANY}
    assert all(model.requests for model in made.values())
    few, varied, in_c, many = ([(made[seed],) for seed in seeds] for seeds in (FEW, VARIED, IN_C, MANY))
    assert not seldom(few, many[:100], 5)
    assert not seldom(varied, many, 2)
    assert not seldom([*in_c, *((vectors_model(name),) for name in NAMES)], many[100:], 1)


def test_smallest_keeps_what_fails_and_nothing_else() -> None:
    lines = [str(number) for number in range(40)]
    assert smallest(lines, lambda some: {"3", "17", "18"} <= set(some)) == ["3", "17", "18"]
    assert smallest(lines, lambda some: True) == []


def test_a_disagreement_is_found_told_and_made_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tables are made to forget what `on … forget` forgets."""
    spec = """spec s;
module m {
    request a() { on ok forget m.b; }
    request b();
    request c() { check past(m.b); }
}"""
    names = ["b", "b ok", "c", "c ok", "a", "a ok", "c", "b", "a"]
    lines = [
        f'{{"report": "m.{name[0]}", "outcome": "ok"}}' if " " in name else f'{{"ask": "m.{name}"}}' for name in names
    ]
    assert disagreement(spec, lines) is None
    monkeypatch.setattr("exover.ocrd.machine.Machine._affect", lambda machine, start, end: None)
    found = disagreement(spec, lines)
    assert found is not None and len(found.lines) == 7
    small = shrink(found)
    assert [line.split('"')[3] for line in small.lines] == ["m.b", "m.b", "m.a", "m.a", "m.c"]
    assert small.answers["reference"] == '{"step": 5, "actions": [{"reject": "m.c", "rule": "m.c.check.1"}]}'
    assert "at event 5 the engines answer" in str(small)


# ---- what random events seldom meet ----


@pytest.mark.parametrize(("text", "events"), SELDOM.values(), ids=SELDOM)
def test_they_agree_on_what_is_seldom_met(text: str, events: list[str]) -> None:
    agree(f"spec s; {text}", lines(events))
