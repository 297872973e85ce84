"""Waivers and baselines: what is excused, what never is, and what is wrong with their files."""

import json
from dataclasses import replace
from datetime import date
from typing import Any

import pytest

from exover.checks.finding import Baselined, Finding, Waived
from exover.diagnostics import Severity, render
from exover.loop.claim import Verdict
from exover.model.model import Location
from exover.report import json as json_report
from exover.report.config import read_config
from exover.report.policy import (
    Baseline,
    Policy,
    Waiver,
    judge,
    read_baseline,
    remarks,
    waivable,
)
from exover.report.summary import overall
from exover.source import Source
from tests.report.samples import finding, summary

TODAY = date(2026, 11, 21)
LATER = date(2027, 1, 31)
CHECKS: dict[str, Severity] = {"safety": "error", "deadlock": "error", "lockout": "warning", "redundancy": "note"}


def waiver(check: str, subject: str = "nd.stop", expires: date = LATER, spec: str | None = None) -> Waiver:
    return Waiver(check, subject, "because", expires, spec, Location("exover.toml", 1, 3))


def one(item: Finding, policy: Policy) -> Finding:
    (judged,) = judge([item], policy, "demo", TODAY)
    return judged


# ---- waivers ----


def test_a_waiver_excuses_its_finding_through_its_last_day() -> None:
    open_ = finding("deadlock", "error", "violated")
    policy = Policy((waiver("deadlock"),))
    assert one(open_, policy).excuse == Waived("because", LATER)
    assert overall([one(open_, policy)]) == "holds"
    assert one(open_, Policy((waiver("deadlock", expires=TODAY),))).excuse is not None
    assert one(open_, Policy((waiver("deadlock", expires=date(2026, 11, 20)),))).excuse is None
    assert one(finding("deadlock", "error", "unknown"), policy).excuse is not None
    assert one(finding("deadlock", "error", "holds"), policy).excuse is None
    assert one(open_, Policy()) == open_


@pytest.mark.parametrize(
    "other",
    [waiver("lockout"), waiver("deadlock", "nd.goto"), waiver("deadlock", spec="rover")],
)
def test_a_waiver_excuses_nothing_else(other: Waiver) -> None:
    assert one(finding("deadlock", "error", "violated"), Policy((other,))).excuse is None


@pytest.mark.parametrize("check", ["consistency", "safety", "completeness", "tables", "a check of tomorrow"])
def test_no_waiver_excuses_what_a_checked_spec_guarantees(check: str) -> None:
    assert not waivable(check, "error")
    assert waivable(check, "warning")
    assert one(finding(check, "error", "violated"), Policy((waiver(check),))).excuse is None


def test_the_first_waiver_that_has_not_expired_counts() -> None:
    expired = waiver("deadlock", expires=date(2020, 1, 1))
    second, third = waiver("deadlock"), replace(waiver("deadlock"), reason="another")
    judged = one(finding("deadlock", "error", "violated"), Policy((expired, second, third)))
    assert judged.excuse == Waived("because", LATER)


def test_the_user_is_told_of_waivers_that_do_nothing() -> None:
    policy = Policy(
        (
            waiver("deadlock", expires=date(2026, 11, 20)),
            waiver("lockout"),
            waiver("redundancy"),
            waiver("deadlock", "nd.goto", spec="rover"),
        )
    )
    findings = [
        finding("deadlock", "error", "violated"),
        finding("lockout", "warning", "unknown"),
        finding("redundancy", "note", "holds"),
    ]
    assert list(remarks(findings, policy, "demo", TODAY)) == [
        "exover.toml:1: the waiver of deadlock nd.stop expired on 2026-11-20: it no longer counts",
        "exover.toml:1: the waiver of redundancy nd.stop matches nothing: no such finding of demo is open",
    ]


# ---- the baseline ----


@pytest.mark.parametrize(
    ("severity", "former", "now", "standing", "excused"),
    [
        ("warning", "violated", "violated", "unchanged", True),
        ("note", "violated", "violated", "unchanged", True),
        ("warning", "violated", "unknown", "updated", True),
        ("warning", "unknown", "violated", "updated", False),
        ("warning", "holds", "violated", "updated", False),
        ("warning", None, "violated", "new", False),
        ("warning", "holds", "holds", "unchanged", False),
        ("error", "violated", "violated", "unchanged", False),
        ("error", "unknown", "unknown", "unchanged", False),
    ],
)
def test_a_baseline_excuses_what_is_no_worse_and_no_error(
    severity: Severity, former: Verdict | None, now: Verdict, standing: str, excused: bool
) -> None:
    baseline: Baseline = {("lockout", "nd.stop"): former} if former else {("lockout", "nd.goto"): "violated"}
    judged = one(finding("lockout", severity, now), Policy(baseline=baseline))
    assert judged.standing == standing
    assert judged.excuse == (Baselined() if excused else None)


def test_a_waiver_goes_before_the_baseline() -> None:
    policy = Policy((waiver("lockout"),), {("lockout", "nd.stop"): "violated"})
    assert one(finding("lockout", "warning", "violated"), policy).excuse == Waived("because", LATER)


def test_a_report_is_a_baseline() -> None:
    whole = summary(finding("safety", "error", "holds"), finding("lockout", "warning", "violated"))
    assert read_baseline(json_report.render(whole), "demo") == {
        ("safety", "nd.stop"): "holds",
        ("lockout", "nd.stop"): "violated",
    }


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("{", "it is not JSON"),
        ("[" * 100_000, "it is nested too deep"),
        ("9" * 5000, "it is not JSON"),
        ("[]", "it is no report"),
        ('{"tool": "other", "findings": []}', "it is no report"),
        ('{"tool": "exover", "findings": {}}', "it is no report"),
        ('{"tool": "exover", "spec": "rover", "findings": []}', "it is about the spec rover, not demo"),
        ('{"tool": "exover", "spec": "demo", "findings": [3]}', "one of its findings has no check"),
        (
            '{"tool": "exover", "spec": "demo", "findings": [{"check": "a", "subject": "b", "verdict": []}]}',
            "one of its findings has no check, subject or verdict",
        ),
    ],
)
def test_what_is_no_baseline(content: str, reason: str) -> None:
    with pytest.raises(json_report.UnreadableReport, match=reason):
        read_baseline(content, "demo")


