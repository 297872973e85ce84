"""`exover check`: decide a spec and report what was found."""

import argparse
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import date
from functools import cache, partial
from pathlib import Path
from time import monotonic

from exover import __version__
from exover.checks.causes.detail import out_of_range, unchanging
from exover.checks.causes.excluded import never_broken, never_fair
from exover.checks.finding import Finding
from exover.checks.run import CheckOutcome, unanswered
from exover.checks.schedule.answers import AnswerStore
from exover.checks.schedule.engines import Engines
from exover.checks.schedule.plan import CheckPlan
from exover.cli.answer_cache import answers_of
from exover.cli.engines import engines_of
from exover.cli.files import load_spec, read_properties, refuse_unwritable, shown, write_all, write_one
from exover.cli.live import Live
from exover.cli.named_files import outputs_of
from exover.cli.overwriting import refuse_overwriting
from exover.cli.policy import asked_by, configured, read_policy
from exover.cli.report_cache import ReportEntry, entry, remember
from exover.cli.several import Examine, Examined, examine_all
from exover.cli.specs import SpecFiles, specs_of
from exover.cli.status import CliError, ExitStatus, severest
from exover.cli.streams import Complaints, ProgressLine, complain, out
from exover.diagnostics import Severity, quote
from exover.emit.artefact import Artefact
from exover.limits import INTERRUPTED, Limits, TimeUp, interrupted, limits_from, memory_reason
from exover.loop.claim import Verdict
from exover.model.model import Model
from exover.model.property import Properties
from exover.pipeline import Build, build, certify, check
from exover.places import named_after
from exover.raised import out_of_memory
from exover.rendering import report, summarise, table_figures
from exover.report.policy import Policy, judge, remarks
from exover.report.several import ReportFormat, joined
from exover.report.summary import ERRORS, Summary, TableFigures, Unchecked
from exover.source import Source

BY_NAME: tuple[ReportFormat, ...] = ("sarif", "junit")
"""The formats whose readers identify a spec by its name alone."""
STATUS: dict[Verdict, ExitStatus] = {
    "holds": ExitStatus.OK,
    "violated": ExitStatus.VIOLATED,
    "unknown": ExitStatus.UNKNOWN,
}


def run(arguments: argparse.Namespace, kept: ReportEntry | None = None) -> int:
    """Print and write the reports and return the exit status, the severest of all specs.

    `kept`: the entry of the cache for the report; it is used if nothing is unknown and nothing was complained of.
    """
    before = Complaints.count
    named = specs_of(arguments.specs, arguments.changed)
    _refuse_odd(arguments, named)
    examining = partial(examine, engines=engines_of(arguments))
    if named.several:
        return _several(examining, arguments, named.files)
    examined = examining(argparse.Namespace(**vars(arguments), spec=named.files[0], share=None))
    found = examined.found
    if isinstance(found, Summary):
        render: Callable[[ReportFormat], str] = cache(lambda form: report(found, form, arguments.timings))
        _tell(arguments, render)
        if kept and before == Complaints.count and _is_lasting(found, examined.status) and entry(arguments) == kept:
            remember(kept, render(arguments.format), examined.status)
        if arguments.watched and examined.recalled:
            complain(f"exover: note: {examined.recalled} of {len(found.findings)} answers come from the cache")
    return examined.status


def _is_lasting(summary: Summary, status: int) -> bool:
    """Return whether the report would be the same if everything were asked again: nothing unknown or interrupted."""
    known = all(finding.verdict != "unknown" for finding in summary.findings)
    return known and status in (ExitStatus.OK, ExitStatus.VIOLATED)


def _several(examining: Examine, arguments: argparse.Namespace, specs: Sequence[str]) -> int:
    checked = examine_all(examining, arguments, specs)
    verdicts = [each.verdict for each in checked]
    _tell(arguments, lambda form: joined([each.parts[form] for each in checked], verdicts, form, arguments.timings))
    return severest(each.status for each in checked)


