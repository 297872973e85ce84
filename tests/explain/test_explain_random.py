"""Explanations of random runs: every action has the verdict of the rule that it names, and every turn told is true."""

import json
import random
from collections.abc import Iterator
from dataclasses import replace

import pytest

from exover.explain.counterfactuals import outcome_of, turned
from exover.explain.explain import accounts_of, explain
from exover.explain.interventions import Intervention, Interventions
from exover.explain.recorder import watch
from exover.explain.relevance import Factor, concern_of, quantities
from exover.explain.verdicts import RuleVerdicts
from exover.model.event import Ask, Event, Invalid, Killed, Launched, Observe, Rejected, Report, Violated, Waits
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.wire_reading import read_event
from exover.report.explanation import render_json, render_text
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.fuzz import spec_of

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


@pytest.mark.parametrize("seed", SEEDS)
def test_a_watched_step_is_the_step_and_its_actions_have_their_verdicts(seed: int) -> None:
    model = model_of(spec_of(seed))
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


def put(state: State, event: Event, quantity: Factor, value: int | float) -> tuple[State, Event]:
    """Return the state and the event with a number as this quantity."""
    match quantity.kind, event:
        case "reading", _:
            return state.with_reading(quantity.name, value), event
        case "level", _:
            return state.with_level(quantity.name, int(value)), event
        case "given", Ask(args=old):
            return state, replace(event, args=(*old[: quantity.index], value, *old[quantity.index + 1 :]))
        case "given", Report(results=old):
            return state, replace(event, results=(*old[: quantity.index], value, *old[quantity.index + 1 :]))
        case _:
            return state, Observe(quantity.name, value)


def numbers(option: Intervention, dice: random.Random) -> Iterator[int | float]:
    """Yield the ends of an option's interval that are in it, and a number between them."""
    interval = option.interval
    assert interval is not None
    inside = dice.uniform(max(interval.low, -1e6), min(interval.high, 1e6))
    found = [interval.low] * interval.low_closed + [interval.high] * interval.high_closed
    found += [inside] if interval.low < inside < interval.high else []
    yield from (int(number) if isinstance(interval.sample, int) else number for number in found)


@pytest.mark.parametrize("seed", (182, 1, 2, 3, 5))
def test_all_numbers_of_a_region_turn_the_answer_or_none_does(seed: int) -> None:
    """What is told of a interval is tried on one number of it only."""
    model = model_of(spec_of(seed))
    reference, dice, compared = Reference(model), random.Random(seed), 0
    for state, event in moments(model, seed, 40):
        _, actions = reference.step(state, event)
        before = outcome_of(event, actions)
        concern = concern_of(reference, state, event, actions)
        options = Interventions(model, state, event, concern.mentions())
        for quantity in quantities(state, event, concern):
            for option in options.of(quantity):
                if option.interval is None:
                    continue
                _, answer = reference.step(option.state, option.event)
                for number in numbers(option, dice):
                    other, changed = put(state, event, quantity, number)
                    _, found = reference.step(other, changed)
                    compared += 1
                    assert turned(event, before, outcome_of(event, found)) == turned(
                        event, before, outcome_of(event, answer)
                    )
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
