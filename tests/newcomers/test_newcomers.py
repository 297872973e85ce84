"""The corpus mistakes.md: every message says what is wrong, where, and what to do next."""

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from exover.diagnostics import CODES, Diagnostic
from exover.pipeline import load, load_properties
from exover.source import Source

ROVER = """spec rover;
enum zone { base, dock, field }
poster battery: int in 0 .. 100 = 100;
poster speed: real in 0 .. 2 = 0;
resource power: 100;
resource film: 36 consumable;
module nd { request goto(v: real in 0 .. 2); request stop(); }
module arm {
    state tool: {none, gripper} = none;
    request move(where: zone) { uses power 60; consumes film 1; }
    request calibrate();
}
"""
PAGE = Path(__file__).with_name("mistakes.md").read_text("utf-8")
PART = re.compile(r"^## (.+?)\n\n```(.+?)\n(.*?)^```\n\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
MARK = "«"
LEAST = 60


@dataclass(frozen=True, slots=True)
class Case:
    """A text of a kind, with marks, and what is told of it: message and advice of each mistake."""

    title: str
    kind: str
    text: str
    told: tuple[tuple[str, str], ...]


def cases() -> list[Case]:
    found = []
    for title, kind, text, told in PART.findall(PAGE):
        mistakes = re.findall(r"^- (.+)\n  (.+)$", told, re.MULTILINE)
        found.append(Case(title, kind, text, tuple(mistakes)))
    return found


def mistakes(kind: str, text: str) -> tuple[Source, tuple[Diagnostic, ...]]:
    if kind == "prop":
        model = load(Source("rover.exo", ROVER)).model
        assert model is not None
        source = Source("rover.prop", text)
        return source, load_properties(source, model).diagnostics
    source = Source("t.exo", ROVER * (kind == "exo rover") + text)
    return source, load(source).diagnostics


CASES = cases()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.title)
def test_a_mistake_is_told_at_its_place_with_what_to_do(case: Case) -> None:
    source, found = mistakes(case.kind, case.text.replace(MARK, ""))
    world = len(source.text) - len(case.text.replace(MARK, ""))
    *before, _ = case.text.split(MARK)
    places = [world + sum(map(len, before[:number])) for number in range(1, len(before) + 1)]
    assert [each.span.start for each in found if each.span] == places
    told = [(f"{each.code} {each.message}", f"{each.label}; {each.advice}".removeprefix("; ")) for each in found]
    assert told == list(case.told)
    assert all(each.code in CODES and each.advice for each in found)


FORM = re.compile(r"`((?:always|never|possible|from|ltl|ctl|CONDITION) [^`]*CONDITION[^`]*)`")
CLAUSE = re.compile(r"`((?:check|fail|wait until) [^`]*;)`")
STATEMENT = re.compile(r"`((?:forbid|limit|launch|mutex|resource|property) [^`]*;)`")
MEANT = {
    "CONDITION": "active(nd.stop)", "MODULE.REQUEST": "nd.stop", "NAME": "zz", "NUMBER": "1", "CAPACITY": "9",
    "REQUESTS": "nd.*", "LEVEL": "3",
}  # fmt: skip


def meant(form: str) -> str:
    """Return what a form is with names that the rover has; "" if it has placeholders that stand for several parts."""
    text = form.replace("MODULE.REQUEST, MODULE.REQUEST", "nd.goto, nd.stop")
    for placeholder, name in MEANT.items():
        text = text.replace(placeholder, name)
    return "" if "…" in text or re.search(r"\b[A-Z]{2,}\b", re.sub(r"\b[AE][FGX]\b", "", text)) else text


def advised() -> list[tuple[str, str]]:
    """Return the forms that the advice of the corpus names, as texts of a kind."""
    told = [advice for case in CASES for _, advice in case.told]
    texts = {("prop", f"for rover; property p: {meant(form)};") for each in told for form in FORM.findall(each)}
    clauses = {meant(form) for each in told for form in CLAUSE.findall(each)} - {""}
    texts |= {("exo rover", f"context arm.move {{ {clause} }}") for clause in clauses}
    for form in {meant(form) for each in told for form in STATEMENT.findall(each)} - {""}:
        texts.add(("prop", f"for rover; {form}") if form.startswith("property") else ("exo rover", form))
    return sorted(texts)


@pytest.mark.parametrize(("kind", "text"), advised(), ids=lambda part: part)
def test_what_the_advice_names_is_of_the_language(kind: str, text: str) -> None:
    assert mistakes(kind, text)[1] == ()


def test_the_corpus_is_large_and_each_part_is_read() -> None:
    assert len(CASES) == PAGE.count("\n## ") >= LEAST
    assert len({case.text for case in CASES}) == len(CASES)
