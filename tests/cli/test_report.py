"""`exover report`: the page is written whatever the checks say, with the status that they have."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.support.command import Run

SAFE = "spec s; module m { request a(); request b(); } mutex one: m.a, m.b;"
BROKEN = "spec s; poster wind: int in 0 .. 9 = 0; module m { request a(); } forbid storm: wind > 5 and active(m.a);"


def page(path: Path) -> dict[str, Any]:
    found = re.search(r'id="report">(.*?)</script>', path.read_text("utf-8"), re.S)
    assert found
    told: dict[str, Any] = json.loads(found[1])
    return told


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "safe.exo").write_text(SAFE)
    (tmp_path / "broken.exo").write_text(BROKEN)
    return tmp_path


def test_a_report_is_written_whatever_the_checks_say(folder: Path) -> None:
    run = Run(folder)
    for name, status, verdict in (("safe", 0, "holds"), ("broken", 1, "violated")):
        done = run("report", f"{name}.exo", "--out", f"out/{name}.html")
        assert (done.returncode, done.stderr) == (status, "")
        assert done.stdout.splitlines()[0] == run("check", f"{name}.exo").stdout.splitlines()[-1]
        assert done.stdout.splitlines()[1:] == [f"out/{name}.html"]
        assert page(folder / "out" / f"{name}.html")["verdict"] == verdict


def test_the_options_of_check_count(folder: Path) -> None:
    run = Run(folder)
    report = folder / "r.html"
    done = run("report", "broken.exo", "--out", report, "--only", "consistency,rule-use")
    assert done.returncode == 0
    assert {each["check"] for each in page(report)["findings"]} == {"consistency", "rule-use"}
    assert "safety" in page(report)["skipped"]
    (folder / "asked").mkdir()
    (folder / "asked" / "a.prop").write_text("for s; property never_a: never active(m.a);")
    assert run("report", "safe.exo", "--out", report, "--properties", "asked/a.prop").returncode == 1
    asked = next(each for each in page(report)["findings"] if each["subject"] == "never_a")
    assert asked["place"] == {"file": "asked/a.prop", "line": 1}
    (folder / "idle.exo").write_text(SAFE + " mutex two: m.a, m.b;")
    assert run("report", "idle.exo", "--out", report, "--deny", "warnings").returncode == 1
    (folder / "old.json").write_text(run("check", "idle.exo", "--format", "json").stdout)
    arguments = ("--deny", "warnings", "--baseline", "old.json")
    assert run("report", "idle.exo", "--out", report, *arguments).returncode == 0
    assert any(each["excuse"] for each in page(report)["findings"])


def test_what_is_not_known_in_time_is_unknown(folder: Path) -> None:
    crowd = "".join(f"request r{number}(); " for number in range(60))
    (folder / "large.exo").write_text(f"spec s; module m {{ {crowd}}} limit few: at most 20 of m.*;")
    done = Run(folder)("report", "large.exo", "--out", "r.html", "--timeout", "0.01", "--jobs", "1")
    assert done.returncode == 3
    if (folder / "r.html").exists():  # else not even the spec was read in time
        assert page(folder / "r.html")["verdict"] == "unknown"


def test_mistakes_leave_nothing_behind(folder: Path) -> None:
    run = Run(folder)
    (folder / "bad.exo").write_text("spec s; module m { request a(; }")
    done = run("report", "bad.exo", "--out", "r.html")
    assert done.returncode == 2
    assert "bad.exo:1:" in done.stderr
    before = sorted(folder.iterdir())
    (folder / "file").write_text("")
    for out, reason in (
        ("safe.exo", "safe.exo cannot be written over: the command reads it"),
        ("file/r.html", "cannot write file"),
        ("./", "./ is a folder: --out names the file to write"),
    ):
        done = run("report", "safe.exo", "--out", out)
        assert (done.returncode, reason in done.stderr) == (2, True), done.stderr
    assert sorted(folder.iterdir()) == sorted([*before, folder / "file"])
    assert (folder / "safe.exo").read_text() == SAFE
    assert run("report", "safe.exo").returncode == 2


def test_a_spec_from_standard_input(folder: Path) -> None:
    done = Run(folder)("report", "-", "--out", "r.html", input=SAFE)
    assert done.returncode == 0
    assert page(folder / "r.html")["files"] == [{"name": "<stdin>", "text": SAFE}]


def test_the_files_that_a_spec_includes_are_shown(folder: Path) -> None:
    (folder / "whole.exo").write_text('spec s; include "arm.exo"; module m { request a(); }')
    (folder / "arm.exo").write_text("part arm; module n { request b(); }\nmutex one: n.b, m.a;")
    assert Run(folder)("report", "whole.exo", "--out", "r.html").returncode == 0
    found = page(folder / "r.html")
    assert [file["name"] for file in found["files"]] == ["whole.exo", "arm.exo"]
    (rule,) = found["rules"]
    assert (rule["written"], rule["place"]) == ("mutex one: n.b, m.a;", {"file": "arm.exo", "line": 2})
