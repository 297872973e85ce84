"""`exover check`: decide a spec and report what was found."""

import argparse
import os
from collections.abc import Collection, Iterator
from datetime import date

from exover.checks import SEVERITY
from exover.checks.engines import PORTFOLIO, Engines
from exover.checks.finding import Severity
from exover.checks.limits import INTERRUPTED, Limits, TimeUp, interrupted, limits_from
from exover.checks.run import Outcome
from exover.cli.engines import engines_of
from exover.cli.files import read_properties, read_spec, refuse_twice, shown, write_all
from exover.cli.live import Live
from exover.cli.policy import asked_by, configured, read_policy
from exover.cli.status import Refused, Status
from exover.cli.streams import Progress, complain, out
from exover.emit.artefact import Artefact
from exover.loop.claim import Verdict
from exover.model.model import Model
from exover.model.property import Properties
from exover.pipeline import Build, build, certify, check, report, summarise, table_figures, unanswered
from exover.report.policy import judge, remarks
from exover.report.summary import ERRORS, Summary

STATUS: dict[Verdict, Status] = {"holds": Status.OK, "violated": Status.VIOLATED, "unknown": Status.UNKNOWN}


def run(arguments: argparse.Namespace) -> int:
    """Print and write the findings and return the status of their verdict."""
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    _refuse_odd(arguments)
    engines = engines_of(arguments)
    try:
        with interrupted(limits):
            model, properties = read(arguments)
            config = configured(arguments)
            asked = asked_by(arguments, config)
            policy = read_policy(arguments, config, asked, model.name)
    except TimeUp:
        return too_late(arguments, limits)
    if arguments.certificate and asked is not None:
        raise Refused("a certificate is about all checks: leave out --only, --skip, --errors-only and [check]")
    built, outcome = decide(model, properties, limits, asked, engines, arguments.count)
    written = Status.OK
    if arguments.certificate:
        written = _certify(arguments.certificate, built, outcome, properties, limits)
    today = date.today()
    for remark in remarks(outcome.findings, policy, model.name, today):
        complain(f"exover: warning: {remark}")
    findings = judge(outcome.findings, policy, model.name, today)
    counted: frozenset[Severity] = ERRORS | {"warning"} if arguments.deny else ERRORS
    sizes = outcome.state_bits, counted, outcome.states, arguments.bounds, properties, skipped(asked)
    summary = summarise(shown(arguments.spec), model, built, findings, *sizes)
    _write(arguments, summary)
    out(report(summary, arguments.format, arguments.timings))
    if outcome.interrupted or written is Status.INTERRUPTED:
        return Status.INTERRUPTED
    exceeded = list(_exceeded(arguments, built)) if built else []
    for complaint in exceeded:
        complain(f"exover: error: {complaint}")
    if exceeded or summary.verdict == "violated":
        return Status.VIOLATED
    return written or STATUS[summary.verdict]


def skipped(asked: Collection[str] | None) -> tuple[str, ...]:
    """Return the checks that are not asked."""
    return () if asked is None else tuple(name for name in SEVERITY if name not in asked)


def _exceeded(arguments: argparse.Namespace, built: Build) -> Iterator[str]:
    """Yield what the tables take more of than the command line allows."""
    figures = table_figures(built, bounded=arguments.max_tests is not None)
    if figures.bounds:
        tests, event = figures.bounds.worst("tests")
        if tests > arguments.max_tests:
            yield f"an event may take {tests} tests ({event}), but --max-tests is {arguments.max_tests}"
    for option, limit, size in (
        ("rom", arguments.max_rom, figures.bytes),
        ("ram", arguments.max_ram, figures.ram_bytes),
    ):
        if limit is not None and size > limit:
            yield f"the tables take {size} bytes of {option.upper()}, but --max-{option} is {limit}"


def read(arguments: argparse.Namespace) -> tuple[Model, Properties]:
    """Return the model of the spec, and what its properties file says."""
    refuse_twice(arguments.spec, arguments.properties)
    model = read_spec(arguments.spec)
    return model, read_properties(arguments.spec, arguments.properties, model)


def too_late(arguments: argparse.Namespace, limits: Limits) -> Status:
    """Tell the user that not even the spec could be read in time, and return the status for that."""
    complain(f"exover: error: {limits.reason}: it was over before {shown(arguments.spec)} was read")
    return Status.UNKNOWN


def decide(
    model: Model,
    properties: Properties,
    limits: Limits,
    asked: Collection[str] | None = None,
    engines: Engines = PORTFOLIO,
    count: bool = False,
) -> tuple[Build | None, Outcome]:
    """Return the tables of a model, unless the time is over before, and what the checks say of them."""
    with Live() as progress:
        try:
            with interrupted(limits):
                progress("tables")
                built = build(model)
        except TimeUp:
            return None, unanswered(model, properties, limits.reason, asked, engines, count)
        except KeyboardInterrupt:
            return None, unanswered(model, properties, INTERRUPTED, asked, engines, count)
        outcome = check(built, progress, asked, properties, limits, engines, count, progress)
        progress.finish()
    if outcome.note:
        complain(f"exover: note: {outcome.note}")
    return built, outcome


def _certify(file: str, built: Build | None, outcome: Outcome, properties: Properties, limits: Limits) -> Status:
    """Write the certificate of what was found, if there is time for it, and return how that ends."""
    try:
        if outcome.interrupted:
            raise KeyboardInterrupt
        with interrupted(limits), Progress() as progress:
            content = None if built is None else certify(built, outcome, properties, progress)
    except TimeUp:
        content = None
    except KeyboardInterrupt:
        complain(f"exover: error: {INTERRUPTED}: {file} is not written")
        return Status.INTERRUPTED
    if content is None:
        complain(f"exover: error: {limits.reason}: {file} is not written")
        return Status.UNKNOWN
    folder, name = os.path.split(file)
    write_all(folder or os.curdir, [Artefact(name, content)])
    return Status.OK


def _refuse_odd(arguments: argparse.Namespace) -> None:
    """Raise `Refused` if a report would be written over the spec or over another report."""
    outputs = [file for _, file in arguments.output] + ([arguments.certificate] if arguments.certificate else [])
    outputs = [file for file in outputs if os.path.isfile(file) or not os.path.exists(file)]  # others take any number
    files = [os.path.realpath(file) for file in outputs]
    for number, file in enumerate(outputs):
        if files[number] in files[:number]:
            raise Refused(f"two reports cannot be written to {file}")
        if files[number] == os.path.realpath(arguments.spec):
            raise Refused(f"a report cannot be written over the spec {file}")


def _write(arguments: argparse.Namespace, summary: Summary) -> None:
    folders: dict[str, list[Artefact]] = {}
    for form, file in arguments.output:
        folder, name = os.path.split(file)
        content = report(summary, form, arguments.timings).encode("utf-8", "backslashreplace")
        folders.setdefault(folder or os.curdir, []).append(Artefact(name, content))
    for folder, artefacts in folders.items():
        write_all(folder, artefacts)
