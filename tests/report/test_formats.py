"""The reports for machines: SARIF against its schema, JUnit XML as an XML reader sees it, commands of GitHub Actions.

`sarif-schema-2.1.0.json` is the schema that OASIS publishes with the standard, unchanged, in its JSON Schema draft-07
edition.
"""

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from exover.checks.finding import Baselined, Finding, Waived
from exover.checks.questions import CHECKS
from exover.manual import pages
from exover.model.event import Ask, Observe, Violated
from exover.model.model import NOWHERE, Location, Resource
from exover.model.trace import Moment, Trace
from exover.report import github, junit, sarif
from exover.report import json as json_report
from exover.report import text as text_report
from exover.report.summary import Summary
from tests.report.samples import FOUR, HERE, LASSO, finding, summary

SCHEMA = json.loads(Path(__file__).with_name("sarif-schema-2.1.0.json").read_text(encoding="utf-8"))
WAIVED = Waived("accepted by the board", date(2027, 1, 31))
HOSTILE = "a\x1b<b>&\"'%,:\r\n]]>\ud800::error::x"


def with_excuses() -> Summary:
    """A report with a waived error, a known warning, one that counts, and one that the baseline has otherwise."""
    found = [
        replace(finding("deadlock", "error", "violated", LASSO), excuse=WAIVED, standing="new"),
        replace(finding("lockout", "warning", "violated"), excuse=Baselined(), standing="unchanged"),
        replace(finding("rule-use", "warning", "unknown"), standing="updated"),
        replace(finding("safety", "error", "holds"), standing="unchanged"),
    ]
    return replace(summary(*found), counted=frozenset({"error", "warning"}))


# ---- SARIF ----


def log(whole: Summary, **options: bool) -> Any:
    """Return the only run of a SARIF log that its schema allows."""
    content = json.loads(sarif.render(whole, **options))
    jsonschema.Draft7Validator(SCHEMA, format_checker=jsonschema.FormatChecker()).validate(content)
    (run,) = content["runs"]
    return run


def test_sarif_is_valid_and_tells_every_finding() -> None:
    run = log(FOUR)
    results = run["results"]
    assert [(r["ruleId"], r["kind"], r["level"]) for r in results] == [
        ("exover/safety", "pass", "none"),
        ("exover/deadlock", "fail", "error"),
        ("exover/deadlock", "pass", "none"),
        ("exover/lockout", "open", "none"),
    ]
    rules = run["tool"]["driver"]["rules"]
    assert [rules[r["ruleIndex"]]["id"] for r in results] == [r["ruleId"] for r in results]
    assert [rule["defaultConfiguration"]["level"] for rule in rules] == ["error", "error", "warning"]
    assert results[1]["locations"][0]["physicalLocation"] == {
        "artifactLocation": {"uri": "specs/demo.exo"},
        "region": {"startLine": 3, "startColumn": 5},
    }
    assert all("baselineState" not in result and result["suppressions"] == [] for result in results)


def test_sarif_tells_the_run_as_a_code_flow() -> None:
    (flow,) = log(FOUR)["results"][1]["codeFlows"]
    (thread,) = flow["threadFlows"]
    assert [step["location"]["message"]["text"] for step in thread["locations"]] == [
        "ask nd.goto(x = 1, to = dock); launch nd.goto[1](x = 1, to = dock)",
        "ask nd.stop(); kill nd.goto[1] [drive]; wait nd.stop [drive] a stop\x1b is a stop",
        "report nd.stop ok(dist = 0.5)",
        "observe battery broken, taken as 0; violation [low] empty",
    ]
    assert thread["properties"] == {"loopStart": 1}
    empty = summary(finding("consistency", "error", "violated", Trace(())))
    assert "codeFlows" not in log(empty)["results"][0]


def test_sarif_steps_stand_where_their_request_is_declared() -> None:
    whole = summary(finding("deadlock", "error", "violated", LASSO))
    requests = tuple(replace(r, location=Location("lib.exo", 7, 2)) for r in whole.model.requests)
    steps = log(replace(whole, model=replace(whole.model, requests=requests)))["results"][0]["codeFlows"][0]
    places = [step["location"]["physicalLocation"] for step in steps["threadFlows"][0]["locations"]]
    assert places[0] == {"artifactLocation": {"uri": "lib.exo"}, "region": {"startLine": 7, "startColumn": 2}}
    assert places[3] == {"artifactLocation": {"uri": "specs/demo.exo"}}


