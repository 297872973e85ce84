"""The part of the page that shows an audit of missions."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from exover.audit import json as audit_json
from exover.audit.auditor import Job, MissionAuditor
from exover.audit.result import Audit
from exover.pipeline import build, load
from exover.rendering import look, summarise
from exover.source import Source
from tests.audit.missions import CRANE, LOOSE, told, write
from tests.support.browser import chromium, opened


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as found:
        yield found


def page_of(folder: Path, audited: bool) -> Path:
    """Write a report, with an audit of two missions."""
    loaded = load(Source("crane.exo", CRANE))
    assert loaded.model is not None
    built = build(loaded.model)
    auditor = MissionAuditor(Job(loaded.model, built.tables))
    results = [
        auditor.audit(str(write(folder, "m.jsonl", told(LOOSE, 1, 80))), "m.jsonl"),
        auditor.audit(str(folder / "<b>.jsonl"), "<b>.jsonl"),
    ]
    audit = Audit("0", loaded.model, "crane.exo", tuple(results))
    summary = summarise("crane.exo", loaded.model, built, None, frozenset())
    page = look(summary, loaded.source, built, audit_json.document(audit) if audited else None)
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


def test_an_audit_is_a_part_of_the_page(tmp_path: Path, browser: Browser) -> None:
    with opened(browser, page_of(tmp_path, True), "missions") as page:
        part = page.locator("#part-missions")
        assert page.locator("#tab-missions").is_visible()
        assert part.locator("p").first.text_content().startswith("crane: 2 missions, 80 events; 1 of them diverges")
        rows = part.locator("table").first.locator("tbody tr")
        assert rows.nth(0).locator("td").all_text_contents()[:2] == ["m.jsonl", "80"]
        assert rows.nth(1).locator("td").first.text_content() == "<b>.jsonl"  # a name is never read as HTML
        assert part.locator("section[data-mission='m.jsonl'] li").count() >= 2
        assert part.get_by_role("link", name="one", exact=True).get_attribute("href") == "#rules/one"


def test_without_an_audit_there_is_no_such_part(tmp_path: Path, browser: Browser) -> None:
    with opened(browser, page_of(tmp_path, False)) as page:
        assert not page.locator("#tab-missions").is_visible()
