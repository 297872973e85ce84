"""The page of a report in a browser: every part of it, by mouse and by keyboard, offline and safe."""

import json
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from exover.audit import json as audit_json
from exover.audit.auditor import Job, MissionAuditor
from exover.audit.result import Audit
from exover.pipeline import build, load
from exover.rendering import look, summarise
from exover.run.simulate import ReferenceEngine, simulate
from exover.source import Source
from tests.audit import missions
from tests.support.browser import PARTS, built, opened, report, shown

SPECS = Path(__file__).parents[2] / "specs"
HOSTILE = r"""spec __proto__;
module constructor {
    request toString(__proto__: int in 0 .. 3, x: {__proto__, hasOwnProperty}) {
        check valueOf: __proto__ < 3 because "</script><script>document.title = 'broken'</script>";
    }
    request b() fails (__proto__);
}
poster hasOwnProperty: int in 0 .. 9 = 0;
mutex __proto__: constructor.toString, constructor.b because "<img src=x onerror=document.title='broken'> \" & ' <!--";
// </script><svg onload="document.title = 'broken'">
"""

SLOTS = """spec s;
poster wind: int in 0 .. 9 = 0;
resource fuel: 9 consumable = 8 by wait;
module a { request go() instances 2 { fail windy: when wind > 5; consumes fuel 2; } request home(); }
launch home: a.home() when wind > 7;
"""


