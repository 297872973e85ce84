"""The page of `exover report`: how long it takes to be made of findings, and how large it is."""

from collections.abc import Callable, Iterator
from functools import partial

from benchmarks import families
from benchmarks.measure import Row, median_seconds
from exover.checks.run import CheckOutcome, unanswered
from exover.checks.schedule.plan import CheckPlan
from exover.pipeline import Build, build, check, load
from exover.rendering import look, summarise
from exover.report.summary import ERRORS
from exover.source import Source

SECONDS = 5.0
BYTES = 2_000_000


def pages(rounds: int) -> Iterator[Row]:
    """Yield seconds and bytes of pages of 50 requests; what the checks take is not counted.

    The first has all findings and runs; the second has the most rules and the largest diagrams, and its questions are
    left open, for they would take an hour.
    """
    yield from _page("150 mutexes", families.mutexes(50), lambda built: check(built, lambda _: None), rounds)
    yield from _page("17 coupled modules", families.coupled(17), _open, rounds)


def _open(built: Build) -> CheckOutcome:
    return unanswered(built.model, CheckPlan(), "not asked here")


def _page(what: str, text: str, answers: Callable[[Build], CheckOutcome], rounds: int) -> Iterator[Row]:
    loaded = load(Source("page.exo", text))
    model = loaded.model
    assert model is not None
    built = build(model)
    outcome = answers(built)
    summary = summarise("page.exo", model, built, outcome, ERRORS)
    written = partial(look, summary, loaded.source, built)
    requests = f"{len(model.requests)} requests, {what}"
    yield Row(f"report: {requests}", median_seconds(written, rounds), "s", SECONDS)
    yield Row(f"report: {requests}, size", len(written().encode()), "B", BYTES)
