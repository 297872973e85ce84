"""The playground: a spec is read, shown and answered in the browser, by the same Python, from a static server."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from exover import playground
from playground.__main__ import EXAMPLE, HERE, main
from tests.support.browser import LATER

EXAMPLE_TEXT = EXAMPLE.read_text("utf-8")
MISTAKE = "spec s; module m { request a(); } mutex m.a, m.b;"
SMALL = 'spec small; module m { request a(); request b(); } mutex one: m.a, m.b because "only one";'


class Quiet(SimpleHTTPRequestHandler):
    """A static server that says nothing."""

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Build the playground with the pinned Pyodide, and serve it."""
    folder = tmp_path_factory.mktemp("playground")
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("npm is not installed")
    for name in ("package.json", "package-lock.json"):
        shutil.copy(HERE / name, folder)
    command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    if done.returncode:
        pytest.skip(f"npm cannot fetch Pyodide: {done.stderr.strip()[-200:]}")
    main(folder / "node_modules" / "pyodide", folder / "site")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder / "site")))
    thread = Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(scope="module")
def wrong() -> list[str]:
    """Return what goes wrong in the page; nothing may, in any test."""
    return []


@pytest.fixture(scope="module")
def opened(browser: Browser, address: str, wrong: list[str]) -> Iterator[Page]:
    """Open the playground, once: it takes Python seconds to be loaded. Nothing may be loaded from elsewhere."""

    def asks(url: str) -> None:
        if not url.startswith((address, "data:", "blob:")):
            wrong.append(url)

    found = browser.new_page()
    found.set_default_timeout(LATER)
    found.on("pageerror", lambda error: wrong.append(str(error)))
    found.on("console", lambda message: wrong.append(message.text))
    found.on("request", lambda request: asks(request.url))
    found.goto(address)
    yield found
    found.close()


@pytest.fixture
def page(opened: Page, wrong: list[str]) -> Iterator[Page]:
    """Wait until the page of the example is there."""
    if opened.locator("#editor textarea").input_value() != EXAMPLE_TEXT:
        write(opened, EXAMPLE_TEXT)
    expect(opened.locator("#title")).to_have_text("rover", timeout=LATER)
    expect(opened.locator("#editor .status")).to_have_text("no mistakes", timeout=LATER)
    yield opened
    assert wrong == []


def write(page: Page, text: str) -> None:
    page.locator("#editor textarea").fill(text)


def test_the_example_is_there_and_engines_are_not_asked(page: Page) -> None:
    assert page.locator("#editor textarea").input_value() == EXAMPLE_TEXT
    assert page.locator("#verdict").inner_text() == "not asked"
    assert page.locator("#part-verdicts summary .badge").all_inner_texts() == ["not asked"] * 14
    assert "Nothing was asked" in page.locator("#part-verdicts h3").all_inner_texts()
    assert "exover check asks them" in page.locator("#part-verdicts .outcome").inner_text()


def test_the_page_follows_the_editor(page: Page) -> None:
    write(page, SMALL)
    expect(page.locator("#title")).to_have_text("small")
    assert page.evaluate("page.report") == json.loads(playground.look(SMALL))["report"]
    write(page, MISTAKE)
    expect(page.locator("#editor .mistakes")).to_be_visible()
    assert page.locator("#editor .mistakes").text_content() == json.loads(playground.look(MISTAKE))["mistakes"]
    assert page.locator("#title").inner_text() == "small"  # the last text without mistakes
    write(page, SMALL.replace("small", "other"))
    expect(page.locator("#title")).to_have_text("other")
    expect(page.locator("#editor .mistakes")).to_be_hidden()


def test_the_reference_interpreter_answers_what_is_clicked(page: Page) -> None:
    write(page, SMALL)
    expect(page.locator("#title")).to_have_text("small")
    page.locator("#tab-simulator").click()
    for request in ("m.a", "m.b"):
        page.locator(f"fieldset[data-request='{request}']").get_by_text("ask", exact=True).click()
    said = page.locator("#part-simulator .aside")
    expect(said).to_have_text("The reference interpreter answers the same: 2 of 2.")
    page.evaluate("page.simulator.run.moments[2].answer = '{}'; page.simulator.onchange()")
    expect(said).to_contain_text('otherwise, please report it: {"step": 2, "actions": [{"reject": "m.b", "rule": "one"')
    write(page, SMALL.replace("mutex one", "mutex two"))  # what was asked is asked again
    expect(page.locator("#part-simulator .said")).to_contain_text("for two")
    expect(said).to_have_text("The reference interpreter answers the same: 2 of 2.")


def test_what_takes_too_long_is_ended(page: Page) -> None:
    ended = page.evaluate(
        "() => { const call = editor.python.call('answer', 'x', '[]').catch(error => error.message);"
        " editor.python.end('this takes too long'); return call; }"
    )
    assert ended == "this takes too long"
    write(page, SMALL)
    expect(page.locator("#title")).to_have_text("small", timeout=LATER)


def test_python_may_take_any_time_to_be_loaded(page: Page) -> None:
    watched = page.evaluate(
        "() => { const python = editor.python; python.end('again'); const call = python.call('look', 'spec s;');"
        " const late = () => [...python.calls.values()].map(each => each.late !== undefined); const before = late();"
        " python.heard({ready: true}); return [before, late()]; }"
    )
    assert watched == [[False], [True]]


@pytest.mark.parametrize(
    ("missing", "said"),
    [("worker.js", "worker.js cannot be loaded"), ("exover.zip", "exover.zip: 404 Not Found")],
)
def test_what_cannot_be_loaded_is_asked_for_again_by_the_next_change(
    browser: Browser, address: str, missing: str, said: str
) -> None:
    page, asked = browser.new_page(), list[str]()
    page.set_default_timeout(LATER)
    page.route(f"**/{missing}", lambda route: (asked.append(route.request.url), route.fulfill(status=404)))
    page.goto(address)
    expect(page.locator("#editor .status")).to_have_text(f"Python could not be started: {said}", timeout=LATER)
    tries = len(asked)
    page.wait_for_timeout(300)
    assert len(asked) == tries <= 2  # at once, and by the first call if that comes after the failure
    page.unroute(f"**/{missing}")
    write(page, SMALL)
    expect(page.locator("#title")).to_have_text("small", timeout=LATER)
    page.close()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("\ufeff" + SMALL, ""),
        ("\ud800", "error[E002]: the file is no UTF-8 text"),
        (f"{SMALL} //{'x' * 2**24}", "error[E003]: the file is too large: more than 16 MiB"),
    ],
)
def test_a_text_is_read_as_a_file_is(text: str, said: str) -> None:
    found = json.loads(playground.look(text))
    assert found["mistakes"].startswith(said) and bool(found["mistakes"]) == bool(said) == (found["report"] is None)
    if not said:
        assert json.loads(playground.answer(text, '["{}"]'))


def test_neither_dd_nor_a_solver_is_imported() -> None:
    code = f"import sys; from exover import playground as p; p.look({SMALL!r}); p.answer({SMALL!r}, '[]'); "
    code += "print(sorted({'dd', 'z3', 'numpy', 'pysat', 'lark'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
