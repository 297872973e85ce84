"""The pages of checks and codes: each is there, its examples do what it says, and docs have the same text."""

import re
from pathlib import Path

import pytest

from exover.checks.questions import CHECKS
from exover.diagnostics import CODES, Diagnostic
from exover.gate.reading import read_binding
from exover.manual import Page, page, pages
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES, Properties
from exover.pipeline import load, load_properties
from exover.report.config import read_config
from exover.source import Source
from tests.support.diagrams import check_by_diagrams
from tests.support.small import compiled

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
WORLD = "spec s; module m { request a(); request b(); }"
BOUND = "spec s; module m { request a(x: real); request b() fails (stuck); } poster p: bool = false;"
WITHOUT_EXAMPLE = {"E001", "E002", "E003", "E006", "E007", "E109", "E199", "E414", "tables"}
"""Files that cannot be read, texts of several files, and such as are too large to be shown; a fault of the toolkit."""
SEVERITIES = {check.name: check.severity for check in CHECKS}


def examples(name: str) -> list[tuple[str, str]]:
    return BLOCK.findall(pages()[name].text)


def mistakes(language: str, text: str) -> tuple[Diagnostic, ...]:
    match language:
        case "toml":
            return read_config(Source("exover.toml", text), SEVERITIES)[1]
        case "bind":
            return read_binding(Source("s.bind.toml", text), model_of(BOUND))[1]
        case "prop":
            return load_properties(Source("s.prop", text), model_of(WORLD)).diagnostics
        case _:
            return load(Source("s.exo", text)).diagnostics


def model_of(text: str) -> Model:
    loaded = load(Source("s.exo", text))
    assert loaded.model is not None, loaded.diagnostics
    return loaded.model


def test_every_check_and_every_code_has_its_page() -> None:
    assert list(pages()) == [*SEVERITIES, *CODES]
    for name, found in pages().items():
        assert found.mend and not found.mend.endswith("."), name
        assert found.text.partition(found.mend)[2].partition("\n\n")[0] in (".", ""), name
        assert found.title == CODES.get(name, "")
        assert bool(found.iff) == (name in SEVERITIES)
    assert {name for name in pages() if not examples(name)} == WITHOUT_EXAMPLE


@pytest.mark.parametrize("code", [code for code in CODES if code not in WITHOUT_EXAMPLE])
def test_the_example_of_a_code_is_told_with_that_code_alone(code: str) -> None:
    ((language, text),) = examples(code)
    assert {mistake.code for mistake in mistakes(language, text)} == {code}


@pytest.mark.parametrize("check", [check for check in SEVERITIES if check not in WITHOUT_EXAMPLE])
def test_the_first_example_of_a_check_fails_it_and_the_second_passes(check: str) -> None:
    found: list[tuple[Model, Properties]] = []
    for language, text in examples(check):
        if language == "exo":
            found.append((model_of(text), NO_PROPERTIES))
        else:
            loaded = load_properties(Source("s.prop", text), found[-1][0]).properties
            assert loaded is not None
            found[-1] = found[-1][0], loaded
    verdicts = [verdicts_of(check, model, said) for model, said in found]
    assert ["violated" in each for each in verdicts] == [True, False]
    assert verdicts[1] == {"holds"}


def verdicts_of(check: str, model: Model, said: Properties) -> set[str]:
    findings = check_by_diagrams(compiled(model), properties=said).findings
    return {finding.verdict for finding in findings if finding.check == check}


def test_the_pages_and_the_contract_have_the_sentences_of_the_checks() -> None:
    contract = (ROOT / "docs" / "checks.md").read_text("utf-8")
    for check in CHECKS:
        assert f"| {check.severity} | {check.iff} |" in contract, check.name
        assert pages()[check.name].iff == check.iff
        assert pages()[check.name].severity == check.severity


def test_a_page_is_found_by_its_name() -> None:
    found = page("e307")
    assert isinstance(found, Page) and found.name == "E307"
    assert page("safety") is not None
    assert page("E999") is None and page("Safety") is None and page("") is None
