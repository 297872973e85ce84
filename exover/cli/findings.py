"""A finding with its run, chosen from a report by the options of a command."""

import argparse
from collections.abc import Iterable

from exover.cli.files import read_text, shown
from exover.cli.status import CliError
from exover.cli.streams import complain
from exover.diagnostics import quote
from exover.escaping import visible
from exover.report.json import UnreadableReport
from exover.report.recorded import Recorded, choose, read


def chosen(arguments: argparse.Namespace) -> tuple[Recorded, str]:
    """Return the first finding that the options choose, and its spec: the one given, else that of the report.

    A note names the other findings; raises `CliError` if there is no finding, or no spec is known.
    """
    path = shown(arguments.finding)
    try:
        found = read(read_text(arguments.finding))
    except UnreadableReport as reason:
        raise CliError(f"cannot use {path}: {reason}") from reason
    recorded = _first(arguments, found)
    spec = arguments.spec or recorded.file
    if not spec:
        raise CliError(f"{path} does not say which spec it is about: name the spec as well")
    return recorded, spec


def _first(arguments: argparse.Namespace, found: tuple[Recorded, ...]) -> Recorded:
    named = choose(found, arguments.check, arguments.subject)
    path = shown(arguments.finding)
    if not named:
        checks = tuple(dict.fromkeys(each.check for each in found))
        if arguments.check is not None and arguments.check not in checks:
            with_one = ", ".join(checks) or "none at all"
            raise CliError(f"{path} has no finding of {quote(arguments.check)} with a trace; with one: {with_one}")
        raise CliError(f"{path} has no such finding with a trace; with one: {_listed(found)}")
    first, *others = named
    if others:
        complain(visible(f"exover: note: {first.title}; --check and --subject choose among {_listed(named)}"))
    return first


def _listed(found: Iterable[Recorded]) -> str:
    """Return the findings by check and subject, at most 20 of them."""
    most = 20
    names = [f"{each.check} {each.subject}" for each in found]
    more = [f"{len(names) - most} more"] if len(names) > most else []
    return ", ".join(names[:most] + more) or "there is none at all"
