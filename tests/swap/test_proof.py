"""What `exover swap` proves is true of random runs of OLD: no rule of NEW is broken once the named have ended."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from random import Random
from typing import TypeVar

import pytest

from exover.model.evaluate import holds
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import State, resting
from exover.model.types import Real
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.vector import Vocabulary
from exover.pipeline import Build, build, load, swap
from exover.source import Source
from exover.swap.carry import Carry
from exover.swap.prove import SwapAnswer
from exover.swap.record import CarriedReading, Refusal
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.fuzz import spec_of
from tests.support.generate import random_spec
from tests.support.proving import proved
from tests.support.small import SIZES

T = TypeVar("T")
SEEDS = (0, 2, 5, 13, 21, 34)
PAIRS = (1, 4, 8, 9, 19, 24, 31, 37, 39, 48, 50)
"""Seeds of pairs of small specs, of which one lacks what the other has."""


@cache
def with_and_without(seed: int) -> tuple[Build, Build]:
    """Return a small spec, and what is left of it once some of its lines are gone; whether it is right is not asked."""
    random = Random(seed)
    size = replace(SIZES[seed % len(SIZES)], launches=2, latches=2, readings=3, resources=2)
    lines = random_spec(seed, size).splitlines()
    gone = random.choice(model_of("\n".join(lines)).requests).name
    left = [line for line in lines if gone not in line]
    at = next(number for number, line in enumerate(left) if line.startswith(f"    request {gone.partition('.')[2]}("))
    del left[at : left.index("    }", at) + 1 if left[at].endswith("{") else at + 1]
    if not load(Source("left.exo", "\n".join(left))).model:
        left = lines
    for _ in range(30):
        at = random.randrange(1, len(left))
        fewer = [*left[:at], *left[at + random.randint(1, 6) :]]
        if load(Source("left.exo", "\n".join(fewer))).model:
            left = fewer
    whole, part = (build(model_of("\n".join(each)), unchecked=True) for each in (lines, left))
    return whole, part


def carried(state: State, answer: SwapAnswer, new: Model) -> State:
    """Return a state of OLD as one of NEW: what has the same name, and what NEW starts with in place of what is new
    or said to start anew. What has to end has ended.
    """
    fresh = resting(new)
    gone = {*answer.ended, *answer.forgotten}

    def kept(mine: Mapping[str, T], start: Mapping[str, T], called: str = "{}") -> dict[str, T]:
        return {name: start[name] if called.format(name) in gone else mine.get(name, start[name]) for name in start}

    slots = {name: (*kept(state.slots, fresh.slots)[name], *idle)[: len(idle)] for name, idle in fresh.slots.items()}
    found = State(
        slots,
        kept(state.places, fresh.places),
        kept(state.past, fresh.past, "past({})"),
        kept(state.last, fresh.last, "last({})"),
        kept(state.readings, fresh.readings),
        kept(state.levels, fresh.levels),
        frozenset((name, at) for name, each in slots.items() for at, slot in enumerate(each) if slot),
    )
    for latch in new.latches:
        if holds(new, found, latch.condition):
            found = found.with_reading(latch.name, True)
    return found


def broken(new: Model, state: State) -> list[str]:
    """Return the rules of NEW that are broken in a state and are not restored yet."""
    reference, questions = Reference(new), DecisionContext(Vocabulary(new))
    found = []
    for rule in new.rules:
        seen = state.once_stopped() if questions.restored(rule) else state
        found += [rule.name for each in reference.instances(seen, rule) if reference.true(seen, each)]
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_no_state_of_old_breaks_a_rule_of_new(seed: int) -> None:
    """OLD has every other rule; where that is not proved, some rule is named that may be broken."""
    new = model_of(spec_of(seed))
    old = replace(new, name="old", rules=new.rules[::2])
    before = build(old)
    _, answer = swap(before, build(new), proved(before))
    assert (answer.verdict == "holds") == (answer.open == ())
    stream, looked = Stream(old, seed), 0
    for _ in stream.lines(400):
        state = carried(stream.state, answer, new)
        idle = not any(slot for name in answer.ended for slot in state.slots[name])
        looked += idle
        wrong = [name for name in broken(new, state) if name not in answer.open] if idle else []
        assert wrong == [], stream.state
    assert looked > 0


@pytest.mark.parametrize("seed", PAIRS)
@pytest.mark.parametrize("grows", [True, False], ids=["more", "less"])
def test_what_one_version_alone_has_is_carried_nowhere(seed: int, grows: bool) -> None:
    """What both have is carried over, the rest is not, and no state of OLD breaks a rule of NEW."""
    new, old = with_and_without(seed)[:: 1 if grows else -1]
    carry = Carry(old.compiled, new.compiled)
    known = list(carry.before)
    for number in carry.after:
        way = carry.way(number)
        if way is not None:
            assert known[way[0]] == number
        elif number in carry.before and not isinstance(number, Refusal):
            otherwise = isinstance(number, CarriedReading) and isinstance(_type(new.model, number.name), Real)
            unread = isinstance(number, CarriedReading) and number.how == "unread"
            assert otherwise or unread or getattr(number, "request", None) in carry.changed, number
    _, answer = swap(old, new, proved(old))
    stream = Stream(old.model, seed)
    for _ in stream.lines(200):
        if not any(slot for name in answer.ended for slot in stream.state.slots[name]):
            state = carried(stream.state, answer, new.model)
            assert set(broken(new.model, state)) <= set(answer.open), stream.state


def test_the_pairs_have_everything_that_one_alone_can_have() -> None:
    lacking = set()
    for whole, part in map(with_and_without, PAIRS):
        one, other = whole.model, part.model
        for kind in ("requests", "variables", "latches", "resources", "rules", "launches"):
            names = {each.name for each in getattr(other, kind)}
            lacking |= {kind for each in getattr(one, kind) if each.name not in names}
        alone = [request for request in one.requests if request.name not in other.request]
        lacking |= {kind for kind in ("params", "results", "statuses") if any(getattr(r, kind) for r in alone)}
    assert lacking == {
        *("requests", "params", "results", "statuses"),
        *("variables", "latches", "resources", "rules", "launches"),
    }


def test_what_is_of_another_kind_starts_anew() -> None:
    """A state, a poster and a latch of one name are not the same."""
    words = ("module m { state s: bool = true; ", "module m { poster s: bool = true; ")
    rest = "request a() { check s; %s } request b(); }"
    texts = [word + rest % effect for word, effect in zip(words, ("on launch set s = false;", ""), strict=True)]
    texts += ["poster p: bool = true; latch s: when p until m.a; module m { request a() { check s; } }"]
    texts += ["poster s: bool = true; module m { request a() { check s; } }"]
    builds = [build(model_of(f"spec s{n}; {text}"), unchecked=True) for n, text in enumerate(texts)]
    for old, new, name in ((0, 1, "m.s"), (1, 0, "m.s"), (2, 3, "s"), (3, 2, "s")):
        carry = Carry(builds[old].compiled, builds[new].compiled)
        assert not carry.remembers(CarriedReading(name, "ordinal"))


def module(*requests: str) -> str:
    return f"module m {{ {' '.join(requests)} }}"


HOT = "forbid x: hot and active(m.a) by kill m.a;"
INK = "resource ink: 3 consumable; latch hot: when level(ink) < 2 until m.b;"
DRAWING = INK + module("request a() { consumes ink 1; check not hot; }", "request b();") + HOT
READ, COLD, PLAIN = (module(f"request a() {{ {guard} }}", "request b();") for guard in ("check p;", "check not p;", ""))
WARM = "poster t: real in 0 .. 10 = {}; latch hot: when t > 5 until m.b;" + HOT
TWO = "latch warm: when {} until m.b; latch hot: when warm until m.b;" + HOT
P, Q = "poster p: bool = false;", "poster q: bool = false;"
LATCHED = {
    "a latch of NEW is set at the start": (
        P + COLD,
        P.replace("false", "true") + "latch hot: when p until m.b;" + COLD + HOT,
    ),
    "a launch lowers a level that is looked at later": (DRAWING, DRAWING),
    "what it reads starts anew": (
        WARM.format(0) + PLAIN.replace("a() {", "a() { check not hot;"),
        WARM.format(6) + PLAIN.replace("a() {", "a() { check t < 8;"),
    ),
    "the latch that it reads is another": (
        P + Q + TWO.format("p") + PLAIN.replace("a() {", "a() { check not warm; check not q;"),
        P + Q + TWO.format("p or q") + PLAIN,
    ),
    "one that nothing reads is not remembered": (
        P + "latch hot: when p until m.b;" + READ,
        P + Q + "latch hot: when p and q until m.b;" + PLAIN + HOT.replace("hot", "not hot"),
    ),
}  # fmt: skip
"""OLD and NEW, whose rule x is broken before the latches of NEW are looked at, or after, while m.a runs."""


@pytest.mark.parametrize(("old", "new"), LATCHED.values(), ids=LATCHED)
def test_a_rule_is_asked_before_and_after_the_latches_are_looked_at(old: str, new: str) -> None:
    before, after = (build(model_of(f"spec s; {text}")) for text in (old, new))
    _, answer = swap(before, after, proved(before))
    assert (answer.verdict, answer.ended) == ("holds", {"m.a": ("x",)})


def test_a_past_whose_condition_is_always_true_is_any_past() -> None:
    old = "spec s;" + module("request a(v: int in 0 .. 2);", "request b() { check not past(m.a); }")
    new = old + "forbid x: past(m.a with 0 * v < 1) and active(m.b) by kill m.b;"
    before, after = (build(model_of(each)) for each in (old, new))
    _, answer = swap(before, after, proved(before))
    assert (answer.verdict, answer.ended) == ("holds", {"m.b": ("x",)})


TURNED = "poster v: {x, y} = x; poster w: {y, x} = y;"
APART = "".join(f"forbid {v}: v == {v} and w == {w} and active(m.b) by kill m.b;" for v, w in ("xy", "yx"))
SAME = "forbid x: v == w and active(m.b) by kill m.b;"
READ_V, READ_BOTH = "request a() { check v == x; }", "request a() { check v == x; check w == y; }"
ENUMS = {
    "two orders in OLD": (
        TURNED + module(READ_BOTH, "request b();") + APART, TURNED.replace("y, x", "x, y"), SAME, ["m.b"],
    ),
    "what starts anew, at the right": (
        "poster v: {x, y} = x;" + module(READ_V, "request b();"),
        "poster v: {x, y, z} = x; poster w: {x, y, z} = z;", SAME.replace("v == w", "w == v"), [],
    ),
    "a value that OLD lacks, at the left": (
        "poster v: {x, y} = x;" + module(READ_V, "request b();"),
        "poster v: {x, y, z} = x;", SAME.replace("v == w", "z == v"), [],
    ),
    "a value that no argument of OLD has, at the left": (
        module("request a(v: {x, y});", "request b() { check not active(m.a with v == x); }"), "",
        "forbid x: active(m.a with z == v) and active(m.b) by kill m.b;", [],
    ),
}  # fmt: skip
"""OLD, what NEW declares, its rule, and what has to end."""


@pytest.mark.parametrize(("old", "posters", "rule", "ended"), ENUMS.values(), ids=ENUMS)
def test_enums_are_compared_by_the_names_of_their_values(old: str, posters: str, rule: str, ended: list[str]) -> None:
    requests = module("request a();" if posters else "request a(v: {x, y, z});", "request b();")
    before, after = (build(model_of(f"spec s; {text}")) for text in (old, posters + requests + rule))
    _, answer = swap(before, after, proved(before))
    assert (answer.verdict, list(answer.ended)) == ("holds", ended)


def test_an_end_that_old_does_not_remember_is_told() -> None:
    old, new = (
        build(model_of(f"spec s; module m {{ request a(); request b() {{ {guard} }} }}"))
        for guard in ("", "check last(m.a) == none;")
    )
    _, answer = swap(old, new, proved(old))
    assert answer.forgotten == ("last(m.a)",)


@pytest.mark.parametrize(
    ("latch", "forgotten"),
    [("latch alarm: when hot until m.b;", ("alarm",)), ("", ())],
    ids=["not read in OLD", "not there in OLD"],
)
def test_a_latch_that_old_does_not_remember_is_told(latch: str, forgotten: tuple[str, ...]) -> None:
    """It may be set, and is not in NEW; one that OLD has not is as it is in every start of NEW."""
    head = "poster hot: bool = false; poster on: bool = false;"
    old = build(model_of(f"spec old; {head} module m {{ request a(); request b() {{ check hot; }} }} {latch}"))
    module = "module m { request a() { check not alarm; } request b(); }"
    new = build(model_of(f"spec new; {head} {module} latch alarm: when hot until m.b;"))
    _, answer = swap(old, new, proved(old))
    assert answer.forgotten == forgotten


def test_pasts_that_old_does_not_remember_are_told_once() -> None:
    old, new = (
        build(model_of(f"spec s; module m {{ request a(n: int in 0 .. 3); request b() {{ {guards} }} }}"))
        for guards in ("", "check past(m.a with n == 1); wait until past(m.a with n == 2);")
    )
    _, answer = swap(old, new, proved(old))
    assert answer.forgotten == ("past(m.a)",)


def _type(model: Model, name: str) -> object:
    return model.variable[name].type if name in model.variable else None


def test_requests_that_are_named_are_needed() -> None:
    """Without their end, runs come to states that NEW forbids: what is named is not named in vain."""
    seen = 0
    for seed in SEEDS:
        new = model_of(spec_of(seed))
        old = replace(new, name="old", rules=new.rules[::2])
        stream = Stream(old, seed)
        seen += any(broken(new, stream.state) for _ in stream.lines(400))
    assert seen >= 2