def _tell(arguments: argparse.Namespace, render: Callable[[ReportFormat], str]) -> None:
    """Write the reports to their files, and print one, whatever becomes of the files."""
    folders: dict[str, list[Artefact]] = {}
    for form, file in arguments.output:
        folder, name = os.path.split(file)
        content = render(form).encode("utf-8", "backslashreplace")
        folders.setdefault(folder or os.curdir, []).append(Artefact(name, content))
    try:
        for folder, artefacts in folders.items():
            write_all(folder, artefacts)
    finally:
        out(render(arguments.format))


def examine(arguments: argparse.Namespace, engines: Engines) -> Examined:
    """Return the findings of one spec, and their exit status."""
    file = shown(arguments.spec)
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    if arguments.share is not None:
        limits = replace(limits, deadline=min(limits.deadline, monotonic() + arguments.share))
    try:
        with interrupted(limits):
            source, model, properties = read(arguments)
            config = configured(arguments)
            asked = asked_by(arguments, config)
            policy = read_policy(arguments, config, asked, model.name)
    except TimeUp:
        status = too_late(arguments, limits)
        return Examined(Unchecked(__version__, file, f"{limits.reason}: the spec was not read"), status)
    if arguments.certificate and asked is not None:
        raise CliError("a certificate is about all checks: leave out --only, --skip, --errors-only and [check]")
    for remark in (*out_of_range(model, properties), *never_fair(properties), *never_broken(model, properties)):
        complain(f"exover: warning: {remark}")
    store = answers_of(arguments, arguments.spec)
    plan = CheckPlan(asked, properties, engines, arguments.count)
    built, outcome = decide(model, plan, limits, store)
    if asked is None or "rule-use" in asked:
        for remark in unchanging(model, outcome.findings):
            complain(f"exover: warning: {remark}")
    written = ExitStatus.OK
    if arguments.certificate:
        written = _certify(arguments.certificate, built, outcome, properties, limits)
    judged = replace(outcome, findings=_judged(outcome, policy, model))
    counted: frozenset[Severity] = ERRORS | {"warning"} if arguments.deny else ERRORS
    summary = summarise(
        file,
        model,
        built,
        judged,
        counted,
        bounded=arguments.bounds,
        properties=properties,
        skipped=plan.skipped,
        limits=limits,
    )
    figures = summary.tables
    if built and figures and arguments.max_tests is not None and not figures.bounds:
        figures = table_figures(built, bounded=True, limits=limits)
    status = _status(arguments, summary, figures, written, outcome.interrupted)
    return Examined(summary, status, source, built, len(outcome.recalled))


def _judged(outcome: CheckOutcome, policy: Policy, model: Model) -> tuple[Finding, ...]:
    """Return the findings with their excuses; warn of waivers that have expired or match nothing."""
    today = date.today()
    for remark in remarks(outcome.findings, policy, model.name, today):
        complain(f"exover: warning: {remark}")
    return judge(outcome.findings, policy, model.name, today)


def _status(
    arguments: argparse.Namespace, summary: Summary, figures: TableFigures | None, written: ExitStatus, stopped: bool
) -> ExitStatus:
    """Return the exit status; complain of each budget that is exceeded."""
    if stopped or written is ExitStatus.INTERRUPTED:
        return ExitStatus.INTERRUPTED
    exceeded = list(_exceeded(arguments, figures)) if figures else []
    for complaint in exceeded:
        complain(f"exover: error: {shown(arguments.spec)}: {complaint}")
    if exceeded or summary.verdict == "violated":
        return ExitStatus.VIOLATED
    return written or STATUS[summary.verdict]


def _exceeded(arguments: argparse.Namespace, figures: TableFigures) -> Iterator[str]:
    """Yield a message for each budget of the command line that the tables exceed."""
    if figures.bounds and arguments.max_tests is not None:
        tests, event = figures.bounds.worst("tests")
        if tests > arguments.max_tests:
            yield f"an event may take {tests} tests ({event}), but --max-tests is {arguments.max_tests}"
    for option, limit, size in (
        ("rom", arguments.max_rom, figures.bytes),
        ("ram", arguments.max_ram, figures.ram_bytes),
    ):
        if limit is not None and size > limit:
            yield f"the tables take {size} bytes of {option.upper()}, but --max-{option} is {limit}"


