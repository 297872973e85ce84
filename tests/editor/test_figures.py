"""What is measured of the server, with limits that a busy machine keeps, and that nobody else pays for it."""

import subprocess
import sys

from benchmarks import editor
from tests.support.command import environment

PATIENCE = 2_000.0
"""Milliseconds; `python -m benchmarks editor` holds it against 150."""


def test_diagnostics_of_a_thousand_lines_come_at_once() -> None:
    rows = list(editor.keys(3))
    assert len(editor.texts()) == 3
    assert len(rows) == 2 * 3, "by the clock, and of the processor"
    for row in rows:
        assert 0 < row.value < PATIENCE, row
        assert row.limit == 150
    for text, _ in editor.texts().values():
        assert 1_000 <= text.count("\n") <= 1_100


def test_help_imports_nothing_of_it() -> None:
    code = "import sys; from exover.cli.main import main; main(['--help']); print(*sys.modules, file=sys.stderr)"
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, env=environment(), check=True
    )
    modules = set(ended.stderr.split())
    assert "exover.cli.main" in modules
    assert not modules & {"pygls", "lsprotocol", "exover.editor", "exover.graph", "asyncio", "lark"}
