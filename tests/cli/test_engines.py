"""`exover check --engine`: who answers, who is missing, and programs that crash, hang, print rubbish, or lie."""

import json
import time
import uuid
from pathlib import Path

import pytest

from exover.engines.smv import program as smv
from exover.engines.smv.program import find
from tests.cli.processes import FOREVER, processes
from tests.cli.specs import DEAF, SPEC
from tests.support.command import environment
from tests.support.needed import needs_nusmv

pytestmark = needs_nusmv

LARGE = """spec large;
poster p: int in 0 .. 100000 = 0; poster q: int in 0 .. 100000 = 0;
module m { request a() { check p + q < 1000; } request b(); }
mutex apart: m.a, m.b;
"""
"""More than decision diagrams are meant for."""
CRASHES = "#!/bin/sh\nkill -SEGV $$\n"
RUBBISH = "#!/bin/sh\necho all is well\nfor n in 0 1 2 3; do echo '-- everything is maybe' > $n.txt; done\n"
SILENT = "#!/bin/sh\nexit 0\n"
LIES = """#!/bin/sh
"$REAL" "$@" || exit 1
for file in *.txt; do sed -i 's/is true/is neither/; s/is false/is true/; s/is neither/is false/' $file; done
"""
LEAVES = """#!/bin/sh
"$REAL" "$@" || exit 1
rm 1.txt 2.txt
echo 'out of luck' >&2
exit 7
"""


@pytest.fixture
def program(tmp_path: Path):
    """Make an executable script of a text."""

    def make(text: str) -> Path:
        path = tmp_path / "fake"
        path.write_text(text)
        path.chmod(0o755)
        return path

    return make


def report(done):
    return json.loads(done.stdout)


def verdicts(found):
    return {(each["check"], each["subject"]): each["verdict"] for each in found["findings"]}


def reasons(found):
    return {each["message"] for each in found["findings"] if each["verdict"] == "unknown"}


# ---- who answers ----


@pytest.mark.parametrize("text", [SPEC, DEAF])
def test_engines_say_the_same(run, spec, text):
    spec.write_text(text)
    wanted = report(run("check", spec, "--engine", "bdd", "--format", "json"))
    assert report(run("check", spec, "--format", "json")) == wanted
    together = report(run("check", spec, "--engine", "all", "--format", "json"))
    assert verdicts(together) == verdicts(wanted)
    for engine in ("z3", "nusmv"):
        done = run("check", spec, "--engine", engine, "--format", "json")
        found = report(done)
        assert (done.returncode, done.stderr) == ({SPEC: {"z3": 0, "nusmv": 3}[engine], DEAF: 1}[text], "")
        assert {each["engine"] for each in found["findings"]} == {engine}
        assert [list(each) for each in found["findings"]] == [list(each) for each in wanted["findings"]]
        known = {key: verdict for key, verdict in verdicts(found).items() if verdict != "unknown"}
        assert known.items() <= verdicts(wanted).items()
        assert {check for check, _ in verdicts(found).keys() - known.keys()} <= {"tables", "redundancy", "starvation"}
        assert any(f"bdd+z3+{engine}" in each["engine"] or engine == "z3" for each in together["findings"])


@pytest.mark.parametrize("engine", ["auto", "bdd", "z3", "nusmv", "all"])
def test_reports_are_the_same_bytes_every_time(run, spec, engine):
    spec.write_text(DEAF)
    arguments = ("check", spec, "--engine", engine, "--format", "json")
    runs = [run(*arguments, env=environment(PYTHONHASHSEED=seed)) for seed in ("1", "2")]
    assert runs[0].stdout == runs[1].stdout != ""
    assert runs[0].returncode == runs[1].returncode == 1


def test_what_diagrams_cannot_express_another_answers(run, spec):
    spec.write_text(LARGE)
    alone = report(run("check", spec, "--engine", "bdd", "--format", "json"))
    both = report(run("check", spec, "--format", "json"))
    assert verdicts(alone)["reachability", "m.a"] == "unknown"
    found = [each for each in both["findings"] if each["check"] == "reachability"]
    assert {(each["engine"], each["verdict"], each["method"]) for each in found} == {("aig", "holds", "witness")}


def test_the_text_says_who_answered(run, spec):
    assert "\nanswered by" not in run("check", spec).stdout
    assert "\nanswered by aig+bdd+z3+nusmv: " in run("check", spec, "--engine", "all").stdout
    assert "\nanswered by z3: " in run("check", spec, "--engine", "z3").stdout


