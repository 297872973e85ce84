"""`exover check`: decide a spec and report what was found."""

import argparse

from exover.checks.finding import Severity, Verdict
from exover.cli.files import read_spec
from exover.cli.status import Status
from exover.cli.streams import Progress, complain, out
from exover.pipeline import build, check, summarise
from exover.report import json, text
from exover.report.summary import ERRORS

STATUS: dict[Verdict, Status] = {"holds": Status.OK, "violated": Status.VIOLATED, "unknown": Status.UNKNOWN}


def run(arguments: argparse.Namespace) -> int:
    """Print the findings and return the status of their verdict."""
    counted: frozenset[Severity] = ERRORS | {"warning"} if arguments.deny else ERRORS
    model = read_spec(arguments.spec)
    with Progress() as progress:
        built = build(model)
        outcome = check(built, progress)
    if outcome.note:
        complain(f"exover: note: {outcome.note}")
    summary = summarise(arguments.spec, built, outcome, counted)
    report = json if arguments.format == "json" else text
    out(report.render(summary, arguments.timings))
    return STATUS[summary.verdict]
