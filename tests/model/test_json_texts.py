"""Texts from templates are those of the objects."""

import json
import random
from collections.abc import Iterator

import pytest

from exover.model.event import Abort, AbortWaiting, Ask, Event, Launched, Observe, Report
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.texts import WireTexts
from exover.model.types import Value
from exover.model.wire import action_json, event_json
from tests.support.engines import model_of

SPEC = """spec texts;
poster level: int in 0 .. 9 = 0 else 9;
poster door: bool = false;
module a {
    request go(v: real in -10 .. 10, n: int in 0 .. 9, side: {left, right}, fast: bool) returns (way: real) fails (lost)
        instances 2 { check shut: not door because "100 % \\"sure\\" é %s"; interrupts self; }
    request halt() { interrupts a.go because "%d of them"; wait until level < 5 because "full"; }
}
"""


def events(seed: int) -> Iterator[Event]:
    pick = random.Random(seed)
    numbers: list[float] = [0.0, 2.0, -2.0, 0.1, 1e-9, 5.0, 7.25]
    for _ in range(150):
        args: tuple[Value, ...] = (pick.choice(numbers), pick.randrange(10), pick.choice(("left", "right")), True)
        yield pick.choice(
            [
                Ask("a.go", args),
                Ask("a.go", args),
                Ask("a.halt"),
                Report("a.go", pick.randrange(2), "ok", (pick.choice([*numbers, 1e300]),)),
                Report("a.go", pick.randrange(2), "failed", (), pick.choice([None, "lost"])),
                Report("a.halt", 0, "interrupted"),
                Observe("level", pick.randrange(10)),
                Observe("level", 9, True),
                Observe("door", pick.random() < 0.5),
                Abort("a.go", pick.randrange(2)),
                AbortWaiting("a.halt"),
            ]
        )


@pytest.mark.parametrize("seed", range(3))
def test_a_text_is_the_object_printed(seed: int) -> None:
    model: Model = model_of(SPEC)
    texts, reference = WireTexts(model), Reference(model)
    state, kinds = reference.start(), set[type]()
    for event in events(seed):
        state, actions = reference.step(state, event)
        said = {"event": event_json(model, event), "actions": [action_json(model, each) for each in actions]}
        assert texts.decision(event, actions) == json.dumps(said, ensure_ascii=False)
        kinds |= {type(each) for each in actions}
    assert len(kinds) > 3 and Launched in kinds
