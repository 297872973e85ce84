"""Results as texts: summaries, reports, drawings, runs and the page."""

from hashlib import sha256
from typing import TYPE_CHECKING, Any, Literal, assert_never

from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.property import Properties
from exover.pipeline import Build
from exover.source import Source

if TYPE_CHECKING:
    from exover.checks.run import CheckOutcome
    from exover.diagnostics import Severity
    from exover.graph.interactions import InteractionGraph
    from exover.limits import Limits
    from exover.model.difference import Compared
    from exover.report.recorded import Recorded
    from exover.report.several import ReportFormat
    from exover.report.story import Story
    from exover.report.summary import BoundFigures, Summary, TableFigures

Picture = Literal["text", "json", "svg", "vcd"]
Drawing = Literal["dot", "svg", "mermaid"]
Differing = Literal["text", "json", "sarif", "markdown"]


def summarise(
    file: str,
    model: Model,
    built: Build | None,
    outcome: "CheckOutcome | None",
    counted: "frozenset[Severity]",
    *,
    bounded: bool = False,
    properties: Properties | None = None,
    skipped: tuple[str, ...] = (),
    limits: "Limits | None" = None,
) -> "Summary":
    """Return the content of a report: the findings, and the sizes of the spec and of its tables, if these were made.

    `outcome`: the findings, None if no check was asked. `counted`: the severities that decide the verdict.
    With `bounded`, bounds on the costs of events and calls are added. `properties`: those that were checked, if any;
    `skipped`: the checks that were not asked; `limits`: of the time that is left for bounds.
    """
    from exover import __version__
    from exover.report.summary import ModelFigures, Summary

    findings, bits, states = (outcome.findings, outcome.state_bits, outcome.states) if outcome else ((), None, None)
    figures = ModelFigures(len(model.requests), len({rule.name for rule in model.rules}), bits, states)
    tables = None if built is None else table_figures(built, bounded, limits)
    return Summary(__version__, file, model, findings, figures, tables, counted, properties, skipped)


def table_figures(built: Build, bounded: bool, limits: "Limits | None") -> "TableFigures":
    """Return the sizes of tables; with `bounded`, also bounds on the costs of events and calls."""
    from exover.bounds.sizes import ram_bytes
    from exover.report.summary import TableFigures

    figures, digest = built.compiled.figures, sha256(built.data).hexdigest()
    bounds = _bound_figures(built, limits) if bounded else None
    ram = ram_bytes(built.tables)
    return TableFigures(figures.nodes, figures.depth, figures.tests, len(built.data), ram, digest, bounds)


def _bound_figures(built: Build, limits: "Limits | None") -> "BoundFigures":
    """Return bounds on the costs of events, those of the tables alone if the time is over before."""
    from exover.bounds.events import bounds
    from exover.bounds.sizes import STACK_TARGET, stack_bytes
    from exover.limits import NO_LIMITS, TimeUp, interrupted
    from exover.report.summary import BoundFigures, EventFigures

    index = ModelIndex(built.model)
    requests = index.requests
    try:
        with interrupted(limits or NO_LIMITS):
            found = built.event_bounds
    except TimeUp:
        found = bounds(built.tables)
    named = [
        *((f"ask {name}", bound) for name, bound in zip(requests, found.asks, strict=True)),
        *((f"report {name}", bound) for name, bound in zip(requests, found.reports, strict=True)),
        *((f"abort {name}", bound) for name, bound in zip(requests, found.aborts, strict=True)),
        *((f"abort {name} waiting", bound) for name, bound in zip(requests, found.withdrawals, strict=True)),
        *((f"observe {poster.name}", found.readings[number]) for number, poster in index.posters),
        *((f"observe {name}", bound) for name, bound in zip(index.stocks, found.levels, strict=True)),
    ]
    events = tuple(EventFigures(event, bound.tests, bound.answers, bound.passes) for event, bound in named)
    return BoundFigures(events, found.method, stack_bytes(built.tables), STACK_TARGET)


def report(summary: "Summary", form: "ReportFormat", timings: bool) -> str:
    """Return the report in a format, with a final newline; it has times in seconds only with `timings`."""
    match form:
        case "text":
            from exover.report import text

            return text.render(summary, timings)
        case "json":
            from exover.report import json

            return json.render(summary, timings)
        case "sarif":
            from exover.report import sarif

            return sarif.render(summary, timings)
        case "junit":
            from exover.report import junit

            return junit.render(summary, timings)
        case "github":
            from exover.report import github

            return github.render(summary, timings)
        case _:
            assert_never(form)


def picture(recorded: "Recorded", story: "Story", form: Picture) -> str:
    """Return a finding and its run as text, as JSON, as an SVG drawing, or as a VCD file for waveform viewers."""
    from exover import __version__
    from exover.report import recorded as plain
    from exover.report import timeline, vcd

    match form:
        case "text":
            return plain.render_text(recorded, story)
        case "json":
            return plain.render_json(recorded, story)
        case "svg":
            return timeline.render(recorded.title, story)
        case "vcd":
            return vcd.render(recorded.title, __version__, story)
        case _:
            assert_never(form)


def draw(graph: "InteractionGraph", form: Drawing) -> str:
    """Return the interaction graph as text for Graphviz or Mermaid, or as an SVG drawing.

    Raises `NotRunnable` if Graphviz, which draws SVG, is missing or fails, and `TimeoutError`.
    """
    from exover.graph import dot, mermaid, svg

    match form:
        case "dot":
            return dot.render(graph)
        case "mermaid":
            return mermaid.render(graph)
        case "svg":
            return svg.draw(dot.render(graph))
        case _:
            assert_never(form)


def look(summary: "Summary", source: Source, built: Build | None, audit: "dict[str, Any] | None" = None) -> str:
    """Return the page of a report: findings, rules, diagrams, runs and a simulator of the tables, as one HTML file.

    `audit`: the result of an audit of missions, as the JSON object that it prints.
    """
    from exover.page.html import render

    return render(page_of(summary, source, built, audit))


def page_of(
    summary: "Summary", source: Source, built: Build | None, audit: "dict[str, Any] | None" = None
) -> "dict[str, Any]":
    """Return the data of the page of a report; without tables it has no diagrams and no simulator."""
    from exover.page.document import document

    tables, data = (built.tables, built.data) if built else (None, b"")
    return document(summary, source, tables, data, audit)


def told(compared: "Compared", form: Differing) -> str:
    """Return the differences between two versions in a format, with a final newline."""
    from exover.report import difference, difference_json, difference_markdown, difference_sarif

    match form:
        case "text":
            return difference.render(compared)
        case "json":
            return difference_json.render(compared)
        case "markdown":
            return difference_markdown.render(compared)
        case "sarif":
            return difference_sarif.render(compared)
        case _:
            assert_never(form)
