"""What compilers made is taken again, in this run of the tests and in the next, and nothing else is."""

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from exover.engines.compiler import compile_in
from tests.support import compiled
from tests.support.compiled import across_runs, kept_in

COPY = ("sh", "-c", 'cat source.c >> made; echo once >> "$COUNT"')


@pytest.fixture(autouse=True)
def _counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COUNT", str(tmp_path / "count"))
    monkeypatch.setattr(compiled, "_versions", lambda: "these")


def made(folder: Path, text: str, command: Sequence[str] = COPY) -> str:
    """Return what such a compiler makes of a source."""
    folder.mkdir()
    (folder / "source.c").write_text(text)
    compile_in(folder, command, "made")
    return (folder / "made").read_text()


def test_the_same_command_on_the_same_sources_is_run_once(tmp_path: Path) -> None:
    with kept_in(tmp_path / "store"):
        found = [made(tmp_path / str(number), text) for number, text in enumerate(("a", "a", "b", "a"))]
        assert found == ["a", "a", "b", "a"]
        assert made(tmp_path / "4", "a", [*COPY[:2], f"{COPY[2]}; true"]) == "a"
    assert (tmp_path / "count").read_text() == "once\n" * 3


@pytest.mark.parametrize("word", ["-I{}", "{}/source.c", "below/source.c", "../source.c"])
def test_what_reads_other_folders_is_run_each_time(word: str, tmp_path: Path) -> None:
    with kept_in(tmp_path / "store"):
        for number in range(2):
            made(tmp_path / str(number), "a", [*COPY, word.format(tmp_path)])
    assert (tmp_path / "count").read_text() == "once\n" * 2


def test_another_run_takes_what_was_made_if_the_compilers_are_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    for number, times in ((0, 1), (1, 1), (2, 2)):
        if number == 2:
            monkeypatch.setattr(compiled, "_versions", lambda: "others")
        with kept_in(across_runs(kept)):
            assert made(tmp_path / str(number), "a") == "a"
        assert (tmp_path / "count").read_text() == "once\n" * times
        assert len(list(kept.iterdir())) == 1


def test_what_was_used_last_is_kept(tmp_path: Path) -> None:
    store = across_runs(tmp_path / "kept")
    with kept_in(store):
        for number, text in enumerate(("a" * 100, "b" * 100, "c" * 100)):
            made(tmp_path / str(number), text)
            for each in store.iterdir():
                os.utime(each, (each.stat().st_mtime - 100,) * 2)
        made(tmp_path / "3", "a" * 100)
    room = sum(file.stat().st_size for each in list(store.iterdir())[:2] for file in (each, *each.glob("*")))
    assert across_runs(tmp_path / "kept", room) == store
    assert {next(each.glob("made")).read_text()[0] for each in store.iterdir()} == {"a", "c"}
