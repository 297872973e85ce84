"""The properties file of a spec: where it is found, and what becomes of a broken one."""

from pathlib import Path

import pytest

from exover.cli.files import read_properties, read_spec
from exover.cli.status import Refused
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


def test_the_folder_of_properties_comes_before_the_file_beside_the_spec(spec: Path, model: Model) -> None:
    """And the file that is given comes before both."""
    spec.with_suffix(".prop").write_text(STOPS)
    assert names(spec, None, model) == ["stops"]
    folder = spec.parent.parent / "properties"
    folder.mkdir()
    (folder / "demo.prop").write_text(GOES)
    assert names(spec, None, model) == ["goes"]
    assert names(spec, spec.with_suffix(".prop"), model) == ["stops"]
    (folder / "demo.prop").unlink()
    (folder / "demo.prop").mkdir()
    assert names(spec, None, model) == ["stops"]


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
    with pytest.raises(Refused, match=ending):
        read_properties(str(spec), None, model)
    assert told in capsys.readouterr().err


def test_a_file_that_is_given_must_be_there(spec: Path, model: Model) -> None:
    with pytest.raises(Refused, match=r"cannot read .*none\.prop: No such file"):
        read_properties(str(spec), "none.prop", model)


@pytest.mark.parametrize("path", sorted((ROOT / "properties").glob("*.prop")), ids=lambda path: path.stem)
def test_every_spec_finds_its_properties(path: Path) -> None:
    spec = ROOT / "specs" / f"{path.stem}.exo"
    found = read_properties(str(spec), None, read_spec(str(spec)))
    assert len(found.properties) > 5
    assert found.fair
