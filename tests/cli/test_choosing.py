"""Which checks are asked: by the command line, by `exover.toml`, and what the reports say of the others."""

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from exover.checks.questions import SEVERITY
from tests.cli.specs import DEAF, SHADOWED, SPEC

ERRORS = [name for name, severity in SEVERITY.items() if severity == "error"]
IMPOSSIBLE = "for demo; assume always (battery > 3); assume never (battery > 3);\n"
PROPERTY = "property goes: possible active(nd.goto);\n"


def asked(report: dict) -> set[str]:
    return {finding["check"] for finding in report["findings"]}


def checked(run, *options: str) -> dict:
    done = run("check", "demo.exo", "--format", "json", *options)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ((), set(SEVERITY)),
        (("--only", "safety"), {"safety"}),
        (("--only", "safety,deadlock", "--only", "lockout"), {"safety", "deadlock", "lockout"}),
        (("--only", "note"), {"redundancy", "idle-guard"}),
        (("--only", "error", "--skip", "safety, tables"), set(ERRORS) - {"safety", "tables"}),
        (("--skip", "note,warning"), set(ERRORS)),
        (("--errors-only",), set(ERRORS)),
        (("--errors-only", "--only", "safety,lockout"), {"safety"}),
    ],
)
def test_the_command_line_chooses(run, spec: Path, options: tuple[str, ...], expected: set[str]) -> None:
    spec.write_text(SPEC + "launch stop: nd.stop() when battery < 0;\n")
    properties = "for demo; property p: always (active(nd.stop) implies not waiting(nd.stop));\n"
    spec.with_suffix(".prop").write_text(properties)
    report = checked(run, *options)
    assert asked(report) == expected
    assert report.get("skipped", []) == [name for name in SEVERITY if name not in expected]


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--only", "safty"), "--only: there is no check `safty`; did you mean `safety`?"),
        (("--skip", "idle_guard"), "--skip: there is no check `idle_guard`; did you mean `idle-guard`?"),
        (("--skip", "qqqqqq"), "--skip: there is no check `qqqqqq`; there are consistency, safety, "),
        (("--only", "safety,,tables"), "'safety,,tables' is no list of checks, separated by commas"),
        (("--only", "safety", "--skip", "error"), "no check is left to ask"),
        (("--errors-only", "--certificate", "a.cert"), "a certificate is about all checks"),
    ],
)
def test_what_is_refused(run, spec: Path, options: tuple[str, ...], reason: str) -> None:
    done = run("check", "demo.exo", *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr


# ---- exover.toml ----


def test_the_configuration_chooses_unless_the_command_line_does(run, spec: Path) -> None:
    (spec.parent / "exover.toml").write_text('[check]\nonly = ["error"]\nskip = ["tables"]\n')
    assert asked(checked(run)) <= set(ERRORS) - {"tables"}
    assert asked(checked(run, "--only", "tables,lockout")) == {"tables", "lockout"}
    (spec.parent / "exover.toml").write_text("[check]\nerrors-only = true\n")
    assert asked(checked(run)) <= set(ERRORS)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('only = ["safty"]', "error[E605]: there is no check `safty`"),
        ('only = "safety"', 'error[E603]: `only` is not a list of names, as ["safety"]'),
        ("only = []", "error[E603]: `only` names no check"),
        ("errors-only = 1", "error[E603]: `errors-only` is not true or false"),
        ("skp = []", "error[E602]: [check] has no key `skp`"),
    ],
)
def test_mistakes_in_the_configuration_have_a_place(run, spec: Path, text: str, told: str) -> None:
    (spec.parent / "exover.toml").write_text(f"# which\n[check]\n{text}\n")
    done = run("check", "demo.exo")
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{told}\n  --> exover.toml:3:1\n" in done.stderr


def test_no_waiver_of_a_check_that_is_not_asked_is_called_idle(run, spec: Path) -> None:
    waiver = '[[waiver]]\ncheck = "lockout"\nsubject = "nd.goto"\nreason = "x"\nexpires = 9999-12-31\n'
    (spec.parent / "exover.toml").write_text(waiver)
    assert run("check", "demo.exo", "--errors-only").stderr == ""
    assert "matches nothing" in run("check", "demo.exo", "--only", "lockout").stderr


# ---- what is said of the others ----


