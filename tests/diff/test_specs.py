"""Edits of the specs of the project: which requests change, by shortest runs, and that no edit changes nothing."""

from functools import cache
from pathlib import Path

import pytest

from benchmarks.changes import EDITS, edited
from exover.diff.compare import differences
from exover.model.event import Ask, Observe
from exover.ocrd.compile import Compiled
from tests.support.edits import loops_of
from tests.support.engines import model_of
from tests.support.small import compiled

SPECS = Path(__file__).parents[2] / "specs"
CHANGED = {
    ("assistant", "a rule removed"): {"arm.grab", "arm.hand_over", "base.move"},
    ("assistant", "a bound changed"): {"base.move", "arm.grab"},
    ("assistant", "a wait made a reject"): {"vacuum.clean"},
    ("diligent", "a rule removed"): {"teleop.drive", "topo.travel"},
    ("diligent", "a bound changed"): {"nd.goto", "teleop.drive"},
    ("diligent", "a wait made a reject"): {"platine.point", "cameras.shoot"},
    ("rover", "a rule removed"): {"nd.goto"},
    ("rover", "a bound changed"): {"nd.goto"},
    ("rover", "a wait made a reject"): {"nd.goto", "arm.move"},
    ("satellite", "a rule removed"): {"camera.shoot"},
    ("satellite", "a bound changed"): {"lens.expose", "thruster.fire"},
    ("satellite", "a wait made a reject"): {"attitude.point", "thruster.fire"},
}


@cache
def tables(spec: str) -> Compiled:
    return compiled(model_of((SPECS / f"{spec}.exo").read_text(encoding="utf-8")))


@pytest.mark.parametrize(("spec", "change"), [(spec, change) for spec, changes in EDITS.items() for change in changes])
def test_an_edit_changes_the_requests_that_it_is_about(spec: str, change: str) -> None:
    old, new = tables(spec), compiled(model_of(edited(spec, change)))
    shown, undecided = differences(loops_of(old, new), "", print)
    assert not undecided
    assert all(each.shortest for each in shown)
    assert {each.change.request for each in shown} == CHANGED[spec, change]


@pytest.mark.parametrize("spec", EDITS)
def test_a_spec_is_the_same_as_itself(spec: str) -> None:
    assert differences(loops_of(tables(spec), tables(spec)), "", print) == ((), ())


def test_numbers_of_a_run_are_plain_for_both_versions() -> None:
    """Each value is the nearest to the start, or to 0, that neither version tells from the one that was found."""
    text = """spec s; poster wind: int in 0 .. 99 = 3; poster t: real in 0 .. 9 = 1;
    module m { request a(x: int in -9 .. 9) { check wind < 45; check t < 2.5; check x > 4; } }"""
    old = compiled(model_of(text))
    new = compiled(model_of(text.replace("45", "50").replace("2.5", "3").replace("> 4", "> 6")))
    shown, undecided = differences(loops_of(old, new), "", print)
    assert not undecided
    found: dict[str, set[object]] = {"wind": {3}, "t": {1.0}, "x": set()}
    for each in shown:
        for step in each.steps:
            match step.events[1]:
                case Ask(_, (x,)):
                    found["x"].add(x)
                case Observe(name, value):
                    found[name].add(value)
    assert found["wind"] <= {3, 45} and found["t"] <= {1.0, 2.5} and found["x"] <= {0, 5, 7}
    assert 45 in found["wind"] or 2.5 in found["t"]
