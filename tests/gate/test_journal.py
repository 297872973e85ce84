"""The decision log: whole lines, and what happens where they cannot be written."""

import json
import os
from pathlib import Path

import pytest

from exover.gate.journal import JournalFile, published


def test_lines_are_appended_with_their_time(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    for _ in range(2):
        journal = JournalFile(str(path), print, lambda: 12.3456789)
        journal({"alarm": "stray", "detail": "é\ud800"})
        journal.close()
    lines = path.read_text("utf-8").splitlines()
    assert json.loads(lines[0])["time"] == 12.345679 and len(lines) == 2


def test_what_is_published_is_the_line_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    lines: list[str] = []
    file = JournalFile(str(path), print, lambda: 99.0)
    journal = published(file, lines.append, lambda: 12.3456789)
    journal({"alarm": "stray", "detail": "é\ud800"})
    journal({"refused": "a", "rule": "starting"})
    file.close()
    assert path.read_text("utf-8").splitlines() == lines and len(lines) == 2
    assert json.loads(lines[1]) == {"time": 12.345679, "refused": "a", "rule": "starting"}


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device that is always full is of Linux")
def test_a_full_disk_is_told_once_and_counted(tmp_path: Path) -> None:
    told: list[str] = []
    journal = JournalFile("/dev/full", told.append)
    journal({"a": 1})
    journal({"a": 2})
    assert len(told) == 1 and "No space left" in told[0] and "decisions go on" in told[0]
    path = tmp_path / "log.jsonl"
    os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), journal._file)
    journal({"a": 3})
    lost, last = (json.loads(line) for line in path.read_text().splitlines())
    assert lost["lost"] == 2 and last["a"] == 3


def test_half_a_line_does_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    journal = JournalFile(str(tmp_path / "log"), told.append)
    journal({"a": 1})
    whole, real = (tmp_path / "log").read_bytes(), os.write
    monkeypatch.setattr(os, "write", lambda file, data: real(file, data[:5]))
    journal({"a": 2})
    assert (tmp_path / "log").read_bytes() == whole and len(told) == 1
