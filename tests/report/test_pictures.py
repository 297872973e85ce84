"""Traces as text, JSON, drawings and waveforms: read back, and compared with the run that they show."""

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from exover.model.event import Event, Invalid
from exover.model.model import Model
from exover.model.semantics import Reference
from exover.model.trace import Trace, run
from exover.model.wire_reading import read_event
from exover.pipeline import build, load
from exover.rendering import picture, summarise
from exover.report import json as json_report
from exover.report.lanes import lanes_of
from exover.report.recorded import Recorded, choose, read, retell
from exover.report.story import Story, story_lines, story_of
from exover.report.summary import ERRORS
from exover.source import Source
from tests.support.diagrams import check_by_diagrams

ROOT = Path(__file__).parents[2]
VIOLATIONS = sorted((ROOT / "specs" / "violations").glob("*.exo"))
SVG = "{http://www.w3.org/2000/svg}"


def model_of(text: str, name: str = "demo.exo") -> Model:
    model = load(Source(name, text)).model
    assert model is not None
    return model


def events_of(model: Model, lines: list[str]) -> tuple[Event, ...]:
    found = [read_event(model, line) for line in lines]
    assert not any(isinstance(event, Invalid) for event in found)
    return tuple(event for event in found if not isinstance(event, Invalid))


def told(model: Model, lines: list[str], loop_start: int | None = None) -> Story:
    trace = run(Reference(model), events_of(model, lines))
    return story_of(model, replace(trace, loop_start=loop_start))


def recorded(title: str = "deadlock nd.goto violated") -> Recorded:
    check, subject, verdict = title.split(" ")
    return Recorded("demo.exo", check, subject, verdict, "it waits", (), None)


DEMO = """spec demo;
enum side { left, right }
poster battery: int in 0 .. 100 = 100 else 0;
poster temperature: real in -40 .. 200 = 20;
latch hot: when temperature > 80 until nd.cool;
resource power: 100;
resource ammo: 5 consumable = 2;
module nd {
    state homed: bool = false; state tool: {none, gripper} = none;
    request goto(x: real in 0 .. 9, to: side) returns (dist: real in 0 .. 9) instances 2 {
        uses power 40; interrupts self; fail low: when battery < 10 because "<low> & \\"empty\\"";
    }
    request stop() { on ok set tool = gripper; consumes ammo 1; }
    request cool();
    request tool();
}
mutex drive: nd.stop over nd.goto because "a stop is a stop";
"""
RUN = [
    '{"ask": "nd.goto", "args": {"x": 1, "to": "left"}}',
    '{"ask": "nd.stop"}',
    '{"observe": "temperature", "value": 90.5}',
    '{"report": "nd.goto", "outcome": "interrupted"}',
    '{"report": "nd.stop", "outcome": "ok"}',
    '{"ask": "nd.goto", "args": {"x": 0.25, "to": "right"}}',
    '{"observe": "battery", "value": 3}',
    '{"report": "nd.goto", "outcome": "failed"}',
]


# ---- text ----


def test_text_says_what_changed() -> None:
    assert list(story_lines(told(model_of(DEMO), RUN, loop_start=5))) == [
        "1. ask nd.goto(x = 1, to = left)",
        "     launch nd.goto[0](x = 1, to = left)",
        "2. ask nd.stop()",
        "     kill nd.goto[0] [drive] a stop is a stop",
        "     wait nd.stop [drive] a stop is a stop",
        "3. observe temperature = 90.5",
        "     temperature 20 -> 90.5",
        "     hot false -> true",
        "4. report nd.goto[0] interrupted",
        "     launch nd.stop()",
        "     level(ammo) 2 -> 1",
        "5. report nd.stop ok",
        "     nd.tool none -> gripper",
        "     past(nd.stop) none -> ok",
        "   the loop starts here:",
        "6. ask nd.goto(x = 0.25, to = right)",
        "     launch nd.goto[0](x = 0.25, to = right)",
        "7. observe battery = 3",
        '     kill nd.goto[0] [nd.goto.low] <low> & "empty"',
        "     battery 100 -> 3",
        "8. report nd.goto[0] failed",
        "   and again from step 6, for ever",
    ]


