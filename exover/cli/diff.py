"""`exover diff`: find the answers and the properties that differ between two versions of a spec."""

import argparse
from collections.abc import Collection
from dataclasses import replace

from exover.checks.finding import Finding
from exover.cli.engines import portfolio
from exover.cli.files import print_or_write, read_properties, read_spec, refuse_unwritable, shown
from exover.cli.named_files import refuse_twice
from exover.cli.revision import Revision
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import ProgressLine, complain
from exover.dataclass import dataclass
from exover.diagnostics import did_you_mean
from exover.limits import Limits, TimeUp, interrupted, limits_from
from exover.model.difference import Compared
from exover.model.model import Model
from exover.model.property import Properties
from exover.model.versions import Versions
from exover.pipeline import DiffSide, build, diff, property_findings
from exover.rendering import told


@dataclass(frozen=True, slots=True)
class ReadVersion:
    """A version as it is read: what messages call its file, its model, and its properties."""

    file: str
    model: Model
    properties: Properties

    def built(self) -> DiffSide:
        """Return the version with its tables."""
        return DiffSide(build(self.model), self.file, self.properties)


def run(arguments: argparse.Namespace) -> int:
    """Print or write the differences, and return the exit status."""
    if arguments.out is not None:
        refuse_unwritable(arguments.out)
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    try:
        with interrupted(limits):
            old, new = _read(arguments)
        renamed = _renamed(arguments.rename, old.model, new.model)
        _refuse_clashes(Versions(old.model, new.model, renamed))
        compared = _compared(old, new, renamed, arguments.abc, limits)
    except TimeUp:
        complain(f"exover: error: {limits.reason}: it is not known whether anything changes")
        return ExitStatus.UNKNOWN
    print_or_write(arguments.out, told(compared, arguments.format))
    return _status(compared, arguments.deny_weaker)


def _read(arguments: argparse.Namespace) -> tuple[ReadVersion, ReadVersion]:
    if arguments.new is None and arguments.against is None:
        raise CliError("say what OLD is compared with: NEW, or with --against the revision at which it is OLD")
    path = arguments.new or arguments.old
    if arguments.against is not None:
        revision = Revision(arguments.old, arguments.against)
        model, given = revision.model(), arguments.old_properties
        properties = revision.properties(model) if given is None else read_properties(arguments.old, given, model)
        old = ReadVersion(revision.shown(), model, properties)
    else:
        refuse_twice(arguments.old_properties or arguments.properties, arguments.properties)
        old = _in_work_tree(arguments.old, arguments.old_properties or arguments.properties)
    return old, _in_work_tree(path, arguments.properties)


def _in_work_tree(path: str, properties: str | None) -> ReadVersion:
    model = read_spec(path)
    return ReadVersion(shown(path), model, read_properties(path, properties, model))


def _renamed(pairs: Collection[tuple[str, str]], old: Model, new: Model) -> dict[str, str]:
    """Return by request of OLD its name in NEW; `CliError` if a request does not exist, or two would be one."""
    for side, model, names in (("OLD", old, [a for a, _ in pairs]), ("NEW", new, [b for _, b in pairs])):
        for name in names:
            if name not in model.request:
                hint = did_you_mean(name, model.request)
                raise CliError(f"--rename: {side} has no request {name}{f'; {hint}' if hint else ''}")
            if names.count(name) > 1:
                raise CliError(f"--rename: {name} of {side} is named twice")
    renamed = dict(pairs)
    for name, other in pairs:
        if other in old.request and other not in renamed and other != name:
            raise CliError(f"--rename {name}={other}: OLD has a {other} of its own; say what it is called in NEW")
    return renamed


def _refuse_clashes(versions: Versions) -> None:
    clashes = list(versions.clashes())
    for clash in clashes:
        complain(f"exover: error: {clash}")
    if clashes:
        raise CliError("the two specs cannot be compared")


def _compared(old: ReadVersion, new: ReadVersion, renamed: dict[str, str], abc: str | None, limits: Limits) -> Compared:
    engines = portfolio(abc)
    with ProgressLine() as progress:
        with interrupted(limits, of_memory=True):
            progress("tables")
            sides = old.built(), new.built()

        def judged(side: DiffSide, share: Limits) -> Collection[Finding]:
            return property_findings(side.build, side.properties, progress, share, engines)

        def ask() -> tuple[Collection[Finding], Collection[Finding]]:
            half = replace(limits, deadline=limits.deadline - max(limits.left, 0) / 2) if limits.seconds else limits
            return judged(sides[0], half), judged(sides[1], limits)

        return diff(*sides, renamed, ask, engines.abc, progress, limits)


def _status(compared: Compared, deny_weaker: bool) -> ExitStatus:
    """Return 1 if `deny_weaker` and NEW launches what OLD refuses or lets wait, 3 if something is unknown, else 0."""
    if deny_weaker and compared.weaker:
        return ExitStatus.VIOLATED
    unknown = compared.undecided or any(each.unknown for each in compared.judged)
    return ExitStatus.UNKNOWN if unknown else ExitStatus.OK
