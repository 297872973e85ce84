"""Several specs in one call: which they are, one status, and reports that tell of each."""

import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import jsonschema
import pytest

from exover.cli.specs import specs_of
from exover.cli.status import CliError, ExitStatus, severest
from tests.cli.processes import ENDLESS, SLEEPING, await_begun, gone
from tests.cli.specs import DEAF, SHADOWED, SPEC
from tests.support.command import Ended, Run, environment

FORMS = ("text", "json", "sarif", "junit", "github")
SCHEMA = json.loads((Path(__file__).parents[1] / "report" / "sarif-schema-2.1.0.json").read_text())


FILES = ("my specs/a.exo", "my specs/b/deaf.exo", "my specs/c.exo")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three specs: one that holds, one that does not, and one with a warning; beside them what is none."""
    return specs_below(tmp_path)


def specs_below(place: Path) -> Path:
    """Write these specs, `FILES`, and return their folder."""
    specs = place / "my specs"
    (specs / "b").mkdir(parents=True)
    (specs / ".cache").mkdir()
    for name, text in (("a", SPEC), ("b/deaf", DEAF), ("c", SHADOWED)):
        (specs / f"{name}.exo").write_text(text.replace("spec demo", f"spec {name[0]}"))
    (specs / ".cache" / "old.exo").write_text("spec old")
    (specs / "notes.txt").write_text("")
    return specs


# ---- which specs ----


def test_links_to_one_spec_are_specs_of_the_folders_that_name_them(run, tmp_path: Path) -> None:
    (tmp_path / "shared.exo").write_text(SPEC)
    for name, property_of in (("a", "possible active(nd.goto)"), ("b", "never active(nd.goto)")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "y.exo").symlink_to("../shared.exo")
        (tmp_path / name / "y.prop").write_text(f"for demo; property p: {property_of};")
    (tmp_path / "again").symlink_to("b")
    assert specs_of([str(tmp_path / "b" / "y.exo"), str(tmp_path / "again" / "y.exo")]).files == (
        str(tmp_path / "b" / "y.exo"),
    )
    done = run("check", "a/y.exo", "b/y.exo", "--only", "property")
    assert (done.returncode, "2 specs" in done.stdout) == (1, True), done.stdout


def test_a_folder_stands_for_its_specs_and_each_counts_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["a.exo", "b/deaf.exo", "c.exo"]
    found = specs_of([str(folder)])
    assert ([str(Path(each).relative_to(folder)) for each in found.files], found.several) == (names, True)
    monkeypatch.chdir(folder)
    assert specs_of(["."]).files == ("a.exo", "b/deaf.exo", "c.exo")
    assert specs_of(["c.exo", "./c.exo", "."]).files == ("c.exo", "a.exo", "b/deaf.exo")
    assert (specs_of(["c.exo"]).files, specs_of(["c.exo"]).several) == (("c.exo",), False)
    assert specs_of(["b"]).several
    assert specs_of(["-"]).files == ("-",)
    (folder / "empty").mkdir()
    with pytest.raises(CliError, match=r"empty holds no \.exo file"):
        specs_of(["empty"])


@pytest.mark.parametrize("place", ["", "properties", "../properties"])
def test_properties_and_configurations_stand_for_the_specs_that_they_are_for(folder: Path, place: str) -> None:
    (folder / place).mkdir(exist_ok=True)
    for name, meant in (("a", "a"), ("other", "c")):
        path = folder / place / f"{name}.prop"
        path.write_text(f"for {meant};")
        assert [Path(each).name for each in specs_of([str(path)]).files] == [f"{meant}.exo"]
    (folder / place / "z.prop").write_text("for z;")
    with pytest.raises(CliError, match="is read by no spec"):
        specs_of([str(folder / place / "z.prop")])


def test_a_configuration_stands_for_the_specs_whose_nearest_it_is(folder: Path) -> None:
    (folder.parent / ".git").mkdir()
    for place in (folder.parent, folder / "b"):
        (place / "exover.toml").write_text("")
    upper, lower = (specs_of([str(place / "exover.toml")]).files for place in (folder.parent, folder / "b"))
    assert [Path(each).name for each in upper] == ["a.exo", "c.exo"]
    assert [Path(each).name for each in lower] == ["deaf.exo"]
    (folder.parent / "empty").mkdir()
    (folder.parent / "empty" / "exover.toml").write_text("")
    with pytest.raises(CliError, match="configures no spec"):
        specs_of([str(folder.parent / "empty" / "exover.toml")])


# ---- one status ----


def test_the_severest_status_is_that_of_all() -> None:
    order = [
        ExitStatus.OK,
        ExitStatus.UNKNOWN,
        ExitStatus.VIOLATED,
        ExitStatus.WRONG,
        ExitStatus.FAULT,
        ExitStatus.INTERRUPTED,
    ]
    for number, status in enumerate(order):
        assert severest(order[: number + 1]) is status
        assert severest(reversed(order[: number + 1])) is status


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Ended, Ended]]:
    """Return how a check of each of these specs alone ends, with a report as text and as JSON."""
    place = tmp_path_factory.mktemp("alone")
    specs_below(place)
    command = Run(place)
    return [(command("check", file), command("check", file, "--format", "json")) for file in FILES]


@pytest.mark.parametrize("jobs", ["1", "2", "7"])
def test_specs_are_reported_one_by_one_with_one_status(
    run, folder: Path, alone: list[tuple[Ended, Ended]], jobs: str
) -> None:
    outputs = [f"--output={form}=out/a.{form}" for form in FORMS]
    done = run("check", "my specs", "--jobs", jobs, *outputs)
    assert (done.returncode, done.stderr) == (1, "")
    for ended in zip(*alone, strict=True):
        assert [(each.returncode, each.stderr) for each in ended] == [(0, ""), (1, ""), (0, "")]
    assert done.stdout == "\n".join([*(text.stdout for text, _ in alone), "3 specs: 1 violated, 2 hold\n"])
    told = {form: (folder.parent / "out" / f"a.{form}").read_text() for form in FORMS}
    assert told["text"] == done.stdout
    report = json.loads(told["json"])
    assert (list(report), report["verdict"]) == (["tool", "version", "verdict", "specs"], "violated")
    assert report["specs"] == [json.loads(each.stdout) for _, each in alone]
    log = json.loads(told["sarif"])
    jsonschema.Draft7Validator(SCHEMA).validate(log)
    assert [each["properties"]["spec"] for each in log["runs"]] == ["a", "b", "c"]
    root = ElementTree.fromstring(told["junit"])
    assert {suite.attrib["name"].split(".")[0] for suite in root} == {"a", "b", "c"}
    for key in ("tests", "failures", "skipped"):
        assert int(root.attrib[key]) == sum(int(suite.attrib[key]) for suite in root) > 0
    assert told["github"].endswith("3 specs: 1 violated, 2 hold\n")


def test_two_specs_of_one_name_are_told_apart_or_refused_before_anything_is_written(run, folder: Path) -> None:
    (folder / "b" / "again.exo").write_text((folder / "c.exo").read_text())
    for form in ("sarif", "junit"):
        for options in (("--format", form), ("--output", f"{form}=out/a.{form}")):
            done = run("check", "my specs", "--output", "text=out/a.txt", *options)
            assert (done.returncode, done.stdout) == (2, "")
            told = f"my specs/b/again.exo and my specs/c.exo are both called `c`, and a {form} report tells"
            assert told in done.stderr and not (folder.parent / "out").exists()
    assert run("check", "my specs/c.exo", "my specs/b/again.exo", "--format", "json").returncode == 0


@pytest.mark.parametrize("jobs", ["1", "3"])
def test_a_spec_that_is_wrong_keeps_no_other_from_being_checked(run, folder: Path, jobs: str) -> None:
    (folder / "a.exo").write_text("spec a")
    outputs = [f"--output={form}=out/a.{form}" for form in FORMS]
    done = run("check", folder / "a.exo", folder / "none.exo", folder / "c.exo", "--jobs", jobs, *outputs)
    assert done.returncode == 2
    assert "error[E107]" in done.stderr
    assert "none.exo: No such file" in done.stderr
    assert f"{folder / 'a.exo'}: not checked: {folder / 'a.exo'} has a mistake\n" in done.stdout
    assert "\nc: holds" in done.stdout
    told = {form: (folder.parent / "out" / f"a.{form}").read_text() for form in FORMS}
    assert all("has a mistake" in text and "No such file" in text for text in told.values())
    report = json.loads(told["json"])
    assert [list(each) for each in report["specs"][:2]] == [["file", "verdict", "error"]] * 2
    log = json.loads(told["sarif"])
    jsonschema.Draft7Validator(SCHEMA).validate(log)
    assert [each["invocations"][0]["executionSuccessful"] for each in log["runs"]] == [False, False, True]
    assert ElementTree.fromstring(told["junit"]).attrib["errors"] == "2"
    assert told["github"].count("title=not checked::") == 2


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--certificate", "a.cert"), "--certificate is for one spec: name one file, once"),
        (("--properties", "a.prop"), "--properties is for one spec: name one file, once"),
        (("--output", "json=my specs/c.exo"), "my specs/c.exo cannot be written over: the command reads it"),
    ],
)
def test_what_is_refused(run, folder: Path, options: tuple[str, ...], reason: str) -> None:
    done = run("check", "my specs", *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr


def test_what_is_exceeded_and_what_no_finding_needs_is_told_of_its_spec(run, folder: Path) -> None:
    waiver = 'check = "reachability"\nsubject = "a.b"\nreason = "r"\nexpires = 9999-12-31\n'
    (folder / "exover.toml").write_text(f"[[waiver]]\n{waiver}")
    done = run("check", FILES[0], FILES[2], "--errors-only", "--max-rom", 1)
    for name in (FILES[0], FILES[2]):
        assert f"exover: error: {name}: the tables take " in done.stderr
        assert f"matches nothing: no such finding of {Path(name).stem} is open\n" in done.stderr


def test_a_report_of_several_specs_is_a_baseline_for_each(run, folder: Path) -> None:
    (folder / "b" / "deaf.exo").unlink()
    strict = ("check", "my specs", "--deny", "warnings")
    assert run(*strict, "--output", "json=base.json").returncode == 1
    assert run(*strict, "--baseline", "base.json").returncode == 0
    (folder / "d.exo").write_text(SHADOWED.replace("spec demo", "spec d"))
    assert run(*strict, "--baseline", "base.json").returncode == 1
    assert run("check", "my specs/c.exo", "--deny", "warnings", "--baseline", "base.json").returncode == 0


# ---- limits and signals ----


def test_the_time_limit_is_for_all_of_them(folder: Path) -> None:
    command = [sys.executable, "-c", ENDLESS, "check", str(folder), "--engine", "bdd", "--timeout", "6", "--jobs", "2"]
    began = time.monotonic()
    with subprocess.Popen(
        command, cwd=folder, env=environment(), stdout=subprocess.PIPE, start_new_session=True, text=True
    ) as process:
        printed, _ = process.communicate(timeout=100)
        assert process.returncode in (1, 3)
        assert time.monotonic() - began < 3 * 6  # so it is one limit for all three
        assert gone(process.pid)
    assert printed.count("endless: 2 unknown") == 3
    assert sum(line.startswith("safety: ") and "ok" in line for line in printed.splitlines()) == 3


def heard() -> None:
    """Let a closed terminal be heard, though the tests run under `nohup`."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are counted in /proc")
@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143), (signal.SIGKILL, -9)]
)
def test_signals_leave_nobody_and_ctrl_c_tells_what_is_known(folder: Path, number: int, status: int, jobs: int) -> None:
    command = [sys.executable, "-c", SLEEPING, "check", str(folder), "--engine", "bdd", "--jobs", str(jobs)]
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        start_new_session=True,
        text=True,
        preexec_fn=heard,  # noqa: PLW1509 - no thread of this process holds a lock
    ) as process:
        await_begun(folder, jobs)
        os.kill(process.pid, number)
        printed, _ = process.communicate(timeout=60)
        assert process.returncode == status
        assert gone(process.pid)
    if number == signal.SIGINT:
        assert printed.endswith("3 specs: 3 unknown\n")
        assert printed.count("interrupted") >= 3
