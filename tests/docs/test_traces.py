"""The examples of docs/traces.md, run as they stand."""

import xml.etree.ElementTree as ET
from pathlib import Path

from tests.docs.pages import ROOT, play


def test_the_page_on_traces_runs(tmp_path: Path) -> None:
    played = list(play(ROOT / "docs" / "traces.md", tmp_path))
    assert sum(block.language == "sh" for block in played) == 4
    assert sum(block.language == "text" for block in played) == 2
    assert ET.parse(tmp_path / "run.svg").getroot().get("role") == "img"
    assert (tmp_path / "run.vcd").read_text(encoding="utf-8").startswith("$version exover ")
