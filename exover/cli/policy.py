"""What a project has decided about findings: its waivers and its baseline, read from their files."""

import argparse
from pathlib import Path

from exover.checks import CHECKS
from exover.cli.files import read_source, read_text
from exover.cli.status import Refused
from exover.cli.streams import complain
from exover.diagnostics import render_all
from exover.report.config import read_config
from exover.report.policy import Baseline, Policy, Unusable, Waiver, read_baseline

CONFIG = "exover.toml"


def read_policy(arguments: argparse.Namespace, spec: str) -> Policy:
    """Return the waivers and the baseline of a spec; what is wrong is told, and `Refused` is raised."""
    return Policy(_waivers(arguments), _baseline(arguments.baseline, spec))


def _waivers(arguments: argparse.Namespace) -> tuple[Waiver, ...]:
    path = arguments.config or find_config(arguments.spec)
    if path is None:
        return ()
    source = read_source(path)
    waivers, diagnostics = read_config(source, {check.name: check.severity for check in CHECKS})
    if diagnostics:
        complain(render_all(diagnostics, source))
        raise Refused(f"{path} has {'a mistake' if len(diagnostics) == 1 else 'mistakes'}")
    return waivers


def find_config(spec: str) -> str | None:
    """Return the nearest `exover.toml` from the folder of the spec up to the root of its repository, if there is one.

    The root is the folder that holds `.git`; outside of a repository only the folder of the spec counts.
    """
    folders = list(Path(spec).absolute().parents)
    roots = [number for number, folder in enumerate(folders) if (folder / ".git").exists()]
    for number, folder in enumerate(folders[: roots[0] + 1 if roots else 1]):
        if (folder / CONFIG).is_file():
            return str(Path(spec).parent / CONFIG if number == 0 else folder / CONFIG)
    return None


def _baseline(path: str | None, spec: str) -> Baseline | None:
    if path is None:
        return None
    try:
        return read_baseline(read_text(path), spec)
    except Unusable as reason:
        raise Refused(f"cannot use {path}: {reason}") from reason
