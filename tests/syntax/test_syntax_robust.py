"""No text, however broken, deep or long, raises or takes long; and the tables are those of the grammar."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exover.syntax.grammar as grammar_module
import exover.syntax.parse as parse_module
from exover.diagnostics import CODES, MAX_REPORTS, Diagnostic, render_all
from exover.source import Source
from exover.syntax.decode import MAX_BYTES, decode
from exover.syntax.grammar import grammar, make, packed
from exover.syntax.lex import END, tokens
from exover.syntax.parse import parse
from tests.support.format_spec import format_spec
from tests.support.mutations import any_words, mutations

SAMPLE = Path(__file__).with_name("sample.exo").read_text("utf-8")
MEGABYTE = 1_000_000
TOKENS = [token.text for token in tokens(SAMPLE, []) if token.kind != END]


def check(text: str) -> tuple[Diagnostic, ...]:
    """Return the reports on a text, of which the parser has to make some sense."""
    source = Source("t", text)
    spec, reports = parse(source)
    assert (spec is None) == bool(reports)
    assert len(reports) <= MAX_REPORTS + 1
    starts = []
    for report in reports:
        assert report.code in CODES
        assert report.span is not None
        assert 0 <= report.span.start <= report.span.end <= len(text)
        starts.append(report.span.start)
    assert starts == sorted(starts)
    assert all(len(line) < 400 for line in render_all(reports, source).splitlines())
    return reports


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    check(text)
    check("spec s; " + text)


@settings(max_examples=100, deadline=None)
@given(any_words(TOKENS))
def test_any_sequence_of_tokens(words: list[str]) -> None:
    check(" ".join(words))
    check("spec s; module m { request r() { " + " ".join(words))


@settings(max_examples=100, deadline=None)
@given(mutations(TOKENS))
def test_any_mutation_of_a_spec(words: list[str]) -> None:
    check("\n".join(words))


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes(data: bytes) -> None:
    match decode("t", data):
        case Source(text=text):
            check(text)
        case Diagnostic(code="E002", span=None):
            pass
        case other:
            raise AssertionError(other)


@pytest.mark.parametrize(
    ("before", "behind", "blocks"),
    [
        ("forbid ", ";", 0),
        ("context m.a { check ", "; }", 1),
        ("module m { request a(n: int in 0 .. 9) { check ", "; } }", 2),
    ],
)
def test_brackets_nest_as_deep_as_the_page_says(before: str, behind: str, blocks: int) -> None:
    for opening, closing in (("(", ")"), ("not ", ""), ("a implies ", "")):
        for levels, codes in ((64 - blocks, []), (65 - blocks, ["E109"])):
            text = f"spec s;\n{before}{opening * levels}a{closing * levels}{behind}"
            assert [each.code for each in check(text)][:1] == codes


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("forbid " + "(" * 10_000 + "a" + ")" * 10_000 + ";", "E109"),
        ("forbid " + "not " * 10_000 + "a;", "E109"),
        ("forbid " + "a implies " * 10_000 + "a;", "E109"),
        ("forbid " + "active(m.r with " * 10_000, "E109"),
        ("module m " + "{" * 10_000, "E106"),
        ("forbid a in " + "{a in " * 10_000, "E106"),
        ("forbid " + "(" * MEGABYTE, "E109"),
        ("}" * MEGABYTE, "E106"),
        ("$" * MEGABYTE, "E101"),
        ("\0" * MEGABYTE, "E101"),
        ("/* " * (MEGABYTE // 3), "E103"),
        ("forbid a because " + '"' + "x" * MEGABYTE, "E102"),
        ("forbid x > " + "1" * MEGABYTE + ";", "E105"),
        ("forbid x > " + "1" * MEGABYTE + "x;", "E105"),
        ("x;" * (MEGABYTE // 2), "E106"),
        ("forbid a because " + '"' + "\\q" * MEGABYTE + '"', "E104"),
    ],
    ids=lambda value: value[:24] if len(value) > 4 else value,
)
def test_deep_and_long_texts_are_refused_at_once(text: str, code: str) -> None:
    assert check("spec s;\n" + text)[0].code == code


@pytest.mark.parametrize(
    "text",
    [
        "forbid a because " + '"' + "x" * MEGABYTE + '";',
        "forbid " + "a" * MEGABYTE + ";",
        "/*" + "*" * MEGABYTE + "*/ forbid a;",
        "\n" * MEGABYTE + "forbid a;",
    ],
    ids=["string", "name", "comment", "lines"],
)
def test_long_parts_are_fine(text: str) -> None:
    assert check("spec s;" + text) == ()


def test_long_lists_are_flat() -> None:
    text = "spec s; forbid " + "a or " * 5000 + "a; forbid 0 < " + "a + " * 5000 + "a; mutex " + "a, " * 5000 + "b;\n"
    spec, reports = parse(Source("t", text))
    assert reports == ()
    assert spec is not None
    assert format_spec(spec).replace("\n", "") == text.replace("; ", ";").replace("\n", "")


def test_a_line_of_megabytes_is_cut_around_the_mistake() -> None:
    text = "spec s; " + "forbid a; " * 2_000 + "forbid a b; " + "forbid a; " * 2_000
    shown = render_all(check(text), Source("t", text)).splitlines()
    assert shown[1] == f"  --> t:1:{8 + 20_000 + 10}"
    assert shown[3].startswith("1 | … ")
    assert shown[3].endswith(" …")
    assert shown[3][shown[4].index("^")] == "b"


def test_too_many_tokens_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parse_module, "MAX_TOKENS", 1000)
    assert check("spec s; mutex a" + ", a" * 497 + ";") == ()
    (report,) = check("spec s; mutex a" + ", a" * 498 + ";")
    assert (report.code, report.message) == ("E003", "the file is too large: more than 1000 words and symbols")
    (report,) = check("spec s; forbid (((a b " + ", a" * 5000)
    assert report.code == "E106"


def test_decode() -> None:
    assert decode("t", b"\xef\xbb\xbfspec s;\r\n") == Source("t", "spec s;\r\n")
    assert decode("t", "é".encode()) == Source("t", "é")
    assert decode("t", b"spec s;\n\xff\xfe") == Diagnostic(
        "E002", "the file is no UTF-8 text: byte 0xff on line 2", None, help="save it as UTF-8"
    )
    assert decode("t", b"\xef\xbb\xbfspec s;\n\n\xff") == Diagnostic(
        "E002", "the file is no UTF-8 text: byte 0xff on line 3", None, help="save it as UTF-8"
    )
    assert decode("t", b" " * (MAX_BYTES + 1)) == Diagnostic("E003", "the file is too large: more than 16 MiB", None)
    assert isinstance(decode("t", b" " * MAX_BYTES), Source)


def test_the_kept_tables_are_those_of_the_grammar() -> None:
    folder = Path(grammar_module.__file__).parent
    text = folder.joinpath("grammar.lark").read_text("utf-8")
    assert folder.joinpath("grammar.json").read_text("utf-8") == packed(text), "run python -m exover.syntax.grammar"
    assert grammar() == make(text)