def test_sarif_tells_what_is_excused_and_what_is_new() -> None:
    results = log(with_excuses())["results"]
    assert [result["baselineState"] for result in results] == ["new", "unchanged", "updated", "unchanged"]
    assert [[s["justification"] for s in result["suppressions"]] for result in results] == [
        ["waived until 2027-01-31: accepted by the board"],
        ["known: the baseline has it"],
        [],
        [],
    ]


def test_sarif_fingerprints_know_no_lines() -> None:
    def prints(*found: Finding, spec: str = "demo") -> list[str]:
        whole = summary(*found)
        return [
            result["partialFingerprints"]["exover/v1"]
            for result in log(replace(whole, model=replace(whole.model, name=spec)))["results"]
        ]

    base = finding("deadlock", "error", "violated", LASSO)
    (known,) = prints(base)
    assert prints(replace(base, location=Location("b.exo", 9, 1), message="x", trace=None)) == [known]
    others = [replace(base, check="safety"), replace(base, subject="nd.goto"), replace(base, verdict="unknown")]
    assert len({known, *prints(*others), *prints(base, spec="other")}) == 5


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("specs/a b%.exo", "specs/a%20b%25.exo"),
        ("/robot/a b.exo", "file:///robot/a%20b.exo"),
        ("été.exo", "%C3%A9t%C3%A9.exo"),
        ("no\udcffutf8:.exo", "no%FFutf8%3A.exo"),
    ],
)
def test_files_are_uris(file: str, expected: str) -> None:
    assert sarif.uri(file) == expected


def test_every_check_has_a_help_text() -> None:
    whole = summary(*(finding(check.name, check.severity, "holds") for check in CHECKS))
    for rule in log(whole)["tool"]["driver"]["rules"]:
        page = pages()[rule["id"].removeprefix("exover/")]
        assert rule["help"] == {"text": page.text, "markdown": page.markdown}
        assert rule["helpUri"] == f"exover:explain/{page.name}"


def test_sarif_takes_any_text() -> None:
    strange = replace(finding("safety", "error", "violated"), subject=HOSTILE, message=HOSTILE, location=NOWHERE)
    (result,) = log(summary(strange))["results"]
    assert result["message"]["text"] == f"{HOSTILE}: {HOSTILE}"
    assert result["locations"] == [{"physicalLocation": {"artifactLocation": {"uri": "specs/demo.exo"}}}]


# ---- JUnit ----


def test_junit_has_a_suite_for_each_check_and_a_case_for_each_subject() -> None:
    root = ElementTree.fromstring(junit.render(FOUR))
    assert root.attrib == {"name": "demo", "tests": "4", "failures": "1", "errors": "0", "skipped": "1"}
    assert [(suite.get("name"), len(suite), suite.get("failures")) for suite in root] == [
        ("safety", 1, "0"),
        ("deadlock", 2, "1"),
        ("lockout", 1, "0"),
    ]
    case = root[1][0]
    assert case.attrib == {"classname": "demo.deadlock", "name": "nd.stop", "file": "specs/demo.exo", "line": "3"}
    (failure,) = case
    assert failure.attrib == {"message": "violated: it waits for ever", "type": "violated"}
    assert failure.text is not None
    assert failure.text.startswith("1. ask nd.goto(x = 1, to = dock)\n     launch nd.goto[1]")
    assert failure.text.endswith("and again from step 2, for ever")
    assert [len(case) for case in (root[0][0], root[1][1])] == [0, 0]


def test_junit_fails_iff_the_command_does() -> None:
    (skipped,) = ElementTree.fromstring(junit.render(FOUR))[2][0]
    assert (skipped.tag, skipped.get("message")) == ("skipped", "unknown: it waits for ever")
    root = ElementTree.fromstring(junit.render(with_excuses()))
    assert [child.tag for suite in root for case in suite for child in case] == ["skipped", "skipped", "error"]
    assert root[0][0][0].get("message") == (
        "violated: it waits for ever (waived until 2027-01-31: accepted by the board)"
    )


