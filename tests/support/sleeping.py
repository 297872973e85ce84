"""Whether another process sleeps, as it does while it waits for input."""

import time
from pathlib import Path

PATIENCE = 60.0
"""Seconds after which a process that does not sleep has gone wrong."""


def await_sleep(pid: int) -> None:
    """Return once the first thread of a process sleeps; at once where the system does not tell."""
    state = Path(f"/proc/{pid}/task/{pid}/stat")
    until = time.monotonic() + PATIENCE
    while state.exists() and state.read_text().rpartition(")")[2].split()[0] != "S":
        assert time.monotonic() < until, f"the process {pid} does not come to sleep"
        time.sleep(0.01)
