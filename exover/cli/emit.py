"""`exover emit`: check a spec and write its tables."""

import argparse

from exover.checks.limits import TimeUp, interrupted, limits_from
from exover.cli.check import STATUS, decide, read, too_late
from exover.cli.engines import portfolio
from exover.cli.files import read_spec, write_all
from exover.cli.neighbours import neighbours, spared
from exover.cli.status import Refused, Status
from exover.cli.streams import complain, out
from exover.emit.config import FILE
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import Build, build, emit, report, summarise
from exover.report.summary import ERRORS
from exover.verify.cells import TooLarge

QUESTIONS = ("smt2", "smv", "aiger")
"""Targets that say what is asked of the loop."""


def run(arguments: argparse.Namespace) -> int:
    """Write the artefacts and print their paths; write nothing, and say why, if an error check does not hold.

    No waiver and no baseline counts here: what is emitted is marked as checked. Questions for others to answer are
    written whatever the answers are.
    """
    if arguments.target in QUESTIONS:
        model, properties = read(arguments)
        return _write(arguments, build(model), properties)
    if arguments.unchecked:
        return _write(arguments, build(read_spec(arguments.spec), unchecked=True))
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    try:
        with interrupted(limits):
            model, properties = read(arguments)
    except TimeUp:
        return too_late(arguments, limits)
    built, outcome = decide(model, properties, limits, errors_only=True, engines=portfolio())
    summary = summarise(arguments.spec, model, built, outcome.findings, outcome.state_bits, ERRORS)
    if built is None or outcome.interrupted or summary.verdict != "holds":
        complain(report(summary, "text", timings=False).rstrip())
        complain("exover: error: nothing is emitted; --unchecked emits all the same, and the tables say so")
        return Status.INTERRUPTED if outcome.interrupted else STATUS[summary.verdict]
    return _write(arguments, built)


def _write(arguments: argparse.Namespace, built: Build, properties: Properties = NO_PROPERTIES) -> Status:
    beside = neighbours(arguments.out, built.tables, built.model.name) if arguments.target == "c" else ()
    try:
        artefacts = emit(built, arguments.target, properties, beside)
    except TooLarge as reason:
        raise Refused(f"{arguments.spec} cannot be written so: {reason}") from reason
    out("".join(f"{path}\n" for path in write_all(arguments.out, spared(arguments.out, artefacts))))
    if beside:
        names = " and ".join([built.model.name, *(each.name for each in beside)])
        complain(f"exover: note: {FILE} serves {names} now: compile all of {arguments.out} anew")
    return Status.OK
