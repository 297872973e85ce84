"""Explanations of random runs: every action has the verdict of the rule that it names, and every turn told is true."""

import json
import math
import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import product

import pytest

from exover.explain.counterfactuals import CounterfactualReference, Trials, said
from exover.explain.explain import accounts_of, explain
from exover.explain.interventions import Intervention
from exover.explain.recorder import watch
from exover.explain.relevance import concern_of, quantities
from exover.explain.verdicts import RuleVerdicts
from exover.model.event import Event, Invalid, Killed, Launched, Rejected, Violated, Waits
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import Slot, State
from exover.model.wire_reading import read_event
from exover.report.explanation import render_json, render_text
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.fuzz import spec_of
from tests.support.small import small_spec_of

SEEDS = range(12)
BY_ITSELF = {"busy", "superseded", "aborted", "abort"}
"""What answers call what is no rule."""


def moments(model: Model, seed: int, length: int) -> Iterator[tuple[State, Event]]:
    """Yield the states of a random run with the valid events that are answered in them."""
    reference = Reference(model)
    state = reference.start()
    for line in Stream(model, seed).lines(length):
        event = read_event(model, line)
        if not isinstance(event, Invalid) and reference.validate(state, event) is None:
            yield state, event
            state, _ = reference.step(state, event)


@pytest.mark.parametrize(("of", "seed"), [*product([spec_of], SEEDS), (small_spec_of, 103), (small_spec_of, 233)])
def test_a_watched_step_is_the_step_and_its_actions_have_their_verdicts(of: Callable[[int], str], seed: int) -> None:
    model = model_of(of(seed))
    reference = Reference(model)
    heard = 0
    for state, event in moments(model, seed, 60):
        watched = watch(reference, state, event)
        after, actions = reference.step(state, event)
        assert (watched.after, tuple(action for action, _ in watched.actions)) == (after, actions)
        accounts = accounts_of(RuleVerdicts(reference, {}), watched)
        assert tuple(account.action for account in accounts) == (actions or (None,))
        for account in accounts:
            match account.action:
                case Launched(rule=None):
                    assert all(verdict.demand in ("nothing", "dismiss") for verdict in account.others)
                case Launched(rule=str(rule)):
                    assert [verdict.rule for verdict in account.deciding] == [rule]
                case Waits(_, rule) | Rejected(_, rule) | Killed(_, _, rule) | Violated(rule) if rule not in BY_ITSELF:
                    assert account.deciding[-1].rule == rule
                    assert account.deciding[-1].demand not in ("nothing", "launch")
                    assert all(fact.read for fact in account.deciding[-1].facts)
                    heard += 1
                case _:
                    assert account.deciding == ()
    assert heard


def trials_of(model: Model, state: State, event: Event) -> Trials:
    reference = CounterfactualReference(model)
    _, actions = reference.step(state, event)
    mentions = concern_of(reference, state, event, actions).mentions()
    return Trials(reference, state, event, actions, mentions, 1_000_000)


def numbers(option: Intervention, dice: random.Random) -> Iterator[int | float]:
    """Yield numbers of an option's interval: its first and last one, and one between them."""
    interval = option.interval
    assert interval is not None
    if isinstance(interval.sample, int):
        yield from (int(interval.low), int(interval.high), dice.randint(int(interval.low), int(interval.high)))
        return
    first = interval.low if interval.low_closed else math.nextafter(interval.low, math.inf)
    last = interval.high if interval.high_closed else math.nextafter(interval.high, -math.inf)
    yield from (first, last, dice.uniform(max(first, -1e6), min(last, 1e6)) if first < 1e6 and last > -1e6 else first)


def answers_to(trials: Trials, option: Intervention, numbers: Iterable[int | float]) -> Iterator[object]:
    assert option.put
    for number in numbers:
        state, event = option.put(trials.state, trials.event, number)
        answer = trials.answer(replace(option, state=state, event=event))
        yield answer if answer is None else said(answer)


@pytest.mark.parametrize("seed", (182, 1, 2, 3, 10, 13, 46, 128))
def test_all_numbers_of_an_interval_have_one_answer(seed: int) -> None:
    """What is told of an interval is tried on one number of it only."""
    model = model_of(spec_of(seed))
    dice, compared = random.Random(seed), 0
    for state, event in moments(model, seed, 40):
        trials = trials_of(model, state, event)
        concern = concern_of(trials.reference, state, event, trials.actions)
        for quantity in quantities(state, event, concern):
            for option in trials.options(quantity):
                if option.interval is None:
                    continue
                found = set(answers_to(trials, option, (option.interval.sample, *numbers(option, dice))))
                assert len(found) == 1, option.text
                compared += 1
    assert compared


def other_arguments(model: Model, told: str, seed: int, slot: Slot, name: str) -> Iterator[Slot]:
    """Yield a slot with other arguments, beside those that are told."""
    stream, params = Stream(model, seed), model.request[name].params
    for _ in range(20):
        drawn = stream._values(params).values()
        pairs = zip(params, slot.args, drawn, strict=True)
        yield Slot(slot.phase, tuple(mine if f"{field.name} = " in told else other for field, mine, other in pairs))


@pytest.mark.parametrize("seed", (1, 2, 5, 24, 69))
def test_arguments_that_are_not_told_make_no_difference(seed: int) -> None:
    model = model_of(spec_of(seed))
    compared = 0
    for state, event in moments(model, seed, 40):
        trials = trials_of(model, state, event)
        concern = concern_of(trials.reference, state, event, trials.actions)
        for quantity in (each for each in quantities(state, event, concern) if each.kind == "slot"):
            place = (quantity.name, quantity.index)
            for option in trials.options(quantity):
                slot = option.state.slots[quantity.name][quantity.index]
                answer = trials.answer(option)
                if slot is None or answer is None:
                    continue
                for other in other_arguments(model, option.predicate, seed, slot, quantity.name):
                    changed = trials.answer(replace(option, state=option.state.with_slot(place, other)))
                    assert changed is not None, option.text
                    assert said(changed) == said(answer), option.text
                    compared += 1
    assert compared


@pytest.mark.parametrize("seed", range(6))
def test_explanations_of_random_runs_are_the_same_twice_and_can_be_written(seed: int) -> None:
    model = model_of(spec_of(seed))
    lines = list(Stream(model, seed).lines(40))
    for length in range(1, 41, 3):
        found = explain(model, {}, lines[:length])
        assert found is not None
        assert found == explain(model, {}, lines[:length])
        assert found.step == length
        assert render_text(model, found).startswith(f"step {length}: ")
        assert json.loads(render_json(model, found))["step"] == length
