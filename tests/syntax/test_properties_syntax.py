"""Properties files as text: trees, canonical text, mistakes each told once, and no text that raises or takes long."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exover.diagnostics import CODES, MAX_REPORTS, Diagnostic, render_all
from exover.source import Source
from exover.syntax import tree
from exover.syntax.grammar import grammar
from exover.syntax.lex import END, RESERVED, tokens
from exover.syntax.parse import parse, parse_properties
from tests.support.format_properties import format_properties
from tests.support.mutations import any_words, mutations
from tests.support.reported import places_of

SAMPLE = Path(__file__).with_name("sample.prop").read_text("utf-8")
TOKENS = [token.text for token in tokens(SAMPLE, [], formulas=True) if token.kind != END]
KEYWORDS = sorted({kind for row in grammar().actions for kind in row if kind.isalpha() and kind not in RESERVED})


def check(text: str) -> tuple[Diagnostic, ...]:
    """Return the reports on a text, of which the parser has to make some sense."""
    source = Source("t", text)
    found, reports = parse_properties(source)
    assert (found is None) == bool(reports)
    assert len(reports) <= MAX_REPORTS + 1
    for report in reports:
        assert report.code in CODES
        assert report.span is not None
        assert 0 <= report.span.start <= report.span.end <= len(text)
    assert all(len(line) < 400 for line in render_all(reports, source).splitlines())
    return reports


def parsed(text: str) -> tree.Properties:
    found, reports = parse_properties(Source("t", text))
    assert reports == ()
    assert found is not None
    return found


def formed(text: str) -> str:
    return format_properties(parsed(f"for s; property p: {text};")).split(": ", 1)[1].rstrip("\n;")


def places(text: str) -> list[str]:
    return places_of(check(text), text)


# ---- trees ----


def test_the_canonical_text_of_a_tree_gives_the_tree() -> None:
    found = parsed(SAMPLE)
    text = format_properties(found)
    assert parsed(text) == found
    assert format_properties(parsed(text)) == text
    assert {type(item) for item in found.items} == {tree.Define, tree.Property, tree.AssumeFair, tree.Assume}
    forms = {type(item.form) for item in found.items if isinstance(item, tree.Property)}
    assert len(forms) == 9


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("ltl a U b U c", "ltl a U b U c"),
        ("ltl (a U b) U c", "ltl (a U b) U c"),
        ("ltl !a U b & c", "ltl !a U b & c"),
        ("ltl !(a U b)", "ltl !(a U b)"),
        ("ltl G (a)", "ltl G a"),
        ("ltl G a -> F b -> c", "ltl G a -> F b -> c"),
        ("ltl (a -> b) -> c", "ltl (a -> b) -> c"),
        ("ltl a and b or not c implies d", "ltl a & b | !c -> d"),
        ("ltl a & (b & c) | (d | e)", "ltl a & (b & c) | (d | e)"),
        ("ltl a <-> b <-> c", "ltl a <-> b <-> c"),
        ("ltl (a <-> b) <-> c", "ltl (a <-> b) <-> c"),
        ("ltl X X (a W (b R c))", "ltl X X (a W b R c)"),
        ("ctl A[a U b]&E [ a & b W c|d ]", "ctl A [a U b] & E [a & b W c | d]"),
        ("ctl AG AF !(x in 1..3)", "ctl AG AF !x in 1 .. 3"),
        ("ctl EF active(m.r with x > 1)", "ctl EF active(m.r with x > 1)"),
        ("ltl x < -1 -> y > 2", "ltl x < -1 -> y > 2"),
        ("ltl x <-1", "ltl x < -1"),
        ("never a or b", "never (a or b)"),
        ("always ((a) leads to b and c)", "always (a leads to b and c)"),
        ("always (a) and b", "always (a and b)"),
        ("a or b until (c)", "(a or b) until (c)"),
        ("from (from) possible (possible)", "from (from) possible (possible)"),
    ],
)
def test_formulas(text: str, canonical: str) -> None:
    assert formed(text) == canonical
    assert formed(canonical) == canonical


EVERYWHERE = """for zz;
define zz = zz;
define d2 = zz.zz == zz and zz in {zz, zz} or active(zz.zz with zz > 1) and asked(zz, zz.*);
property zz: never zz;
property p0 "text": possible zz == zz;
property p1: from zz.zz possible zz;
property p2: always (zz leads to zz);
property p3: (zz) precedes zz;
property p4: (zz) until zz.zz;
property p5: ltl zz == 1 & (zz.zz) & launched(zz.zz with zz);
property p6: ctl AG (1 < zz);
assume always zz;
assume never zz;
"""


@pytest.mark.parametrize("keyword", [*KEYWORDS, "forr", "G1", "never_"])
def test_a_keyword_is_a_name_everywhere(keyword: str) -> None:
    renamed = format_properties(parsed(EVERYWHERE.replace("zz", keyword)))
    assert renamed == format_properties(parsed(EVERYWHERE)).replace("zz", keyword)


# ---- mistakes ----


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ["E004 1:1"]),
        ("for", ["E106 1:4"]),
        ("for s", ["E107 1:6"]),
        ("property p: never a;\nproperty q: never;", ["E106 1:1", "E106 2:18"]),
        ("assume fair reports;", ["E106 1:1"]),
        ("spec s; property p: never a;", ["E106 1:1"]),
        ("for s; spec t;", ["E106 1:8"]),
        ("for s; property p: never a\nproperty q: never b;", ["E107 1:27"]),
        ("for s; property p never a; property q: b;", ["E106 1:19", "E106 1:41"]),
        ("for s; property p: ; property q: always; property r: from a; assume;",
         ["E106 1:20", "E106 1:40", "E106 1:60", "E106 1:68"]),
        ("for s; property p: alway a; property q: posible a;", ["E106 1:26", "E106 1:49"]),
        ("for s; property p: alway active(m.a) and b; property q: ltll G a; property r: never a b;",
         ["E106 1:26", "E106 1:62", "E106 1:87"]),
        ("for s; property p: never (a; property q: ctl A [a U b; property r: ltl (a;",
         ["E108 1:26", "E108 1:48", "E108 1:72"]),
        ("for s; property p: ctl A [a U (E [a U b; property q: ctl A [a U (b];", ["E108 1:34", "E108 1:65"]),
        ("for s; property p: ltl G; property q: ltl a U; property r: ltl U b;", ["E106 1:46", "E106 1:66"]),
        ("for s; property p: ltl a &; property q: ctl E a U b;", ["E106 1:27", "E106 1:47"]),
        ("for s; property p: never a & b || !c && d -> e;",
         ["E101 1:28", "E101 1:32", "E101 1:38", "E101 1:43"]),
        ("for s; define d = a | b; assume always !a;", ["E101 1:21", "E101 1:40"]),
        ("for s; property p: never a <-> b; property q: never a[1];", ["E106 1:28", "E106 1:54"]),
        ("for s; property p: always a leads to b;", ["E106 1:29"]),
        ("for s; property p: ltl a && b; property q: ltl a || b;", ["E101 1:26", "E101 1:50"]),
        ("for s; enum e {a, b} module m { request r(); } property p: never a b;", ["E106 1:8", "E106 1:68"]),
        ("for s; property true: never a; property p: never and;", ["E110 1:17", "E106 1:50"]),
        ("for s; property p: never a b c; foo; property q: never d e;", ["E106 1:28", "E106 1:58"]),
        ("for s; assume fair; assume always a b; assume reports;", ["E106 1:19", "E106 1:37", "E106 1:47"]),
        ("for s; property p \"text: never a;\nproperty q: never b c;\nassume fair;", ["E102 1:19", "E106 3:12"]),
        ("for s; property p: ltl " + "(" * 70 + "a" + ")" * 70 + ";", ["E109 1:88"]),
        ("for s; property p: ltl " + "!" * 70 + "a;", ["E109 1:88"]),
        ("for s; property p: ltl " + "G " * 70 + "a;", ["E109 1:152"]),
        ("for s; property p: ltl " + "a U " * 70 + "a;", ["E109 1:282"]),
        ("for s; property p: ctl " + "A [a U " * 70 + "a;", ["E109 1:250"]),
    ],
)  # fmt: skip
def test_each_mistake_is_told_once_at_its_place(text: str, expected: list[str]) -> None:
    assert places(text) == expected


@pytest.mark.parametrize(
    ("text", "message", "help_line"),
    [
        ("", "the file holds no properties", "a properties file begins with `for NAME;`"),
        ("for s; forbid a;", "expected a property, an assumption, a define or the end of the file, found `forbid`",
         "`forbid` stands in a spec"),
        ("for s; property p: ;", "expected a form of property, found `;`", ""),
        ("for s; property p: ltl ;", "expected a formula, found `;`", ""),
        ("for s; property p: never ;", "expected a condition, found `;`", ""),
        ("for s; property p: never a & b;", "unknown operator `&`", "write `and`"),
        ("for s; property p: ltl a b;", "expected an operator or `;`, found `b`", ""),
        ("for s; property p a;", "expected a string or `:`, found `a`", 'it reads `property NAME "TEXT": FORM;`'),
        ("for s; property p: always a leads to b;", "expected `;`, found `leads`",
         "it reads `always (CONDITION leads to CONDITION)`"),
        ("for s; property p: always (a lead to b);", "expected an operator, `leads` or `)`, found `lead`",
         "did you mean `leads`?"),
        ("for s; property p: always active(m.a) lead to b;", "expected `and`, `implies`, `or` or `;`, found `lead`",
         "it reads `always (CONDITION leads to CONDITION)`"),
        ("for s; property p: (active(m.a)) preceds b;",
         "expected `and`, `implies`, `or`, `precedes` or `until`, found `preceds`", "did you mean `precedes`?"),
        ("for s; assme fair reports;",
         "expected a property, an assumption, a define or the end of the file, found `assme`",
         "did you mean `assume`?"),
    ],
)  # fmt: skip
def test_wording(text: str, message: str, help_line: str) -> None:
    report = check(text)[0]
    assert (report.message, report.help) == (message, help_line)


def test_a_statement_of_a_properties_file_in_a_spec_is_told_so() -> None:
    (report,) = parse(Source("t", "spec s; property p: never a;"))[1]
    assert report.help == "`property` stands in a properties file"


def test_operators_of_formulas_are_none_in_a_spec() -> None:
    reports = parse(Source("t", "spec s; forbid a & b -> !c;"))[1]
    assert [(each.code, each.help) for each in reports][:1] == [("E101", "write `and`")]


# ---- any text ----


@settings(max_examples=60, deadline=None)
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    check(text)
    check("for s; " + text)


@settings(max_examples=100, deadline=None)
@given(any_words(TOKENS))
def test_any_sequence_of_tokens(words: list[str]) -> None:
    check(" ".join(words))
    check("for s; property p: ltl " + " ".join(words))


@settings(max_examples=60, deadline=None)
@given(mutations(TOKENS))
def test_any_mutation_of_a_file(words: list[str]) -> None:
    check("\n".join(words))


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("property p: ltl " + "(" * 200_000, "E109"),
        ("property p: ctl " + "E [" * 60_000, "E109"),
        ("property p: ltl " + "-> " * 60_000, "E106"),
        ("]" * 200_000, "E106"),
        ("property p: never " + "& " * 60_000, "E106"),
    ],
    ids=lambda value: value[:24] if len(value) > 4 else value,
)
def test_deep_and_long_texts_are_refused_at_once(text: str, code: str) -> None:
    assert check("for s;\n" + text)[0].code == code
