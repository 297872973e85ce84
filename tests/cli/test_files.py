"""Files are written whole, all of them, or nothing is."""

import json
import os
import resource
import shlex
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from exover.cli import check
from exover.cli.files import write_all
from exover.cli.replacing import replacing
from exover.cli.status import CliError
from exover.emit.artefact import Artefact
from tests.cli.specs import DEAF
from tests.support import warm
from tests.support.command import Run, environment

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
        with pytest.raises(CliError, match=r"cannot write .*b\.c: File too large"), small_files():
            write_all(str(out), TWO)
        assert tree(tmp_path) == before


def test_a_folder_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "b.c").mkdir()
    with pytest.raises(CliError, match=r"cannot write .*b\.c: it is a directory"):
        write_all(str(tmp_path), TWO)
    assert tree(tmp_path) == {"b.c": None}


# ---- what is no regular file ----


def test_links_are_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "old").write_bytes(b"old")
    (tmp_path / "a.h").symlink_to("there/old")
    (tmp_path / "b.c").symlink_to("there/new")
    assert write_all(str(tmp_path), TWO) == [str(tmp_path / "a.h"), str(tmp_path / "b.c")]
    assert (tmp_path / "a.h").is_symlink()
    assert (tmp_path / "b.c").is_symlink()
    assert tree(tmp_path / "there") == {"old": b"1\n", "new": b"2" * 5000}


def test_links_that_lead_to_one_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "old").write_bytes(b"old")
    (tmp_path / "a.h").symlink_to("old")
    (tmp_path / "b.c").symlink_to("old")
    with pytest.raises(CliError, match=r"cannot write .*b\.c: it is the same file as .*a\.h"):
        write_all(str(tmp_path), TWO)
    assert tree(tmp_path) == {"old": b"old", "a.h": b"old", "b.c": b"old"}


def test_a_file_of_somebody_else_is_neither_in_the_way_nor_removed(tmp_path: Path) -> None:
    stranger = f".a.h.{os.getpid()}"
    (tmp_path / stranger).write_bytes(b"mine")
    write_all(str(tmp_path), TWO)
    assert tree(tmp_path) == {stranger: b"mine", "a.h": TWO[0].content, "b.c": TWO[1].content}


def test_files_that_are_whole_take_their_places_or_are_gone(tmp_path: Path) -> None:
    file = tmp_path / "a"
    with pytest.raises(KeyboardInterrupt), replacing(str(file)) as temporary:
        Path(temporary).write_bytes(b"half")
        assert os.path.dirname(temporary) == str(tmp_path)
        raise KeyboardInterrupt
    assert tree(tmp_path) == {}
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError), replacing(str(tmp_path / "folder")) as temporary:
        Path(temporary).write_bytes(b"whole")
    assert tree(tmp_path) == {"folder": None}
    with replacing(str(file), private=True) as temporary:
        Path(temporary).write_bytes(b"whole")
        assert not file.exists()
    assert (file.read_bytes(), file.stat().st_mode & 0o777) == (b"whole", 0o600)


def test_a_link_that_leads_nowhere(tmp_path: Path) -> None:
    for name, target, why in (("a.h", "a.h", "Too many levels"), ("b.c", "none/b.c", "No such file")):
        (tmp_path / name).symlink_to(target)
        with pytest.raises(CliError, match=rf"cannot write .*{name}: {why}"):
            write_all(str(tmp_path), TWO)
        (tmp_path / name).unlink()
    assert tree(tmp_path) == {}


def test_devices_stay_devices(tmp_path: Path) -> None:
    for device in ("full", "null"):
        (tmp_path / "a.h").unlink(missing_ok=True)
        (tmp_path / "a.h").symlink_to(f"/dev/{device}")
        if device == "full":
            with pytest.raises(CliError, match=r"cannot write .*a\.h: No space left on device"):
                write_all(str(tmp_path), TWO)
            assert not (tmp_path / "b.c").exists()
        else:
            write_all(str(tmp_path), TWO)
            assert (tmp_path / "b.c").read_bytes() == TWO[1].content
        assert Path(f"/dev/{device}").is_char_device()
        assert not list(Path("/dev").glob(f".{device}.*"))