def test_a_waiting_that_becomes_a_clearing_is_told() -> None:
    spec = """spec s; module m { request a(); request b(); request c(); }
mutex x: m.b over m.a else wait; mutex y: m.b, m.c by wait;"""
    lines = ['{"ask": "m.a"}', '{"ask": "m.c"}', '{"ask": "m.b"}', '{"report": "m.c", "outcome": "failed"}']
    assert list(story_lines(told(model_of(spec), lines)))[-3:] == [
        "4. report m.c failed",
        "     kill m.a [x]",
        "     m.b waiting -> clearing",
    ]


# ---- findings of every kind, in every format ----


@pytest.mark.parametrize("path", VIOLATIONS, ids=[path.stem for path in VIOLATIONS])
def test_every_trace_of_the_violations_is_told_in_every_format(path: Path) -> None:
    model = model_of(path.read_text(encoding="utf-8"), str(path))
    built = build(model)
    outcome = check_by_diagrams(built.compiled)
    report = json_report.render(summarise(str(path), model, built, outcome, ERRORS))
    found = read(report)
    assert len(found) == sum(finding.trace is not None for finding in outcome.findings) > 0
    for each in found:
        story = retell(model, each)
        assert each.file == str(path)
        lines = picture(each, story, "text").splitlines()
        assert lines[0] == f"{each.title}: {each.message}"
        assert sum(bool(re.match(r" *\d+\. ", line)) for line in lines) == len(each.moments)
        again = read(picture(each, story, "json"))
        assert again == (each,)
        ET.fromstring(picture(each, story, "svg"))
        changes = waves(picture(each, story, "vcd"))
        assert {len(values) for values in changes.values()} == {len(each.moments) + 1}
        assert all(picture(each, story, form) == picture(each, story, form) for form in ("svg", "vcd"))


def test_a_lasso_keeps_its_loop_through_every_format() -> None:
    model = model_of(DEMO)
    story = told(model, RUN, loop_start=5)
    text = picture(recorded(), story, "text")
    assert "the loop starts here" in text
    assert text.endswith("and again from step 6, for ever\n")
    (back,) = read(picture(recorded(), story, "json"))
    assert back.loop_start == 5
    drawing = ET.fromstring(picture(recorded(), story, "svg"))
    assert "for ever: 6–8" in [element.text for element in drawing.iter(f"{SVG}text")]
    assert len(drawing.findall(f"{SVG}rect[@class='loop']")) == 1
    dump = picture(recorded(), story, "vcd")
    assert "$comment steps 6 to 8 are repeated for ever $end" in dump
    assert waves(dump)["demo.loop"] == ["0"] * 6 + ["1"] * 3


# ---- reading ----


def finding(**changes: object) -> str:
    story = told(model_of(DEMO), RUN)
    return json.dumps(json.loads(picture(recorded(), story, "json")) | changes)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "not JSON"),
        ("{", "not JSON"),
        ("[" * 200_000, "nested too deep"),
        ("9" * 10_000, "not JSON"),
        ("[]", "neither a report"),
        ('{"tool": "exover"}', "neither a report"),
        ('{"findings": 3}', "`findings` are no list"),
        ('{"findings": [3]}', "no object"),
        (finding(trace="x"), "wrong type"),
        (finding(trace=[3]), "lacks `event` or `actions`"),
        (finding(check=3), "wrong type"),
        (finding(loop_start=8), "no step of the trace"),
        (finding(loop_start=True), "no step of the trace"),
    ],
)
def test_what_is_no_report_is_refused_with_its_reason(text: str, reason: str) -> None:
    with pytest.raises(json_report.UnreadableReport, match=reason):
        read(text)


def test_findings_without_a_trace_are_left_out_and_violated_ones_come_first() -> None:
    whole = json.loads(finding())
    others = [
        whole | {"check": "reachability", "verdict": "holds"},
        whole | {"check": "safety", "trace": None},
        whole | {"check": "deadlock", "subject": "nd.stop"},
        whole,
    ]
    found = read(json.dumps({"file": "x.exo", "findings": others}))
    assert [(each.check, each.subject, each.file) for each in found] == [
        ("reachability", "nd.goto", "x.exo"),
        ("deadlock", "nd.stop", "x.exo"),
        ("deadlock", "nd.goto", "x.exo"),
    ]
    assert choose(found, None, None) == found[1:]
    assert choose(found, None, "nd.goto") == found[2:]
    assert choose(found, "reachability", None) == found[:1]
    assert choose(found, "safety", None) == ()
    assert read(json.dumps({"findings": [whole | {"file": None, "location": {"file": "y.exo"}}]}))[0].file == "y.exo"


