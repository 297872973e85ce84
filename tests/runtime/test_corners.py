"""Corners of the C runtime, each by a spec that leads there, on random events: the answers are the reference's."""

from collections.abc import Sequence

import pytest

from exover.model.event import Action, Ask, Event, Observe, Report
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.pipeline import build
from tests.runtime.compiling import Engine, model_of
from tests.support.events import Stream

CORNERS = {
    "consumption and products that depend on arguments": """
        resource fuel: 5 consumable = 3;
        module m {
            request burn(n: int in 0 .. 3) { consumes fuel 2 when n > 0; consumes fuel 1 when n > 1; }
            request fill(n: int in 0 .. 3) { produces fuel 2; produces fuel 2 when n > 1; }
            request tour() { check level(fuel) == 5; }
        }""",
    "real posters and arguments, as they change under running slots": """
        poster top: real in 0 .. 2 = 1 else 0;
        poster low: real in 0 .. 2 = 0.5 else 2;
        module m {
            request go(v: real in 0 .. 2, w: real in 0 .. 2) returns (d: real in 0 .. 2) instances 2 {
                fail fast: when v > top;
                check v <= w;
                check low <= top;
            }
            request next(v: real in 0 .. 2) {
                wait until not active(m.go with v >= 1);
                check past(m.go with d > 0.5 and v < d);
                fail when v < low else wait;
            }
        }""",
    "one slot of several is killed for its argument, or for its number": """
        poster limit: int in 0 .. 3 = 2;
        module m {
            request a() instances 3;
            request b(n: int in 0 .. 3) instances 3 { fail when n > limit; check n != 3 or limit == 3; }
            request c(n: int in 0 .. 3) { check not active(m.b with n == self.n); interrupts m.a else wait; }
        }""",
    "a request falls from clearing to waiting": """
        poster p: bool = false;
        poster q: bool = false;
        module m {
            state s: int in 0 .. 2 = 0;
            request a() { on interrupted set s = 1; on ok set s = 2; }
            request b() { wait until not p; interrupts m.a; settle until s != 1; }
            request c() { interrupts m.b else wait; on ok set s = 0; }
            request d() { interrupts m.a, m.b, m.c; }
            request e() { interrupts self; wait until s == 0; }
        }
        launch m.d() when q and not p;
        launch m.e() when p;""",
    "several copies of a rule are broken, and nothing helps": """
        poster p: bool = false;
        poster q: int in 0 .. 3 = 0;
        module m { request a() instances 2; request b(); request c(); }
        forbid x: p and active(m.a) and q > 0;
        forbid y: active(m.a) and q > 1 by kill m.a;
        forbid z: active(m.b) and q > 1 by wait;
        mutex k: m.a, m.b, m.c by wait;
        launch go: m.c() when q == 3;""",
    "required launches with arguments of every type": """
        enum e { one, two }
        poster p: int in 0 .. 3 = 0;
        module m {
            request a(x: real in 0 .. 1, y: e, z: bool, n: int in -5 .. 5) { check x < 0.5 or z; interrupts self; }
            request b(x: real) { check x <= 0.25; wait until p != 2; }
        }
        launch m.a(0.25, two, false, -5) when p == 1;
        launch m.a(0.75, one, true, 5) when p == 2;
        launch m.b(0.25) when p > 1;""",
    "latches that set and clear in one step, and pasts that are forgotten": """
        poster p: bool = false;
        latch l: when p until m.a, m.b;
        poster q: int in 0 .. 3 = 0;
        latch k: when l and q > 1 until m.b;
        module m {
            request a() { check not k; on failed forget m.b, m.a; }
            request b() { check past(m.a); on launch forget m.a; on interrupted set s = true; }
            request c() { check l or s; check last(m.b) != failed; }
            state s: bool = false;
        }""",
}


def assert_like_the_reference(model: Model, events: Sequence[Event]) -> None:
    reference = Reference(model)
    state, due = reference.start(), []
    for event in events:
        state, actions = reference.step(state, event)
        due.append((event, actions))
    assert_answers(model, due)


def assert_answers(model: Model, due: Sequence[tuple[Event, tuple[Action, ...]]]) -> None:
    """Raise `AssertionError` unless events are answered as is due."""
    with Engine(model, build(model).tables) as engine:
        answers = engine.replay(event for event, _ in due)
    for (event, actions), answer in zip(due, answers, strict=True):
        assert answer == actions, event


@pytest.mark.parametrize("name", CORNERS)
def test_corner(name: str) -> None:
    model = model_of(f"spec corner;{CORNERS[name]}")
    assert_answers(model, list(Stream(model, 7).events(600)))


def test_what_fell_to_waiting_does_not_clear_again_in_the_same_step() -> None:
    """The report makes `b` fall; then `y` starts and takes the reason away; `z` tells whether `b` clears again."""
    model = model_of(
        """spec falls;
        module m {
            state s: int in 0 .. 1 = 0;
            request a(); request z();
            request x() { on ok set s = 1; }
            request b() { wait until s == 0; interrupts m.a, m.z; }
            request y() { wait until s == 1; on launch set s = 0; }
        }"""
    )
    asked = [Ask("m.x"), Ask("m.a"), Ask("m.b"), Ask("m.y")]
    assert_like_the_reference(model, [*asked, Report("m.x", 0, "ok"), Ask("m.z"), Report("m.a", 0, "ok")])


def test_what_has_waited_dismisses_who_clears_its_way() -> None:
    """The reading lets `n` start while `x`, which would be killed for it, waits for `z` to stop."""
    model = model_of(
        """spec gives_way;
        poster p: bool = true;
        module m { request z(); request n() { wait until not p; } request x() { interrupts m.z; } }
        mutex last: m.x, m.n by kill m.n or kill m.x;"""
    )
    stopped = Report("m.z", 0, "interrupted")
    assert_like_the_reference(model, [Ask("m.z"), Ask("m.n"), Ask("m.x"), Observe("p", False), stopped])


def test_a_product_fills_up_to_the_capacity() -> None:
    model = model_of(
        """spec fuel;
        resource fuel: 5 consumable = 3;
        module m { request burn() { consumes fuel 3; } request fill() { produces fuel 4; } }"""
    )
    burnt = [Ask("m.burn"), Report("m.burn", 0, "ok")]
    assert_like_the_reference(model, [Ask("m.fill"), Report("m.fill", 0, "ok"), *burnt, *burnt])
