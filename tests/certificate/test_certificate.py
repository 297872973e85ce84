"""A certificate is taken as it was written, and refused as soon as anything in it, or what it is about, is not so."""

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from struct import pack as pack_words
from typing import Any
from zlib import crc32

import pytest

from exover.certificate.check import Checker, SolverGaveUp
from exover.certificate.table import HEADER, Refused, decode
from exover.certificate.verify import Unreadable, Verified, read, verify
from exover.model.property import NO_PROPERTIES
from exover.ocrd.packing import pack
from exover.pipeline import Build, build, claimed
from exover.proofs.certify import certificate, render
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of

SPEC = """spec demo;
poster battery: int in 0 .. 100 = 100 else 0;
module nd {
    request goto(x: real in 0 .. 9) { fail low: when battery < 10; }
    request stop();
    request never() { check 1 > 2; }
}
mutex drive: nd.stop over nd.goto because "a stop is a stop";
launch home: nd.goto(0) when battery in 10 .. 20;
"""
Json = dict[str, Any]


@pytest.fixture(scope="module")
def built() -> Build:
    return build(model_of(SPEC))


@pytest.fixture(scope="module")
def made(built: Build) -> Json:
    outcome = check_by_diagrams(built.compiled)
    return certificate(built.compiled, built.data, outcome.findings, NO_PROPERTIES, "0", lambda what: None)


@pytest.fixture(scope="module")
def verified(built: Build, made: Json) -> Verified:
    """Return what is said of the certificate as it was written."""
    return verify(built.data, read(render(made)), claimed(built.model, NO_PROPERTIES), 20)


def finding(made: Json, check: str, subject: str) -> Json:
    (found,) = [each for each in made["findings"] if (each["check"], each["subject"]) == (check, subject)]
    return found


def refusal(built: Build, changed: Json, expected: Json | None = None) -> str:
    with pytest.raises(Refused) as refused:
        verify(built.data, read(render(changed)), expected, 20)
    return str(refused.value)


def test_a_certificate_is_verified_and_says_what_has_no_proof(verified: Verified) -> None:
    kinds = {(f["check"], f["verdict"], part["kind"]) for f in verified.proved for part in f["proof"]["parts"] if part}
    assert {
        ("safety", "holds", "invariant"),
        ("completeness", "holds", "invariant"),
        ("reachability", "holds", "run"),
        ("reachability", "violated", "invariant"),
        ("obligation", "violated", "run"),
        ("deadlock", "holds", "layers"),
        ("lockout", "holds", "layers"),
        ("rule-use", "holds", "run"),
    } <= kinds
    assert {each["check"] for each, _ in verified.unproved} <= {
        "tables",
        "redundancy",
        "idle-guard",
        "starvation",
        "lockout",
    }
    assert all(reason for _, reason in verified.unproved)


def test_tables_that_say_that_they_are_unchecked_are_verified_too(built: Build, made: Json, verified: Verified) -> None:
    unchecked = build(built.model, unchecked=True)
    assert unchecked.data != built.data
    proved = verify(unchecked.data, read(render(made)), claimed(built.model, NO_PROPERTIES), 20).proved
    assert proved == verified.proved != ()
    assert "another table" in refusal(replace(built, data=_with_flags(built.data, 2)), made)


def _with_flags(data: bytes, flags: int) -> bytes:
    head = data[:8] + pack_words("<I", flags)
    return head + pack_words("<I", crc32(data[16:], crc32(head + bytes(4)))) + data[16:]


def test_the_same_findings_give_the_same_bytes(built: Build, made: Json) -> None:
    outcome = check_by_diagrams(built.compiled)
    again = certificate(built.compiled, built.data, outcome.findings, NO_PROPERTIES, "0", lambda what: None)
    assert render(again) == render(made)