@pytest.mark.parametrize(
    ("step", "event", "reason"),
    [
        (2, {"ask": "nd.gone"}, r"step 2 .*unknown-request, .*did you mean `nd.goto`"),
        (4, {"ask": "nd.cool"}, r"step 4 .*launch nd.cool"),
        (8, {"report": "nd.cool", "outcome": "ok"}, r"step 8 .*not-active"),
        (1, 3, r"step 1 .*not an object"),
    ],
)
def test_a_trace_of_another_spec_is_refused(step: int, event: object, reason: str) -> None:
    (whole,) = read(finding())
    moments = list(whole.moments)
    moments[step - 1] = (event, moments[step - 1][1])
    with pytest.raises(json_report.UnreadableReport, match=reason):
        retell(model_of(DEMO), replace(whole, moments=tuple(moments)))


def test_a_loop_that_does_not_come_back_is_refused() -> None:
    model = model_of("spec s; module m { request b(); }")
    lines = ['{"ask": "m.b"}', '{"report": "m.b", "outcome": "ok"}'] * 2
    for loop_start in range(4):
        (back,) = read(picture(recorded(), told(model, lines, loop_start), "json"))
        if loop_start == 2:
            assert retell(model, back) == told(model, lines, loop_start)
        else:
            with pytest.raises(
                json_report.UnreadableReport, match=f"not come back to where it was after {loop_start} steps"
            ):
                retell(model, back)


def test_a_spec_that_changed_since_is_refused() -> None:
    (whole,) = read(finding())
    with pytest.raises(json_report.UnreadableReport, match=r"step 2 otherwise .*changed since"):
        retell(model_of(DEMO.replace("nd.stop over nd.goto", "nd.stop, nd.goto")), whole)


# ---- drawings ----


def rects(drawing: ET.Element, kind: str) -> list[tuple[int, int]]:
    """Return where the bars of a class begin and end, from left to right."""
    found = drawing.findall(f"{SVG}rect[@class='{kind}']")
    return sorted((int(each.get("x", "")), int(each.get("x", "")) + int(each.get("width", ""))) for each in found)


def columns(drawing: ET.Element) -> dict[str, int]:
    """Return by number where the column of each step begins."""
    ticks = [int(path.get("d", "")[1:].split(" ")[0]) for path in drawing.findall(f"{SVG}path[@class='tick']")]
    labels = [text.text or "" for text in drawing.findall(f"{SVG}text") if re.fullmatch(r"start|\d+", text.text or "")]
    return dict(zip(labels, ticks, strict=False))


def test_the_drawing_shows_the_run() -> None:
    drawing = ET.fromstring(picture(recorded(), told(model_of(DEMO), RUN), "svg"))
    assert drawing.get("role") == "img"
    assert drawing.find(f"{SVG}title").text == "deadlock nd.goto violated"  # type: ignore[union-attr]
    assert "1. ask nd.goto(x = 1, to = left)" in (drawing.find(f"{SVG}desc").text or "")  # type: ignore[union-attr]
    at = columns(drawing)
    assert list(at) == ["start", *map(str, range(1, 9))]
    legend = 1  # each class once more
    assert rects(drawing, "running")[legend:] == [(at["1"], at["2"]), (at["4"], at["5"]), (at["6"], at["7"])]
    assert rects(drawing, "stopping")[legend:] == [(at["2"], at["4"]), (at["7"], at["8"])]
    assert rects(drawing, "clearing")[legend:] == [(at["2"], at["4"])]
    marks = [text.text for group in drawing.findall(f"{SVG}g") for text in group.findall(f"{SVG}text")]
    assert marks.count("kill drive") == 1
    assert "wait drive" in marks
    assert "kill nd.goto.low" in marks
    assert "ask x=1, to=left" in marks
    tips = [title.text or "" for title in drawing.iter(f"{SVG}title")]
    assert 'kill nd.goto[0] [nd.goto.low] <low> & "empty"' in tips
    assert "hot: true" in tips


