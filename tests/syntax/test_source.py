"""Places in texts, and how a diagnostic is shown."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exover.diagnostics import CODES, QUOTE_WIDTH, Diagnostic, did_you_mean, quote, render
from exover.source import Source, Span


@pytest.mark.parametrize(
    ("text", "offset", "place"),
    [
        ("", 0, (1, 1)),
        ("ab", 1, (1, 2)),
        ("ab", 2, (1, 3)),
        ("ab", 99, (1, 3)),
        ("ab", -1, (1, 1)),
        ("a\nb", 1, (1, 2)),
        ("a\nb", 2, (2, 1)),
        ("a\r\nb", 3, (2, 1)),
        ("a\rb", 2, (1, 3)),
        ("\té🙂x", 3, (1, 4)),
        ("a\n", 2, (2, 1)),
    ],
)
def test_positions(text: str, offset: int, place: tuple[int, int]) -> None:
    assert Source("t", text).position(offset) == place


@given(st.text("ab\n\r", max_size=40).map(lambda text: text * 3000), st.integers(0, 130_000))
def test_positions_of_long_texts(text: str, offset: int) -> None:
    inside = min(offset, len(text))
    before = text[:inside].split("\n")
    assert Source("t", text).position(offset) == (len(before), len(before[-1]) + 1)


@pytest.mark.parametrize(
    ("text", "offset", "line"),
    [
        ("a\r\nbc\r\nd", 3, "bc"),
        ("a\r\nbc\r\nd", 5, "bc"),
        ("a\nb", 1, "a"),
        ("a\n", 2, ""),
        ("", 0, ""),
        ("\r\n", 0, ""),
    ],
)
def test_lines(text: str, offset: int, line: str) -> None:
    source = Source("t", text)
    assert source.slice(source.line_span(offset)) == line


def shown(text: str, span: Span | None, **parts: str) -> list[str]:
    return render(Diagnostic("E203", "unknown request `nd.got`", span, **parts), Source("s.exo", text)).splitlines()  # type: ignore[arg-type]


def test_a_diagnostic_with_everything() -> None:
    text = "spec s;\n" * 9 + "mutex nd.got, a.b;\n"
    assert shown(text, Span(78, 84), label="not declared", help="did you mean `nd.goto`?") == [
        "error[E203]: unknown request `nd.got`",
        "   --> s.exo:10:7",
        "   |",
        "10 | mutex nd.got, a.b;",
        "   |       ^^^^^^ not declared",
        "   = help: did you mean `nd.goto`?",
    ]


def test_a_diagnostic_without_a_place() -> None:
    assert shown("x", None, help="look elsewhere", severity="warning") == [
        "warning[E203]: unknown request `nd.got`",
        "  --> s.exo",
        "  = help: look elsewhere",
    ]


def test_a_tab_is_shown_as_blanks_and_underlined_as_such() -> None:
    assert shown("\ta\tb", Span(1, 4))[3:] == ["1 |     a    b", "  |     ^^^^^^"]


def test_a_span_of_several_lines_is_underlined_on_its_first() -> None:
    assert shown("abc\r\ndef", Span(1, 7))[3:] == ["1 | abc", "  |  ^^"]


def test_a_span_behind_the_text_is_its_end() -> None:
    assert shown("abc", Span(9, 12))[1:] == ["  --> s.exo:1:4", "  |", "1 | abc", "  |    ^"]


def test_control_characters_do_not_reach_the_terminal() -> None:
    assert shown("a\x1b[31mb\x00", Span(0, 1))[3] == "1 | a\ufffd[31mb\ufffd"
    assert quote("a\x1b\nb") == "`a\ufffd\ufffdb`"


def test_long_quotes_are_cut() -> None:
    assert quote("x" * QUOTE_WIDTH) == "`" + "x" * QUOTE_WIDTH + "`"
    assert quote("x" * (QUOTE_WIDTH + 1)) == "`" + "x" * (QUOTE_WIDTH - 1) + "…`"


@pytest.mark.parametrize(
    ("name", "candidates", "help"),
    [
        ("nd.got", ["nd.goto", "arm.move"], "did you mean `nd.goto`?"),
        ("Battery", ["battery", "batteries"], "did you mean `battery`?"),
        ("zzz", ["nd.goto"], ""),
        ("crane.wind", ["crane.load", "crane.winds"], "did you mean `crane.winds`?"),
        ("crane.wind", ["crane.load"], ""),
        ("height", ["crane.height"], "did you mean `crane.height`?"),
        ("a", [], ""),
        ("abc", ["abc"], ""),
        ("x" * 65, ["x" * 64], ""),
        ("abcd", ["abce", "abcf"], "did you mean `abcf`?"),
        ("abcd", ["abcf", "abce"], "did you mean `abcf`?"),
    ],
)
def test_did_you_mean(name: str, candidates: list[str], help: str) -> None:
    assert did_you_mean(name, candidates) == help


def test_codes_are_distinct_sayings() -> None:
    assert len(set(CODES.values())) == len(CODES)
    assert all(code[0] == "E" and code[1:].isdigit() and len(code) == 4 for code in CODES)
    assert list(CODES) == sorted(CODES)
