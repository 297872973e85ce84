"""`exover explain` as a process."""

import json

from exover.manual import pages

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
