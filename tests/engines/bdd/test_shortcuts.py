"""What is seen without composing whole steps is what whole steps say: waits that end, and runs of quiescent steps."""

from collections import Counter
from functools import cache

from exover.engines.bdd.analysis import Analysis, _past, asks, is_abort
from exover.engines.bdd.backward_reachability import BackwardReachability
from exover.loop.finite.builder import LoopEvent
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.semantics import Reference
from tests.support.engines import model_of
from tests.support.small import compiled, small_spec_of

SEEDS = (0, 3, 4, 7, 8, 9, 11, 12, 14, 15, 16, 17, 21, 23, 25, 26, 28, 29)
"""Of small specs, whose diagrams are soon made."""


@cache
def analysed(spec: str) -> Analysis:
    """Return the analysis of a spec."""
    made = compiled(model_of(spec))
    return Analysis(made, Reference(made.model), lambda what: None)


def asked_of(analysis: Analysis, request: str) -> bool:
    """Return whether every wait of the request can end, by whole steps among the reachable states."""
    waiting, exact = analysis.meaning.waiting(request), analysis._search._exact

    def allowed(event: LoopEvent) -> bool:
        return not is_abort(event) and not asks(event, request)

    events, mark = analysis.loop.events, ("launch", request)
    passing = [number for number in exact.passing(mark) if allowed(events[number])]
    first = ~waiting | exact.union(exact.before(analysis.space.none, passing, mark))
    able = exact.possible(first, allowed, lambda found: False)
    return bool(analysis.reached & waiting & ~able == analysis.space.none)


def test_waits_that_are_seen_to_end_can_end() -> None:
    seen: Counter[tuple[bool, bool]] = Counter()
    for seed in SEEDS:
        spec = small_spec_of(seed)
        try:
            analysis = analysed(spec)
            waiting = [
                r.name for r, waits in zip(analysis.loop.model.requests, analysis.loop.may_wait, strict=True) if waits
            ]
        except TooLarge:
            continue
        for request in waiting:
            told, true = analysis.ends_waiting(request), asked_of(analysis, request)
            assert true or not told, f"{spec}\n{request}"
            seen[told, true] += 1
    assert seen[True, True] > 4
    assert seen[False, False] > 0


def test_runs_of_calm_steps_are_runs() -> None:
    found = Counter[bool]()
    for seed in SEEDS:
        spec = small_spec_of(seed)
        try:
            analysis = analysed(spec)
            loop = analysis.loop
        except TooLarge:
            continue
        for request in loop.model.requests:
            mark = ("launch", request.name)

            def rings(backwards: BackwardReachability, mark: tuple[str, str] = mark) -> object:
                return backwards.rings(_past(backwards, mark))

            shown = analysis._search.shown(rings) is not None
            assert not shown or rings(analysis._search._exact) is not None, f"{spec}\n{request.name}"
            found[shown] += 1
    assert found[True] > len(SEEDS)


RISING = """
spec rising;
poster q: int in 0 .. 1 = 0;
poster z: int in 0 .. 1 = 0;
module m {
    state never: bool = false;
    request c() { wait until q == 1; settle until never; }
    request r() { wait until q == 1; }
    request s() { wait until z == 1; }
}
forbid m1: active(m.r) and active(m.c) by kill m.r or wait;
"""


def test_what_rises_in_the_way_of_another_is_no_progress() -> None:
    analysis = analysed(RISING)
    told = {request.name: analysis.ends_waiting(request.name) for request in analysis.loop.model.requests}
    true = {name: asked_of(analysis, name) for name in told}
    assert true == {"m.c": False, "m.r": False, "m.s": True}
    assert told == true