@pytest.fixture(scope="module")
def rover(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report(SPECS / "rover.exo", tmp_path_factory.mktemp("rover"))


def go(page: Page, part: str) -> None:
    page.evaluate("part => { location.hash = part; }", part)
    page.locator(f"#part-{part.split('/')[0]}:not([hidden])").wait_for()


def test_every_part_shows_what_it_is_about(page: Page, rover: Path) -> None:
    told = {
        "verdicts": "obligation",
        "rules": "the rover must know where it is",
        "graph": "nd.goto",
        "diagrams": "active(pom.localize) <= 0",
        "runs": "violated: obligation go_home",
        "simulator": "Click an event",
        "spec": "mutex still",
    }
    with shown(page, rover):
        for part, text in told.items():
            go(page, part)
            assert (
                text in page.locator(f"#part-{part}").inner_text() or text in page.locator(f"#part-{part}").inner_html()
            )
            assert page.locator(f"#tab-{part}").get_attribute("aria-selected") == "true"
        assert page.locator("[role=tabpanel]:not([hidden])").count() == 1


@pytest.mark.parametrize("path", sorted(SPECS.rglob("*.exo")), ids=lambda path: path.stem)
def test_every_diagram_is_drawn_whole(page: Page, path: Path, tmp_path: Path) -> None:
    _, made = built(path)
    with shown(page, report(path, tmp_path, checked=False)):
        for request, row in zip(made.model.requests, made.tables.requests, strict=True):
            go(page, f"diagrams/ask%20{request.name}")
            drawn = page.locator("#part-diagrams svg .node:not(.end)").evaluate_all(
                "nodes => nodes.map(n => n.dataset.id)"
            )
            assert sorted(map(int, drawn)) == made.tables.below(row.decide)
            tests = [
                node for node in map(made.tables.nodes.__getitem__, made.tables.below(row.decide)) if node.code >= 0
            ]
            assert page.locator("#part-diagrams svg .edge.no").count() == len(tests)


def test_slots_have_diagrams_of_their_own_and_rules_their_texts(page: Page, tmp_path: Path) -> None:
    spec = tmp_path / "s.exo"
    spec.write_text(SLOTS)
    with shown(page, report(spec, tmp_path), "rules"):
        row = page.locator("#part-rules [data-rule=fuel]")
        assert row.locator("pre").inner_text() == "resource fuel: 9 consumable = 8 by wait;"
        assert row.get_attribute("aria-label") == "consumable fuel"
        home = page.locator("#part-rules [data-rule=home]").get_by_role("link", name="launch home")
        assert home.get_attribute("href") == "#diagrams/launch%20home"
        nodes = {}
        for name in ("recover a.go.windy", "recover a.go.windy (2)"):
            go(page, f"diagrams/{name}")
            assert page.locator("#part-diagrams select").input_value() == name
            assert page.locator("#part-diagrams h3").inner_text() == name
            nodes[name] = page.locator("#part-diagrams svg .node:not(.end)").first.get_attribute("data-id")
        assert len(set(nodes.values())) == 2
        go(page, "simulator")
        for line in ('{"ask": "a.go"}', '{"ask": "a.go"}', '{"observe": "wind", "value": 9}'):
            page.get_by_label("event as a JSON line").fill(line)
            page.get_by_label("event as a JSON line").press("Enter")
        told = page.locator("#part-simulator .shows select option").all_inner_texts()
        assert {name for name in told if "windy" in name} == nodes.keys()


def test_the_graph_is_that_of_exover_graph(page: Page, rover: Path) -> None:
    with shown(page, rover, "graph"):
        for box in page.locator("#part-graph input[type=checkbox]").all():
            box.check()
        rows = page.locator("#part-graph tbody tr").count()
        assert rows == page.evaluate("page.report.graph.edges.length")
        loops = page.evaluate("page.report.graph.edges.filter(edge => edge.from === edge.to).length")
        assert page.locator("#part-graph svg .edge").count() == rows - loops
        page.locator("#part-graph svg .node[data-id='nd.stop']").press("Enter")
        page.locator("#part-graph svg .node.lit").wait_for()
        assert page.locator("#part-graph svg .node").count() == 2


def test_a_run_steps_by_buttons_slider_and_keys(page: Page, rover: Path) -> None:
    with shown(page, rover, "runs"):
        steps = page.evaluate("page.report.runs[0].events.length")
        now = page.locator("#part-runs thead th.now")
        assert now.inner_text() == "start"
        page.get_by_label("one step on").click()
        assert now.inner_text() == "1"
        told = page.get_by_label("moment of the run").get_attribute("aria-valuetext")
        assert told == "step 1: " + page.locator("#part-runs .moment p").first.inner_text().removeprefix("Step 1: ")
        assert "go_home" in page.locator("#part-runs .moment").inner_text()
        page.locator("#part-runs .lanes").press("End")
        assert now.inner_text() == str(steps)
        page.locator("#part-runs .lanes").press("Home")
        page.get_by_label("moment of the run").press("ArrowRight")
        assert now.inner_text() == "1"
        for run in range(page.evaluate("page.report.runs.length")):
            go(page, f"runs/{run + 1}")
            assert page.locator("#part-runs .message").count() == 0  # the page answers as the finding says
        go(page, "runs/1")
        page.get_by_text("open in the simulator").click()
        assert page.locator("#part-simulator .history li").count() == steps + 1


@pytest.mark.parametrize(
    ("action", "told"),
    [
        ('{"launch": "nd.stop", "instance": 0, "args": {}}', False),
        ('{"reject": "nd.stop", "rule": "invalid"}', True),
        ('{"invalid": "bad-event", "detail": "in other words"}', False),
    ],
)
def test_an_answer_that_the_page_does_not_give_is_told(page: Page, rover: Path, action: str, told: bool) -> None:
    with shown(page, rover):
        seen = page.evaluate(
            """action => {
                const answers = [`{"step": 1, "actions": [${action}]}`];
                const nodes = runView(page, { finding: 0, events: ['{"ask": "nd.stop"}'], answers });
                return nodes.some((node) => node?.className === "message");
            }""",
            action,
        )
        assert seen == told


def test_a_poster_may_have_the_name_of_a_request(page: Page, tmp_path: Path) -> None:
    spec = tmp_path / "s.exo"
    spec.write_text("spec s; module m { request go(); poster go: bool = false; }")
    with shown(page, report(spec, tmp_path, checked=False)):
        told = page.evaluate(
            """() => {
                const run = new Run(page.tables, page.names);
                run.step('{"ask": "m.go"}');
                run.step('{"observe": "m.go", "value": true}');
                return lanesOf(run).map(({ isValue, marks }) => [isValue, marks.flat().map(({ kind }) => kind)]);
            }"""
        )
        assert told == [[False, ["ask", "launch"]], [True, ["observe"]]]


def test_the_simulator_answers_what_is_clicked_and_typed(page: Page, rover: Path, tmp_path: Path) -> None:
    _, made = built(SPECS / "rover.exo")
    with shown(page, rover, "simulator"):
        part = page.locator("#part-simulator")
        goto = part.locator("fieldset[data-request='nd.goto']")
        goto.get_by_text("ask", exact=True).click()
        assert "nd.goto.after.pom.localize" in part.locator(".answers").first.inner_text()
        assert part.locator("svg .node.action.lit").text_content().endswith("reject (nd.goto.after.pom.localize)")  # type: ignore[union-attr]
        localize = part.locator("fieldset[data-request='pom.localize']")
        localize.get_by_text("ask", exact=True).press("Enter")
        localize.get_by_text("ok", exact=True).press("Enter")
        assert localize.evaluate(
            "node => node.contains(document.activeElement)"
        )  # the button is gone, the focus is not
        goto.get_by_label("v (a number in 0 .. 1.5)").fill("0.30000000000000004")
        goto.get_by_label("v (a number in 0 .. 1.5)").press("Enter")
        assert "launch nd.goto" in part.locator(".answers").first.inner_text()
        goto.get_by_text("failed: lost").click()
        part.get_by_label("event as a JSON line").fill('{"observe": "battery", "value": 3}')
        part.get_by_text("send").click()
        part.get_by_label("event as a JSON line").fill('{"observe": "battery"')
        part.get_by_text("send").click()
        part.get_by_text("undo").click()
        assert part.locator(".history li").count() == 7
        with page.expect_download() as events:
            part.get_by_text("save events").click()
        with page.expect_download() as answers:
            part.get_by_text("save answers").click()
        assert events.value.suggested_filename == "rover.events.jsonl"
        lines = Path(events.value.path()).read_text("utf-8").splitlines()
        assert lines[3] == '{"ask": "nd.goto", "args": {"x": 0, "y": 0, "v": 0.30000000000000004}}'
        expected = list(simulate(made.model, ReferenceEngine(made.model), lines))
        assert Path(answers.value.path()).read_text("utf-8").splitlines() == expected


def test_files_of_events_are_loaded(page: Page, rover: Path, tmp_path: Path) -> None:
    mission = tmp_path / "a.jsonl"
    mission.write_text('{"ask": "pom.localize"}\n\n{"report": "pom.localize", "outcome": "ok"}\n', encoding="utf-8")
    bad = tmp_path / "b.jsonl"
    bad.write_bytes(b'{"ask": "\xff"}\n')
    long = tmp_path / "c.jsonl"
    long.write_text('{"ask": "nd.stop"}\n' * 10_001, encoding="utf-8")
    with shown(page, rover, "simulator"):
        part, message = page.locator("#part-simulator"), page.locator("#part-simulator .message")
        part.get_by_label("load events").set_input_files(mission)
        expect(message).to_contain_text("2 events")
        part.get_by_text("play one").click()
        assert part.locator(".history li").count() == 2
        part.get_by_text("play all").click()
        assert part.locator(".history li").count() == 3
        for file, reason in ((bad, "it is not UTF-8"), (long, "the page takes 10000")):
            part.get_by_label("load events").set_input_files(file)
            expect(message).to_contain_text(reason)
            assert file.name in message.inner_text()
            assert part.locator(".history li").count() == 3  # nothing is lost


def test_nothing_in_a_spec_is_read_as_html(page: Page, tmp_path: Path) -> None:
    path = tmp_path / "hostile.exo"
    path.write_text(HOSTILE, encoding="utf-8")
    with shown(page, report(path, tmp_path)):
        title = page.title()
        for part in PARTS:
            go(page, part)
        assert "<img src=x" in page.locator("#part-rules").inner_text()
        go(page, "simulator")
        line = json.dumps({"ask": "constructor.toString", "args": {"__proto__": 3, "x": "__proto__"}})
        page.get_by_label("event as a JSON line").fill(line)
        page.get_by_role("button", name="send").click()
        assert "</script>" in page.locator(".answers").first.inner_text()
        assert page.evaluate("page.simulator.run.last.answer").endswith("'broken'</script>\"}]}")
        assert page.title() == title == "__proto__: holds"
        assert page.locator("img, main script").count() == 0


def test_nothing_can_be_loaded(browser: Browser, rover: Path) -> None:
    page = browser.new_page()
    page.goto(rover.as_uri())
    assert page.evaluate("fetch('data:,x').then(() => 'loaded', () => 'refused')") == "refused"
    assert (
        page.evaluate(
            "new Promise(done => { const s = document.createElement('script'); s.textContent = 'window.ran = 1';"
            " document.body.append(s); setTimeout(() => done(window.ran), 50); })"
        )
        is None
    )
    page.close()


@pytest.mark.parametrize("scheme", ("light", "dark"))
def test_a_phone_shows_all_parts_in_both_colours(browser: Browser, rover: Path, scheme: str) -> None:
    options = {"viewport": {"width": 390, "height": 844}, "color_scheme": scheme, "has_touch": True, "is_mobile": True}
    with opened(browser, rover, **options) as page:
        for part in PARTS:
            go(page, part)
            assert page.evaluate("document.documentElement.scrollWidth") <= 390, part
        for word in ("holds", "violated", "warning", "note", "kill"):
            assert contrast(page, f"badge {word}") >= 4.5, word
        assert contrast(page, "excuse") >= 4.5


def contrast(page: Page, name: str) -> float:
    """Return the contrast of text in a class of elements, as WCAG 2 counts it."""
    colours = page.evaluate(
        "name => { const node = document.createElement('span'); node.className = name; document.body.append(node);"
        " const own = getComputedStyle(node); const back = own.backgroundColor === 'rgba(0, 0, 0, 0)'"
        " ? getComputedStyle(document.body).backgroundColor : own.backgroundColor;"
        " const found = [own.color, back].map(text => text.match(/[\\d.]+/g).slice(0, 3).map(Number));"
        " node.remove(); return found; }",
        name,
    )
    bright, dim = sorted((_luminance(*colour) for colour in colours), reverse=True)
    return (bright + 0.05) / (dim + 0.05)


def _luminance(*channels: float) -> float:
    red, green, blue = (c / 255 / 12.92 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in channels)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_the_parts_are_turned_by_keys(browser: Browser, rover: Path) -> None:
    with opened(browser, rover) as page:
        page.locator("#tab-verdicts").focus()
        for key, part in (("ArrowRight", "rules"), ("End", "spec"), ("ArrowRight", "verdicts"), ("ArrowLeft", "spec")):
            page.keyboard.press(key)
            assert page.evaluate("document.activeElement.id") == f"tab-{part}"
            page.locator(f"#part-{part}:not([hidden])").wait_for()
        page.locator("#theme select").select_option("dark")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 27)"


