"""Specs of several files on the command line and in the library (docs/language.md section 10)."""

import json
import os
from pathlib import Path

import pytest

import exover
from exover.places import find_including, find_specs

SPEC = """spec demo;
include "parts/drive.exo";
include "parts/arm.exo";
mutex still: nd.goto, arm.calibrate because "it stands still";
"""
DRIVE = """part drive;
include "arm.exo";

module nd {
    request goto(v: int in 0 .. 3) { check slow: v <= 2 because "no faster"; }
}
"""
ARM = "part arm;\n\nmodule arm {\n    request calibrate();\n}\n"
DEAF = ARM.replace("calibrate();", "calibrate() { check bad: v > 3; }").replace(
    "module arm {", "module arm {\n    poster v: int in 0 .. 3 = 0;"
)


@pytest.fixture
def demo(tmp_path: Path) -> Path:
    (tmp_path / "parts").mkdir()
    (tmp_path / "demo.exo").write_text(SPEC)
    (tmp_path / "parts" / "drive.exo").write_text(DRIVE)
    (tmp_path / "parts" / "arm.exo").write_text(ARM)
    return tmp_path


def test_a_spec_of_several_files_is_checked_and_emitted_as_one_text(run, demo):
    done = run("check", "demo.exo")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("demo.exo: spec demo, 2 requests, 1 rule\n")
    one = DRIVE.replace('include "arm.exo";', ARM.replace("part arm;", "")).replace("part drive;", "spec demo;")
    (demo / "one.exo").write_text(one + SPEC.splitlines()[-1])
    for name in ("demo", "one"):
        assert run("emit", f"{name}.exo", "--target", "c,bin,json", "--out", f"{name}.out").returncode == 0
    several, single = (sorted((demo / f"{name}.out").iterdir()) for name in ("demo", "one"))
    assert [file.name for file in several] == [file.name for file in single]
    assert [file.read_bytes() for file in several] == [file.read_bytes() for file in single]


