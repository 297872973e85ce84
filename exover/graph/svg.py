"""A graph in the DOT language, laid out and drawn as SVG by Graphviz."""

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from exover.engines.process import NotRunnable, run

PROGRAM = "dot"
PATIENCE = 60.0
"""The seconds for a layout, which may not end for thousands of edges."""


def find() -> str:
    """Return the program of Graphviz on PATH; `NotRunnable` if there is none."""
    program = shutil.which(PROGRAM)
    if program is None:
        raise NotRunnable("no dot was found on PATH")
    return program


def draw(text: str) -> str:
    """Return a DOT text as SVG. Raises `NotRunnable` if Graphviz is missing or fails, and `TimeoutError`."""
    program = find()
    with TemporaryDirectory(prefix="exover-") as folder:
        Path(folder, "graph.dot").write_text(text, encoding="utf-8")
        ended = run([program, "-Tsvg", "graph.dot"], Path(folder), seconds=PATIENCE)
    if ended.status:
        raise NotRunnable(f"{program} ended with status {ended.status}: {ended.complained.strip()}")
    return ended.printed
