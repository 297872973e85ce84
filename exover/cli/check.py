"""`exover check`: decide a spec and report what was found."""

import argparse

from exover.checks.finding import Severity, Verdict
from exover.cli.files import read_spec
from exover.cli.status import Status
from exover.cli.streams import Progress, out
from exover.pipeline import check, compile_tables, summarise
from exover.report import json, text

STATUS: dict[Verdict, Status] = {"holds": Status.OK, "violated": Status.VIOLATED, "unknown": Status.UNKNOWN}


def run(arguments: argparse.Namespace) -> int:
    """Print the findings and return the status of their verdict."""
    counted: frozenset[Severity] = frozenset({"error", "warning"} if arguments.deny else {"error"})
    model = read_spec(arguments.spec)
    with Progress() as progress:
        tables = compile_tables(model)
        findings = check(model, tables, progress)
    summary = summarise(arguments.spec, model, tables, findings, counted)
    report = json if arguments.format == "json" else text
    out(report.render(summary, arguments.timings))
    return STATUS[summary.verdict]
