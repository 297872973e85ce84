"""The README and the tutorial say what the tool says today."""

import re
from pathlib import Path

from tests.docs.pages import ROOT, Block, blocks, fill, play, run
from tests.support.needed import needs_cudd


def test_the_readme_runs_and_its_spec_holds(tmp_path: Path) -> None:
    fill(tmp_path)
    played = list(play(ROOT / "README.md", tmp_path))
    specs = [block.info for block in played if block.language == "exo"]
    assert sum(block.language == "sh" for block in played) >= 4
    assert specs
    for spec in specs:
        run(Block("sh", "", f"exover check {spec}"), tmp_path)


@needs_cudd
def test_the_tutorial_runs(tmp_path: Path) -> None:
    played = list(play(ROOT / "docs" / "tutorial.md", tmp_path))
    assert sum(block.language == "sh" for block in played) >= 4


def test_the_tutorial_writes_the_rover() -> None:
    rover, *_ = [block.text for block in blocks(ROOT / "docs" / "tutorial.md") if block.info == "rover.exo"]
    assert (ROOT / "specs" / "rover.exo").read_text(encoding="utf-8").endswith(rover)
    assert rover == (ROOT / "tests" / "vectors" / "rover.exo").read_text(encoding="utf-8")


def test_excerpts_of_the_tutorial_stand_in_its_specs() -> None:
    page = [block for block in blocks(ROOT / "docs" / "tutorial.md") if block.language == "exo"]
    written = {line.strip() for block in page if block.info for line in block.text.splitlines()}
    excerpts = [line.strip() for block in page if not block.info for line in block.text.splitlines()]
    assert excerpts
    assert [line for line in excerpts if line not in written] == []


def test_links_between_pages_lead_somewhere() -> None:
    pages = [ROOT / "README.md", ROOT / "properties" / "README.md"]
    pages += [*(ROOT / "docs").glob("*.md"), *(ROOT / "specs").rglob("*.md")]
    texts = {page: re.sub(r"`[^`]*`", "", page.read_text(encoding="utf-8")) for page in pages}
    links = [(page, link) for page, text in texts.items() for link in re.findall(r"\]\((?!https?:)([^)#]+)\)", text)]
    assert len(links) > 10
    assert [(str(page), link) for page, link in links if not (page.parent / link).exists()] == []
