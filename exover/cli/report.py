"""`exover report`: check a spec and write a page to look at."""

import argparse
import json
import os
from typing import Any

from exover.cli.check import examine
from exover.cli.engines import engines_of
from exover.cli.files import read_text, refuse_twice, refuse_unwritable, shown, write_one
from exover.cli.status import CliError
from exover.cli.streams import out
from exover.rendering import look
from exover.report.summary import Summary
from exover.report.text import last_line


def run(arguments: argparse.Namespace) -> int:
    """Write the page whatever the checks say, print their outcome, and return the status that `exover check` has.

    Raises `CliError` if the page cannot be written; nothing is left of it then.
    """
    if os.path.realpath(arguments.out) == os.path.realpath(arguments.spec):
        raise CliError(f"a report cannot be written over the spec {arguments.spec}")
    refuse_twice(arguments.spec, arguments.audit)
    refuse_unwritable(arguments.out)
    audit = _audit(arguments.audit) if arguments.audit else None
    examined = examine(argparse.Namespace(**vars(arguments), share=None), engines_of(arguments))
    if isinstance(examined.found, Summary) and examined.source:
        name = examined.found.model.name
        if audit and audit["audit"] != name:
            raise CliError(f"{arguments.audit} is an audit by the spec {audit['audit']}, not {name}")
        page = look(examined.found, examined.source, examined.built, audit)
        written = write_one(arguments.out, page.encode())
        out("".join(f"{line}\n" for line in (last_line(examined.found), *written)))
    return examined.status


def _audit(path: str) -> dict[str, Any]:
    """Return what `exover audit --format json` has printed; `CliError` if the file holds something else."""
    try:
        found = json.loads(read_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise CliError(f"{shown(path)} is no JSON: print the audit with --format json") from error
    if not _is_audit(found):
        raise CliError(f"{shown(path)} is no audit: print one with `exover audit --format json`")
    return dict(found)


def _is_audit(found: object) -> bool:
    """Return whether an object has what the page reads."""
    if not isinstance(found, dict) or found.get("tool") != "exover" or not isinstance(found.get("audit"), str):
        return False
    missions, total = found.get("missions"), found.get("total")
    if not isinstance(missions, list) or not isinstance(total, dict) or not isinstance(found.get("outcome"), str):
        return False
    if not all(isinstance(total.get(key), dict) for key in ("asks", "rules")):
        return False
    return all(
        isinstance(each, dict) and ("error" in each or isinstance(each.get("diverged"), dict)) for each in missions
    )