def test_a_large_diagram_is_drawn_in_part_and_opened_by_picking(page: Page, tmp_path: Path) -> None:
    path = Path(__file__).parents[1] / "specs" / "lab_automation.exo"
    _, made = built(path)
    request = [request.name for request in made.model.requests].index("head.dispense")
    below = made.tables.below(made.tables.requests[request].decide)
    with shown(page, report(path, tmp_path, checked=False), "diagrams/ask%20head.dispense"):
        nodes = page.locator("#part-diagrams svg .node:not(.end)")
        assert len(below) > 400 > 120 == nodes.count()
        assert page.locator("#part-diagrams tbody tr").count() == len(below)
        more = page.locator("#part-diagrams svg .node.end", has_text="…").first
        number = int((more.get_attribute("data-id") or "").removeprefix("more "))
        more.press("Enter")
        page.get_by_text(f"ask head.dispense, from node {number}").wait_for()
        drawn = [int(node) for node in nodes.evaluate_all("nodes => nodes.map(node => node.dataset.id)")]
        assert set(drawn) <= set(made.tables.below(number))
        assert number in drawn
        page.get_by_text("back to the whole diagram").click()
        expect(nodes).to_have_count(120)


# ---- an audit of missions ----


def audited_page(folder: Path, audited: bool) -> Path:
    """Write a report, with an audit of two missions."""
    loaded = load(Source("crane.exo", missions.CRANE))
    assert loaded.model is not None
    made = build(loaded.model)
    auditor = MissionAuditor(Job(loaded.model, made.tables))
    results = [
        auditor.audit(str(missions.write(folder, "m.jsonl", missions.told(missions.LOOSE, 1, 80))), "m.jsonl"),
        auditor.audit(str(folder / "<b>.jsonl"), "<b>.jsonl"),
    ]
    audit = Audit("0", loaded.model, "crane.exo", tuple(results))
    summary = summarise("crane.exo", loaded.model, made, None, frozenset())
    text = look(summary, loaded.source, made, audit_json.document(audit) if audited else None)
    path = folder / "report.html"
    path.write_text(text, encoding="utf-8")
    return path


def test_an_audit_is_a_part_of_the_page(page: Page, tmp_path: Path) -> None:
    with shown(page, audited_page(tmp_path, True), "missions"):
        part = page.locator("#part-missions")
        assert page.locator("#tab-missions").is_visible()
        assert part.locator("p").first.text_content().startswith("crane: 2 missions, 80 events; 1 of them diverges")
        rows = part.locator("table").first.locator("tbody tr")
        assert rows.nth(0).locator("td").all_text_contents()[:2] == ["m.jsonl", "80"]
        assert rows.nth(1).locator("td").first.text_content() == "<b>.jsonl"  # a name is never read as HTML
        assert part.locator("section[data-mission='m.jsonl'] li").count() >= 2
        assert part.get_by_role("link", name="one", exact=True).get_attribute("href") == "#rules/one"


def test_without_an_audit_there_is_no_such_part(page: Page, tmp_path: Path) -> None:
    with shown(page, audited_page(tmp_path, False)):
        assert not page.locator("#tab-missions").is_visible()
