"""What the GitHub action runs: each spec is checked, and the first status that is not 0 is that of the action."""

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from itertools import chain, count
from pathlib import Path


def main() -> int:
    """Check the specs of `SPECS` with the further `ARGUMENTS`, write to `REPORTS`, and return the status."""
    reports = Path(os.environ["REPORTS"])
    try:
        specs, arguments = list(names(os.environ["SPECS"])), shlex.split(os.environ["ARGUMENTS"])
    except ValueError as error:  # a quotation that does not end
        print(f"::error title=exover::the inputs of the action cannot be read: {error}")
        return 2
    if not specs:
        print("::error title=exover::the input `specs` of the action names none")
        return 2
    statuses = [check(spec, reports / name, arguments) for spec, name in zip(specs, report_names(specs), strict=True)]
    return next((status for status in statuses if status), 0)


def names(text: str) -> Iterator[str]:
    """Yield the names in a text: a line that is one, blanks and all; of other lines the words, as a shell has them."""
    for line in map(str.strip, text.splitlines()):
        yield from [line] if line and os.path.exists(line) else shlex.split(line)


def report_names(specs: list[str]) -> list[str]:
    """Return a name for the reports of each spec: its path with `-` for each separator; a number parts equal ones."""
    found: list[str] = []
    for spec in specs:
        name = os.path.normpath(spec).replace(os.sep, "-")
        others = (f"{name}-{number}" for number in count(2))
        found.append(next(each for each in chain([name], others) if each not in found))
    return found


def check(spec: str, report: Path, arguments: list[str]) -> int:
    """Write the reports on a spec, or a folder of specs, and return the status of `exover check`."""
    log = Path(f"{report}.sarif")
    log.unlink(missing_ok=True)
    outputs = [f"--output=sarif={log}", f"--output=junit={report}.xml"]
    command = [sys.executable, "-P", "-m", "exover", "check", spec, "--format=github", *outputs, *arguments]
    status = subprocess.run(command, check=False).returncode
    if log.is_file():
        keep_alerts(log)
    return status


def keep_alerts(path: Path) -> None:
    """Leave out of a log what passes and what is suppressed: code scanning takes every result for an alert."""
    log = json.loads(path.read_text(encoding="utf-8"))
    for run in log["runs"]:
        run["results"] = [each for each in run["results"] if each["kind"] != "pass" and not each["suppressions"]]
    path.write_text(json.dumps(log, indent=1), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
