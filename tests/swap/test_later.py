"""No rule of NEW is broken after a swap in states that `BrokenLater` does not name, whatever has led there."""

from dataclasses import replace
from functools import cache

import pytest

from exover.model.evaluate import holds
from exover.model.event import Violated
from exover.model.expression import FALSE
from exover.model.model import Model
from exover.model.semantics import Reference, Step
from exover.model.state import State
from exover.ocrd.compile import Compiled
from exover.pipeline import build, swap
from exover.swap.later import BrokenLater
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.proving import proved
from tests.support.small import small_spec_of

FREE = "spec old; module m { state s: bool = false; request a(); request c(); request d() { check s; } }"
GUARDED = """spec new; {}module m {{ state s: bool = false;
    request a() {{ {} not active(m.c); {} }} request c() {{ check not active(m.a); on ok set s = true; }}
    request d() {{ on ok set s = false; }} }} forbid x: m.s and active(m.a){};"""
PLAIN = GUARDED.format("", "check", "", "")
SEEDS = (4, 7, 14, 23, 26, 30, 40, 57, 98, 101)


def ended(old: str, new: str) -> tuple[str, dict[str, tuple[str, ...]], tuple[str, ...]]:
    before, after = (build(model_of(text)) for text in (old, new))
    _, answer = swap(before, after, proved(before))
    return answer.verdict, dict(answer.ended), answer.open


def test_what_new_starts_one_after_the_other_does_not_run_at_once_before() -> None:
    """NEW alone never breaks x: m.c, whose end sets m.s, runs while m.a does not."""
    assert ended(FREE, PLAIN) == ("holds", {"m.a": ("x",)}, ())
    assert ended(PLAIN, PLAIN) == ("holds", {}, ())


def test_what_a_kill_restores_needs_no_end() -> None:
    assert ended(FREE, GUARDED.format("", "check", "", " by kill m.a")) == ("holds", {}, ())


def test_what_only_a_launch_sets_is_kept_by_decisions_however_large_the_spec_is() -> None:
    posters = " ".join(f"poster p{n}: bool = false;" for n in range(65))
    read = " and ".join(f"p{n}" for n in range(65))
    text = """spec new; {} module m {{ state s: {{on, off}} = on; request a() {{ check {}; }}
        request c() {{ on launch set s = off; on {} set s = {}; }} }} forbid x: m.s == off and active(m.a) by reject;"""
    for outcome, value, found in (("ok", "on", FALSE), ("failed", "off", None)):
        later = BrokenLater(built(text.format(posters, read, outcome, value)))
        assert later.of(later.new.model.rules[0]) == found


def test_what_waits_may_start_by_the_swap() -> None:
    """In OLD m.a waits for m.d, in NEW for m.c that runs."""
    old = FREE.replace("a();", "a() { wait until not active(m.d, m.c); }").replace("{ check s; }", ";")
    later = BrokenLater(built(GUARDED.format("", "wait until", "", "")))
    (rule,) = later.new.model.rules
    cond = later.of(rule)
    assert cond is not None
    stream, seen = Stream(model_of(old), 1), 0
    for _ in stream.lines(500):
        waits = stream.state.places["m.a"] is not None and bool(stream.state.active(["m.c"]))
        seen += waits
        assert not waits or holds(later.new.model, stream.state, cond)
    assert seen > 0


def test_what_a_launch_rule_requires_may_start_by_the_swap() -> None:
    """So m.a may be active where it is not, and m.s what its launch sets."""
    text = GUARDED.format("poster p: bool = false; launch m.a() when p; ", "check", "on launch set s = false;", "")
    verdict, named, _ = ended(FREE, text)
    assert verdict == "holds" and "m.c" in named


def test_a_large_spec_is_not_looked_at() -> None:
    """Its rule may be broken as far as is known."""
    posters = " ".join(f"poster p{n}: bool = false;" for n in range(65))
    read = " and ".join(f"p{n}" for n in range(65))
    text = PLAIN.replace("module m", f"{posters} module m").replace("check not active(m.a);", f"check {read};")
    verdict, _, left = ended(FREE, text)
    assert (verdict, left) == ("unknown", ("x",))


def unguarded(new: Model) -> Model:
    """Return a model whose requests start whatever the guards say: it comes to states that NEW does not reach."""
    return replace(new, name="old", requests=tuple(replace(each, guards=()) for each in new.requests))


@cache
def built(text: str) -> Compiled:
    return build(model_of(text)).compiled


def settled(reference: Reference, state: State) -> State:
    """Return what the step of NEW that the swap is leaves."""
    step = Step(state)
    while True:
        before = step.state
        step = reference._settle(reference._launch_required(reference._recover(step)))
        if step.state == before:
            return replace(step.state, refused=step.refused)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_run_from_any_other_state_breaks_a_rule(seed: int) -> None:
    found = built(small_spec_of(seed))
    new, later = found.model, BrokenLater(found)
    reference, stream = Reference(new), Stream(unguarded(new), seed)
    conditions = {rule: later.of(rule) for rule in new.rules}
    for number, _ in enumerate(stream.lines(60)):
        start = reference._latch(stream.state, None)
        if any(isinstance(each, Violated) for each in reference.violations(start)):
            continue
        named = {rule.name for rule, cond in conditions.items() if cond is None or holds(new, stream.state, cond)}
        after = Stream(new, number)
        after.state = settled(reference, start)
        for _, actions in after.events(40):
            said = {each.rule for each in actions if isinstance(each, Violated)}
            assert said <= named, (stream.state, said)


def test_some_rules_of_these_are_named_and_some_are_not() -> None:
    said = []
    for seed in SEEDS:
        found = built(small_spec_of(seed))
        later = BrokenLater(found)
        said += [later.of(rule) for rule in found.model.rules]
    assert FALSE in said and any(cond not in (None, FALSE) for cond in said)
