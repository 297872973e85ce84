"""The reports of docs/checks.md: keys in their order, the verdict, and text that a reader can follow."""

import json
from dataclasses import replace

import pytest

from exover.checks.finding import Baselined, Finding
from exover.diagnostics import Severity
from exover.loop.claim import CONTRADICTION, VERDICTS, Verdict
from exover.report import json as json_report
from exover.report import text as text_report
from tests.report.samples import FOUR, finding, summary
from tests.support.growth import LINEAR, growth


def test_json_has_the_keys_of_the_contract_in_their_order() -> None:
    report = json.loads(json_report.render(FOUR))
    assert list(report) == ["tool", "version", "spec", "file", "verdict", "findings", "model", "tables"]
    assert list(report["findings"][1]) == [
        "check", "subject", "severity", "verdict", "engine", "method", "message", "location", "trace", "loop_start",
    ]  # fmt: skip
    assert list(report["model"].items()) == [("requests", 2), ("rules", 1), ("state_bits", 9)]
    assert list(report["tables"]) == ["nodes", "depth", "bytes", "ram_bytes", "sha256"]
    assert list(report["findings"][0]["location"].items()) == [("file", "specs/demo.exo"), ("line", 3), ("column", 5)]
    assert (report["tool"], report["version"], report["verdict"]) == ("exover", "1.2.3", "violated")


def test_bits_of_a_state_that_are_not_known_are_said_to_be_unknown() -> None:
    unknown = replace(FOUR, figures=replace(FOUR.figures, state_bits=None))
    assert json.loads(json_report.render(unknown))["model"]["state_bits"] is None
    assert "state bits: unknown" in text_report.render(unknown)
    assert "state bits" not in text_report.render(FOUR)


def test_json_has_seconds_only_when_asked() -> None:
    assert "seconds" not in json_report.render(FOUR)
    keys = list(json.loads(json_report.render(FOUR, timings=True))["findings"][0])
    assert keys.index("seconds") == keys.index("method") + 1 == keys.index("message") - 1
    slower = replace(FOUR, findings=tuple(replace(f, seconds=9.0) for f in FOUR.findings))
    assert json_report.render(slower) == json_report.render(FOUR)
    assert text_report.render(slower) == text_report.render(FOUR)


def test_json_tells_the_run() -> None:
    found = json.loads(json_report.render(FOUR))["findings"]
    assert found[0]["trace"] is None
    assert found[0]["loop_start"] is None
    assert found[1]["loop_start"] == 1
    assert found[1]["trace"][0] == {
        "event": {"ask": "nd.goto", "args": {"x": 1, "to": "dock"}},
        "actions": [{"launch": "nd.goto", "instance": 1, "args": {"x": 1, "to": "dock"}}],
    }
    assert found[1]["trace"][2] == {
        "event": {"report": "nd.stop", "instance": 0, "outcome": "ok", "results": {"dist": 0.5}},
        "actions": [],
    }


@pytest.mark.parametrize(
    ("verdicts", "overall", "strict"),
    [
        ([], "holds", "holds"),
        ([("error", "holds"), ("note", "violated"), ("note", "unknown")], "holds", "holds"),
        ([("error", "holds"), ("warning", "violated")], "holds", "violated"),
        ([("error", "unknown"), ("warning", "violated")], "unknown", "violated"),
        ([("error", "unknown"), ("error", "violated")], "violated", "violated"),
        ([("error", "holds"), ("warning", "unknown")], "holds", "unknown"),
    ],
)
def test_the_verdict_is_that_of_the_severities_that_count(verdicts, overall, strict) -> None:
    whole = summary(*(finding("safety", severity, verdict) for severity, verdict in verdicts))
    assert whole.verdict == overall
    assert replace(whole, counted=frozenset({"error", "warning"})).verdict == strict
    assert json.loads(json_report.render(whole))["verdict"] == overall


def test_text_tells_what_is_open_first_with_its_run() -> None:
    assert text_report.render(FOUR) == (
        """\
specs/demo.exo: spec demo, 2 requests, 1 rule

deadlock: 1 violated, 1 ok (reachable set)
  nd.stop violated at specs/demo.exo:3:5: it waits for ever
    1. ask nd.goto(x = 1, to = dock)
         launch nd.goto[1](x = 1, to = dock)
       the loop starts here:
    2. ask nd.stop()
         kill nd.goto[1] [drive]
         wait nd.stop [drive] a stop\ufffd is a stop
    3. report nd.stop ok(dist = 0.5)
         past(nd.stop) none -> dist = 0.5
    4. observe battery broken, taken as 0
         violation [low] empty
         battery 100 -> 0
       and again from step 2, for ever
lockout: 1 unknown
  nd.stop unknown at specs/demo.exo:3:5: it waits for ever
safety: 1 ok (reachable set)

tables: 4 nodes, depth 3, 1 test before the first action, 512 bytes, 64 bytes of RAM
demo: violated: 1 error, 1 unknown; 2 of 4 findings ok
"""
    )


