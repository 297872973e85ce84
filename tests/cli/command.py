"""The command as a process of its own, as users run it, and small specs for it."""

import os
import sys
from pathlib import Path

COMMAND = [sys.executable, "-m", "exover"]
SPEC = """spec demo;
poster battery: int in 0 .. 100 = 100 else 0;
module nd { request goto(x: real in 0 .. 9); request stop(); }
mutex drive: nd.stop over nd.goto because "a stop is a stop";
"""


def environment(**changes: str) -> dict[str, str]:
    """Return the environment without what would change how Python writes."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return kept | changes


DEAF = SPEC + "forbid deaf: battery >= 0 and active(nd.goto);\n"
"""No goto is ever launched."""
SHADOWED = SPEC + "mutex again: nd.stop over nd.goto;\n"
"""The second mutex is never the reason of anything."""


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}
