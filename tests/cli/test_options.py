"""The words that the command line takes are those of the types behind it, which it does not import: it loads fast."""

from typing import Any, get_args

import pytest

from exover.checks.schedule.engines import EngineName
from exover.cli import options, values
from exover.graph.interactions import InteractionKind
from exover.pipeline import CheckerName, EmitTarget
from exover.rendering import Differing, Drawing, Picture
from exover.report.several import ReportFormat


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (options.RUN_ENGINES, CheckerName),
        (options.TRACE_FORMATS, Picture),
        (options.DIFF_FORMATS, Differing),
        (options.GRAPH_FORMATS, Drawing),
        (options.TARGETS, EmitTarget),
        (options.EDGES, InteractionKind),
        (values.REPORT_FORMATS, ReportFormat),
    ],
)
def test_the_words_of_an_option_are_those_of_its_type(words: tuple[str, ...], meant: Any) -> None:
    assert len(words) == len(set(words))
    assert set(words) == set(get_args(meant))


def test_every_engine_of_checks_can_be_asked_for() -> None:
    assert set(options.CHECK_ENGINES) == {"auto", "all", *get_args(EngineName)}
