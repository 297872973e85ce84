"""`exover report`: check a spec and write an HTML page."""

import argparse

from exover.cli.check import examine
from exover.cli.engines import engines_of
from exover.cli.files import read_text, refuse_unwritable, shown, write_one
from exover.cli.status import CliError
from exover.cli.streams import out
from exover.model.model import Model
from exover.model.wire import Json
from exover.rendering import look
from exover.report.summary import Summary
from exover.report.text import last_line


def run(arguments: argparse.Namespace) -> int:
    """Write the page whatever the verdict is, print the verdict, and return the status that `exover check` has.

    Raises `CliError` if the page cannot be written; no part of it is left then.
    """
    refuse_unwritable(arguments.out)
    audit = _audit(arguments.audit) if arguments.audit else None
    examined = examine(argparse.Namespace(**vars(arguments), share=None), engines_of(arguments))
    if isinstance(examined.found, Summary) and examined.source:
        if audit:
            _refuse_other(audit, arguments.audit, examined.found.model)
        page = look(examined.found, examined.source, examined.built, audit)
        written = write_one(arguments.out, page.encode())
        out("".join(f"{line}\n" for line in (last_line(examined.found), *written)))
    return examined.status


def _audit(path: str) -> Json:
    """Return the audit in the output of `exover audit --format json`; raises `CliError` for any other file."""
    from exover.audit.json import NoAudit, read

    try:
        return read(read_text(path))
    except ValueError as error:
        raise CliError(f"{shown(path)} is no JSON: print the audit with --format json") from error
    except NoAudit as error:
        raise CliError(f"{shown(path)} is no audit: print one with `exover audit --format json`") from error


def _refuse_other(audit: Json, path: str, model: Model) -> None:
    """Raise `CliError` if an audit is by another spec, or by another version of it, with another sha256."""
    from exover.model.canonical import digest

    if audit["audit"] != model.name:
        raise CliError(f"{shown(path)} is an audit by the spec {audit['audit']}, not {model.name}")
    if audit["sha256"] != digest(model).hex():
        raise CliError(f"{shown(path)} is an audit by another version of {model.name}: audit the missions again")
