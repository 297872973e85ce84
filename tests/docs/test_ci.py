"""The commands of the page about gates, run as they stand."""

import shutil
from pathlib import Path

from tests.docs.pages import ROOT, play


def test_the_page_about_gates_runs(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "specs", tmp_path / "specs")
    played = list(play(ROOT / "docs" / "ci.md", tmp_path))
    assert sum(block.language == "sh" for block in played) >= 5
    assert {path.suffix for path in (tmp_path / "reports").iterdir()} == {".sarif", ".xml", ".json"}
