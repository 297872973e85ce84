"""The policy of a project for a spec, waivers and baseline, and the choice of checks that are asked."""

import argparse
import os
from collections.abc import Collection
from pathlib import Path

from exover.checks.questions import SEVERITY
from exover.checks.questions.choice import ALL, CheckSelection, asked, unknown
from exover.cli.files import read_source, read_text, shown, whole
from exover.cli.repository import CONFIG, folders_up
from exover.cli.status import CliError
from exover.places import refuse_irregular
from exover.report.config import NO_CONFIG, Config, read_config
from exover.report.json import UnreadableReport
from exover.report.policy import Baseline, Policy, read_baseline


def read_policy(arguments: argparse.Namespace, config: Config, asked: Collection[str] | None, spec: str) -> Policy:
    """Return the waivers and the baseline of a spec, for the checks that are asked; raises `CliError`."""
    waivers = tuple(waiver for waiver in config.waivers if asked is None or waiver.check in asked)
    return Policy(waivers, _baseline(arguments.baseline, spec, shown(arguments.spec)))


def configured(arguments: argparse.Namespace) -> Config:
    """Return the configuration of a spec, empty if none is found; mistakes are printed, and `CliError` is raised."""
    path = arguments.config or find_config(arguments.spec)
    if path is None:
        return NO_CONFIG
    source = read_source(path)
    return whole(*read_config(source, SEVERITY), source)


def asked_by(arguments: argparse.Namespace, config: Config) -> tuple[str, ...] | None:
    """Return the checks that are asked, None for all: by the choice of the command line, else of the configuration.

    Raises `CliError` if the command line names an unknown check, or no check is left.
    """
    choice = CheckSelection(tuple(arguments.only), tuple(arguments.skip), arguments.errors_only)
    for option, names in (("--only", choice.only), ("--skip", choice.skip)):
        for what, advice in unknown(names, SEVERITY):
            raise CliError(f"{option}: {what}; {advice}")
    choice = config.choice if choice == ALL else choice
    if choice == ALL:
        return None
    names = asked(choice, SEVERITY)
    if not names:
        raise CliError(
            "no check is left to ask: --only, --skip and --errors-only, or exover.toml, leave out all of them"
        )
    return names


def find_config(spec: str) -> str | None:
    """Return the nearest `exover.toml` from the folder of the spec up to the root of its repository, if there is one.

    The root is the folder that holds `.git`; outside a repository only the folder of the spec is searched. Raises
    `CliError` if the path found is no regular file.
    """
    for number, folder in enumerate(folders_up(Path(spec))):
        if os.path.lexists(folder / CONFIG):
            return _regular(str(Path(spec).parent / CONFIG if number == 0 else folder / CONFIG))
    return None


def _regular(path: str) -> str:
    try:
        refuse_irregular(path)
    except OSError as error:
        raise CliError(f"cannot read {path}: {error.strerror}") from error
    return path


def _baseline(path: str | None, spec: str, file: str) -> Baseline | None:
    if path is None:
        return None
    try:
        return read_baseline(read_text(path), spec, file)
    except UnreadableReport as reason:
        raise CliError(f"cannot use {shown(path)}: {reason}") from reason
