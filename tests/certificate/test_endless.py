"""What is said of runs without end is proved by rankings and by runs that come again; near misses are no proofs."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from exover.certificate.check import Checker
from exover.certificate.proof import Proof
from exover.certificate.table import Refused, decode
from exover.certificate.verify import read, verify
from exover.pipeline import Build, build, claimed, load_properties
from exover.proofs.certify import certificate, render
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of

SPEC = """spec endless;
module m {
    request a(v: real in 0 .. 2) { check not waiting(m.b) and not waiting(m.c); }
    request b() { check not waiting(m.c); wait until not active(m.a); }
    request c() { wait until not active(m.a) and not active(m.b) and not waiting(m.b); }
    request d() { interrupts self; wait until last(m.b) == ok; }
}
"""
FILE = """for endless;
property leads: always (waiting(m.c) leads to launched(m.c) or not waiting(m.c));
property again: ltl G F !waiting(m.c);
property twice: ltl X G F !waiting(m.c) & G F !waiting(m.c);
property never_ends: ltl G (waiting(m.d) -> F !waiting(m.d));
property rests: ctl AG (active(m.a) -> AF !active(m.a));
property may_stay: ctl EF (waiting(m.d) & EG waiting(m.d));
property path: ctl E [!active(m.b) U (active(m.a) & EX !active(m.a))];
property both: ctl EX active(m.a) & EF waiting(m.b);
property fast: possible launched(m.a with v > 1.5);
property slow: never (launched(m.a with v > 1.5) and launched(m.a with v < 1));
assume fair reports;
assume never asked(m.a with v == 1);
"""
Json = dict[str, Any]


@pytest.fixture(scope="module")
def expected(built: Build) -> Json:
    return claimed(built.model, properties_of(built))


@pytest.fixture(scope="module")
def built() -> Build:
    return build(model_of(SPEC))


def properties_of(built: Build, text: str = FILE) -> Any:
    loaded = load_properties(Source("endless.prop", text), built.model)
    assert loaded.properties is not None, loaded.diagnostics
    return loaded.properties


@pytest.fixture(scope="module")
def made(built: Build) -> Json:
    properties = properties_of(built)
    findings = check_by_diagrams(built.compiled, properties=properties).findings
    return certificate(built.compiled, built.data, findings, properties, "0", lambda what: None)


def finding(made: Json, check: str, subject: str) -> Json:
    (found,) = [each for each in made["findings"] if (each["check"], each["subject"]) == (check, subject)]
    return found


def parts(made: Json, subject: str, check: str = "property") -> list[Any]:
    return finding(made, check, subject)["proof"]["parts"]


def kinds(made: Json, subject: str, check: str = "property") -> tuple[str, list[str | None]]:
    return finding(made, check, subject)["verdict"], [p and p["kind"] for p in parts(made, subject, check)]


def test_what_is_said_of_runs_without_end_is_proved(built: Build, made: Json, expected: Json) -> None:
    found = verify(built.data, read(render(made)), expected, 20)
    assert not [each for each, _ in found.unproved if each["check"] in ("property", "starvation", "vacuity")]
    assert kinds(made, "m.c", "starvation") == ("holds", ["invariant", "ranking"])
    assert kinds(made, "m.d", "starvation") == ("violated", ["run", "run"])
    assert kinds(made, "again") == kinds(made, "twice") == ("holds", ["ranking"])
    assert kinds(made, "never_ends") == ("violated", ["run"])
    assert kinds(made, "leads") == kinds(made, "rests") == ("holds", ["invariant", "ranking"])
    assert kinds(made, "may_stay") == ("holds", ["run", "run"])
    assert kinds(made, "path") == ("holds", ["run", "run"])
    assert kinds(made, "both")[0] == kinds(made, "fast")[0] == kinds(made, "slow")[0] == "holds"


def change(subject: str, number: int, how: Callable[[Json], object], check: str = "property") -> Callable[[Json], Any]:
    return lambda made: how(parts(made, subject, check)[number])


def layers(how: Callable[[list[Json]], list[Json]]) -> Callable[[Json], Any]:
    return change("m.c", 1, lambda part: part.update(layers=how(part["layers"])), "starvation")


BROKEN: dict[str, Callable[[Json], Any]] = {
    "no layer": layers(lambda all: []),
    "the last layer left out": layers(lambda all: all[:-1]),
    "the first layer left out": layers(lambda all: all[1:]),
    "the layers turned round": layers(lambda all: all[::-1]),
    "layers that lead out at once": layers(lambda all: [each | {"never": None} for each in all]),
    "layers that are left by another report": layers(lambda all: [each | {"never": "reported.2"} for each in all]),
    "a report of what is not there": layers(lambda all: [each | {"never": "reported.9"} for each in all]),
    "a promise that nobody made": layers(lambda all: [each | {"never": "promise.0"} for each in all]),
    "one layer for everything": layers(lambda all: [each | {"states": "true"} for each in all[:1]]),
    "a ranking of nothing": change("again", 0, lambda part: part.update(layers=[])),
    "another promise": change(
        "twice", 0, lambda part: [each.update(never="promise.0") for each in part["layers"] if each["never"]]
    ),
    "a run that comes again too late": change("never_ends", 0, lambda part: part.update(loop=len(part["steps"]))),
    "a run that does not come again": change("never_ends", 0, lambda part: part.update(steps=part["steps"][:-1])),
    "a run that begins later": change("m.d", 1, lambda part: part.update({"from": part["from"] - 1}), "starvation"),
    "a run that ends earlier": change("m.d", 0, lambda part: part["steps"].pop(), "starvation"),
    "a ranking in place of a run": change("may_stay", 1, lambda part: part.update(kind="ranking", layers=[])),
    "a run in place of a ranking": lambda made: parts(made, "again").__setitem__(0, parts(made, "never_ends")[0]),
    "fewer parts": lambda made: parts(made, "may_stay").pop(),
    "more parts": lambda made: parts(made, "may_stay").append(None),
    "a verdict turned round": lambda made: finding(made, "starvation", "m.c").update(verdict="violated"),
    "runs that need not be fair": lambda made: finding(made, "starvation", "m.c")["claim"].update(fair=False),
}


@pytest.fixture(scope="module")
def checker(built: Build, made: Json) -> Checker:
    found = Checker(decode(built.data), 20, watched=made["watched"])
    found.assumptions = [found.formula(text) for text in made["assumptions"]]
    found.induction(made["invariant"])
    return found


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_nearly_a_proof_is_refused(checker: Checker, made: Json, what: str) -> None:
    changed = deepcopy(made)
    BROKEN[what](changed)
    (wrong,) = [each for each, was in zip(changed["findings"], made["findings"], strict=True) if each != was]
    with pytest.raises((Refused, IndexError, KeyError)):
        Proof(checker, wrong["claim"], wrong["proof"]["parts"]).check(wrong["verdict"])


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("watched", [["launch", 0, "(< value.0 0.5)"]]),
        ("watched", [["launch", 0, "start"]]),
        ("watched", []),
        ("assumptions", ["false"]),
        ("assumptions", []),
    ],
)
def test_what_is_assumed_and_watched_is_what_the_properties_say(
    built: Build, made: Json, expected: Json, key: str, value: list[Any]
) -> None:
    with pytest.raises(Refused, match=f"`{key}` is not what the spec"):
        verify(built.data, made | {key: value}, expected, 20)


@pytest.mark.parametrize("value", [[], [["launch", 0, "start"]], [["launch", 0, "(< value.1 0.5)"]]])
def test_what_is_watched_is_about_arguments(built: Build, made: Json, value: list[Any]) -> None:
    with pytest.raises(Refused):
        verify(built.data, made | {"watched": value}, None, 20)