def test_one_bit_of_the_table_or_of_the_spec_is_enough(built: Build, made: Json) -> None:
    for at in (5, 30, len(built.data) - 3):
        damaged = bytearray(built.data)
        damaged[at] ^= 1
        with pytest.raises(Refused):
            verify(bytes(damaged), made, None, 20)
    other = build(model_of(SPEC.replace("battery < 10", "battery < 11")))
    with pytest.raises(Refused, match="another table"):
        verify(other.data, made, None, 20)
    tables = built.tables
    renamed = pack(type(tables)(**{n: getattr(tables, n) for n in tables.__slots__} | {"digest": bytes(32)}))
    with pytest.raises(Refused, match="another table"):
        verify(renamed, made, None, 20)
    assert "another spec" in refusal(built, made | {"spec_sha256": "00" * 32})


def test_what_is_not_invariant_is_refused(built: Build, made: Json) -> None:
    assert "false what should be invariant" in refusal(built, made | {"invariant": ["(= phase.0 0)"]})
    assert "not true at first" in refusal(built, made | {"invariant": ["(= phase.0 1)"]})
    assert "it does not follow" in refusal(built, made | {"invariant": []})


@pytest.mark.parametrize(
    "formula",
    ["(declare-const p Bool)", "true) (assert false", "phase.99", "(exists ((x Int)) (= x phase.0))", "other.0", 5],
)
def test_formulas_speak_of_the_table_alone(built: Build, made: Json, formula: str) -> None:
    refusal(built, made | {"invariant": [formula]})


def part(made: Json, check: str, subject: str, kind: str) -> Json:
    (found,) = [p for p in finding(made, check, subject)["proof"]["parts"] if p and p["kind"] == kind]
    return found


def steps(made: Json) -> list[Json]:
    """Return the steps of the run that shows that nd.goto can be launched."""
    found: list[Json] = part(made, "reachability", "nd.goto", "run")["steps"]
    return found


def layers(made: Json) -> list[Json]:
    """Return the layers from which nd.stop can be launched."""
    found: list[Json] = part(made, "lockout", "nd.stop", "layers")["layers"]
    return found


