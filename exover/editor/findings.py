"""What the checks say of a text as it is in the editor: `exover check` in a process that the next key ends."""

import asyncio
import json
import os
import signal
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from exover.source import Source

STDIN = "<stdin>"
GRACE = 10.0
"""Seconds beyond its own that the process has to begin and to end."""


@dataclass(frozen=True, slots=True)
class Told:
    """A finding: where, by file, line and column, both from 1, whether it is violated, and how severe that is then."""

    file: str
    line: int
    column: int
    check: str
    subject: str
    violated: bool
    severity: Literal["error", "warning", "note"]
    message: str


async def findings(spec: Source, properties: Source | None, seconds: float) -> list[Told]:
    """Return what is found of a spec within so many seconds; nothing if the command fails.

    Sources are called by their paths. If it is cancelled, the process and what it has started are ended.
    """
    with TemporaryDirectory(prefix="exover-") as folder:
        command = [sys.executable, "-m", "exover", "check", "-", "--format", "json", "--jobs", "1"]
        names = {STDIN: spec.name}
        if properties:
            file = Path(folder, "editor.prop")
            file.write_text(properties.text, encoding="utf-8", newline="")
            names[str(file)] = properties.name
            command += ["--properties", str(file)]
        printed = await _printed([*command, f"--timeout={seconds}"], spec, seconds + GRACE)
    return _told(names, printed)


async def _printed(command: list[str], spec: Source, seconds: float) -> bytes:
    """Return what a command prints that reads a spec, in the folder of that; nothing if it takes longer."""
    pipe, nowhere = asyncio.subprocess.PIPE, asyncio.subprocess.DEVNULL
    here = Path(spec.name).parent
    process = await asyncio.create_subprocess_exec(
        *command, stdin=pipe, stdout=pipe, stderr=nowhere, cwd=here, start_new_session=True
    )
    try:
        printed, _ = await asyncio.wait_for(process.communicate(spec.text.encode()), seconds)
    except TimeoutError:
        return b""
    finally:
        if process.returncode is None:
            _kill(process)
    return printed


def _kill(process: asyncio.subprocess.Process) -> None:
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def _told(names: Mapping[str, str], printed: bytes) -> list[Told]:
    """Return the findings of a report that are known and have a place; nothing if this is no report.

    `names`: how the files are called that the report knows by other names.
    """
    try:
        found = json.loads(printed)["findings"]
    except (ValueError, KeyError, TypeError):
        return []
    told = []
    for each in found:
        where = each["location"]
        if each["verdict"] != "unknown" and where and where["line"]:
            violated = each["verdict"] == "violated"
            place = names.get(where["file"], where["file"]), where["line"], where["column"]
            told.append(Told(*place, each["check"], each["subject"], violated, each["severity"], each["message"]))
    return told
