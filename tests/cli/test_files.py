"""Files are written whole, all of them, or nothing is."""

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from exover.cli.files import write_all
from exover.cli.status import Refused
from exover.emit.artefact import Artefact

TWO = (Artefact("a.h", b"1\n"), Artefact("b.c", b"2" * 5000))


def tree(folder: Path) -> dict[str, bytes | None]:
    paths = sorted(folder.rglob("*"))
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in paths}


def test_the_folder_is_made_and_files_are_replaced(tmp_path: Path) -> None:
    out = tmp_path / "x" / "y"
    for _ in range(2):
        assert write_all(str(out), TWO) == [str(out / "a.h"), str(out / "b.c")]
        assert tree(tmp_path) == {"x": None, "x/y": None, "x/y/a.h": b"1\n", "x/y/b.c": b"2" * 5000}
    mask = os.umask(0)
    os.umask(mask)
    assert (out / "a.h").stat().st_mode & 0o777 == 0o666 & ~mask


@contextmanager
def small_files() -> Iterator[None]:
    """Let no file grow beyond 1000 bytes, for the call alone: the test runner's own output may be a file as well."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_leaves_everything_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_bytes(b"old")
    before = tree(tmp_path)
    for out in (tmp_path, tmp_path / "new" / "er"):
        with pytest.raises(Refused, match=r"cannot write .*b\.c: File too large"), small_files():
            write_all(str(out), TWO)
        assert tree(tmp_path) == before


def test_a_folder_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "b.c").mkdir()
    with pytest.raises(Refused, match=r"cannot write .*b\.c: it is a directory"):
        write_all(str(tmp_path), TWO)
    assert tree(tmp_path) == {"b.c": None}


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "out").write_bytes(b"mine")
    for out in ("out", "out/deeper"):
        with pytest.raises(Refused, match=rf"cannot write .*{out}: (File exists|Not a directory)"):
            write_all(str(tmp_path / out), TWO)
    assert tree(tmp_path) == {"out": b"mine"}


def test_a_folder_that_takes_no_files() -> None:
    with pytest.raises(Refused, match="cannot write /proc/self/"):
        write_all("/proc/self", TWO)
    with pytest.raises(Refused, match="cannot write /proc/none: No such file or directory"):
        write_all("/proc/none", TWO)


def test_folders_below_are_made_or_left_away(tmp_path: Path) -> None:
    out, deep = tmp_path / "out", (Artefact("src/a", b"1"), *TWO)
    assert write_all(str(out), deep) == [str(out / "src/a"), str(out / "a.h"), str(out / "b.c")]
    assert tree(out) == {"src": None, "src/a": b"1", "a.h": b"1\n", "b.c": b"2" * 5000}
    before = tree(tmp_path)
    with pytest.raises(Refused, match=r"cannot write .*b\.c: File too large"), small_files():
        write_all(str(tmp_path / "new"), deep)
    assert tree(tmp_path) == before


def test_what_is_written_in_part_goes_when_the_user_interrupts(tmp_path: Path) -> None:
    def artefacts() -> Iterator[Artefact]:
        yield TWO[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_all(str(tmp_path / "out"), artefacts())
    assert tree(tmp_path) == {}
