"""The properties file of a spec: where it is found, and what becomes of a broken one."""

import json
import os
from pathlib import Path

import pytest

from exover.cli.files import read_properties, read_spec
from exover.cli.status import CliError
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES

SPEC = "spec demo; module nd { request goto(x: real in 0 .. 9); request stop(); } mutex drive: nd.stop over nd.goto;"
ROOT = Path(__file__).parents[2]
STOPS = "for demo; property stops: always possible active(nd.stop);"
GOES = "for demo; property goes: possible active(nd.goto);"


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "specs" / "demo.exo"
    path.parent.mkdir()
    path.write_text(SPEC)
    return path


@pytest.fixture
def model(spec: Path) -> Model:
    return read_spec(str(spec))


def names(spec: Path, given: Path | None, model: Model) -> list[str]:
    found = read_properties(str(spec), given and str(given), model)
    return [each.name for each in found.properties]


def test_without_a_file_there_are_none(spec: Path, model: Model) -> None:
    assert read_properties(str(spec), None, model) is NO_PROPERTIES


@pytest.mark.parametrize("place", ["demo.prop", "properties/demo.prop", "../properties/demo.prop"])
@pytest.mark.parametrize("name", ["demo.prop", "other.prop"])
def test_each_place_is_looked_at_for_the_name_and_for_what_the_file_is_for(
    spec: Path, model: Model, place: str, name: str
) -> None:
    path = spec.parent / Path(place).with_name(name)
    path.parent.mkdir(exist_ok=True)
    path.write_text("// which spec?\n" + STOPS)
    (path.parent / "elsewhere.prop").write_text("for rover; property x: never true;")
    (path.parent / "legacy.prop").write_bytes(b"// caf\xe9\nfor rover;")
    (path.parent / ".#demo.prop").symlink_to("editor@host.1")
    (path.parent / "._demo.prop").write_bytes(b"\0\5\x16\7")
    found = read_properties(str(spec), None, model)
    assert [each.name for each in found.properties] == ["stops"]
    assert found.file is not None
    assert Path(found.file).resolve() == path.resolve()


@pytest.mark.parametrize(
    ("one", "two"),
    [("demo.prop", "../properties/demo.prop"), ("demo.prop", "other.prop"), ("properties/a.prop", "demo.prop")],
)
def test_two_files_are_refused_unless_one_is_named(spec: Path, model: Model, one: str, two: str) -> None:
    for place, content in ((one, STOPS), (two, GOES)):
        (spec.parent / place).parent.mkdir(exist_ok=True)
        (spec.parent / place).write_text(content)
    with pytest.raises(CliError, match="has 2 properties files") as refused:
        read_properties(str(spec), None, model)
    assert {Path(one).name, Path(two).name} <= {Path(word.strip(":,")).name for word in str(refused.value).split()}
    assert names(spec, spec.parent / one, model) == ["stops"]
    assert names(spec, spec.parent / two, model) == ["goes"]


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"// caf\xe9\n" + STOPS.encode(), "E002"),
        (STOPS.encode("utf-16"), "E002"),
        (b"/* " + STOPS.encode(), "E103"),
        (b'"' + STOPS.encode(), "E102"),
        (STOPS.removeprefix("for demo; ").encode(), "E106"),
        (b"", "E004"),
    ],
)
@pytest.mark.parametrize("place", ["demo.prop", "rules.prop", "../properties/rules.prop"])
def test_what_may_be_for_the_spec_is_refused_if_it_cannot_be_read(run, spec, place, content, code) -> None:
    path = spec.parent / place
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    for command in (("check",), ("emit", "--target=bin", "--out=out"), ("check", "--changed")):
        verb, *options = command
        done = run(verb, *options, str(path if "--changed" in options else spec))
        assert done.returncode == 2, done
        assert code in done.stderr
        assert path.name in done.stderr
    assert not (spec.parent / "out").exists()


def test_what_cannot_be_told_to_be_for_another_spec_is_told_before_two_files_are(run, spec: Path) -> None:
    (spec.parent / "rules.prop").write_text(STOPS.removeprefix("for demo; "))
    spec.with_suffix(".prop").write_text(STOPS)
    done = run("check", str(spec))
    assert done.returncode == 2
    assert "rules.prop:1:1" in done.stderr
    assert run("check", str(spec), "--properties", str(spec.with_suffix(".prop"))).returncode == 0


@pytest.mark.parametrize("name", ["demo.prop", "rules.prop", "exover.toml"])
@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda path: path.symlink_to("nowhere"), "No such file or directory"),
        (lambda path: path.symlink_to(path.name), "Too many levels of symbolic links"),
        (lambda path: path.mkdir(), "Is a directory"),
        (os.mkfifo, "it is no regular file"),
    ],
    ids=["dangling", "loop", "folder", "pipe"],
)
@pytest.mark.usefixtures("cached")
def test_what_is_called_so_and_is_no_file_is_refused(run, spec: Path, name: str, make, why: str) -> None:
    assert run("check", str(spec)).returncode == 0
    make(spec.parent / name)
    done = run("check", str(spec))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"exover: error: cannot read {spec.parent / name}: {why}\n"