def read(arguments: argparse.Namespace) -> tuple[Source, Model, Properties]:
    """Return the text of the spec, its model, and its properties."""
    source, model = load_spec(arguments.spec)
    return source, model, read_properties(arguments.spec, arguments.properties, model)


def too_late(arguments: argparse.Namespace, limits: Limits) -> ExitStatus:
    """Complain that the time was over before the spec was read, and return the exit status."""
    complain(f"exover: error: {limits.reason}: it was over before {shown(arguments.spec)} was read")
    return ExitStatus.UNKNOWN


def decide(
    model: Model, plan: CheckPlan, limits: Limits, store: AnswerStore | None = None
) -> tuple[Build | None, CheckOutcome]:
    """Return the tables of a model, None if time or memory are not enough for them, and the outcome of the checks.

    Questions that `store` has an answer to are not asked.
    """
    with Live() as progress:
        try:
            with interrupted(limits, of_memory=True):
                progress("tables")
                built = build(model)
        except TimeUp:
            return None, unanswered(model, plan, limits.reason)
        except KeyboardInterrupt:
            return None, unanswered(model, plan, INTERRUPTED, interrupted=True)
        except Exception as error:
            if not out_of_memory(error):
                raise
            return None, unanswered(model, plan, memory_reason(error))
        outcome = check(built, progress, plan, limits=limits, audience=progress, store=store)
        progress.finish()
    if outcome.note:
        complain(f"exover: note: {outcome.note}")
    return built, outcome


def _certify(
    file: str, built: Build | None, outcome: CheckOutcome, properties: Properties, limits: Limits
) -> ExitStatus:
    """Write the certificate of the findings and return the exit status: UNKNOWN if the time is over, INTERRUPTED."""
    try:
        if outcome.interrupted:
            raise KeyboardInterrupt
        with interrupted(limits), ProgressLine() as progress:
            content = None if built is None else certify(built, outcome, properties, progress)
    except TimeUp:
        content = None
    except KeyboardInterrupt:
        complain(f"exover: error: {INTERRUPTED}: {file} is not written")
        return ExitStatus.INTERRUPTED
    if content is None:
        complain(f"exover: error: {limits.reason}: {file} is not written")
        return ExitStatus.UNKNOWN
    write_one(file, content, "--certificate")
    return ExitStatus.OK


def _refuse_odd(arguments: argparse.Namespace, named: SpecFiles) -> None:
    """Raise `CliError` if an output is read or is named twice, or an option or format does not fit the specs."""
    if named.several and "-" in named.files:
        raise CliError("standard input is checked alone: name no other spec beside -")
    if arguments.watched:  # files have changed since the command began
        refuse_overwriting(arguments)
    places: set[str] = set()
    for file in outputs_of(arguments):
        refuse_unwritable(file, "--certificate" if file == arguments.certificate else "--output")
    for file in outputs_of(arguments):
        if os.path.isfile(file) or not os.path.exists(file):  # a device or a pipe takes any number
            place = os.path.realpath(file)
            if place in places:
                raise CliError(f"two reports cannot be written to {file}")
            places.add(place)
    for option in ("certificate", "properties"):
        if named.several and getattr(arguments, option):
            raise CliError(f"--{option} is for one spec: name one file, once, and no folder")
    forms = {arguments.format, *(form for form, _ in arguments.output)}
    for form in (form for form in BY_NAME if form in forms):
        _refuse_namesakes(named.files, form)


def _refuse_namesakes(specs: Sequence[str], form: ReportFormat) -> None:
    """Raise `CliError` if two specs have the same name, since a report of this format would mix their findings."""
    known: dict[str, str] = {}
    for spec in specs:
        with suppress(OSError):  # what cannot be read is told of later
            name = named_after(Path(spec), "spec")
            if name and known.setdefault(name, spec) != spec:
                told = f"{shown(known[name])} and {shown(spec)} are both called {quote(name)}"
                raise CliError(f"{told}, and a {form} report tells specs apart by name: check them one by one")
