"""`exover check` as a gate: several reports at once, limits that are kept, waivers and baselines, and its statuses."""

import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from exover.checks.finding import Counted
from exover.checks.schedule.plan import CheckPlan
from exover.cli.check import decide
from exover.cli.policy import find_config
from exover.limits import Limits
from exover.pipeline import load
from exover.source import Source
from tests.cli.processes import ENDLESS, gone, in_session
from tests.cli.specs import DEAF, SHADOWED, SPEC, files
from tests.support.command import environment

FORMS = ("text", "json", "sarif", "junit", "github")


def endless(folder: Path, *arguments: str) -> "subprocess.Popen[bytes]":
    """Start that command in a session of its own."""
    command = [sys.executable, "-c", ENDLESS, "check", "demo.exo", "--engine", "bdd", *arguments]
    return subprocess.Popen(command, cwd=folder, env=environment(), stdout=subprocess.DEVNULL, start_new_session=True)


# ---- reports ----


def test_reports_are_written_and_printed_at_once(run, spec, tmp_path):
    spec.write_text(DEAF)
    outputs = [f"--output={form}=reports/a.{form}" for form in FORMS]
    done = run("check", "demo.exo", "--format", "github", *outputs)
    assert (done.returncode, done.stderr) == (1, "")
    written = files(tmp_path / "reports")
    assert sorted(written) == sorted(f"a.{form}" for form in FORMS)
    assert run("check", "demo.exo", "--format", "sarif").stdout.encode() == written["a.sarif"]
    assert done.stdout.encode() == written["a.github"]
    assert json.loads(written["a.json"])["verdict"] == "violated"
    (result,) = json.loads(written["a.sarif"])["runs"]
    assert {r["kind"] for r in result["results"]} >= {"pass", "fail"}
    assert int(ElementTree.fromstring(written["a.junit"]).attrib["failures"]) > 0
    assert done.stdout.startswith("::error file=demo.exo,line=3,col=21,title=reachability nd.goto violated::")


