"""`exover check`: print the report from the cache, or check; with `--watch`, again whenever a file changes."""

import argparse
import time
from importlib import import_module

from exover.cli.report_cache import entry, recall, state
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out

PAUSE = 0.3
"""The seconds between two polls of the files."""
ENDED = (ExitStatus.INTERRUPTED, ExitStatus.TERMINATED)


def run(arguments: argparse.Namespace) -> int:
    """Print the report and return its status."""
    if arguments.watch:
        return _watch(arguments)
    kept = entry(arguments)
    found = recall(kept) if kept else None
    if found is not None:
        out(found.text)
        return found.status
    decided: int = import_module("exover.cli.check").run(arguments, kept)
    return decided


def _watch(arguments: argparse.Namespace) -> int:
    """Check each spec again whenever its files have changed, until a signal ends it; return the status for that."""
    from exover.cli.main import ExitGuard
    from exover.cli.specs import specs_of

    if "-" in arguments.specs:
        raise CliError("--watch is for files, not for standard input")
    seen: dict[str, str] = {}
    while True:
        found = {spec: state(arguments, spec) for spec in specs_of(arguments.specs).files}
        changed = [spec for spec, now in found.items() if seen.get(spec) != now]
        for spec in changed:
            outcome = ExitGuard()
            with outcome:
                alone = {"specs": [spec], "watch": False, "watched": True, "started": time.monotonic()}
                outcome.status = run(argparse.Namespace(**{**vars(arguments), **alone}))
            if outcome.status in ENDED:
                return outcome.status
        if changed:
            complain("exover: waiting for changes; Ctrl-C ends")
        seen = found
        time.sleep(PAUSE)
