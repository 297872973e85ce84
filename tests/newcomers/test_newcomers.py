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


def test_the_corpus_is_large_and_each_part_is_read() -> None:
    assert len(CASES) == PAGE.count("\n## ") >= LEAST
    assert len({case.text for case in CASES}) == len(CASES)