def test_findings_carry_the_file_they_are_about(run, demo):
    (demo / "parts" / "arm.exo").write_text(DEAF)
    done = run("check", "demo.exo")
    assert done.returncode == 1
    place = os.path.join("parts", "arm.exo")
    assert f"violated at {place}:5:13: " in done.stdout
    report = json.loads(run("check", "demo.exo", "--format", "json").stdout)
    assert report["file"] == "demo.exo"
    places = {f["subject"]: f["location"] for f in report["findings"] if f["check"] == "reachability"}
    assert places["arm.calibrate"] == {"file": place, "line": 5, "column": 13}
    assert places["nd.goto"]["file"] == os.path.join("parts", "drive.exo")
    log = json.loads(run("check", "demo.exo", "--format", "sarif").stdout)
    uris = {
        each["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        for each in log["runs"][0]["results"]
        if each["ruleId"] == "exover/reachability"
    }
    assert uris == {"parts/arm.exo", "parts/drive.exo"}
    assert f"file={place}" in run("check", "demo.exo", "--format", "github").stdout
    assert f'file="{place}"' in run("check", "demo.exo", "--format", "junit").stdout


def test_an_answer_is_explained_by_the_clause_of_a_part(run, demo):
    done = run("explain", "demo.exo", input='{"ask": "nd.goto", "args": {"v": 3}}\n')
    assert f"{os.path.join('parts', 'drive.exo')}:5: check slow: v <= 2" in done.stdout


def test_a_part_is_not_checked_alone(run, demo):
    part = os.path.join("parts", "arm.exo")
    done = run("check", part)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"error[E009]: `{part}` is a part" in done.stderr
    assert f" --> {part}:1:6" in done.stderr
    assert "check `demo.exo`, which includes it" in done.stderr
    (demo / "demo.exo").unlink()
    assert "no spec beside it includes it" in run("check", part).stderr
    assert run("emit", part, "--out", "out").returncode == 2
    assert not (demo / "out").exists()


def test_a_part_beside_other_specs_is_an_error_of_its_own(run, demo):
    done = run("check", "demo.exo", os.path.join("parts", "arm.exo"))
    assert done.returncode == 2
    assert "error[E009]" in done.stderr
    assert done.stdout.endswith("2 specs: 1 unknown, 1 holds\n")


def test_of_a_folder_parts_are_left_out(run, demo):
    done = run("check", ".")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("1 spec: 1 holds\n")
    done = run("check", "parts")
    assert done.returncode == 2
    assert done.stderr == "exover: error: parts holds parts and no spec; name what includes them: demo.exo\n"
    (demo / "demo.exo").unlink()
    none = "parts holds parts and no spec; no spec beside it includes one: write one that does"
    assert run("check", "parts").stderr == f"exover: error: {none}\n"


def test_a_part_that_has_changed_stands_for_its_specs(run, demo):
    done = run("check", "--changed", os.path.join("parts", "arm.exo"), os.path.join("parts", "drive.exo"))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("1 spec: 1 holds\n")
    (demo / "demo.exo").write_text("spec demo; module m { request a(); }")
    done = run("check", "--changed", os.path.join("parts", "arm.exo"))
    assert done.returncode == 2
    assert "no spec beside it includes" in done.stderr


def test_standard_input_has_no_folder(run, demo):
    done = run("check", "-", input=SPEC)
    assert done.returncode == 2
    assert "error[E005]" in done.stderr and " --> <stdin>:2:1" in done.stderr


@pytest.mark.parametrize("kind", ["missing", "folder", "bytes", "fifo", "unreadable"])
def test_a_part_that_cannot_be_read_is_an_error_at_the_include(run, demo, kind):
    part = demo / "parts" / "arm.exo"
    part.unlink()
    match kind:
        case "folder":
            part.mkdir()
        case "bytes":
            part.write_bytes(b"part arm;\xff")
        case "fifo":
            os.mkfifo(part)
        case "unreadable":
            if os.geteuid() == 0:
                part.symlink_to(part)
            else:
                part.touch(0)
    done = run("check", "demo.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert "error[E005]: cannot read `parts/arm.exo`: " in done.stderr
    assert " --> parts/drive.exo:2:1" in done.stderr
    assert done.stderr.count("error[") == 1


def test_links_lead_to_one_file(run, demo):
    (demo / "link.exo").symlink_to(demo / "parts" / "arm.exo")
    (demo / "other").symlink_to(demo / "parts")
    (demo / "demo.exo").write_text(SPEC.replace("mutex", 'include "link.exo";\ninclude "other/arm.exo";\nmutex'))
    assert run("check", "demo.exo").returncode == 0


def test_dots_follow_links_as_the_system_does(run, demo):
    (demo / "far" / "inner").mkdir(parents=True)
    (demo / "far" / "arm.exo").write_text(ARM.replace("calibrate", "calibrate(); request far"))
    (demo / "near").symlink_to(demo / "far" / "inner")
    (demo / "demo.exo").write_text('spec demo; include "near/../arm.exo";')
    assert "demo.exo: spec demo, 2 requests" in run("check", "demo.exo").stdout


def test_fmt_lays_out_parts_and_keeps_includes_where_they_stand(run, demo):
    text = 'part x;  include   "arm.exo"; // the arm\nmodule a{request b();}\ninclude "b.exo" ;include "c.exo";\n'
    (demo / "x.exo").write_text(text)
    assert run("fmt", "x.exo").returncode == 0
    assert (demo / "x.exo").read_text() == (
        'part x;\n\ninclude "arm.exo"; // the arm\n\nmodule a {\n    request b();\n}\n\n'
        'include "b.exo";\ninclude "c.exo";\n'
    )
    assert run("fmt", "--check", "x.exo").returncode == 0


def test_a_report_is_not_written_over_a_part(run, demo):
    part = os.path.join("parts", "arm.exo")
    done = run("check", "demo.exo", f"--output=json={part}")
    assert done.returncode == 2
    assert (demo / "parts" / "arm.exo").read_text() == ARM


def test_properties_are_those_of_the_spec(run, demo):
    (demo / "parts" / "demo.prop").write_text("for demo;\nproperty p: never active(nd.goto);\n")
    (demo / "parts" / "drive.prop").write_text("for other;\n")
    assert find_specs(str(demo / "parts" / "drive.prop")) == []
    assert run("check", "demo.exo").returncode == 0
    (demo / "demo.prop").write_text("for demo;\nproperty p: always not (active(nd.goto) and active(arm.calibrate));\n")
    done = run("check", "demo.exo")
    assert "property: 1 ok" in done.stdout


def test_specs_are_found_through_other_parts_and_in_folders_beside(demo):
    (demo / "specs").mkdir()
    (demo / "specs" / "two.exo").write_text('spec two; include "../parts/drive.exo";')
    found = find_including(str(demo / "parts" / "arm.exo"))
    assert [Path(each).name for each in found] == ["demo.exo", "two.exo"]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_a_spec_that_is_no_text_is_checked_with_its_parts_and_properties(run, demo, encoding):
    (demo / "old.exo").write_text('spec old; // caf\xe9\ninclude "parts/arm.exo";', encoding=encoding)
    (demo / "rules.prop").write_text("for old;")
    for changed in ("parts/arm.exo", "rules.prop"):
        done = run("check", "--changed", changed)
        assert done.returncode == 2
        assert "E002" in done.stderr
        assert "old.exo" in done.stderr
    (demo / "parts" / "arm.exo").write_text(ARM + "// caf\xe9", encoding=encoding)
    assert run("check", "--changed", "parts/drive.exo").returncode == 2


def test_the_library_reads_parts_beside_a_file_and_none_of_a_text(demo):
    spec = exover.load(demo / "demo.exo")
    assert spec.requests == ("arm.calibrate", "nd.goto")
    assert exover.check(spec).verdict == "holds"
    with pytest.raises(exover.SpecError, match="E005"):
        exover.loads(SPEC)
    with pytest.raises(exover.SpecError, match=r"which includes it"):
        exover.load(demo / "parts" / "arm.exo")
    (demo / "parts" / "arm.exo").write_text(ARM.replace("calibrate", "home"))
    with pytest.raises(exover.SpecError) as raised:
        exover.load(demo / "demo.exo")
    (mistake,) = raised.value.diagnostics
    assert raised.value.source.place(mistake.span.start).file.endswith("demo.exo")
