"""What the GitHub action runs: each spec is checked, and the first status that is not 0 is that of the action."""

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
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
    statuses = [check(spec, reports, arguments) for spec in specs]
    for log in reports.glob("*.sarif"):
        keep_alerts(log)
    return next((status for status in statuses if status), 0)


def names(text: str) -> Iterator[str]:
    """Yield the names in a text: a line that is one, blanks and all; of other lines the words, as a shell has them."""
    for line in map(str.strip, text.splitlines()):
        yield from [line] if line and os.path.exists(line) else shlex.split(line)


def check(spec: str, reports: Path, arguments: list[str]) -> int:
    """Return the status of `exover check` for a spec, or a folder of specs."""
    name = reports / os.path.normpath(spec).replace(os.sep, "-")
    outputs = [f"--output=sarif={name}.sarif", f"--output=junit={name}.xml"]
    command = [sys.executable, "-P", "-m", "exover", "check", spec, "--format=github", *outputs, *arguments]
    return subprocess.run(command, check=False).returncode


def keep_alerts(path: Path) -> None:
    """Leave out of a log what passes and what is suppressed: code scanning takes every result for an alert."""
    log = json.loads(path.read_text(encoding="utf-8"))
    for run in log["runs"]:
        run["results"] = [each for each in run["results"] if each["kind"] != "pass" and not each["suppressions"]]
    path.write_text(json.dumps(log, indent=1), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
