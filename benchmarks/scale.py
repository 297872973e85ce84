"""How the tables grow with the spec, from the text to their bytes."""

import time
from collections.abc import Callable, Iterator
from functools import partial

from benchmarks import families
from benchmarks.measure import Row, median_seconds
from exover import pipeline
from exover.source import Source

LINEAR = 1.1
"""Tables are linear in the rules iff those of eight times as many rules have at most so much more nodes a rule."""
FAMILIES: tuple[tuple[str, Callable[[int], str], int, int], ...] = (
    ("1 of every pair of 3n wins", families.priorities, 200, 1000),
    ("1 request interrupts n", families.stop, 1000, 4000),
    ("1 asks whether any of n is active", families.crowd, 400, 1000),
    ("at most 3 of n, the last ones killed", families.limit, 200, 500),
    ("at most 3 of n, all others killed", families.limit_all, 50, 200),
    ("n share a resource", families.power, 200, 500),
    ("n fail contexts", families.contexts, 500, 2000),
    ("n slots killed by their arguments share a resource", families.fleet, 20, 100),
    ("n requests killed by their arguments share a resource", families.convoy, 20, 100),
)
"""What, the spec, and its size in the short and the slow run."""


def built(text: str) -> pipeline.Build:
    """Return the tables of a spec."""
    model = pipeline.load(Source("family.exo", text)).model
    assert model is not None
    return pipeline.build(model)


def mutexes(rounds: int, slow: bool) -> Iterator[Row]:
    """Yield the time for random binary mutexes of 200 requests, and whether nodes are linear in the rules."""
    text = families.mutexes(200)
    seconds = median_seconds(partial(built, text), rounds)
    yield Row("tables: 200 requests, 600 random mutexes", seconds, "s", 3)
    ratios = []
    for size in (100, 200, 400, 800, *((1600, 3200) if slow else ())):
        nodes = built(families.mutexes(size)).compiled.figures.nodes
        ratios.append(nodes / (families.DEGREE * size))
    growth = max(ratios) / ratios[0]
    note = "nodes a rule: " + ", ".join(f"{ratio:.2f}" for ratio in ratios)
    yield Row("tables: nodes a rule, 800 requests to 100", growth, "", LINEAR, note=note)
    for size in (1000, *((4000,) if slow else ())):
        text = families.mutexes(size)
        seconds = median_seconds(partial(built, text), 1)
        yield Row(f"tables: {size} requests, {families.DEGREE * size} random mutexes", seconds, "s")


def others(slow: bool) -> Iterator[Row]:
    """Yield the time for specs of other kinds, with their nodes."""
    for what, family, short, long in FAMILIES:
        size = long if slow else short
        begin = time.perf_counter()
        figures = built(family(size)).compiled.figures
        seconds = time.perf_counter() - begin
        note = f"{figures.nodes} nodes, depth {figures.depth}"
        yield Row(f"tables: {what}, n = {size}", seconds, "s", note=note)
