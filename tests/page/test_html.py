"""The file of a report, without a browser: what it holds, what it allows, and that it is the same each time."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from exover.page.document import document
from exover.page.html import LIBRARY, SCRIPTS, asset, embedded
from exover.source import Source
from tests.report.samples import LASSO, finding, summary
from tests.support.browser import built, report
from tests.support.growth import LINEAR, growth

SPECS = Path(__file__).parents[2] / "specs"
DAGRE = "54a503e346f93ca0bb10abe7999587e037262935687aca45eb4e4b0f64bbb578"
"""The sha256 of dist/dagre.min.js of @dagrejs/dagre 3.1.3 on npm."""


@pytest.fixture(scope="module")
def rover(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report(SPECS / "rover.exo", tmp_path_factory.mktemp("rover"))


def told(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="report">(.*?)</script>', text, re.S)
    assert found
    document: dict[str, Any] = json.loads(found[1])
    return document


def test_the_policy_allows_the_scripts_and_the_style_and_nothing_else(tmp_path: Path) -> None:
    text = report(SPECS / "rover.exo", tmp_path, checked=False).read_text("utf-8")
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    assert found
    policy = dict(part.split(" ", 1) for part in unescape(found[1]).split("; "))
    inside = re.findall(r"<script>(.*?)</script>", text, re.S) + re.findall(r"<style>(.*?)</style>", text, re.S)
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(each.encode()).digest()).decode()}'" for each in inside]
    assert len(hashes) == len(SCRIPTS) + 3
    assert policy == {
        "default-src": "'none'",
        "script-src": " ".join(hashes[:-1]),
        "style-src": hashes[-1],
        "img-src": "data:",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    assert re.findall(r'\b(?:src|href)="(?!#)([^"]*)"', re.sub(r"<script.*?</script>", "", text, flags=re.S)) == [
        "data:,"
    ]


def test_the_page_holds_the_very_bytes_of_the_tables(tmp_path: Path) -> None:
    _, made = built(SPECS / "satellite.exo")
    page = told(report(SPECS / "satellite.exo", tmp_path, checked=False).read_text("utf-8"))
    assert base64.b64decode(page["table"]) == made.data
    assert [file["text"] for file in page["files"]] == [(SPECS / "satellite.exo").read_text("utf-8")]


def test_equal_findings_give_equal_bytes(tmp_path: Path, rover: Path) -> None:
    assert report(SPECS / "rover.exo", tmp_path).read_bytes() == rover.read_bytes()


def test_findings_rules_and_runs_point_at_each_other(rover: Path) -> None:
    page = told(rover.read_text("utf-8"))
    worst = page["findings"][page["runs"][0]["finding"]]
    assert (worst["check"], worst["subject"], worst["word"], worst["run"]) == ("obligation", "go_home", "violated", 0)
    used = {each["subject"]: each["word"] for each in page["findings"] if each["check"] == "rule-use"}
    assert [rule["name"] for rule in page["rules"]] == list(used)
    lines = page["files"][0]["text"].splitlines()
    for rule in page["rules"]:
        assert rule["written"].split()[0] in lines[rule["place"]["line"] - 1]


def test_no_text_ends_the_element_that_it_stands_in() -> None:
    text = "</script> <!-- \u2028 \ud800 \x00 &amp;"
    written = embedded({"a": text})
    assert "<" not in written
    assert json.loads(written) == {"a": text}
    assert not any("</script" in asset(f"assets/{name}") for name in SCRIPTS)
    assert "</script" not in asset(LIBRARY)


def test_the_library_is_the_one_that_is_named() -> None:
    path = Path(__file__).parents[2] / "exover" / "page" / LIBRARY
    assert hashlib.sha256(path.read_bytes()).hexdigest() == DAGRE
    assert "Chris Pettitt" in path.with_name("LICENSE").read_text("utf-8")


def test_the_page_of_many_runs_takes_time_in_proportion() -> None:
    def page(size: int) -> object:
        alike = finding("starvation", "warning", "violated", replace(LASSO, moments=LASSO.moments[:1]))
        shown = summary(*(replace(alike, subject=f"r{number}") for number in range(size)))
        return document(shown, Source("demo.exo", ""), None, b"")

    assert growth(page, 400) < LINEAR