BROKEN: dict[str, Callable[[Json], object]] = {
    "a verdict turned round": lambda made: finding(made, "safety", "drive").update(verdict="violated"),
    "a claim that does not follow": lambda made: finding(made, "safety", "drive")["claim"].update(
        formula=["not", ["EX", ["EU", "true", "(not (= phase.0 0))"]]]
    ),
    "an answer that the table does not give": lambda made: steps(made)[0].update(answers=[["launch", 0, 1, -1]]),
    "a run that shows nothing": lambda made: part(made, "reachability", "nd.goto", "run").update(steps=[]),
    "an event out of range": lambda made: steps(made)[0].update(event=["ask", 0, 0, ["10"]]),
    "an event that is none": lambda made: steps(made)[0].update(event=["ask", 7, 0, []]),
    "a layer too few": lambda made: layers(made).pop(),
    "a layer that does not lead on": lambda made: layers(made)[0].update(event=["observe", 0, 0, [50]]),
    "a proof of another kind": lambda made: finding(made, "lockout", "nd.stop")["proof"].update(
        parts=[{"kind": "invariant"}, None, {"kind": "invariant"}]
    ),
    "a proof that is none": lambda made: finding(made, "lockout", "nd.stop").update(proof={"kind": "layers"}),
    "parts that are none": lambda made: finding(made, "lockout", "nd.stop")["proof"].update(parts=5),
    "a part too few": lambda made: finding(made, "lockout", "nd.stop")["proof"]["parts"].pop(),
    "a part too many": lambda made: finding(made, "lockout", "nd.stop")["proof"]["parts"].append({"kind": "invariant"}),
    "a finding left out": lambda made: made["findings"].remove(finding(made, "safety", "nd.goto.low")),
    "a finding there twice": lambda made: made["findings"].append(finding(made, "safety", "drive")),
    "a request left out": lambda made: made["requests"].pop(),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_certificate_that_lies_is_refused(built: Build, made: Json, what: str) -> None:
    changed = deepcopy(made)
    BROKEN[what](changed)
    changed["findings"].sort(key=made["findings"].__contains__)  # the lie is looked at first
    refusal(built, changed)


def test_findings_that_a_table_calls_for_may_not_be_missing(built: Build, made: Json) -> None:
    wanted = [
        (check, name) for check in ("reachability", "deadlock", "lockout", "starvation") for name in made["requests"]
    ]
    wanted += [(check, "nd.goto.low") for check in ("consistency", "safety", "completeness", "rule-use")]
    wanted += [(check, "home") for check in ("obligation", "rule-use")]
    for check, subject in wanted:
        left = [each for each in made["findings"] if (each["check"], each["subject"]) != (check, subject)]
        assert refusal(built, made | {"findings": left}) == f"the finding {check} {subject} is left out"


def test_claims_are_those_of_the_spec(built: Build, made: Json) -> None:
    changed = deepcopy(made)
    finding(changed, "safety", "drive")["claim"]["formula"][1][1][2] = "false"
    verify(built.data, changed, None, 20)
    assert "claims are not those of the spec" in refusal(built, changed, claimed(built.model, NO_PROPERTIES))


def test_names_are_those_of_the_spec(built: Build, made: Json) -> None:
    wanted = claimed(built.model, NO_PROPERTIES)
    for key in ("requests", "reasons"):
        assert f"its `{key}` is not what the spec" in refusal(built, made | {key: made[key][::-1]}, wanted)
    assert "its `spec` is not what the spec" in refusal(built, made | {"spec": "other"}, wanted)


@pytest.mark.parametrize("key", ["tool", "spec", "requests", "watched", "invariant", "kept", "findings"])
def test_what_lacks_a_key_is_no_certificate(made: Json, key: str) -> None:
    with pytest.raises(Unreadable, match=f"it lacks `{key}`"):
        read(render({name: value for name, value in made.items() if name != key}))


def test_a_finding_that_lacks_a_key_is_no_finding(made: Json) -> None:
    for wrong in ({"check": "safety", "subject": "drive", "claim": None, "proof": {}}, 5, []):
        with pytest.raises(Unreadable, match="a finding lacks `"):
            read(render(made | {"findings": [*made["findings"], wrong]}))


WORDS: dict[str, Callable[[Json], object]] = {
    "safety drive: the proof lacks 'parts'": lambda made: finding(made, "safety", "drive")["proof"].pop("parts"),
    "safety drive: the proof has fewer parts than the claim": lambda made: finding(made, "safety", "drive")[
        "proof"
    ].update(parts=[]),
    "lockout nd.stop: the proof lacks 'layers'": lambda made: part(made, "lockout", "nd.stop", "layers").pop("layers"),
    "safety drive: the proof has not the form": lambda made: finding(made, "safety", "drive").update(verdict="unknown"),
    "this is no formula of SMT-LIB: 5": lambda made: made.update(invariant=[5]),
    "not true at first: false": lambda made: made.update(invariant=["false"]),
    "it, or the table, has not the form": lambda made: made.update(watched=[5]),
    "the event `ask` of request 1 makes false what should be invariant": lambda made: made.update(
        invariant=["(= phase.1 0)"]
    ),
    "the event `report` of slot 0, ok makes `kept` false": lambda made: made.update(kept=["(= last.0 0)"]),
    'the table has no event ["ask", 7, 0, []]': lambda made: steps(made)[0].update(event=["ask", 7, 0, []]),
}


@pytest.mark.parametrize("said", WORDS)
def test_a_refusal_says_in_words_what_is_wrong(built: Build, made: Json, said: str) -> None:
    changed = deepcopy(made)
    WORDS[said](changed)
    assert said in refusal(built, changed)


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b'{"certificate": 1}', b"\xff", b"[" * 100_000])
def test_what_is_no_certificate_cannot_be_read(content: bytes) -> None:
    with pytest.raises(Unreadable):
        read(content)


@pytest.mark.parametrize("written", [1, 3.0, True, "3", None])
def test_a_certificate_of_another_format_cannot_be_read(made: Json, written: object) -> None:
    with pytest.raises(Unreadable, match="format"):
        read(json.dumps(made | {"certificate": written}).encode())


def test_what_says_a_key_twice_cannot_be_read(made: Json) -> None:
    text = json.dumps(made)
    read(text.encode())
    for once, twice in (("{", '{"findings": [], '), ('"check":', '"check": "safety", "check":')):
        with pytest.raises(Unreadable):
            read(text.replace(once, twice, 1).encode())