def test_every_format_says_what_was_not_asked(run, spec: Path) -> None:
    spec.write_text(SHADOWED)
    forms = ("text", "json", "sarif", "junit", "github")
    done = run("check", "demo.exo", "--skip", "rule-use,note", *(f"--output={form}=a.{form}" for form in forms))
    assert (done.returncode, done.stderr) == (0, "")
    names = ["rule-use", "redundancy", "idle-guard"]
    told = {form: (spec.parent / f"a.{form}").read_text() for form in forms}
    assert f"\nnot asked: {', '.join(names)}\n" in told["text"]
    assert told["text"].endswith("; 3 checks not asked\n")
    assert json.loads(told["json"])["skipped"] == names
    (log,) = json.loads(told["sarif"])["runs"]
    (invocation,) = log["invocations"]
    off = [each["descriptor"] for each in invocation["ruleConfigurationOverrides"]]
    assert [rule["id"] for rule in off] == [f"exover/{name}" for name in names]
    assert [log["tool"]["driver"]["rules"][rule["index"]]["id"] for rule in off] == [rule["id"] for rule in off]
    cases = ElementTree.fromstring(told["junit"]).findall("testsuite/testcase[skipped]")
    assert [case.attrib["name"] for case in cases] == names
    assert ElementTree.fromstring(told["junit"]).attrib["skipped"] == "3"
    assert "::notice title=checks not asked::rule-use, redundancy, idle-guard\n" in told["github"]


# ---- assumptions ----


def test_assumptions_hold_whatever_is_asked(run, spec: Path) -> None:
    spec.write_text(SPEC + "forbid low: battery < 20 and active(nd.stop);\n")
    assert run("check", "demo.exo", "--only", "completeness").returncode == 1
    spec.with_suffix(".prop").write_text("for demo; assume always (battery >= 20);\n" + PROPERTY)
    done = run("check", "demo.exo", "--format", "json", "--only", "completeness")
    report = json.loads(done.stdout)
    assert (done.returncode, done.stderr.count("\n")) == (0, 1)
    assert "no run on which `battery` is broken" in done.stderr
    assert [(f["check"], f["subject"]) for f in report["findings"] if f["check"] != "completeness"] == [
        ("property", "assumptions")
    ]


@pytest.mark.parametrize("engine", ["auto", "bdd", "aig", "z3"])
@pytest.mark.parametrize("asked", [(), ("--only", "safety")], ids=["all", "safety"])
def test_fair_reports_alone_are_assumptions_that_do_not_contradict_each_other(
    run, spec: Path, engine: str, asked: tuple[str, ...]
) -> None:
    spec.with_suffix(".prop").write_text("for demo;\nassume fair reports;\n")
    done = run("check", "demo.exo", *asked, "--engine", engine, "--format", "json")
    (found,) = (f for f in json.loads(done.stdout)["findings"] if f["check"] == "property")
    assert (found["subject"], found["verdict"], found["location"]["line"]) == ("assumptions", "holds", 2)


@pytest.mark.parametrize("engine", ["auto", "bdd", "z3"])
@pytest.mark.parametrize("stated", ["", PROPERTY])
def test_assumptions_that_contradict_each_other_are_never_passed_over(
    run, spec: Path, stated: str, engine: str
) -> None:
    spec.with_suffix(".prop").write_text(IMPOSSIBLE + stated)
    done = run("check", "demo.exo", "--skip", "property", "--engine", engine, "--format", "json")
    assert done.returncode == 1
    found = [f for f in json.loads(done.stdout)["findings"] if f["check"] == "property"]
    assert [(f["subject"], f["verdict"]) for f in found] == [("assumptions", "violated")]


# ---- emit ----


def test_emit_asks_all_errors_whatever_the_configuration_says(run, spec: Path) -> None:
    (spec.parent / "exover.toml").write_text('[check]\nskip = ["error"]\n')
    spec.write_text(DEAF)
    assert run("check", "demo.exo").returncode == 0
    assert run("emit", "demo.exo", "--target", "bin", "--out", "out").returncode == 1
    spec.write_text(SPEC)
    spec.with_suffix(".prop").write_text("for demo; property p: never active(nd.goto);\n")
    assert run("check", "demo.exo").returncode == 0
    assert run("emit", "demo.exo", "--target", "bin", "--out", "out").returncode == 1
    assert not (spec.parent / "out").exists()
