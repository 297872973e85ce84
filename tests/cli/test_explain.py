"""`exover explain` as a process."""

import json

import pytest

from exover.manual import pages
from tests.cli.specs import SPEC

GOTO, STOP = '{"ask": "nd.goto", "args": {"x": 1}}\n', '{"ask": "nd.stop"}\n'


def test_the_last_event_is_explained(run, spec):
    (spec.parent / "e.jsonl").write_text(STOP + GOTO + "\n")
    done = run("explain", "demo.exo", "--events", "e.jsonl")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "step 2: ask nd.goto(x = 1)",
        "  reject nd.goto [drive] a stop is a stop",
        "",
        "why reject nd.goto: what any guard, resource or rule rejects is rejected",
        "  drive rejects it: a stop is a stop",
        '    demo.exo:4: mutex drive: nd.stop over nd.goto because "a stop is a stop";',
        "    with nd.goto running",
        "      active(nd.stop) is true: nd.stop is running",
        "      active(nd.goto) is true: the newcomer is running",
        "    remedy kill nd.goto does not apply: nothing that it could end is active",
        "    remedy reject is taken: no remedy of the rule applies",
        "",
        "what would have turned the answer (2 changes tried):",
        "  if nd.stop were idle: launch nd.goto(x = 1)",
    ]
    assert run("explain", "demo.exo", input=STOP + GOTO).stdout == done.stdout


def test_as_json(run, spec):
    report = json.loads(run("explain", spec, "--format", "json", input=STOP + GOTO).stdout)
    assert report["why"][0]["deciding"][0]["rule"] == "drive"
    assert report["search"]["turns"] == [
        {"if": ["nd.stop were idle"], "actions": [{"launch": "nd.goto", "instance": 0, "args": {"x": 1}}]}
    ]


def test_an_invalid_last_event_is_an_answer_like_any_other(run, spec):
    done = run("explain", spec, input=STOP + "x" * 2_000_000)
    assert done.returncode == 0
    assert done.stdout.splitlines()[1].startswith("  invalid bad-event: the line is longer than")
    assert json.loads(run("explain", spec, "--format", "json", input="\x1b\n").stdout)["search"] is None


def test_a_file_of_no_events_is_refused(run, spec):
    done = run("explain", spec, input='{\n "format": "nothing"\n}\n')
    assert done.returncode == 2 and "step 3: an event that cannot be read" in done.stdout
    assert done.stderr.startswith("exover: error: no line of <stdin> is an event: write one JSON object a line, as ")
    assert run("explain", spec, input='{"ask": "nd.gogo"}\n').returncode == 0


def test_no_event_at_all(run, spec):
    (spec.parent / "empty.jsonl").write_text("\n  \n")
    done = run("explain", spec, "--events", "empty.jsonl")
    assert (done.returncode, done.stdout, done.stderr) == (
        2, "", "exover: error: empty.jsonl holds no event to explain\n",
    )  # fmt: skip


def test_wrong_files(run, spec):
    assert run("explain", "none.exo", input=STOP).returncode == 2
    assert "cannot read none.jsonl" in run("explain", spec, "--events", "none.jsonl").stderr
    spec.write_text("spec demo; module")
    done = run("explain", spec, input=STOP)
    assert (done.returncode, done.stdout) == (2, "")


def test_pages_of_checks_and_codes(run, tmp_path):
    for name, page in (("E307", "E307"), ("e307", "E307"), ("starvation", "starvation")):
        done = run("explain", name)
        assert (done.returncode, done.stderr, done.stdout) == (0, "", pages()[page].markdown)
    told = json.loads(run("explain", "E307", "--format", "json").stdout)
    assert list(told) == ["name", "title", "text", "mend"]
    wrong = run("explain", "starvatoin")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "no spec, check or error code starvatoin; did you mean `starvation`?" in wrong.stderr


# ---- a step of a counterexample ----


BROKEN = SPEC + "forbid low: battery < 20 and active(nd.stop);\n"


@pytest.fixture
def report(run, spec):
    spec.write_text(BROKEN)
    assert run("check", "demo.exo", "--output", "json=a.json").returncode == 1
    (found,) = [
        f
        for f in json.loads((spec.parent / "a.json").read_text())["findings"]
        if f["check"] == "completeness" and f["trace"]
    ]
    return found


def test_a_step_of_a_finding_is_explained_as_its_events_would_be(run, spec, report):
    lines = [json.dumps(step["event"]) + "\n" for step in report["trace"]]
    assert len(lines) == 2
    for step in (1, 2):
        done = run("explain", "--finding", "a.json", "--check", "completeness", "--step", step)
        assert (done.returncode, done.stderr) == (0, "")
        head, told = done.stdout.split("\n", 1)
        assert head == f"completeness low violated: {report['message']}"
        assert told == run("explain", "demo.exo", input="".join(lines[:step])).stdout
    last = run("explain", "--finding", "-", "--check", "completeness", input=(spec.parent / "a.json").read_text())
    assert last.stdout == done.stdout
    as_json = ("explain", "demo.exo", "--format", "json")
    found = run(*as_json, "--finding", "a.json", "--check", "completeness")
    assert found.stdout == run(*as_json, input="".join(lines)).stdout


def test_a_report_of_several_specs_will_do(run, spec, report):
    (spec.parent / "wrong.exo").write_text("spec wrong")
    assert run("check", "wrong.exo", "demo.exo", "--output", "json=b.json").returncode == 2
    done = run("explain", "--finding", "b.json", "--subject", "low", "--check", "completeness")
    assert done.stdout == run("explain", "--finding", "a.json", "--check", "completeness").stdout != ""
    assert (
        run("trace", "b.json", "--check", "completeness").stdout
        == run("trace", "a.json", "--check", "completeness").stdout
    )


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ((), "say which spec the events are for"),
        (("demo.exo", "--check", "safety"), "--check chooses in a report: say with --finding in which"),
        (("demo.exo", "--step", "1"), "--step chooses in a report"),
        (("deadlock", "--finding", "no.json"), "deadlock names a page, to which --finding says nothing"),
        (("E101", "--events", "no.jsonl"), "E101 names a page, to which --events says nothing"),
        (("--finding", "a.json", "--events", "e"), "--finding has the events of its run"),
        (("--finding", "none.json"), "cannot read none.json"),
        (("--finding", "demo.exo"), "cannot use demo.exo: it is not JSON"),
        (("--finding", "a.json", "--check", "obligation"), "has no finding of `obligation` with a trace; with one: "),
        (("--finding", "a.json", "--check", "completeness", "--step", "3"), "there is no step 3: the run of"),
        (("--finding", "a.json", "--check", "completeness", "--step", "0"), "there is no step 0"),
        (("other.exo", "--finding", "a.json", "--check", "completeness"), "answers step 2 otherwise"),
    ],
)
def test_what_is_refused(run, spec, report, arguments, reason):
    (spec.parent / "other.exo").write_text(SPEC)
    done = run("explain", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert reason in done.stderr


def test_a_finding_about_the_start_has_no_step(run, spec):
    spec.write_text(SPEC + "forbid always_low: battery > 20;\n")
    assert run("check", "demo.exo", "--output", "json=a.json").returncode == 1
    done = run("explain", "--finding", "a.json", "--check", "consistency")
    assert (done.returncode, done.stdout) == (2, "")
    assert "consistency always_low violated shows the start" in done.stderr
