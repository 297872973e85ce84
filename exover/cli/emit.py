"""`exover emit`: check a spec and write its tables."""

import argparse

from exover.checks.run import Outcome
from exover.cli.check import STATUS
from exover.cli.files import read_spec, write_all
from exover.cli.status import Status
from exover.cli.streams import Progress, complain, out
from exover.pipeline import build, check, emit, summarise
from exover.report import text
from exover.report.summary import ERRORS


def run(arguments: argparse.Namespace) -> int:
    """Write the artefacts and print their paths; write nothing, and say why, if an error check does not hold."""
    model = read_spec(arguments.spec)
    with Progress() as progress:
        built = build(model, arguments.unchecked)
        outcome = Outcome() if arguments.unchecked else check(built, progress, errors_only=True)
    summary = summarise(arguments.spec, built, outcome, ERRORS)
    if summary.verdict != "holds":
        complain(text.render(summary).rstrip())
        complain("exover: error: nothing is emitted; --unchecked emits all the same, and the tables say so")
        return STATUS[summary.verdict]
    paths = write_all(arguments.out, emit(built, arguments.target))
    out("".join(f"{path}\n" for path in paths))
    return Status.OK