def test_texts_of_a_spec_cannot_break_the_drawing() -> None:
    model = model_of(DEMO.replace("a stop is a stop", "]]> </text> & \u202e <!--"))
    drawing = picture(replace(recorded(), message="\x1b"), told(model, RUN), "svg")
    whole = [title.text or "" for title in ET.fromstring(drawing).iter(f"{SVG}title")]
    assert any("]]> </text> & \ufffd <!--" in text for text in whole)
    # A title may come from anywhere.
    hostile = picture(replace(recorded(), subject="\x00\x1b\ud800</title>"), told(model, RUN), "svg")
    assert ET.fromstring(hostile).find(f"{SVG}title").text == "deadlock \ufffd\ufffd\ufffd</title> violated"  # type: ignore[union-attr]


@pytest.mark.parametrize("length", [1, 3, 200])
def test_nothing_overlaps_in_a_short_run_and_in_a_long_one(length: int) -> None:
    model = model_of(DEMO)
    story = told(model, (RUN * 30)[:length])
    drawing = ET.fromstring(picture(recorded(), story, "svg"))
    width, height = int(drawing.get("width", "")), int(drawing.get("height", ""))
    assert width < 1600
    texts: dict[int, list[tuple[float, float]]] = {}
    marks = [text for group in drawing.findall(f"{SVG}g") for text in group.findall(f"{SVG}text")]
    for text in drawing.iter(f"{SVG}text"):
        x, y = int(text.get("x", "")), int(text.get("y", ""))
        assert 0 <= x < x + 6.6 * len(text.text or "") <= width
        assert y <= height
        if text.get("class") != "head":
            size = 6.02 if text.get("class") == "small" else 6.62
            start = x - 11 if text in marks else x  # where the sign before it begins
            texts.setdefault(y, []).append((start, x + size * len(text.text or "")))
    for line in texts.values():
        line.sort()
        assert all(end <= start for (_, end), (start, _) in pairwise(line))
    steps = [text.text for text in drawing.findall(f"{SVG}text") if re.fullmatch(r"\d+", text.text or "")]
    assert {str(step) for step in range(1, length + 1)} <= set(steps)


def test_only_what_is_there_has_a_lane() -> None:
    lanes = {lane.name: [row.label for row in lane.rows] for lane in lanes_of(told(model_of(DEMO), RUN))}
    assert lanes == {
        "nd.goto": ["[0]"],
        "nd.stop": ["", "place"],
        "battery": [""],
        "temperature": [""],
        "nd.tool": [""],
        "hot": [""],
        "ammo": [""],
    }


def test_a_poster_may_be_called_as_a_request_is_or_as_the_lane_of_the_checker() -> None:
    text = """spec s; poster checker: bool = false;
        module m { request go(); poster go: bool = false; }
        forbid never: checker and active(m.go) by reject;"""
    events = ['{"ask": "m.go"}', '{"observe": "m.go", "value": true}', '{"observe": "checker", "value": true}']
    lanes = lanes_of(told(model_of(text), events))
    found = [
        (each.name, each.values, step, mark.kind) for each in lanes for step in each.marks for mark in each.marks[step]
    ]
    assert found == [
        ("checker", False, 3, "violation"),
        ("m.go", False, 1, "ask"),
        ("m.go", False, 1, "launch"),
        ("checker", True, 3, "observe"),
        ("m.go", True, 2, "observe"),
    ]


# ---- waveforms ----


def waves(dump: str) -> dict[str, list[str]]:
    """Return by full name the value of every signal at each time but the last, which only ends the dump.

    Reads what IEEE 1364-2005 section 18.2 allows and `string` signals besides, and refuses everything else.
    """
    head, _, body = dump.partition("$enddefinitions $end\n")
    scopes: list[str] = []
    names: dict[str, tuple[str, str]] = {}
    for section in re.findall(r"\$(\w+)\s+(.*?)\s*\$end", head, re.DOTALL):
        match section[0], section[1].split():
            case "scope", ["module", name]:
                scopes.append(name)
            case "upscope", []:
                scopes.pop()
            case "var", [kind, size, code, name]:
                assert (kind, size) in {
                    ("wire", "1"),
                    ("integer", "32"),
                    ("integer", "64"),
                    ("real", "64"),
                    ("string", "1"),
                }
                assert re.fullmatch(r"[!-~]+", code)
                assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_$]*", name)
                assert code not in names
                names[code] = (".".join([*scopes, name]), kind)
            case (("version" | "comment" | "timescale"), _):
                pass
            case other:
                raise AssertionError(other)
    assert not scopes
    assert "$timescale 1 us $end" in head
    assert len({name for name, _ in names.values()}) == len(names)
    return _values(names, body)