@pytest.mark.parametrize("verdict", ["hold", "holds (proved)", "", None, ["holds"]])
def test_a_verdict_that_is_none_is_refused(built: Build, made: Json, verdict: object) -> None:
    for kind in ("formula", "none"):
        changed = deepcopy(made)
        found = next(each for each in changed["findings"] if each["proof"]["kind"] == "formula")
        found["verdict"] = verdict
        if kind == "none":
            found["proof"] = {"kind": "none", "reason": ""}
        assert "is no verdict" in refusal(built, changed)


def test_a_solver_that_gives_up_is_not_believed(built: Build, made: Json, monkeypatch: pytest.MonkeyPatch) -> None:
    def gives_up(self: Checker, what: str, *parts: object) -> bool:
        raise SolverGaveUp(what)

    monkeypatch.setattr(Checker, "satisfiable", gives_up)
    with pytest.raises(SolverGaveUp):
        verify(built.data, made, None, 20)


def test_tables_that_do_not_fit_together_are_refused(built: Build) -> None:
    for data in (b"", b"EXOV" + bytes(200), built.data[:-1], built.data[: HEADER.size]):
        with pytest.raises(Refused):
            decode(data)


def test_a_table_out_of_which_nothing_can_be_made_is_no_proof_that_lacks_something(built: Build, made: Json) -> None:
    rules = tuple(replace(row, reason=99) for row in built.compiled.tables.rules)
    damaged = pack(replace(built.compiled.tables, rules=rules))
    changed = made | {"table_sha256": decode(damaged).sha256}
    assert refusal(replace(built, data=damaged), changed).startswith("it, or the table, has not the form")


@pytest.mark.parametrize("rest", ("request a() { fail bad: when low == 1; } }", "request a(); } forbid low == 1;"))
def test_a_rule_must_be_told_of_what_it_tests(rest: str) -> None:
    tables = build(model_of(f"spec told; poster low: int in 0 .. 1 = 0; module m {{ {rest}")).tables
    deaf = tuple(replace(entry, rules_end=entry.rules) for entry in tables.entries)
    Checker(decode(pack(tables))).induction([])
    with pytest.raises(Refused, match="is not told to rule 0"):
        Checker(decode(pack(replace(tables, entries=deaf)))).induction([])


def test_posters_are_compared_by_what_each_reads_whenever_that_changes() -> None:
    text = "poster a: real in 0 .. 3 = 0; poster b: real in 0 .. 3 = 1; module m { request x() { check a < b; } }"
    tables = build(model_of(f"spec compared; {text}")).tables
    Checker(decode(pack(tables))).induction([])
    (a, b), (one, other) = tables.variables, tables.orders
    for variables, orders in (
        ((a, replace(b, raw=a.raw)), tables.orders),
        ((a, replace(b, raw=-1)), tables.orders),
        (tables.variables, (one, replace(other, entry=-1))),
    ):
        with pytest.raises(Refused, match="is not compared by what it reads"):
            Checker(decode(pack(replace(tables, variables=variables, orders=orders))))


def test_what_slots_hold_stands_apart_and_a_broken_reading_is_in_range() -> None:
    text = "poster p: int in 0 .. 9 = 0 else 5; poster r: real in 0 .. 9 = 0 else 5;"
    module = "module m { request x(v: bool) { check p < 8; } request y(v: bool) { check r < 6; } }"
    tables = build(model_of(f"spec apart; {text} {module}")).tables
    first, second = tables.requests
    with pytest.raises(Refused, match="what they hold, do not follow each other"):
        decode(pack(replace(tables, requests=(first, replace(second, values=0)))))
    p, r = tables.variables
    far = len(tables.reals)
    for variables in ((replace(p, fallback=10), r), (p, replace(r, fallback=far))):
        damaged = replace(tables, variables=variables, reals=(*tables.reals, 9.5))
        with pytest.raises(Refused, match="out of its range"):
            Checker(decode(pack(damaged)))