def test_a_pipe_is_written_into(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.h")
    reader = os.open(tmp_path / "a.h", os.O_RDONLY | os.O_NONBLOCK)
    write_all(str(tmp_path), TWO)
    assert os.read(reader, 100) == TWO[0].content
    os.close(reader)
    assert (tmp_path / "a.h").is_fifo()


def shell(command: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        ["bash", "-c", command.replace("exover", shlex.quote(str(warm.command())))],
        cwd=folder, env=environment(), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


def test_every_option_that_writes_takes_process_substitution(spec: Path, tmp_path: Path) -> None:
    spec.write_text(DEAF + "forbid low: battery < 20 and active(nd.stop);\n")
    done = shell("exover check demo.exo --output json=>(cat >a.json) --certificate >(cat >a.cert); wait $!", tmp_path)
    assert (done.returncode, done.stderr) in ((0, ""), (1, ""))
    report = wait_for(tmp_path / "a.json")
    assert json.loads(report)["spec"] == "demo"
    assert wait_for(tmp_path / "a.cert")
    traced = [f["check"] for f in json.loads(report)["findings"] if f["trace"]]
    assert traced
    done = shell(f"exover trace a.json --check {traced[0]} --out >(cat >a.txt)", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert wait_for(tmp_path / "a.txt").startswith(traced[0])


def wait_for(path: Path) -> str:
    """Return what the reader of a pipe has written, which may end after the command."""
    until = time.monotonic() + 10
    while not (path.exists() and path.read_text().endswith("\n")) and time.monotonic() < until:
        time.sleep(0.02)
    return path.read_text()


def test_standard_output_by_its_path_loses_nothing(spec: Path, tmp_path: Path) -> None:
    for path in ("/dev/stdout", "all.txt"):
        done = shell(f"exover check demo.exo --output github={path} >all.txt", tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        lines = (tmp_path / "all.txt").read_text().splitlines()
        assert lines[0] == lines[-1] != ""
        assert lines[1].startswith("demo.exo: spec demo")


def test_a_device_takes_several_reports(run, spec: Path) -> None:
    done = run("check", "demo.exo", "--output", "json=/dev/null", "--output", "sarif=/dev/null")
    assert (done.returncode, done.stderr) == (0, "")


def test_a_report_that_cannot_be_written_takes_no_other_with_it(
    run: Run, spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(folder: str, artefacts: object) -> list[str]:
        raise CliError(f"cannot write {folder}: No space left on device")

    alone = run("check", "demo.exo", "--no-cache")
    monkeypatch.setattr(check, "write_all", full)
    done = run("check", "demo.exo", "--no-cache", "--output", "json=reports/a.json")
    assert (done.returncode, done.stdout) == (2, alone.stdout)
    assert done.stderr == "exover: error: cannot write reports: No space left on device\n"


# ---- what is in the way ----


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "out").write_bytes(b"mine")
    for out in ("out", "out/deeper"):
        with pytest.raises(CliError, match=rf"cannot write .*{out}: Not a directory"):
            write_all(str(tmp_path / out), TWO)
    assert tree(tmp_path) == {"out": b"mine"}


def test_a_folder_that_takes_no_files() -> None:
    with pytest.raises(CliError, match="cannot write /proc/self/"):
        write_all("/proc/self", TWO)
    with pytest.raises(CliError, match="cannot write /proc/none: No such file or directory"):
        write_all("/proc/none", TWO)


@pytest.mark.parametrize(
    "command",
    [
        "check demo.exo --output text=a.txt --output json=demo.exo/a",
        "check demo.exo --output json=folder",
        "check demo.exo --certificate demo.exo/a",
        "emit demo.exo --target bin --out demo.exo/a",
        "swap demo.exo demo.exo --out demo.exo/a",
        "report demo.exo --out demo.exo/a",
        "diff demo.exo demo.exo --out demo.exo/a",
        "audit demo.exo events --out demo.exo/a",
    ],
)
def test_what_cannot_be_written_is_told_before_anything_is_read(run: Run, spec: Path, command: str) -> None:
    (spec.parent / "folder").mkdir()
    spec.write_text("no spec")
    done = run(*command.split())
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("exover: error: cannot write ")


def test_folders_below_are_made_or_left_away(tmp_path: Path) -> None:
    out, deep = tmp_path / "out", (Artefact("src/a", b"1"), *TWO)
    assert write_all(str(out), deep) == [str(out / "src/a"), str(out / "a.h"), str(out / "b.c")]
    assert tree(out) == {"src": None, "src/a": b"1", "a.h": b"1\n", "b.c": b"2" * 5000}
    before = tree(tmp_path)
    with pytest.raises(CliError, match=r"cannot write .*b\.c: File too large"), small_files():
        write_all(str(tmp_path / "new"), deep)
    assert tree(tmp_path) == before


def test_what_is_written_in_part_goes_when_the_user_interrupts(tmp_path: Path) -> None:
    def artefacts() -> Iterator[Artefact]:
        yield TWO[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_all(str(tmp_path / "out"), artefacts())
    assert tree(tmp_path) == {}
