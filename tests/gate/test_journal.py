"""The decision log: whole lines, and what happens where they cannot be written."""

import json
import os
from pathlib import Path

import pytest

from exover.gate.journal import JournalFile, stamped


def test_lines_are_appended_with_their_time(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    for _ in range(2):
        file = JournalFile(str(path), print)
        stamped(file, clock=lambda: 12.3456789)('{"alarm": "stray", "detail": "é\ud800"}')
        file.close()
    lines = path.read_text("utf-8").splitlines()
    assert json.loads(lines[0]) == {"time": 12.345679, "alarm": "stray", "detail": "é\ud800"} and len(lines) == 2


def test_what_is_published_is_the_line_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    lines: list[bytes] = []
    times = iter((12.3456789, 13.0))
    file = JournalFile(str(path), print)
    journal = stamped(lines.append, file, clock=lambda: next(times))
    journal('{"alarm": "stray", "detail": "é"}')
    journal('{"refused": "a", "rule": "starting"}')
    file.close()
    assert path.read_bytes() == b"".join(lines) and len(lines) == 2
    assert lines[1] == b'{"time": 13.0, "refused": "a", "rule": "starting"}\n'


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device that is always full is of Linux")
def test_a_full_disk_is_told_once_and_counted(tmp_path: Path) -> None:
    told: list[str] = []
    journal = JournalFile("/dev/full", told.append)
    journal(b'{"a": 1}\n')
    journal(b'{"a": 2}\n')
    assert len(told) == 1 and "No space left" in told[0] and "decisions go on" in told[0]
    path = tmp_path / "log.jsonl"
    os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), journal._file)
    journal(b'{"a": 3}\n')
    lost, last = (json.loads(line) for line in path.read_text().splitlines())
    assert lost["lost"] == 2 and last["a"] == 3


def test_half_a_line_does_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    journal = JournalFile(str(tmp_path / "log"), told.append)
    journal(b'{"a": 1}\n')
    whole, real = (tmp_path / "log").read_bytes(), os.write
    monkeypatch.setattr(os, "write", lambda file, data: real(file, data[:5]))
    journal(b'{"a": 2}\n')
    assert (tmp_path / "log").read_bytes() == whole and len(told) == 1


def test_half_a_line_that_was_there_is_ended_first(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_bytes(b'{"a": 1}\n{"b')
    journal = JournalFile(str(path), print)
    journal(b'{"c": 2}\n')
    journal(b'{"d": 3}\n')
    journal.close()
    assert path.read_bytes() == b'{"a": 1}\n{"b\n{"c": 2}\n{"d": 3}\n'


def test_what_somebody_else_has_written_behind_half_a_line_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, told, real = tmp_path / "log", list[str](), os.write
    journal = JournalFile(str(path), told.append)
    journal(b'{"a": 1}\n')

    def half(file: int, data: bytes) -> int:
        written = real(file, data[:5])
        with path.open("ab") as other:
            other.write(b'{"of": "another"}\n')
        return written

    monkeypatch.setattr(os, "write", half)
    journal(b'{"a": 2}\n')
    assert path.read_bytes() == b'{"a": 1}\n{"a":{"of": "another"}\n' and len(told) == 1


def test_a_pipe_that_is_not_read_holds_nothing_up(tmp_path: Path) -> None:
    path, told = tmp_path / "log", list[str]()
    os.mkfifo(path)
    with pytest.raises(OSError, match="nobody reads it"):
        JournalFile(str(path), told.append)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    journal = JournalFile(str(path), told.append)
    line = b'{"a": "' + b"x" * 9000 + b'"}\n'
    for _ in range(100):
        journal(line)
    assert told == [f"cannot write {path}: what it holds is not read; decisions go on, and are not in it"]
    held = os.read(reader, 1 << 20)
    journal(b'{"b": 2}\n')
    *whole, half, lost, last, end = (held + os.read(reader, 1 << 20)).split(b"\n")
    assert {b"%s\n" % each for each in whole} == {line} and line.startswith(half) and len(half) < len(line)
    assert (json.loads(lost)["lost"], json.loads(last), end) == (100 - len(whole), {"b": 2}, b"")
    journal.close()
    os.close(reader)