# ---- who is missing ----


def test_a_program_that_is_not_there_is_refused(run, spec, tmp_path):
    for engine in ("nusmv", "all"):
        done = run("check", spec, "--engine", engine, "--nusmv", "nowhere/NuSMV")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "exover: error: cannot run nowhere/NuSMV: it is no program\n"
    (tmp_path / "text").write_text("no program")
    assert run("check", spec, "--engine", "nusmv", "--nusmv", tmp_path / "text").returncode == 2


def test_a_program_is_only_for_those_who_run_it(run, spec):
    for engine in ((), ("--engine", "bdd"), ("--engine", "z3"), ("--engine", "auto")):
        done = run("check", spec, *engine, "--nusmv", "NuSMV")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "exover: error: --nusmv is for --engine nusmv and --engine all\n"


def test_an_unknown_engine_is_refused(run, spec):
    done = run("check", spec, "--engine", "spin")
    assert (done.returncode, done.stdout) == (2, "")
    assert "invalid choice: 'spin'" in done.stderr


def test_where_no_program_is_found_others_answer_unless_it_was_asked_for(run, spec, monkeypatch):
    monkeypatch.setattr(smv, "in_wheel", lambda: None)
    env = environment(PATH="/nonexistent", CC="cc")
    done = run("check", spec, "--engine", "all", env=env)
    assert done.returncode == 0
    assert done.stderr == (
        "exover: warning: NuSMV is not asked: no NuSMV or nuXmv was found, "
        "neither on PATH nor in the extra exover[nusmv]\n"
    )
    assert "answered by bdd+z3: " in done.stdout
    done = run("check", spec, "--engine", "nusmv", env=env)
    assert (done.returncode, done.stdout) == (2, "")
    assert "no NuSMV or nuXmv was found" in done.stderr


# ---- programs that fail ----


@pytest.mark.parametrize(
    ("text", "reason", "options"),
    [
        (CRASHES, "was ended by SIGSEGV", ()),
        (CRASHES, "was ended by SIGSEGV", ("--jobs", "2", "--timeout", "60")),
        (RUBBISH, "NuSMV says nothing of it", ()),
        (SILENT, "NuSMV says nothing of it", ()),
    ],
    ids=["crashes", "crashes, limited", "rubbish", "silent"],
)
def test_a_program_that_fails_answers_nothing(run, spec, program, text, reason, options):
    fake = program(text)
    done = run("check", spec, "--engine", "nusmv", "--nusmv", fake, "--format", "json", *options)
    assert (done.returncode, done.stderr) == (3, "")
    found = report(done)
    assert set(verdicts(found).values()) == {"unknown"}
    assert any(reason in each for each in reasons(found)), reasons(found)
    together = run("check", spec, "--engine", "all", "--nusmv", fake, "--format", "json", *options)
    assert together.returncode == 0
    messages = [each["message"] for each in report(together)["findings"] if each["check"] == "safety"]
    assert messages
    assert any(reason in each for each in messages), messages


def test_what_a_program_has_said_before_it_failed_counts(run, spec, program):
    env = environment(REAL=find())
    done = run("check", spec, "--engine", "nusmv", "--nusmv", program(LEAVES), "--format", "json", env=env)
    assert done.returncode == 3
    found = report(done)
    assert set(verdicts(found).values()) == {"holds", "unknown"}
    assert any(each.endswith("ended with status 7: out of luck") for each in reasons(found))


def test_a_program_that_hangs_is_ended_with_all_its_processes(run, spec, program):
    started = time.monotonic()
    token = uuid.uuid4().hex
    env = environment(TOKEN=token)
    limits = ("--timeout", "3", "--jobs", "1")
    done = run("check", spec, "--engine", "nusmv", "--nusmv", program(FOREVER), *limits, env=env)
    assert time.monotonic() - started < 60  # it sleeps for 300 s
    assert done.returncode == 3
    assert "time limit of 3 s" in done.stdout
    until = time.monotonic() + 20
    while processes(token) and time.monotonic() < until:
        time.sleep(0.02)
    assert not processes(token)


def test_a_program_that_lies_is_found_out(run, spec, program):
    env = environment(REAL=find())
    done = run("check", spec, "--engine", "all", "--nusmv", program(LIES), env=env)
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr.startswith(
        "exover: internal fault: Disagreement: engines disagree on consistency of `drive`: "
        "aig says holds, bdd says holds, z3 says holds, nusmv says violated; and on "
    )