# ---- exover.toml ----


def config(text: str) -> tuple[tuple[Waiver, ...], list[str]]:
    source = Source("exover.toml", text)
    found, diagnostics = read_config(source, CHECKS)
    assert (found is None) == bool(diagnostics)
    return found.waivers if found else (), [render(diagnostic, source) for diagnostic in diagnostics]


GOOD = """\
# decided in the review of May
[[waiver]]
check = "lockout"
subject = "nd.goto"
reason = "the dock is closed for the season"
expires = 2027-01-31

[[waiver]]
check = "deadlock"
subject = "nd.stop"
reason = "…"
expires = 2027-02-28
spec = "rover"
"""


def test_waivers_are_read() -> None:
    waivers, mistakes = config(GOOD)
    assert mistakes == []
    assert waivers == (
        Waiver("lockout", "nd.goto", "the dock is closed for the season", LATER, None, Location("exover.toml", 2, 3)),
        Waiver("deadlock", "nd.stop", "…", date(2027, 2, 28), "rover", Location("exover.toml", 8, 3)),
    )
    assert config("") == ((), [])
    assert config(GOOD.replace("\n", "\r\n"))[0] == waivers


@pytest.mark.parametrize(
    ("old", "new", "message", "place"),
    [
        ("reason = \"…\"", "reasons = \"…\"", "error[E602]: a waiver has no key `reasons`", "exover.toml:11:1"),
        ("reason = \"…\"\n", "", "error[E604]: a waiver has no `reason`", "exover.toml:8:3"),
        ("reason = \"…\"", "reason = \" \"", "error[E603]: `reason` is not a text that", "exover.toml:11:1"),
        ("reason = \"…\"", "reason = 3", "error[E603]: `reason` is not a text that", "exover.toml:11:1"),
        ("2027-02-28", '"2027-02-28"', "error[E603]: `expires` is not a date", "exover.toml:12:1"),
        ("2027-02-28", "2027-02-28T10:00:00", "error[E603]: `expires` is not a date", "exover.toml:12:1"),
        ("2027-02-28", "2027-02-30", "error[E601]: the file is not TOML: ", "exover.toml:12:"),
        ("\"deadlock\"", "\"deadlok\"", "error[E605]: there is no check `deadlok`", "exover.toml:9:1"),
        ("\"deadlock\"", "\"safety\"", "error[E606]: an error of `safety` cannot be waived", "exover.toml:9:1"),
        ("# decided", "deny = true #", "error[E602]: a configuration has no key `deny`", "exover.toml:1:1"),
        ("[[waiver]]\ncheck = \"deadlock\"", "[[waivers]]\nx = 1", "error[E602]: a configuration has no", "toml:8:3"),
        ("spec = \"rover\"", "spec = ", "error[E601]: the file is not TOML: invalid value", "exover.toml:13:8"),
        ("spec = \"rover\"\n", "spec = [", "error[E601]: the file is not TOML: invalid value", "exover.toml:13:9"),
    ],
)  # fmt: skip
def test_mistakes_are_placed(old: str, new: str, message: str, place: str) -> None:
    assert old in GOOD
    (mistake,) = [each for each in config(GOOD.replace(old, new))[1] if each.startswith(message)]
    assert place in mistake.splitlines()[1]


def test_all_mistakes_are_told() -> None:
    waivers, mistakes = config('[[waiver]]\ncheck = "tables"\nsubjct = "a"\n[[waiver]]\n')
    assert waivers == ()
    assert [mistake.splitlines()[0] for mistake in mistakes] == [
        "error[E604]: a waiver has no `subject`",
        "error[E604]: a waiver has no `reason`",
        "error[E604]: a waiver has no `expires`",
        "error[E605]: there is no check `tables`",
        "error[E602]: a waiver has no key `subjct`",
        *(f"error[E604]: a waiver has no `{key}`" for key in ("check", "subject", "reason", "expires")),
    ]
    assert "did you mean `subject`?" in mistakes[4]


@pytest.mark.parametrize("text", ["waiver = 3", "[waiver]\ncheck = 1", 'waiver = ["a"]'])
def test_waivers_are_tables(text: str) -> None:
    assert config(text)[1][0].startswith("error[E603]: `waiver` is not an array of tables")


def test_waivers_may_be_written_in_line() -> None:
    text = 'waiver = [{check = "lockout", subject = "a", reason = "b", expires = 2027-01-31}]'
    (found,), mistakes = config(text)
    assert (found.check, found.location, mistakes) == ("lockout", Location("exover.toml", 1, 11), [])
    assert config(text.replace("subject", "x"))[1][1].splitlines()[1] == "  --> exover.toml:1:31"


def test_deep_nesting_is_a_mistake() -> None:
    assert config("a = " + "[" * 100_000)[1][0].startswith("error[E601]: the file is nested too deep")


def test_every_former_verdict_is_kept() -> None:
    entries: list[dict[str, Any]] = [
        {"check": "a", "subject": verdict, "verdict": verdict} for verdict in ("holds", "unknown", "violated")
    ]
    text = json.dumps({"tool": "exover", "spec": "demo", "findings": entries})
    assert read_baseline(text, "demo") == {("a", v): v for v in ("holds", "unknown", "violated")}