def test_junit_takes_any_text() -> None:
    trace = Trace((Moment(Ask("nd.stop"), (Violated("]]>", "<&>\x00"),)),))
    strange = replace(finding(HOSTILE, "error", "violated", trace), subject=HOSTILE, message=HOSTILE)
    root = ElementTree.fromstring(junit.render(summary(strange)).encode("utf-8"))
    legal = HOSTILE.replace("\x1b", "\ufffd").replace("\ud800", "\ufffd")
    case = root[0][0]
    assert case.get("name") == legal
    assert case[0].get("message") == f"violated: {legal}"
    assert case[0].text == "1. ask nd.stop()\n     violation []]>] <&>\ufffd"


# ---- GitHub ----


def test_github_annotates_what_does_not_hold() -> None:
    first, second, last = github.render(FOUR).splitlines()
    assert first.startswith(
        "::error file=specs/demo.exo,line=3,col=5,title=deadlock nd.stop violated::it waits for ever%0A1. ask nd.goto("
    )
    assert second == "::warning file=specs/demo.exo,line=3,col=5,title=lockout nd.stop unknown::it waits for ever"
    assert last == "demo: violated: 1 error, 1 unknown; 2 of 4 findings ok"
    notices = github.render(with_excuses()).splitlines()[:2]
    assert notices[0].startswith("::notice file=")
    assert "::it waits for ever%0Awaived until 2027-01-31: accepted by the board%0A1. ask" in notices[0]
    assert notices[1].endswith("::it waits for ever%0Aknown: the baseline has it")


def test_github_commands_cannot_be_forged() -> None:
    strange = replace(finding("safety", "error", "violated"), subject=HOSTILE, message=HOSTILE)
    strange = replace(strange, location=replace(HERE, file="a,line=9:%.exo"))
    (command, _) = github.render(summary(strange)).split("\n", 1)
    data = "a\x1b<b>&\"'%25,:%0D%0A]]>\ud800::error::x"
    quoted = "a\x1b<b>&\"'%25%2C%3A%0D%0A]]>\ud800%3A%3Aerror%3A%3Ax"
    assert command == f"::error file=a%2Cline=9%3A%25.exo,line=3,col=5,title=safety {quoted} violated::{data}"


# ---- all ----


def test_no_report_knows_the_time_unless_asked() -> None:
    slower = replace(FOUR, findings=tuple(replace(f, seconds=9.0) for f in FOUR.findings))
    for report in (sarif, junit, github):
        assert report.render(slower) == report.render(FOUR)
    for report in (sarif, junit):
        assert report.render(slower, timings=True) != report.render(FOUR, timings=True)
    assert log(slower, timings=True)["results"][0]["properties"]["seconds"] == 9.0
    assert ElementTree.fromstring(junit.render(slower, timings=True))[1].get("time") == "18.000"


def test_text_and_json_tell_what_is_excused() -> None:
    whole = with_excuses()
    lines = text_report.render(whole).splitlines()
    assert "    waived until 2027-01-31: accepted by the board" in lines
    assert "    known: the baseline has it" in lines
    assert lines[-1] == "demo: unknown: 1 unknown, 1 waived, 1 known; 1 of 4 findings ok"
    found = json.loads(json_report.render(whole))["findings"]
    assert found[0]["excuse"] == {"kind": "waiver", "reason": "accepted by the board", "expires": "2027-01-31"}
    assert found[1]["excuse"] == {"kind": "baseline"}
    assert "excuse" not in found[2]
    assert [f["baseline"] for f in found] == ["new", "unchanged", "updated", "unchanged"]


def test_reports_of_a_spec_whose_tables_came_too_late() -> None:
    whole = replace(summary(finding("safety", "error", "unknown")), tables=None)
    assert json.loads(json_report.render(whole))["tables"] is None
    assert "tables: none, the command ended before they were made" in text_report.render(whole).splitlines()
    assert log(whole)["results"][0]["kind"] == "open"


def test_readings_of_consumables_have_a_place() -> None:
    whole = summary(finding("safety", "error", "violated", Trace((Moment(Observe("charge", 3), ()),))))
    charge = Resource("charge", 10, True, 10, (), location=Location("lib.exo", 4, 1))
    (result,) = log(replace(whole, model=replace(whole.model, resources=(charge,))))["results"]
    (step,) = result["codeFlows"][0]["threadFlows"][0]["locations"]
    assert step["location"]["message"]["text"] == "observe charge = 3"
    assert step["location"]["physicalLocation"]["artifactLocation"]["uri"] == "lib.exo"
