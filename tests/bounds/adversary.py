"""Runs that are to cost as much as they can: `python -m tests.bounds.adversary [SPEC …]` prints bounds beside them.

An event is chosen among a few random ones as whoever wants a long step would: most often the one after which most waits
and is active, so that the next events find much to settle. From a state that was come to many events are tried, and
none of them counts but for what it costs. All of it is random with a seed, so equal specs give equal figures.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

from exover.bounds.events import Bound, bounds
from exover.engines.aig.costs import tightened
from exover.model.event import Event, Invalid
from exover.model.model import Model
from exover.model.wire_reading import read_event
from exover.pipeline import Build, build, load
from exover.source import Source
from tests.bounds.counting import Counting, copied
from tests.support.events import Stream

RUNS, LENGTH, TRIED = 8, 300, 3
"""Runs from the start, steps of each, and how many events are tried in each state."""


@dataclass(frozen=True, slots=True)
class Tried:
    """An event that was tried: what it cost, how much waits and is active then, and the machine after it."""

    event: Event
    cost: Bound
    load: float
    held: dict[str, object]


def reached(found: Build, seed: int = 1, runs: int = RUNS) -> Bound:
    """Return the most tests, answers and passes that any event took that was tried."""
    most = Bound(0, 0, 0)
    for run in range(runs):
        for cost in _run(found, Random(1000 * seed + run)):
            most = Bound(*(max(pair) for pair in zip(_figures(most), _figures(cost), strict=True)))
    return most


def _run(found: Build, random: Random) -> Iterator[Bound]:
    machine = Counting(found.model, found.tables)
    stream = Stream(found.model, random.randrange(1 << 30))
    greed = random.choice((0.1, 0.3, 0.6))
    for _ in range(LENGTH):
        held = dict(vars(machine))
        tried = [_try(machine, held, event, random) for event in _events(found.model, stream)]
        yield from (each.cost for each in tried)
        chosen = max(tried, key=lambda each: each.load) if random.random() < greed else random.choice(tried)
        vars(machine).update(chosen.held)
        stream.state, _ = stream.reference.step(stream.state, chosen.event)


def _events(model: Model, stream: Stream) -> list[Event]:
    found: list[Event] = []
    while len(found) < TRIED:
        event = read_event(model, json.dumps(stream.line()))
        found += [] if isinstance(event, Invalid) else [event]
    return found


def _try(machine: Counting, held: dict[str, object], event: Event, random: Random) -> Tried:
    vars(machine).update(held)
    vars(machine).update(copied(machine))
    machine.tests = machine.passes = 0
    answers = len(machine.step(event))
    waits, active = sum(map(bool, machine.place)), sum(map(bool, machine.phase))
    load = 3 * waits + active + random.random()
    return Tried(event, Bound(machine.tests, answers, machine.passes), load, dict(vars(machine)))


def _figures(bound: Bound) -> tuple[int, int, int]:
    return bound.tests, bound.answers, bound.passes


def main(paths: list[str]) -> None:
    """Print for each spec the bounds of its worst events, what was reached, and how the bounds were found."""
    for path in paths or sorted(map(str, Path("specs").glob("*.exo"))):
        model = load(Source(path, Path(path).read_text(encoding="utf-8"))).model
        assert model is not None, path
        found = build(model)
        known, most, plain = tightened(found.compiled), reached(found), bounds(found.tables).worst
        print(f"{path}: found by {known.method}")
        for name in ("tests", "answers", "passes"):
            bound, run, alone = (getattr(each, name) for each in (known.worst, most, plain))
            print(f"    {name}: at most {bound}, {bound / max(run, 1):.1f} times {run}; of the tables alone {alone}")


if __name__ == "__main__":
    main(sys.argv[1:])
