"""`exover trace`: tell the run that a finding shows."""

import argparse
import os

from exover.cli.files import read_spec, read_text, write_all
from exover.cli.status import Refused, Status
from exover.cli.streams import complain, out
from exover.emit.artefact import Artefact
from exover.pipeline import picture
from exover.report.recorded import Recorded, Unreadable, choose, read, retell


def run(arguments: argparse.Namespace) -> int:
    """Print or write the run of the chosen finding; refuse one that the spec does not answer as recorded."""
    path = arguments.finding
    try:
        recorded = _choose(arguments, read(read_text(path)))
        if not (arguments.spec or recorded.file):
            raise Refused(f"{path} does not say which spec it is about; --spec SPEC does")
        model = read_spec(arguments.spec or recorded.file)
        story = retell(model, recorded)
    except Unreadable as reason:
        raise Refused(f"cannot use {path}: {reason}") from reason
    told = picture(recorded, story, arguments.format)
    if arguments.out is None:
        out(told)
    else:
        folder, name = os.path.split(arguments.out)
        write_all(folder or os.curdir, [Artefact(name, told.encode())])
    return Status.OK


def _choose(arguments: argparse.Namespace, found: tuple[Recorded, ...]) -> Recorded:
    """Return the first finding that is meant; say which others are there, or refuse if there is none."""
    named = choose(found, arguments.check, arguments.subject)
    if not named:
        raise Refused(f"{arguments.finding} has no such finding with a trace; with one: {_listed(found)}")
    first, *others = named
    if others:
        complain(f"exover: note: {first.title}; --check and --subject choose among {_listed(named)}")
    return first


def _listed(found: tuple[Recorded, ...]) -> str:
    """Return the findings by check and subject, not too many of them."""
    most = 20
    names = [f"{each.check} {each.subject}" for each in found[:most]]
    more = [f"{len(found) - most} more"] if len(found) > most else []
    return ", ".join(names + more) or "there is none at all"