def _values(names: dict[str, tuple[str, str]], body: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {name: [] for name, _ in names.values()}
    now: dict[str, str] = {}
    for time, lines in _times(body):
        assert time == len(next(iter(found.values()))) or not lines
        for line in lines:
            value, code = (line[0], line[1:]) if line[0] in "01" else (line[1:].split(" ")[0], line.split(" ")[1])
            name, kind = names[code]
            assert {"wire": "01", "integer": "b", "real": "r", "string": "s"}[kind].find(line[0]) >= 0
            assert now.get(name) != value, "only changes are dumped"
            now[name] = str(float(value)) if kind == "real" else str(int(value, 2)) if kind == "integer" else value
        if lines or time < _last(body):
            for name in found:
                found[name].append(now[name])
    return found


def _times(body: str) -> Iterator[tuple[int, list[str]]]:
    for block in re.split(r"^#", body, flags=re.MULTILINE)[1:]:
        time, *lines = block.splitlines()
        yield int(time), [line for line in lines if line not in ("$dumpvars", "$end")]


def _last(body: str) -> int:
    return max(int(time) for time in re.findall(r"^#(\d+)$", body, re.MULTILINE))


def test_the_waveforms_show_the_run() -> None:
    values = waves(picture(recorded(), told(model_of(DEMO), RUN), "vcd"))
    idle = "idle"
    assert values["demo.nd.goto_0"] == [
        idle,
        "running",
        "stopping",
        "stopping",
        idle,
        idle,
        "running",
        "stopping",
        idle,
    ]
    assert values["demo.nd.goto_1"] == [idle] * 9
    assert values["demo.nd.stop"] == [idle] * 4 + ["running"] + [idle] * 4
    assert values["demo.nd.stop_place"] == ["empty", "empty", "clearing", "clearing"] + ["empty"] * 5
    assert values["demo.battery"] == ["100"] * 7 + ["3", "3"]
    assert values["demo.temperature"] == ["20.0"] * 3 + ["90.5"] * 6
    assert values["demo.hot"] == ["0"] * 3 + ["1"] * 6
    assert values["demo.level_ammo"] == ["2"] * 4 + ["1"] * 5
    assert values["demo.used_power"] == ["0", "40", "40", "40", "0", "0", "40", "40", "0"]
    assert values["demo.nd.tool"] == ["none"] * 5 + ["gripper"] * 4
    assert values["demo.nd.tool_"] == [idle] * 9  # the request of that name, which a state has as well
    assert values["demo.event"][2] == "ask_nd.stop()"
    assert values["demo.answer"][5] == "-"


def test_negative_and_large_integers_fit_their_signals() -> None:
    spec = "spec s; poster a: int in -5 .. 5 = -1; poster b: int in 0 .. 9000000000 = 0; module m { request r(); }"
    dump = picture(recorded(), told(model_of(spec), ['{"observe": "b", "value": 9000000000}']), "vcd")
    assert f"b{'1' * 32} " in dump
    assert "$var integer 64" in dump
    assert waves(dump)["s.b"][-1] == "9000000000"


def test_many_signals_have_codes_of_their_own() -> None:
    posters = " ".join(f"poster p{i}: bool = false;" for i in range(300))
    spec = f"spec s; {posters} module m {{ request r(); }}"
    values = waves(picture(recorded(), told(model_of(spec), ['{"observe": "p299", "value": true}']), "vcd"))
    assert len(values) == 300 + 2 + 2
    assert values["s.p299"] == ["0", "1"]
    assert values["s.p298"] == ["0", "0"]


@pytest.mark.parametrize("word", ["$end", "$$end", "$$$end$end"])
def test_no_comment_of_a_dump_ends_before_its_line(word: str) -> None:
    dump = picture(recorded(f"deadlock {word} violated"), told(model_of(DEMO), RUN), "vcd")
    line = dump.splitlines()[1]
    assert line.startswith("$comment deadlock ") and line.index("$end") == len(line) - len("$end")


def test_an_empty_run_can_be_told() -> None:
    model = model_of(DEMO)
    story = story_of(model, Trace(()))
    for form in ("text", "json", "svg", "vcd"):
        assert picture(recorded(), story, form)  # type: ignore[arg-type]
