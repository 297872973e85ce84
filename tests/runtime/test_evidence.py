"""What the runtime is required to do is traced to tests, and every test to what it shows."""

from tests.runtime.evidence import PAGE, existing, requirements, sections, toolkit, written

NO_REQUIREMENTS = {
    "Files": "what is emitted",
    "An example of the generic API": "runs as it stands, with the other pages",
    "Speed": "figures, not requirements: `make bench`",
    "Agreement": "how much is compared, not what",
    "Beside other checkers": "figures of others",
}
"""Sections of the page, and why nothing in them is required."""


def test_every_requirement_stands_in_the_page() -> None:
    lost = [f"{each.number}: {each.text}" for each in requirements() if not each.section]
    assert lost == [], "docs/runtime.md does not say this any more: mend requirements.toml"
    assert all(each.tests for each in requirements())


def test_every_test_is_traced_and_every_traced_test_is_there() -> None:
    traced = {test for each in requirements() for test in each.tests} | toolkit().keys()
    assert sorted(set(existing()) - traced) == [], "say in requirements.toml what these tests show"
    assert sorted(traced - set(existing())) == [], "requirements.toml names tests that there are not"


def test_no_section_is_without_a_requirement() -> None:
    required = {each.section for each in requirements()}
    assert set(sections()) - required - set(NO_REQUIREMENTS) == set()


def test_the_page_is_what_is_generated() -> None:
    assert written() == PAGE.read_text(encoding="utf-8"), "run python -m tests.runtime.evidence"
