"""Every page: its commands are run and their outputs compared, and what it only names is there."""

import re
from argparse import ArgumentParser, _SubParsersAction
from collections.abc import Iterator
from pathlib import Path

import pytest

import exover
from exover.cli.arguments import parser
from exover.pipeline import load_properties
from exover.source import Source
from tests.docs.pages import FENCE, GAP, PAGES, ROOT, Block, agrees, blocks, fill, play, run

LANGUAGES = {
    "bind", "c", "cmake",
    "console", "cpp", "ebnf", "exo", "jsonl", "prop", "python", "rust", "sh", "text", "toml", "yaml",
}  # fmt: skip
RUN_ELSEWHERE = {"README.md", "tutorial.md", "ci.md", "traces.md", "runtime.md", "integration.md", "library.md"}
"""Pages with a test of their own, which knows more of them."""
COMMAND = re.compile(r"(?:^|[\s|(/])exover ([a-z]+)\b(?!:)([^\n|]*)", re.MULTILINE)
MAKE = re.compile(r"`(?:[A-Z]+=\S+ )?make ([a-z0-9-]+)|^\$ .*\bmake ([a-z0-9-]+)", re.MULTILINE)


def identify(page: Path) -> str:
    return page.name


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in RUN_ELSEWHERE], ids=identify)
def test_a_page_runs(page: Path, tmp_path: Path) -> None:
    fill(tmp_path)
    for _ in play(page, tmp_path):
        pass


@pytest.mark.parametrize("page", PAGES, ids=identify)
def test_every_output_is_that_of_a_command(page: Path) -> None:
    before = None
    for block in blocks(page):
        assert block.language in LANGUAGES, block.info
        if block.language == "text":
            assert before in ("sh", "python", "rust"), f"nothing prints this:\n{block.text}"
        before = block.language


def options() -> dict[str, set[str]]:
    """Return the options of each verb."""
    (verbs,) = [action for action in parser()._actions if isinstance(action, _SubParsersAction)]
    return {verb: set(_options(sub)) for verb, sub in verbs.choices.items()}


def _options(parser: ArgumentParser) -> Iterator[str]:
    """Yield the options of a parser and of those below it."""
    yield from parser._option_string_actions
    for action in parser._actions:
        if isinstance(action, _SubParsersAction):
            for below in action.choices.values():
                yield from _options(below)


@pytest.mark.parametrize("page", PAGES, ids=identify)
def test_every_command_that_is_named_is_one(page: Path) -> None:
    known = options()
    for verb, rest in COMMAND.findall(code_of(page)):
        assert verb in known, f"exover {verb}{rest}"
        named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", rest))
        assert named <= known[verb], f"exover {verb}{rest}"


def test_every_verb_has_its_line_in_the_page_of_commands() -> None:
    verbs, _ = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8").split("**Mistakes.**")
    assert re.findall(r"^\| `([a-z]+)` \|", verbs, re.MULTILINE) == list(options())


def test_every_option_is_named_on_some_page() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    named = set(re.findall(r"(?<![\w-])--?[a-zA-Z][a-z0-9-]*", text))
    assert {option for found in options().values() for option in found} - named <= {"-h"}


def code_of(page: Path) -> str:
    """Return what a page says in code: its blocks but those that are wrong, what is indented, what is in backticks."""
    text = page.read_text(encoding="utf-8")
    fences = [block.text for block in blocks(page) if block.info != "exit=2"]
    rest = FENCE.sub("", text)
    return "\n".join([*fences, *re.findall(r"^    \S.*$", rest, re.MULTILINE), *re.findall(r"`([^`]+)`", rest)])


def test_every_target_of_make_is_there() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z0-9-]+):", makefile, re.MULTILINE))
    named = {first or second for page in PAGES for first, second in MAKE.findall(page.read_text(encoding="utf-8"))}
    assert len(named) > 5 and named <= targets


@pytest.mark.parametrize(
    ("text", "output", "expected"),
    [
        ("a\nb\n", "a\nb\n", True),
        ("a\nb\n", "a\nb\nc\n", False),
        ("a\n", "b\na\n", False),
        ("a\n…\n", "a\nb\nc\n", True),
        ("…\nc\n", "a\nb\nc\n", True),
        ("a\n…\nd\n", "a\nc\n", False),
        ("a … (c)\n", "a bb (c)  \n", True),
        ("a.c\n", "abc\n", False),
    ],
)
def test_how_outputs_are_compared(text: str, output: str, expected: bool) -> None:
    assert agrees(text, output) is expected and GAP not in output


def test_the_file_list_of_the_runtime_is_whole(tmp_path: Path) -> None:
    fill(tmp_path)
    run(Block("sh", "", "exover emit specs/satellite.exo --unchecked --target c --out c"), tmp_path)
    run(Block("sh", "", "exover emit specs/satellite.exo --unchecked --target rust --out rust"), tmp_path)
    table = (ROOT / "docs" / "runtime.md").read_text(encoding="utf-8").split("## Files")[1].split("##")[0]
    listed = set(re.findall(r"`([\w.]+)`", "\n".join(re.findall(r"^\| (.*?) \|", table, re.MULTILINE))))
    assert {name.replace("NAME", "satellite") for name in listed} == {path.name for path in (tmp_path / "c").iterdir()}


def test_the_spec_and_the_properties_of_the_language_are_read() -> None:
    page = blocks(ROOT / "docs" / "language.md")
    (text,), (formulas,) = ([block.text for block in page if block.language == kind] for kind in ("exo", "prop"))
    spec = exover.loads(text)
    loaded = load_properties(Source("language.md", formulas), spec.model)
    assert not spec.warnings and not loaded.diagnostics
    assert loaded.properties is not None and len(loaded.properties.properties) == formulas.count("\nproperty ")


def test_every_configuration_is_read(tmp_path: Path) -> None:
    fill(tmp_path)
    pages = [page for page in PAGES if page.name != "errors.md"]  # whose examples are wrong: tests/manual reads them
    configurations = [block.text for page in pages for block in blocks(page) if block.language == "toml"]
    waivers = [text for text in configurations if "[[waiver]]" in text]
    assert len(waivers) > 1
    for text in waivers:
        (tmp_path / "own.toml").write_text(text, encoding="utf-8")
        run(Block("sh", "", "exover check specs/violations/lockout.exo --config own.toml"), tmp_path)
