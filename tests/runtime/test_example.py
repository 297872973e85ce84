"""The examples of docs/runtime.md, compiled and run as they stand; and its tables, which name every field there is."""

import shutil
from dataclasses import fields
from pathlib import Path

from exover.ocrd.packing import SECTIONS
from tests.docs.pages import play
from tests.runtime.compiling import ROOT

PAGE = ROOT / "docs" / "runtime.md"


def test_the_examples_run(tmp_path: Path) -> None:
    shutil.copy(ROOT / "specs" / "rover.exo", tmp_path)
    played = [block.language for block in play(PAGE, tmp_path)]
    assert played == [*2 * ["c", "sh", "text"], "rust", "text"]


def test_every_field_of_the_tables_is_described() -> None:
    chapters = PAGE.read_text(encoding="utf-8").split("## The bytes")[1].split("\n**")
    for name, kind in SECTIONS:
        (chapter,) = [text for text in chapters if text.startswith(f"{name}**")]
        assert [field.name for field in fields(kind) if f"`{field.name}`" not in chapter] == []
