"""The walker of a page answers as the reference interpreter does: it reads the very bytes of the tables."""

import json
import os
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from exover.model.wording import value_text
from exover.run.simulate import ReferenceEngine, simulate
from tests.support import seldom
from tests.support.browser import built, opened, report, shown
from tests.support.events import Stream
from tests.support.seldom import SELDOM
from tests.support.vectors import NAMES, VECTORS, lines, without_details

SPECS = Path(__file__).parents[2] / "specs"
STEPS = int(os.environ.get("EXOVER_STEPS", "1500"))
"""`make soak` takes 100 000."""
WALK = "lines => answersTo(page.tables, page.names, lines)"
NUMBERS = """spec numbers;
module m {
    request go(wide: int in -9007199254740993 .. 9223372036854775807, x: real, y: real in -1 .. 1) {
        check large: wide > 9007199254740992;
        check ordered: x <= y or x > 1e20;
        check exact: x != 0.1;
    }
    request stop();
}
poster far: int in 0 .. 9223372036854775807 = 9007199254740993;
poster near: int in 0 .. 9223372036854775807 = 0;
poster speed: real in 0 .. 3 = 0.1 else 3;
forbid fast: active(m.go) and speed > 0.3 by kill m.go;
forbid apart: active(m.stop) and far == 9007199254740993 by kill m.stop or reject;
"""
ODD = [
    '{"ask": "m.go", "args": {"wide": 9007199254740993, "x": 0.30000000000000004, "y": 0.3}}',
    '{"ask": "m.go", "args": {"wide": 9007199254740993, "x": 1e21, "y": 1e-7}}',
    '{"report": "m.go", "outcome": "interrupted"}',
    '{"ask": "m.go", "args": {"wide": 9007199254740992, "x": -0.0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": 9007199254740993.0, "x": 1e16, "y": -0.0}}',
    '{"ask": "m.go", "args": {"wide": 9.007199254740993e15, "x": 1e22, "y": 1}}',
    '{"ask": "m.go", "args": {"wide": 9223372036854775808, "x": 0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": 9007199254740993.5, "x": 0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": 1e400, "x": 0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": 1e-400, "x": 0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": true, "x": 0, "y": 0}}',
    '{"ask": "m.go", "args": {"wide": 1, "x": NaN, "y": 0}}',
    '{"observe": "far", "value": 9007199254740992}',
    '{"ask": "m.stop"}',
    '{"observe": "far", "value": 9007199254740993}',
    '{"observe": "speed", "value": 0.30000000000000004}',
    '{"observe": "speed", "value": -Infinity}',
    '{"observe": "speed", "value": "fast"}',
    "{",
    "7",
    '{"tell": 1}',
    '{"ask": "m.stop", "args": 7}',
    '{"ask": "m.stop", "__proto__": {"a": 1}, "args": {}}',
    '{"ask": "m.stop", "args": {"__proto__": 1}}',
    '{"abort": "m.stop", "instance": 0.0}',
    '{"abort": "m.stop", "instance": 1e2}',
    '\ufeff{"ask": "m.stop"}',
    '{1: 2, "ask": "m.stop"}',
    '{"ask": "m.stop"} x',
    '{"ask": 012}',
    "   ",
]


def walked(page: Page, file: Path, events: list[str]) -> list[str]:
    with shown(page, file):
        answers: list[str] = page.evaluate(WALK, events)
        return answers


@pytest.mark.parametrize("path", sorted(SPECS.rglob("*.exo")), ids=lambda path: path.stem)
def test_random_runs(page: Page, path: Path, tmp_path: Path) -> None:
    _, made = built(path)
    pairs = list(Stream(made.model, 7).answered(STEPS))
    answers = walked(page, report(path, tmp_path, checked=False), [line for line, _ in pairs])
    for answer, (line, expected) in zip(answers, pairs, strict=True):
        assert answer == expected or without_details(answer) == without_details(expected), line


@pytest.mark.parametrize("name", NAMES)
def test_vectors(page: Page, name: str, tmp_path: Path) -> None:
    pairs = list(lines(name))
    answers = walked(page, report(VECTORS / f"{name}.exo", tmp_path, checked=False), [line for line, _ in pairs])
    for answer, (line, expected) in zip(answers, pairs, strict=True):
        assert json.dumps(without_details(answer)) == json.dumps(without_details(expected)), line


@pytest.mark.parametrize(("text", "events"), SELDOM.values(), ids=SELDOM)
def test_what_random_events_seldom_meet(page: Page, text: str, events: list[str], tmp_path: Path) -> None:
    path = tmp_path / "seldom.exo"
    path.write_text(f"spec s; {text}", encoding="utf-8")
    _, made = built(path)
    asked = seldom.lines(events)
    expected = list(simulate(made.model, ReferenceEngine(made.model), asked))
    assert walked(page, report(path, tmp_path, checked=False), asked) == expected


def test_numbers_are_exact(page: Page, tmp_path: Path) -> None:
    path = tmp_path / "numbers.exo"
    path.write_text(NUMBERS, encoding="utf-8")
    _, made = built(path)
    expected = list(simulate(made.model, ReferenceEngine(made.model), [line.encode() for line in ODD]))
    pairs = list(Stream(made.model, 3).answered(2000))
    file = report(path, tmp_path, checked=False)
    answers = walked(page, file, ODD)
    assert [without_details(answer) for answer in answers] == [without_details(answer) for answer in expected]
    assert [a for a in answers if "launch" in a] == [a for a in expected if "launch" in a]
    assert sum("launch" in answer for answer in expected) == 3
    random = walked(page, file, [line for line, _ in pairs])
    for answer, (line, right) in zip(random, pairs, strict=True):
        assert without_details(answer) == without_details(right), line


def test_a_damaged_table_is_refused(browser: Browser, tmp_path: Path) -> None:
    file = report(SPECS / "rover.exo", tmp_path, checked=False)
    with opened(browser, file) as page:
        for damage, reason in (
            ("bytes[100] ^= 1", "checksum"),
            ("bytes[0] = 0", "no table"),
            ("bytes = bytes.subarray(0, 9)", "too short"),
        ):
            found = page.evaluate(
                f"() => {{ let bytes = bytesOf(page.report.table); {damage};"
                " try { decode(bytes); return ''; } catch (error) { return error.message; } }"
            )
            assert reason in found


@pytest.mark.parametrize("name", ["rover", "satellite"])
def test_the_state_that_is_shown_is_that_of_the_reference(page: Page, name: str, tmp_path: Path) -> None:
    """Readings and pasts are kept for the reader alone, so no answer would tell that they are wrong."""
    path = SPECS / f"{name}.exo"
    _, made = built(path)
    stream = Stream(made.model, 11)
    events, expected = [], []
    for line in stream.lines(400):
        state = stream.state
        events.append(line)
        readings = [value_text(value) for value in state.readings.values()]
        pasts = [None if past is None else [value_text(value) for value in past] for past in state.past.values()]
        slots = [[slot.phase if slot else "idle" for slot in slots] for slots in state.slots.values()]
        expected.append([readings, pasts, slots])
    text = "values => values.map(plainText)"
    with shown(page, report(path, tmp_path, checked=False)):
        found = page.evaluate(
            f"lines => {{ const run = new Run(page.tables, page.names); const texts = {text};"
            " return lines.map(line => { const { state } = run.step(line); return [texts(state.readings),"
            " state.pasts.map(past => past && texts(past)),"
            " state.slots.map(slots => slots.map(({ phase }) => phase))]; }); }",
            events,
        )
    assert found == expected
