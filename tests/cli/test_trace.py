"""`exover trace` as a process."""

import json
import xml.etree.ElementTree as ET

import pytest

POLITE = """spec polite;
module left { request pick() { wait until not waiting(right.pick); } }
module right { request pick() { wait until not waiting(left.pick); } }
module belt { request run(); }
mutex clear: belt.run, left.pick by wait;
mutex clear2: belt.run, right.pick by wait;
"""


@pytest.fixture
def report(run, tmp_path):
    """Return the report of a spec with two deadlocks."""
    (tmp_path / "polite.exo").write_text(POLITE)
    done = run("check", "polite.exo", "--format", "json")
    assert done.returncode == 1
    path = tmp_path / "polite.json"
    path.write_text(done.stdout)
    return path


def test_the_first_violated_finding_is_told_and_the_others_are_named(run, report):
    done = run("trace", report)
    assert done.returncode == 0
    assert done.stdout.splitlines()[0].startswith("deadlock left.pick violated: ")
    assert "1. ask belt.run()" in done.stdout
    assert done.stderr.startswith("exover: note: deadlock left.pick violated; --check and --subject choose among ")
    assert "deadlock right.pick, lockout left.pick, lockout right.pick" in done.stderr


def test_what_a_report_says_does_not_steer_the_terminal(run, report):
    found = json.loads(report.read_text())
    for each in found["findings"]:
        each["subject"] += "\x1b[31m\nexover: error: forged"
        each["message"] += "\x1b[0m\r\nforged"
    report.write_text(json.dumps(found))
    for done in (run("trace", report), run("explain", "--finding", report)):
        assert done.returncode == 0
        assert not {"\x1b", "\r"} & {*done.stdout, *done.stderr}
        assert not any(line.startswith(("forged", "exover: error")) for line in (done.stdout + done.stderr).split("\n"))


def test_check_and_subject_choose(run, report):
    done = run("trace", report, "--check", "deadlock", "--subject", "right.pick")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("deadlock right.pick violated: ")
    witness = run("trace", report, "--check", "reachability", "--subject", "belt.run")
    assert witness.stdout.startswith("reachability belt.run holds: ")


def test_a_report_may_come_from_a_pipe_and_its_finding_again(run, report):
    first = run(
        "trace", "-", "--format", "json", "--subject", "right.pick", "--check", "deadlock", input=report.read_text()
    )
    assert list(json.loads(first.stdout)) == ["file", "check", "subject", "verdict", "message", "trace", "loop_start"]
    again = run("trace", "-", "--format", "json", input=first.stdout)
    assert (again.returncode, again.stderr, again.stdout) == (0, "", first.stdout)


def test_pictures_are_written_whole_to_a_file(run, report, tmp_path):
    for form in ("text", "json", "svg", "vcd"):
        printed = run("trace", report, "--check", "deadlock", "--format", form)
        done = run("trace", report, "--check", "deadlock", "--format", form, "--out", f"new/run.{form}")
        assert (done.returncode, done.stdout) == (0, "")
        assert (tmp_path / "new" / f"run.{form}").read_text(encoding="utf-8") == printed.stdout
    ET.parse(tmp_path / "new" / "run.svg")
    assert run("trace", report, "--out", tmp_path).returncode == 2


def test_the_spec_may_have_moved(run, report, tmp_path):
    (tmp_path / "polite.exo").rename(tmp_path / "moved.exo")
    done = run("trace", report)
    assert (done.returncode, done.stdout) == (2, "")
    assert "cannot read polite.exo" in done.stderr
    assert run("trace", report, "--spec", "moved.exo").returncode == 0


def test_a_spec_that_changed_is_refused(run, report, tmp_path):
    (tmp_path / "polite.exo").write_text(POLITE.replace("by wait", ""))
    done = run("trace", report, "--check", "deadlock")
    assert (done.returncode, done.stdout) == (2, "")
    assert "the spec answers step 2 otherwise than the trace says" in done.stderr


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "not JSON"),
        ("spec polite;", "not JSON"),
        ("{}", "neither a report"),
        ('{"check": "safety", "subject": "x", "trace": null}', "no such finding with a trace; with one: there is none"),
        ('{"check": "safety", "subject": "x", "trace": []}', "does not say which spec it is about"),
        ('{"findings": []}', "no such finding"),
    ],
)
def test_what_is_no_report_is_refused(run, tmp_path, text, reason):
    (tmp_path / "r.json").write_text(text)
    done = run("trace", "r.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr
    assert done.stderr.startswith("exover: error: ")


def test_files_that_cannot_be_read(run, report, tmp_path):
    assert "cannot read none.json" in run("trace", "none.json").stderr
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe{}")
    done = run("trace", "binary.json")
    assert (done.returncode, done.stderr) == (2, "exover: error: cannot read binary.json: it is not UTF-8\n")
    none = run("trace", report, "--check", "safety")
    assert none.returncode == 2
    assert "has no finding of `safety` with a trace; with one: reachability, deadlock, " in none.stderr
    other = run("trace", report, "--check", "deadlock", "--subject", "x.y")
    assert "has no such finding with a trace; with one: " in other.stderr and "deadlock left.pick" in other.stderr


def test_a_run_of_a_warning_is_told_as_a_warning(run, spec):
    spec.write_text("spec demo; poster p: bool = true; module m { request a() { wait until p; } }")
    report = run("check", "demo.exo", "--format", "json").stdout
    assert run("trace", "-", input=report).stdout.startswith("starvation m.a warning: ")