def test_a_run_is_printed_once() -> None:
    (shown,) = (each for each in FOUR.findings if each.trace is not None)
    again = replace(shown, check="starvation", severity="warning", subject="nd.goto")
    assert again.trace is not None
    other = replace(again, subject="nd.other", trace=replace(again.trace, loop_start=None))
    lines = text_report.render(replace(FOUR, findings=(*FOUR.findings, again, other))).splitlines()
    start = lines.index("starvation: 2 warnings")
    assert lines[start + 1].startswith("  nd.goto warning at ")
    assert lines[start + 2] == "    by the run of deadlock nd.stop"
    assert lines[start + 3].startswith("  nd.other warning at ")
    assert lines[start + 4] == "    1. ask nd.goto(x = 1, to = dock)"


def test_a_long_message_has_a_line_for_each_of_its_parts() -> None:
    short = replace(finding("safety", "error", "violated"), message="it is broken; for a cause")
    long = replace(short, message=f"it is broken; {'a cause of many words' * 9}; and another")
    told = text_report.render(summary(short, long)).splitlines()
    begun = [number for number, line in enumerate(told) if "it is broken" in line]
    assert told[begun[0]].endswith("it is broken; for a cause")
    assert told[begun[1]].endswith("it is broken;")
    parts = [f"      {'a cause of many words' * 9};", "      and another"]
    assert told[begun[1] + 1 : begun[1] + 3] == parts


def test_text_of_a_spec_in_which_all_holds() -> None:
    whole = summary(finding("safety", "error", "holds"), finding("safety", "error", "holds"))
    assert text_report.render(whole, timings=True).splitlines()[2:] == [
        "safety: 2 ok (reachable set), 0.500 s",
        "",
        "tables: 4 nodes, depth 3, 1 test before the first action, 512 bytes, 64 bytes of RAM",
        "demo: holds: all of 2 findings",
    ]


def test_people_are_told_of_violations_only_where_they_decide() -> None:
    told = {(s, v): finding("safety", s, v).word for s in ("error", "warning", "note") for v in VERDICTS}
    assert told == {
        ("error", "violated"): "violated",
        ("warning", "violated"): "warning",
        ("note", "violated"): "note",
        **{(severity, "unknown"): "unknown" for severity in ("error", "warning", "note")},
        **{(severity, "holds"): "ok" for severity in ("error", "warning", "note")},
    }
    whole = summary(finding("starvation", "warning", "violated"), finding("safety", "error", "holds"))
    lines = text_report.render(whole).splitlines()
    assert lines[2:4] == ["starvation: 1 warning", "  nd.stop warning at specs/demo.exo:3:5: it waits for ever"]
    assert lines[-1] == "demo: holds: 1 warning; 1 of 2 findings ok"


def test_one_cause_is_told_once() -> None:
    def about(check: str, severity: Severity, subject: str) -> Finding:
        return replace(finding(check, severity, "violated"), subject=subject)

    whole = summary(
        about("safety", "error", "storm"),
        about("completeness", "error", "storm"),
        about("rule-use", "warning", "dead"),
        about("rule-use", "warning", "nd.goto.calm"),
        about("redundancy", "note", "dead"),
        about("redundancy", "note", "twice"),
        about("idle-guard", "note", "dead.reject"),
        about("idle-guard", "note", "dead.kill nd.goto"),
        about("idle-guard", "note", "nd.goto.calm"),
        about("idle-guard", "note", "power.wait"),
    )
    place = "at specs/demo.exo:3:5: it waits for ever"
    assert text_report.render(whole).splitlines()[2:-3] == [
        "safety: 1 violated, told under completeness",
        "completeness: 1 violated",
        f"  storm violated {place}",
        "    the same cause: safety storm",
        "rule-use: 2 warnings",
        f"  dead warning {place}",
        "    the same cause: redundancy dead, idle-guard dead.reject, idle-guard dead.kill nd.goto",
        f"  nd.goto.calm warning {place}",
        "    the same cause: idle-guard nd.goto.calm",
        "redundancy: 2 notes, 1 told under rule-use",
        f"  twice note {place}",
        "idle-guard: 4 notes, 3 told under rule-use",
        f"  power.wait note {place}",
    ]
    excused = replace(whole, findings=(replace(whole.findings[0], excuse=Baselined()), *whole.findings[1:]))
    assert f"  storm violated {place}" in text_report.render(excused).splitlines()[2:5]


def test_a_contradiction_of_assumptions_is_told_once() -> None:
    message = f"{CONTRADICTION}; steps there break that at demo.prop:2:1"
    alike = replace(finding("property", "error", "violated"), message=message)
    other = replace(alike, subject="r", message="it is false")
    whole = summary(*(replace(alike, subject=name) for name in "pqs"), other)
    place = "violated at specs/demo.exo:3:5:"
    assert text_report.render(whole).splitlines()[2:-3] == [
        "property: 4 violated, 2 told under property",
        f"  p {place} {message}",
        "    the same cause: property q, property s",
        f"  r {place} it is false",
    ]


@pytest.mark.parametrize("verdict", ["violated", "unknown", "holds"])
def test_text_of_many_findings_takes_time_in_proportion(verdict: Verdict) -> None:
    def told(size: int) -> str:
        alike = [finding(check, "error", verdict) for check in ("safety", "completeness", "redundancy", "rule-use")]
        return text_report.render(summary(*(replace(a, subject=f"r{n}") for a in alike for n in range(size))))

    assert growth(told, 200) < LINEAR
