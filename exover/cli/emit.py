"""`exover emit`: check a spec and write its tables."""

import argparse
import os
from collections.abc import Sequence
from contextlib import nullcontext

from exover.checks.questions import SEVERITY
from exover.checks.questions.choice import ERRORS, asked
from exover.checks.schedule.plan import CheckPlan
from exover.cli.check import STATUS, decide, read, too_late
from exover.cli.engines import portfolio
from exover.cli.files import read_spec, refuse_closed, shown, write_all
from exover.cli.neighbours import neighbours, refuse_foreign_crate, spared
from exover.cli.overwriting import refuse_overwriting
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import ProgressLine, complain, out
from exover.emit.artefact import Artefact
from exover.emit.config import FILE
from exover.engines.smt.solver import Inconclusive
from exover.limits import Limits, TimeUp, interrupted, limits_from
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import Build, EmitTarget, build, emit
from exover.rendering import report, summarise
from exover.report.summary import ERRORS as COUNTED

QUESTIONS = ("smt2", "smv", "aiger")
"""The targets for other checkers: the loop with the questions about it."""


def run(arguments: argparse.Namespace) -> int:
    """Write the artefacts of all targets and print their paths; if an error does not hold, print the report instead.

    Waivers and baselines do not count here, since tables are marked as checked. Targets in QUESTIONS are written
    whatever the verdict is, unless tables are emitted with them.
    """
    refuse_closed(arguments.out, arguments.out)
    targets = tuple(dict.fromkeys(target for listed in arguments.target for target in listed.split(",")))
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    if set(targets) <= set(QUESTIONS):
        _, model, properties = read(arguments)
        return _write(arguments, targets, _made(model, limits), properties, limits)
    if arguments.unchecked:
        model, properties = (
            read(arguments)[1:] if set(targets) & set(QUESTIONS) else (read_spec(arguments.spec), NO_PROPERTIES)
        )
        return _write(arguments, targets, _made(model, limits, unchecked=True), properties, limits)
    try:
        with interrupted(limits):
            _, model, properties = read(arguments)
    except TimeUp:
        return too_late(arguments, limits)
    plan = CheckPlan(asked(ERRORS, SEVERITY), properties, portfolio())
    built, outcome = decide(model, plan, limits)
    summary = summarise(shown(arguments.spec), model, built, outcome, COUNTED, properties=properties)
    if built is None or outcome.interrupted or summary.verdict != "holds":
        complain(report(summary, "text", timings=False).rstrip())
        complain("exover: error: nothing is emitted; --unchecked emits all the same, and the tables say so")
        return ExitStatus.INTERRUPTED if outcome.interrupted else STATUS[summary.verdict]
    return _write(arguments, targets, built, properties, limits)


def _made(model: Model, limits: Limits, unchecked: bool = False) -> Build:
    """Return the tables of a model; only their memory is limited."""
    with interrupted(Limits(memory=limits.memory), of_memory=True):
        return build(model, unchecked)


def _write(
    arguments: argparse.Namespace,
    targets: Sequence[EmitTarget],
    built: Build,
    properties: Properties,
    limits: Limits,
) -> ExitStatus:
    beside = neighbours(arguments.out, built.tables, built.model.name) if "c" in targets else ()
    try:
        artefacts: list[Artefact] = []
        with interrupted(limits) if set(targets) & set(QUESTIONS) else nullcontext(), ProgressLine() as progress:
            for target in targets:
                progress(f"writing {target}")
                artefacts += emit(built, target, properties, beside, limits.deadline)
    except (TimeUp, Inconclusive):
        late = f"it was over before {', '.join(targets)} could be written"
        complain(f"exover: error: {limits.reason}: {late}: nothing is emitted; give more with --timeout")
        return ExitStatus.UNKNOWN
    except TooLarge as reason:
        advice = "nothing is emitted; leave smv out: aiger and smt2 have no such limit"
        raise CliError(f"{shown(arguments.spec)} cannot be written as smv: {reason}: {advice}") from reason
    refuse_foreign_crate(arguments.out, artefacts)
    refuse_overwriting(arguments, *(os.path.join(arguments.out, artefact.name) for artefact in artefacts))
    out("".join(f"{path}\n" for path in write_all(arguments.out, spared(arguments.out, artefacts))))
    if beside:
        names = " and ".join([built.model.name, *(each.name for each in beside)])
        complain(f"exover: note: {FILE} serves {names} now: compile all of {arguments.out} anew")
    return ExitStatus.OK