def test_a_file_that_two_places_show_is_one(spec: Path, model: Model) -> None:
    folder = spec.parent.parent / "properties"
    folder.mkdir()
    (folder / "demo.prop").write_text(GOES)
    (spec.parent / "properties").symlink_to(folder)
    spec.with_suffix(".prop").symlink_to(folder / "demo.prop")
    assert names(spec, None, model) == ["goes"]
    inner = folder / "demo.exo"
    inner.write_text(SPEC)
    assert names(inner, None, model) == ["goes"]


# ---- what the reports say ----


FALSE = "for demo; property moves: never active(nd.goto); assume never (asked(nd.goto) and waiting(nd.goto));"


def test_properties_beside_the_spec_are_read_and_named(run, tmp_path: Path) -> None:
    """The folder of a newcomer: `spec.exo` and `properties/spec.prop`, and the command run where they are."""
    (tmp_path / "spec.exo").write_text(SPEC)
    (tmp_path / "properties").mkdir()
    (tmp_path / "properties" / "spec.prop").write_text(FALSE)
    done = run("check", "spec.exo", "--output", "json=a.json")
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.splitlines()[1] == "properties: properties/spec.prop, 1 property, 1 assumption"
    assert json.loads((tmp_path / "a.json").read_text())["properties"] == "properties/spec.prop"
    emitted = run("emit", "spec.exo", "--target", "bin", "--out", "out")
    assert emitted.returncode == 1
    assert "moves violated" in emitted.stderr
    assert not (tmp_path / "out").exists()


def test_that_there_are_none_is_said(run, tmp_path: Path) -> None:
    (tmp_path / "spec.exo").write_text(SPEC)
    done = run("check", "spec.exo", "--output", "json=a.json")
    assert done.returncode == 0
    assert done.stdout.splitlines()[1] == (
        "properties: none, no .prop file of this spec was found beside it, in properties/ or in ../properties/"
    )
    report = json.loads((tmp_path / "a.json").read_text())
    assert list(report)[3:5] == ["file", "properties"]
    assert report["properties"] is None


def test_two_files_are_status_2_for_every_verb_that_reads_them(run, tmp_path: Path) -> None:
    (tmp_path / "spec.exo").write_text(SPEC)
    for name in ("spec", "more"):
        (tmp_path / f"{name}.prop").write_text(STOPS)
    for command in (("check", "spec.exo"), ("emit", "spec.exo", "--target", "bin", "--out", "out")):
        done = run(*command)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == (
            "exover: error: spec.exo has 2 properties files, more.prop, spec.prop: "
            "keep one, or name one with --properties\n"
        )
        assert run(*command, "--properties", "more.prop").returncode == 0


def test_the_place_is_told_from_the_folder_that_the_command_runs_in(
    spec: Path, model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec.with_suffix(".prop").write_text(STOPS)
    monkeypatch.chdir(spec.parent)
    found = read_properties(spec.name, None, model)
    assert found.properties[0].location.file == "demo.prop"
    monkeypatch.chdir(ROOT)
    found = read_properties("specs/rover.exo", None, read_spec("specs/rover.exo"))
    assert found.properties[0].location.file == "properties/rover.prop"


@pytest.mark.parametrize(
    ("content", "told", "ending"),
    [
        (b"for demo; property p: never active(nd.fly);", "error[E203]: unknown request `nd.fly`", "has a mistake"),
        (b"for demo; property p: nver; property q: x until;", "error[E106]", "has mistakes"),
        (b"for rover;", "error[E419]: the properties are for `rover`, the spec is `demo`", "has a mistake"),
        (b"\xff\xfe", "error[E002]", "cannot read"),
        (b"", "error[E004]: the file holds no properties", "has a mistake"),
    ],
)
def test_a_broken_file_is_refused(
    spec: Path, model: Model, content: bytes, told: str, ending: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = spec.with_suffix(".prop")
    path.write_bytes(content)
    with pytest.raises(CliError, match=ending):
        read_properties(str(spec), None, model)
    assert told in capsys.readouterr().err


def test_a_file_that_is_given_must_be_there(spec: Path, model: Model) -> None:
    with pytest.raises(CliError, match=r"cannot read .*none\.prop: No such file"):
        read_properties(str(spec), "none.prop", model)


@pytest.mark.parametrize("path", sorted((ROOT / "properties").glob("*.prop")), ids=lambda path: path.stem)
def test_every_spec_finds_its_properties(path: Path) -> None:
    spec = ROOT / "specs" / f"{path.stem}.exo"
    found = read_properties(str(spec), None, read_spec(str(spec)))
    assert len(found.properties) > 5
    assert found.fair
