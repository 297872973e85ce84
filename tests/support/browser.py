"""Reports in headless Chromium: the system's own, driven by Playwright, without any network."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from exover.checks.schedule.plan import CheckPlan
from exover.pipeline import Build, Loaded, build, check, load
from exover.rendering import look, summarise
from exover.report.summary import ERRORS
from exover.source import Source

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
PARTS = ("verdicts", "rules", "graph", "diagrams", "runs", "simulator", "spec")
LATER = 60_000
"""Milliseconds after which a page has hung."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Give a browser; where there is none the test is skipped."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.skip("Chromium is not installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(browser: Browser, file: Path, part: str = "verdicts", **options: Any) -> Iterator[Page]:
    """Open a report from the disk in a page of its own; when it is left, nothing may have gone wrong or been loaded."""
    page = browser.new_page(**options)
    try:
        with shown(page, file, part):
            yield page
    finally:
        page.close()


@contextmanager
def shown(page: Page, file: Path, part: str = "verdicts") -> Iterator[None]:
    """Show a report from the disk in a page; when it is left, nothing may have gone wrong or been loaded.

    What is shown next in the same page takes a third of the time of another page.
    """
    page.goto("about:blank")
    page.set_default_timeout(LATER)
    wrong: list[str] = []
    allowed = (file.as_uri(), "data:", "blob:")
    seen: dict[str, Callable[[Any], None]] = {
        "console": lambda message: wrong.append(message.text),
        "pageerror": lambda error: wrong.append(str(error)),
        "request": lambda request: wrong.append(request.url) if not request.url.startswith(allowed) else None,
    }
    for event, told in seen.items():
        page.on(event, told)  # type: ignore[call-overload]
    page.goto(f"{file.as_uri()}#{part}")
    yield
    assert wrong == []
    for event, told in seen.items():
        page.remove_listener(event, told)


def built(path: Path) -> tuple[Loaded, Build]:
    """Return what became of a spec, and its tables."""
    loaded = load(Source(str(path), path.read_text(encoding="utf-8")))
    assert loaded.model is not None
    return loaded, build(loaded.model)


def report(path: Path, folder: Path, checked: bool = True) -> Path:
    """Write the report of a spec into a folder and return its path; if it is not `checked`, there are no findings."""
    loaded, made = built(path)
    outcome = check(made, lambda _: None, CheckPlan(None if checked else ()))
    summary = summarise(str(path), made.model, made, outcome, ERRORS)
    file = folder / f"{path.stem}.html"
    file.write_text(look(summary, loaded.source, made), encoding="utf-8")
    return file
