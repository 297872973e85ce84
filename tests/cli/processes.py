"""Commands that do not end by themselves, and the processes that they leave."""

import time
from pathlib import Path

from tests.support.hanging import HANG


def in_session(session: int) -> list[int]:
    """Return the processes of a session, those of children that have lost their parent among them."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def gone(session: int) -> bool:
    until = time.monotonic() + 30
    while in_session(session) and time.monotonic() < until:
        time.sleep(0.02)
    return not in_session(session)


PROGRAM = f"""
{HANG}
import os
import sys
import time
from pathlib import Path
from exover.checks.schedule import plan
from exover.checks.questions import safety
from exover.checks.questions.question import Check, requests
from exover.cli.main import main

def decide(context, question):
    Path(f"begun-{{os.getpid()}}").touch()
    CALL

plan.CHECKS = (Check("endless", "error", "it ends", requests, decide, safety.claim), *plan.CHECKS)
sys.exit(main(sys.argv[1:]))
"""
ENDLESS = PROGRAM.replace("CALL", "hang()")
"""The command with a check that never ends, and that no signal handler of Python interrupts."""
SLEEPING = PROGRAM.replace("CALL", "time.sleep(300)")
"""The same with a check that Ctrl-C interrupts."""


def await_begun(folder: Path, number: int) -> None:
    """Wait until so many processes of a command that runs in a folder are in the check that never ends."""
    until = time.monotonic() + 60
    while len(list(folder.glob("begun-*"))) < number:
        assert time.monotonic() < until
        time.sleep(0.02)


FOREVER = "#!/bin/sh\nsleep 300 &\nwait\n"
"""A program of two processes that never ends."""


def processes(token: str) -> list[int]:
    """Return the processes with this token, those that have lost their parent or begun a session among them."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if f"TOKEN={token}".encode() in (process / "environ").read_bytes():
                state = (process / "stat").read_text().rpartition(")")[2].split()[0]
                found += [int(process.name)] if state != "Z" else []
        except OSError:
            continue
    return found
