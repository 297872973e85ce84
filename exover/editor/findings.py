"""What the checks say of a text as it is in the editor: `exover check` in a process that the next key ends."""

import asyncio
import json
import os
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

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


async def findings(path: str, text: str, properties: str | None, seconds: float) -> list[Told]:
    """Return what is found of a spec within so many seconds; nothing if the command fails.

    Files are called by their paths. If it is cancelled, the process and what it has started are ended.
    """
    named = ["--properties", properties] if properties else []
    command = [sys.executable, "-m", "exover", "check", "-", "--format", "json", "--jobs", "1"]
    process = await asyncio.create_subprocess_exec(
        *command,
        *named,
        f"--timeout={seconds}",
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        cwd=Path(path).parent,
        start_new_session=True,
    )
    try:
        printed, _ = await asyncio.wait_for(process.communicate(text.encode()), seconds + GRACE)
    except TimeoutError:
        return []
    finally:
        if process.returncode is None:
            _kill(process)
    return _told(path, printed)


def _kill(process: asyncio.subprocess.Process) -> None:
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def _told(path: str, printed: bytes) -> list[Told]:
    """Return the findings of a report that are known and have a place; nothing if this is no report."""
    try:
        found = json.loads(printed)["findings"]
    except (ValueError, KeyError, TypeError):
        return []
    told = []
    for each in found:
        where = each["location"]
        if each["verdict"] != "unknown" and where and where["line"]:
            file = (
                path if where["file"] == STDIN else os.path.abspath(os.path.join(os.path.dirname(path), where["file"]))
            )
            violated = each["verdict"] == "violated"
            place = file, where["line"], where["column"]
            told.append(Told(*place, each["check"], each["subject"], violated, each["severity"], each["message"]))
    return told
