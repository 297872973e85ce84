"""What answers say of launch rules (docs/language.md section 5), by every engine."""

import json
from collections.abc import Iterable
from shutil import which
from typing import Any

import pytest

from exover.cli.options import RUN_ENGINES
from exover.explain.explain import explain
from exover.model.event import Launched, Rejected, Waits
from exover.model.model import Model
from exover.model.wording import action_text
from exover.pipeline import engine
from exover.run.simulate import simulate
from tests.support.engines import model_of

SPEC = """
spec s;
poster low: bool = false;
poster ready: bool = false;
poster fuel: bool = true;
poster door: {open, shut} = shut;
module m {
    request home(at: int in 0 .. 9) {
        check fuelled: fuel because "no fuel";
        check closed: door == shut;
        wait clear: until ready because "not ready";
        interrupts self, m.work;
    }
    request work();
    request over();
}
launch go: m.home(3) when low because "battery";
"""
TWICE = SPEC + "launch again: m.home(3) when low and not active(m.work);"
DISMISSING = SPEC + "forbid both: active(m.over) and active(m.home) by kill m.over or kill m.home;"
SLOW = """
spec s;
poster low: bool = false;
module m { request home() { wait until not active(m.work); } request work(); }
launch go: m.home() when low;
"""

LOW, NOT_LOW = {"observe": "low", "value": True}, {"observe": "low", "value": False}
READY = {"observe": "ready", "value": True}
FUEL, NO_FUEL = {"observe": "fuel", "value": True}, {"observe": "fuel", "value": False}
OPEN = {"observe": "door", "value": "open"}
WORK = {"ask": "m.work"}
NOTHING: list[dict[str, Any]] = []


def launched(name: str, **more: Any) -> dict[str, Any]:
    return {"launch": name, "instance": 0, "args": {}} | more


def home(**more: Any) -> dict[str, Any]:
    return launched("m.home", **({"args": {"at": 3}} | more))


def rejected(
    rule: str, because: str | None = None, launch_rule: str | None = "go", at: str = "m.home"
) -> dict[str, Any]:
    said: dict[str, Any] = {"reject": at, "rule": rule}
    said |= {"because": because} if because else {}
    return said | ({"launch_rule": launch_rule} if launch_rule else {})


