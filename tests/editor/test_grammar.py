"""The grammars of editors/vscode colour each word as what the parser takes it for."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import END, INT, NAME, NUMBER, STRING, tokens
from exover.syntax.machine import ParserState

ROOT = Path(__file__).resolve().parents[2]
SYNTAXES = ROOT / "editors" / "vscode" / "syntaxes"
FOLDERS = ("specs", "specs/violations", "properties", "tests/specs")
TEXTS = sorted(path for folder in FOLDERS for path in (ROOT / folder).glob("*.*") if path.suffix in (".exo", ".prop"))
COLOURS = {INT: "constant.numeric", NUMBER: "constant.numeric", STRING: "string"}
PREDICATES = ("used", "level")
NAMES = ("entity.name.", "variable.")
WORDS = ("keyword.", "support.function.", "constant.language.", "storage.type.", "variable.language.")


def patterns(path: Path) -> list[dict[str, Any]]:
    """Return the patterns for the texts of a file."""
    name = "exo" if path.suffix == ".exo" else "exo-properties"
    return json.loads((SYNTAXES / f"{name}.tmLanguage.json").read_text(encoding="utf-8"))["patterns"]


def coloured(text: str, path: Path) -> dict[int, tuple[int, str]]:
    """Return where each coloured part of a text begins, where it ends, and its scope, as an editor does."""
    rules = [(re.compile(each.get("match") or each["begin"]), each) for each in patterns(path)]
    found: dict[int, tuple[int, str]] = {}
    place, end_of_block = 0, None
    for line in re.findall(r".*\n|.+\Z", text):
        start = 0
        while start < len(line):
            if end_of_block is not None:
                ended = end_of_block.search(line, start)
                start, end_of_block = (ended.end(), None) if ended else (len(line), end_of_block)
                continue
            matches = [
                (found_.start(), number, found_)
                for number, (rule, _) in enumerate(rules)
                if (found_ := rule.search(line, start))
            ]
            if not matches:
                break
            _, number, match = min(matches, key=lambda each: each[:2])
            rule = rules[number][1]
            if "begin" in rule:
                end_of_block = re.compile(rule["end"])
            for begin, end, scope in scopes(match, rule):
                found[place + begin] = (place + end, scope)
            assert match.end() > start, f"{rule} takes nothing"
            start = match.end()
        place += len(line)
    return found


def scopes(match: re.Match[str], rule: dict[str, Any]) -> Iterator[tuple[int, int, str]]:
    if "name" in rule:
        yield match.start(), match.end(), rule["name"]
    for group, capture in rule.get("captures", {}).items():
        if match[int(group)] is not None:
            yield match.start(int(group)), match.end(int(group)), capture["name"]


@pytest.mark.parametrize("path", TEXTS, ids=[path.name for path in TEXTS])
def test_every_token_has_the_colour_of_its_kind(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    start: Start = "file" if path.suffix == ".exo" else "properties"
    found, wrong = coloured(text, path), []
    machine = ParserState(grammar(), start)
    machine.building = False
    for token in tokens(text, [], start == "properties"):
        kind = machine.kind(token)
        if kind in PREDICATES and not text[token.end :].lstrip().startswith("("):
            kind = NAME  # the parser tells so by what comes behind
        assert machine.feed(token)
        if token.kind == END or not (token.text[0].isalnum() or token.text[0] in '_"'):
            continue
        end, scope = found.get(token.start, (0, ""))
        wanted = NAMES if kind == NAME else COLOURS.get(kind, WORDS)
        if end != token.end or not scope.startswith(wanted):
            wrong.append((text.count("\n", 0, token.start) + 1, token.text, kind, scope))
    assert not wrong


def test_comments_are_coloured_whole() -> None:
    text = "spec s; // mutex\n/* module\n request */ module m { request r(); }\n"
    words = {text[begin:end]: scope for begin, (end, scope) in coloured(text, Path("a.exo")).items()}
    assert words["// mutex"].startswith("comment.line")
    assert "mutex" not in words and words["request"] == words["module"] == "keyword.declaration.exo"
    assert [
        text[:begin].count("\n")
        for begin, (end, _) in coloured(text, Path("a.exo")).items()
        if text[begin:end] == "request"
    ] == [2]


def test_names_that_keywords_spell_are_names() -> None:
    text = "spec s; module wait { request stop(when: bool); request fail(); } mutex over: wait.stop, wait.fail;"
    words = {begin: scope for begin, (_, scope) in coloured(text, Path("a.exo")).items()}
    for word in ("stop", "fail", "when", "over", "wait.stop"):
        assert words[text.index(word)].startswith(NAMES), word


def test_the_words_of_parts_have_their_colours() -> None:
    text = 'part part;\ninclude "drive.exo";\nmodule include { request part(include: bool); }\n'
    text += "mutex include.part, include.*;\n"
    found = coloured(text, Path("x.exo"))
    scopes_of = [found.get(match.start(), (0, ""))[1] for match in re.finditer(r"part|include", text)]
    assert scopes_of[0].startswith(WORDS) and scopes_of[2].startswith(WORDS)
    assert all(each.startswith(NAMES) for each in (scopes_of[1], *scopes_of[3:])), scopes_of