def test_reports_are_the_same_bytes_for_any_number_of_jobs(run, spec, tmp_path):
    spec.write_text(DEAF + "mutex again: nd.stop over nd.goto;\n")
    for jobs in ("1", "2", "3"):
        outputs = [f"--output={form}={jobs}/a.{form}" for form in FORMS]
        done = run("check", "demo.exo", "--jobs", jobs, *outputs, env=environment(PYTHONHASHSEED=jobs))
        assert (done.returncode, done.stdout.encode()) == (1, (tmp_path / jobs / "a.text").read_bytes())
    assert files(tmp_path / "1") == files(tmp_path / "2") == files(tmp_path / "3") != {}


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--output", "json=-"], "- is no file: --format json prints to standard output"),
        (["--output", "json="], "'json=' is no FORMAT=FILE"),
        (["--output", "yaml=a"], "'yaml=a' is no FORMAT=FILE with a format of text, json, sarif, junit, github"),
        (["--output", "json=a", "--output", "text=./a"], "two reports cannot be written to ./a"),
        (["--output", "json=demo.exo"], "demo.exo cannot be written over: the command reads it"),
        (["--output", "json=demo.exo/a"], "cannot write demo.exo"),
        (["--timeout", "0"], "'0' is no number of seconds above 0"),
        (["--timeout", "nan"], "'nan' is no number of seconds above 0"),
        (["--timeout", "1e9"], "'1e9' is no number of seconds above 0"),
        (["--jobs", "0"], "'0' is no number from 1 to 256"),
        (["--jobs", "many"], "'many' is no number from 1 to 256"),
        (["--baseline", "none.json"], "cannot read none.json"),
        (["--baseline", "demo.exo"], "cannot use demo.exo: it is not JSON"),
        (["--config", "none.toml"], "cannot read none.toml"),
        (["--properties", "none.prop"], "cannot read none.prop"),
    ],
)
def test_what_is_refused(run, spec, options, reason):
    done = run("check", "demo.exo", *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr
    assert spec.read_text() == SPEC


# ---- properties ----


def test_properties_are_read_by_check_and_by_emit(run, spec, tmp_path):
    (tmp_path / "bad.prop").write_text("for rover;\n")
    for command in (("check", "demo.exo"), ("emit", "demo.exo", "--target", "bin", "--out", "out")):
        done = run(*command, "--properties", "bad.prop")
        assert (done.returncode, done.stdout) == (2, "")
        assert "error[E419]" in done.stderr
    assert not (tmp_path / "out").exists()


# ---- limits ----


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_the_time_limit_is_kept_and_nobody_is_left(spec, tmp_path, jobs):
    began = time.monotonic()
    with endless(tmp_path, "--timeout", "4", "--jobs", jobs, "--output", "json=a.json") as process:
        assert process.wait(timeout=100) == 3
        took = time.monotonic() - began
        assert gone(process.pid)
    assert 3.9 < took < 60  # the longer the more others use the machine; without a limit it takes 300 s
    report = json.loads((tmp_path / "a.json").read_text())
    assert report["verdict"] == "unknown"
    unknown = {(f["check"], f["message"]) for f in report["findings"] if f["verdict"] == "unknown"}
    assert ("endless", "time limit of 4 s") in unknown
    assert {f["verdict"] for f in report["findings"] if f["check"] == "consistency"} == {"holds"}


def test_no_time_to_make_the_tables():
    model = load(Source("demo.exo", SPEC)).model
    assert model is not None
    built, outcome = decide(model, CheckPlan(count=True), Limits(1, 3.0, deadline=time.monotonic() - 1))
    assert built is None
    assert outcome.states == Counted(None, "time limit of 3 s")
    assert {(f.verdict, f.message) for f in outcome.findings} == {("unknown", "time limit of 3 s")}
    assert {f.check for f in outcome.findings} >= {"safety", "deadlock", "rule-use"}


def test_no_time_to_read_the_spec(run, spec):
    spec.write_text("spec demo;\n" + "module m { request r(); }\n" * 20_000)
    done = run("check", "demo.exo", "--timeout", "0.01")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "exover: error: time limit of 0.01 s: it was over before demo.exo was read\n"
    done = run("emit", "demo.exo", "--target", "bin", "--out", "out", "--timeout", "0.01")
    assert (done.returncode, done.stdout) == (3, "")


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_signals_leave_nobody(spec, tmp_path, number, status):
    with endless(tmp_path, "--jobs", "2") as process:
        until = time.monotonic() + 20
        while len(in_session(process.pid)) < 3 and time.monotonic() < until:
            time.sleep(0.02)
        assert len(in_session(process.pid)) == 3
        os.kill(process.pid, number)
        assert process.wait(timeout=10) == status
        assert gone(process.pid)


def test_a_compiler_that_takes_too_long_is_ended(run, spec, tmp_path):
    spec.write_text(DEAF + "launch now: nd.stop() when battery < 50;\nforbid low: battery < 20 and active(nd.stop);\n")
    compiler = tmp_path / "slow"
    compiler.write_text(f"#!/bin/sh\nsleep 60 &\necho $$ $! > {tmp_path}/processes\nwait\n")
    compiler.chmod(0o755)
    done = run("check", "demo.exo", "--timeout", "5", env=environment(CC=str(compiler), TMPDIR=str(tmp_path)))
    assert done.returncode == 1
    assert done.stderr == "exover: note: traces were not replayed on the C runtime: time limit of 5 s\n"
    assert not list(tmp_path.glob("exover-*"))
    started = (tmp_path / "processes").read_text().split()
    assert len(started) == 2
    until = time.monotonic() + 30
    while any(Path(f"/proc/{process}").exists() for process in started) and time.monotonic() < until:
        time.sleep(0.02)
    assert not any(Path(f"/proc/{process}").exists() for process in started)


# ---- waivers ----


WAIVER = '[[waiver]]\ncheck = "{check}"\nsubject = "{subject}"\nreason = "seen by the board"\nexpires = {expires}\n'


def waive(folder: Path, check: str, subject: str, expires: str = "9999-12-31") -> None:
    (folder / "exover.toml").write_text(WAIVER.format(check=check, subject=subject, expires=expires))


def test_a_waived_error_does_not_count_and_is_shown(run, spec, tmp_path):
    spec.write_text(DEAF)
    before = run("check", "demo.exo", "--format", "json")
    (error,) = [
        f for f in json.loads(before.stdout)["findings"] if f["verdict"] == "violated" and f["severity"] == "error"
    ]
    waive(tmp_path, error["check"], error["subject"])
    done = run("check", "demo.exo", *(f"--output={form}=out/a.{form}" for form in FORMS))
    assert (done.returncode, done.stderr) == (0, "")
    assert "\n    waived until 9999-12-31: seen by the board\n" in done.stdout
    assert " 1 waived" in done.stdout.splitlines()[-1]
    assert all(b"seen by the board" in content for content in files(tmp_path / "out").values())
    emitted = run("emit", "demo.exo", "--target", "bin", "--out", "out")
    assert emitted.returncode == 1


def test_an_expired_waiver_no_longer_counts(run, spec, tmp_path):
    spec.write_text(DEAF)
    waive(tmp_path, "reachability", "nd.goto", "2020-01-01")
    done = run("check", "demo.exo")
    assert done.returncode == 1
    assert done.stderr == (
        "exover: warning: exover.toml:1: the waiver of reachability nd.goto expired on 2020-01-01: "
        "it no longer counts\n"
    )


def test_a_waiver_that_matches_nothing_is_told(run, spec, tmp_path):
    waive(tmp_path, "deadlock", "nd.goto")
    done = run("check", "demo.exo")
    assert done.returncode == 0
    assert done.stderr == (
        "exover: warning: exover.toml:1: the waiver of deadlock nd.goto matches nothing: "
        "no such finding of demo is open\n"
    )


@pytest.mark.parametrize("check", ["consistency", "safety", "completeness", "tables"])
def test_what_a_checked_spec_guarantees_cannot_be_waived(run, spec, tmp_path, check):
    waive(tmp_path, check, "drive")
    done = run("check", "demo.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert f"error[E606]: an error of `{check}` cannot be waived\n  --> exover.toml:2:1\n" in done.stderr


def test_the_configuration_is_looked_for_up_to_the_root_of_the_repository(tmp_path):
    inner = tmp_path / "robot" / "specs"
    inner.mkdir(parents=True)
    spec = inner / "demo.exo"
    (tmp_path / "exover.toml").write_text("")
    assert find_config(str(spec)) is None
    (tmp_path / "robot" / ".git").mkdir()
    assert find_config(str(spec)) is None
    (tmp_path / "robot" / "exover.toml").write_text("")
    assert find_config(str(spec)) == str(tmp_path / "robot" / "exover.toml")
    (inner / "exover.toml").write_text("")
    assert find_config(str(spec)) == str(inner / "exover.toml")


def test_the_configuration_of_a_folder_that_a_path_only_passes_is_of_no_concern(tmp_path, monkeypatch):
    for folder in (".git", "robot/arm", "robot/base", "other"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "robot" / "arm" / "exover.toml").write_text("")
    (tmp_path / "link").symlink_to("robot/base")
    monkeypatch.chdir(tmp_path / "robot" / "arm")
    assert find_config("../base/demo.exo") is None
    assert find_config("../../link/../arm/demo.exo") == "../../link/../arm/exover.toml"
    (tmp_path / "exover.toml").write_text("")
    (tmp_path / "robot" / "exover.toml").write_text("")
    assert find_config("../base/demo.exo") == str(tmp_path / "robot" / "exover.toml")
    assert find_config("../../link/demo.exo") == str(tmp_path / "exover.toml")
    assert find_config("../../link/../demo.exo") == "../../link/../exover.toml"


def test_a_configuration_may_be_named(run, spec, tmp_path):
    spec.write_text(DEAF)
    (tmp_path / "other").mkdir()
    waive(tmp_path / "other", "reachability", "nd.goto")
    assert run("check", "demo.exo").returncode == 1
    assert run("check", "demo.exo", "--config", "other/exover.toml").returncode == 0


# ---- the baseline ----


def test_a_baseline_excuses_known_warnings_and_no_error(run, spec):
    spec.write_text(SHADOWED)
    strict = ("check", "demo.exo", "--deny", "warnings")
    assert run(*strict, "--output", "json=base.json").returncode == 1
    known = run(*strict, "--baseline", "base.json", "--output", "json=base.json")
    assert known.returncode == 0
    assert "\n    known: the baseline has it\n" in known.stdout
    assert run(*strict, "--baseline", "base.json").stdout == known.stdout
    spec.write_text(SHADOWED + "mutex thrice: nd.stop over nd.goto;\n")
    assert run(*strict, "--baseline", "base.json").returncode == 1


def test_a_baseline_never_excuses_an_error(run, spec):
    spec.write_text(DEAF)
    first = run("check", "demo.exo", "--output", "json=base.json")
    second = run("check", "demo.exo", "--baseline", "base.json", "--format", "json")
    assert (first.returncode, second.returncode) == (1, 1)
    found = json.loads(second.stdout)["findings"]
    assert {f["baseline"] for f in found} == {"unchanged"}
    errors = [f for f in found if f["verdict"] == "violated" and f["severity"] == "error"]
    assert errors
    assert all("excuse" not in f for f in errors)
