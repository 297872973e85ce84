"""Where a crate is written: never over files of a host."""

from pathlib import Path

import pytest

from exover.emit import rust
from exover.pipeline import build
from tests.runtime.compiling import model_of
from tests.support.command import Run

SPEC = "spec cart; module base { request drive(); }"
FOREIGN = '[package]\nname = "host"\n'


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def emitted(run: Run, folder: Path, *targets: str) -> tuple[int, str]:
    (folder / "cart.exo").write_text(SPEC)
    ended = run("emit", "cart.exo", "--target", ",".join(targets), "--out", ".", "--unchecked", cwd=folder)
    return ended.returncode, ended.stderr


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Cargo.toml", FOREIGN),
        ("Cargo.toml", ""),
        ("src/lib.rs", "pub fn host() {}\n"),
        ("src/events.rs", "//! Events of the host.\n"),
    ],
)
@pytest.mark.parametrize("targets", [("rust",), ("c", "rust")], ids="+".join)
def test_a_file_of_the_host_is_left_alone_and_nothing_is_written(
    run: Run, tmp_path: Path, name: str, text: str, targets: tuple[str, ...]
) -> None:
    (tmp_path / "src").mkdir()
    (tmp_path / name).write_text(text)
    before = tree(tmp_path) | {"cart.exo": SPEC.encode()}
    status, said = emitted(run, tmp_path, *targets)
    assert status == 2 and tree(tmp_path) == before
    assert said == (
        f"exover: error: {name} is not one of exover's, and the crate would replace it: nothing is written; emit the "
        "crate into a folder of its own\n"
    )


def test_its_own_is_written_anew_beside_other_files(run: Run, tmp_path: Path) -> None:
    assert emitted(run, tmp_path, "rust") == (0, "")
    first = tree(tmp_path)
    (tmp_path / "src" / "main.rs").write_text("fn main() {}\n")
    (tmp_path / "src" / "names.rs").write_text("old")
    assert emitted(run, tmp_path, "c", "rust") == (0, "")
    after = tree(tmp_path)
    assert {name: after[name] for name in first} == first
    assert after["src/main.rs"] == b"fn main() {}\n"


def test_a_manifest_alone_is_no_crate(run: Run, tmp_path: Path) -> None:
    assert emitted(run, tmp_path, "rust") == (0, "")
    (tmp_path / "src" / "lib.rs").write_text("pub fn host() {}\n")
    assert emitted(run, tmp_path, "rust")[0] == 2


def test_the_files_begin_with_their_marks() -> None:
    found = build(model_of(SPEC))
    texts = {artefact.name: artefact.content.decode() for artefact in rust.emit(found.model, found.tables, "cart")}
    assert [name for name, mark in rust.MARKS.items() if not texts[name].startswith(mark)] == []