WAITS = {"wait": "m.home", "rule": "m.home.clear", "because": "not ready", "launch_rule": "go"}
NO_FUEL_LEFT = rejected("m.home.fuelled", "no fuel")
RUNS: dict[str, tuple[str, list[tuple[dict[str, Any], list[dict[str, Any]]]]]] = {
    "at once": (
        SPEC,
        [(READY, NOTHING), (LOW, [home(rule="go", because="battery", launch_rule="go")])],
    ),
    "from the waiting place": (
        SPEC,
        [
            (LOW, [WAITS]),
            (WORK, [launched("m.work")]),
            (NOT_LOW, NOTHING),
            ({"report": "m.work", "outcome": "ok"}, NOTHING),
            (READY, [home(launch_rule="go")]),
        ],
    ),
    "after its way was cleared": (
        SPEC,
        [
            (WORK, [launched("m.work")]),
            (READY, NOTHING),
            (
                LOW,
                [
                    {"kill": "m.work", "instance": 0, "rule": "m.home.interrupts.m.work"},
                    {"wait": "m.home", "rule": "m.home.interrupts.m.work", "launch_rule": "go"},
                ],
            ),
            ({"observe": "ready", "value": False}, NOTHING),
            ({"report": "m.work", "outcome": "interrupted"}, NOTHING),
            (READY, [home(launch_rule="go")]),
        ],
    ),
    "refused": (
        SPEC,
        [
            (NO_FUEL, NOTHING),
            (LOW, [NO_FUEL_LEFT]),
            (WORK, [launched("m.work")]),
            ({"ask": "m.none"}, [{"invalid": "unknown-request"}]),
            (OPEN, NOTHING),
            (FUEL, [rejected("m.home.closed")]),
            (NO_FUEL, [NO_FUEL_LEFT]),
            (READY, NOTHING),
            (NOT_LOW, NOTHING),
            (LOW, [NO_FUEL_LEFT]),
            ({"ask": "m.home", "args": {"at": 3}}, [rejected("m.home.fuelled", "no fuel", None)]),
        ],
    ),
    "refused where it waits, and tried anew": (
        SPEC,
        [
            (LOW, [WAITS]),
            (NO_FUEL, [NO_FUEL_LEFT, NO_FUEL_LEFT]),
            (READY, NOTHING),
            (NOT_LOW, NOTHING),
            (LOW, [NO_FUEL_LEFT]),
        ],
    ),
    "refused where it waits, and no longer due": (
        SPEC.replace("when low because", "when low and fuel because"),
        [(LOW, [WAITS]), (NO_FUEL, [NO_FUEL_LEFT]), (READY, NOTHING)],
    ),
    "superseded, and superseding": (
        SPEC,
        [
            (LOW, [WAITS]),
            (
                {"ask": "m.home", "args": {"at": 5}},
                [
                    rejected("superseded"),
                    {key: WAITS[key] for key in ("wait", "rule", "because")},
                    rejected("superseded", launch_rule=None),
                    WAITS,
                ],
            ),
            (NOT_LOW, NOTHING),
            (
                {"ask": "m.home", "args": {"at": 3}},
                [rejected("superseded"), {key: WAITS[key] for key in ("wait", "rule", "because")}],
            ),
            (LOW, NOTHING),
            (READY, [home()]),
        ],
    ),
    "given up, and waiting anew": (
        SPEC,
        [
            (LOW, [WAITS]),
            ({"abort": "m.home", "waiting": True}, [rejected("aborted"), WAITS]),
            (NOT_LOW, NOTHING),
            ({"abort": "m.home", "waiting": True}, [rejected("aborted")]),
        ],
    ),
    "dismissed": (
        DISMISSING,
        [
            (WORK, [launched("m.work")]),
            (READY, NOTHING),
            (
                LOW,
                [
                    {"kill": "m.work", "instance": 0, "rule": "m.home.interrupts.m.work"},
                    {"wait": "m.home", "rule": "m.home.interrupts.m.work", "launch_rule": "go"},
                ],
            ),
            (NOT_LOW, NOTHING),
            ({"ask": "m.over"}, [rejected("both"), launched("m.over")]),
            (
                LOW,
                [
                    {"kill": "m.over", "instance": 0, "rule": "both"},
                    {"wait": "m.home", "rule": "m.home.interrupts.m.work", "launch_rule": "go"},
                ],
            ),
        ],
    ),
    "busy": (
        SPEC.replace("interrupts self, m.work", "interrupts m.work"),
        [
            ({"ask": "m.home", "args": {"at": 1}}, [{key: WAITS[key] for key in ("wait", "rule", "because")}]),
            (LOW, [rejected("busy")]),
            (READY, [home(args={"at": 1})]),
            (WORK, [rejected("m.home.interrupts.m.work", launch_rule=None, at="m.work")]),
            ({"report": "m.home", "outcome": "ok"}, [home(rule="go", because="battery", launch_rule="go")]),
        ],
    ),
    "two launch rules": (
        TWICE,
        [
            (NO_FUEL, NOTHING),
            (LOW, [NO_FUEL_LEFT, rejected("m.home.fuelled", "no fuel", "again")]),
            (WORK, [launched("m.work")]),
            (OPEN, NOTHING),
            ({"report": "m.work", "outcome": "ok"}, [rejected("m.home.fuelled", "no fuel", "again")]),
            ({"observe": "door", "value": "shut"}, NOTHING),
            (FUEL, [WAITS]),
            (READY, [home(launch_rule="go")]),
        ],
    ),
    "no parameters": (
        SLOW,
        [
            (WORK, [launched("m.work")]),
            (LOW, [{"wait": "m.home", "rule": "m.home.wait.1", "launch_rule": "go"}]),
            ({"ask": "m.home"}, [rejected("busy", launch_rule=None)]),
            ({"report": "m.work", "outcome": "ok"}, [launched("m.home", launch_rule="go")]),
        ],
    ),
}


def answers(chosen: str, model: Model, events: Iterable[object]) -> list[list[dict[str, Any]]]:
    with engine(chosen, model) as running:
        said = [json.loads(line)["actions"] for line in simulate(model, running, [json.dumps(e) for e in events])]
    for actions in said:
        for action in actions:
            action.pop("detail", None)
    return said


def test_an_explanation_tells_of_a_refusal_that_goes_on() -> None:
    found = explain(model_of(SPEC), {}, [json.dumps(event) for event in (NO_FUEL, LOW, OPEN)])
    assert found is not None and found.actions == ()
    (account,) = found.accounts
    assert account.text.endswith("; what go requires is refused as before")
    assert [voice.rule for voice in account.others if voice.demand == "reject"] == ["m.home.fuelled", "m.home.closed"]
    assert found.search is not None and not any(
        "door" in change for turn in found.search.turns for change in turn.changes
    )


def test_what_is_told_of_a_run_names_launch_rules() -> None:
    model = model_of(SPEC)
    assert action_text(model, Launched("m.home", 0, (3,), None, None, "go")) == "launch m.home(at = 3) of go"
    assert action_text(model, Launched("m.home", 0, (3,), "go", None, "go")) == "launch m.home(at = 3) [go]"
    assert action_text(model, Waits("m.home", "m.home.clear", "not ready", "go")) == (
        "wait m.home of go [m.home.clear] not ready"
    )
    assert action_text(model, Rejected("m.home", "busy", None, "go")) == "reject m.home of go [busy]"


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize("chosen", RUN_ENGINES)
def test_answers(chosen: str, name: str) -> None:
    if chosen == "rust" and which("rustc") is None:
        pytest.skip("rustc is not installed")
    text, steps = RUNS[name]
    due = [actions for _, actions in steps]
    given = answers(chosen, model_of(text), [event for event, _ in steps])
    assert [json.dumps(actions) for actions in given] == [json.dumps(actions) for actions in due]
