"""`exover audit`: compare recorded missions with the answers that the checker of a spec would have given."""

import argparse
import os
import shutil
import tempfile
from contextlib import ExitStack
from importlib.util import find_spec

from exover import __version__
from exover.audit.auditor import Job
from exover.audit.native import compile_library
from exover.audit.result import Audit, MissionResult
from exover.audit.sources import SUFFIXES, TABLES, is_bag, missions_in
from exover.audit.spread import ClusterUnavailable, Paths, audit_all, audit_on_cluster
from exover.cli.files import read_spec, refuse_unwritable, shown, standard_input
from exover.cli.gate import binding_of
from exover.cli.replacing import replacing
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import ProgressLine, complain, out
from exover.engines.compiler import NativeUnavailable
from exover.gate.binding import Binding
from exover.model.model import Model
from exover.pipeline import build
from exover.source import STDIN


def run(arguments: argparse.Namespace) -> int:
    """Audit the missions, print the findings, and return the exit status."""
    if arguments.out:
        _refuse_table(arguments.out)
    model = read_spec(arguments.spec)
    binding = binding_of(arguments.bind, model) if arguments.bind else None
    with ExitStack() as stack:
        scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="exover-", ignore_cleanup_errors=True))
        missions = list(_missions(arguments.missions, scratch))
        _refuse_missing(arguments, missions)
        job = _job(model, binding, arguments, scratch)
        found = _audited(job, missions, arguments)
        if arguments.out:
            _write_table(found, arguments.out)
    audit = Audit(__version__, model, shown(arguments.spec), tuple(found))
    _complain(audit)
    out(_render(audit, arguments.format))
    return _status(audit)


def _missions(paths: list[str], scratch: str) -> Paths:
    """Return path and name of each mission; `CliError` if a path cannot be read or holds none."""
    found: list[tuple[str, str]] = []
    for path in paths:
        if path == "-":
            held = os.path.join(scratch, "stdin")
            with open(held, "wb") as file:
                shutil.copyfileobj(standard_input(), file)
            found.append((held, STDIN))
            continue
        inside = list(missions_in(path))
        if not inside:
            raise CliError(f"{path} holds no mission: their names end as {', '.join(SUFFIXES)}")
        found += [(each, each) for each in inside]
    return found


def _refuse_missing(arguments: argparse.Namespace, missions: Paths) -> None:
    """Raise `CliError` if a package that is needed is not installed."""
    needed = []
    if arguments.out or any(path.endswith(TABLES) for path, _ in missions):
        needed.append(("pyarrow", "audit", "Parquet"))
    if any(is_bag(path) for path, _ in missions):
        needed.append(("rosbags", "ros", "a bag"))
    for module, extra, what in needed:
        if find_spec(module) is None:
            raise CliError(f"{what} needs {module}: pip install 'exover[{extra}]'")


def _job(model: Model, binding: Binding | None, arguments: argparse.Namespace, scratch: str) -> Job:
    tables = build(model).tables
    library = None
    if arguments.engine in ("auto", "c"):
        try:
            library = compile_library(model, tables)
        except NativeUnavailable as reason:
            if arguments.engine == "c":
                raise CliError(str(reason)) from reason
            complain(f"exover: note: the tables are walked in Python, which is slower: {str(reason).splitlines()[0]}")
    return Job(model, tables, library, arguments.engine == "reference", binding, scratch if arguments.out else None)


def _audited(job: Job, missions: Paths, arguments: argparse.Namespace) -> list[MissionResult]:
    with ProgressLine() as progress:
        done = 0

        def told(name: str) -> None:
            nonlocal done
            done += 1
            progress(f"{done} of {len(missions)} missions: {name}")

        if not arguments.cluster:
            return audit_all(job, missions, arguments.jobs, told)
        try:
            return audit_on_cluster(job, missions, arguments.cluster, told)
        except ClusterUnavailable as reason:
            raise CliError(str(reason)) from reason


def _refuse_table(path: str) -> None:
    """Raise `CliError` as far as it can be known before any work is done that the table cannot be written."""
    refuse_unwritable(path)
    if os.path.exists(path) and not os.path.isfile(path):
        raise CliError(f"cannot write {path}: it is no regular file")


def _write_table(found: list[MissionResult], path: str) -> None:
    """Write all rows to a file, whole or not at all; raises `CliError`."""
    from exover.audit.table import merge

    target = os.path.realpath(path)
    try:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        with replacing(target) as temporary:
            merge((mission.table for mission in found), temporary)
    except OSError as error:
        raise CliError(f"cannot write {path}: {error.strerror or error}") from error


def _complain(audit: Audit) -> None:
    """Complain of the errors and mistakes in missions."""
    for mission in audit.missions:
        if mission.error:
            complain(f"exover: error: {mission.name}: {mission.error}")
        for mistake in mission.mistakes:
            complain(f"exover: error: {mission.name}:{mistake.line}: {mistake.text}")
        if mission.mistake_count > len(mission.mistakes):
            complain(f"exover: error: {mission.name}: {mission.mistake_count - len(mission.mistakes)} more mistakes")


def _render(audit: Audit, form: str) -> str:
    if form == "json":
        from exover.audit import json

        return json.render(audit)
    if form == "sarif":
        from exover.audit import sarif

        return sarif.render(audit)
    from exover.audit import text

    return text.render(audit)


def _status(audit: Audit) -> ExitStatus:
    if any((mission.error and not mission.died) or mission.mistake_count for mission in audit.missions):
        return ExitStatus.WRONG
    if audit.diverging:
        return ExitStatus.VIOLATED
    undecided = any(mission.died or mission.figures.undecided for mission in audit.missions)
    return ExitStatus.UNKNOWN if undecided else ExitStatus.OK
