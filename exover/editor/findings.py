"""Runs `exover check` on a text as it is in the editor, in a process that is ended when its task is cancelled."""

import asyncio
import json
import os
import signal
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Literal

from exover.dataclass import dataclass
from exover.editor.text import EditorText
from exover.engines.scratch import Scratch
from exover.source import STDIN, Source
from exover.syntax.includes import Gathered, one_text, original

GRACE = 10.0
"""Seconds that the process has to begin and to end, besides those for the checks."""


@dataclass(frozen=True, slots=True)
class PlacedFinding:
    """A finding: file, line and column of its subject, both from 1; whether it is violated, and how severe that is."""

    file: str
    line: int
    column: int
    check: str
    subject: str
    violated: bool
    severity: Literal["error", "warning", "note"]
    message: str


@dataclass(frozen=True, slots=True)
class TextFindings:
    """The findings of a spec, and the texts that they are of."""

    texts: list[list[str]]
    told: list[PlacedFinding]


async def findings(spec: Gathered, properties: Source | None, seconds: float) -> list[PlacedFinding]:
    """Return the findings of a spec within so many seconds; none if the command fails.

    The command reads the editor's text with all parts as one text, and the places in it are mapped back to the files.

    Sources are named by their paths. If the task is cancelled, the process and its children are ended, and the folder
    with their temporary files is removed.
    """
    with Scratch() as scratch:
        if not scratch.folder:
            return []
        command = [sys.executable, "-P", "-m", "exover", "check", "-", "--format", "json", "--jobs", "1"]
        names = {}
        if properties:
            file = Path(scratch.folder, "editor.prop")
            file.write_text(properties.text, encoding="utf-8", newline="")
            names[str(file)] = properties.name
            command += ["--properties", str(file)]
        text, here = one_text(spec), Path(spec.source.name).parent
        kept = os.environ | {"TMPDIR": scratch.folder}
        printed = await _printed([*command, f"--timeout={seconds}"], text, here, kept, seconds + GRACE)
    return [_led_back(spec, text, each) for each in _told(names, printed)]


def _led_back(spec: Gathered, text: str, told: PlacedFinding) -> PlacedFinding:
    """Return a finding with its place in the one text mapped back to the file."""
    if told.file != STDIN:
        return told
    offset = EditorText(text).line(told.line - 1).start + told.column - 1
    return replace(told, **spec.source.place(original(spec, offset))._asdict())


async def _printed(command: list[str], text: str, here: Path, environment: Mapping[str, str], seconds: float) -> bytes:
    """Return the output of a command that reads a text on standard input; empty if it takes more than `seconds`."""
    pipe, nowhere = asyncio.subprocess.PIPE, asyncio.subprocess.DEVNULL
    process = await asyncio.create_subprocess_exec(
        *command, stdin=pipe, stdout=pipe, stderr=nowhere, cwd=here, env=environment, start_new_session=True
    )
    try:
        printed, _ = await asyncio.wait_for(process.communicate(text.encode()), seconds)
    except TimeoutError:
        return b""
    finally:
        if process.returncode is None:
            _kill(process)
            await process.wait()
    return printed


def _kill(process: asyncio.subprocess.Process) -> None:
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def _told(names: Mapping[str, str], printed: bytes) -> list[PlacedFinding]:
    """Return the findings of a JSON report that are not `unknown` and have a place; none if this is no report.

    `names`: the real names of files that have another name in the report.
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
            told.append(
                PlacedFinding(*place, each["check"], each["subject"], violated, each["severity"], each["message"])
            )
    return told
