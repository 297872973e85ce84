"""Names of whole specs: what one stands for is what the resolver takes it for."""

from pathlib import Path

import pytest

from exover.diagnostics import Diagnostic
from exover.editor.analysis import analyse_properties, analyse_spec
from exover.editor.fixes import fix
from exover.editor.rename import RenameRefused, rename
from exover.editor.symbols import SpecSymbol
from exover.editor.text import EditorText
from exover.places import find_properties
from exover.source import Source, Span
from exover.syntax.lex import NAME, tokens

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted([*(ROOT / "specs").glob("*.exo"), *(ROOT / "tests" / "specs").glob("*.exo")])
FRESH = "fresh_name"


def read(path: Path) -> Source:
    return Source(str(path), path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_every_word_that_is_a_name_has_a_meaning(path: Path) -> None:
    found = analyse_spec(read(path))
    assert not found.diagnostics
    known = {each.span.start for each in found.index.occurrences}
    assert len(known) == len(found.index.occurrences), "a name has one meaning"
    text = found.source.text
    names = [each for each in tokens(text, []) if each.kind == NAME]
    unknown = {each.text for each in names if each.start not in known}
    declared = {each.name.rpartition(".")[2] for each in found.index.declared}
    assert not unknown & {each.name for each in found.index.declared if each.sort in ("module", "poster", "define")}
    assert len([each for each in names if each.start in known]) > len(declared)


@pytest.mark.parametrize("path", SPECS, ids=[path.stem for path in SPECS])
def test_every_symbol_can_be_renamed_and_the_meaning_stays(path: Path) -> None:
    spec = analyse_spec(read(path))
    files = find_properties(str(path), spec.model.name)
    texts = [(str(path), spec), *((file, analyse_properties(read(Path(file)), spec)) for file in files)]
    for symbol in [*dict.fromkeys(each.symbol for _, found in texts for each in found.index.occurrences)][::7]:
        changes = rename(texts, symbol, FRESH)
        assert changes, symbol
        for change in changes:
            found = dict(texts)[change.path]
            assert {found.source.slice(span) for span in change.spans} == {symbol.name.rpartition(".")[2]}


def test_a_use_that_is_left_out_is_a_mistake() -> None:
    """Were an occurrence missing in the index, the renamed text would have a mistake: that is what refuses it."""
    found = analyse_spec(Source("a.exo", "spec s; module m { request a(); request b(); } mutex m.a, m.b;"))
    found.index.occurrences.pop()
    with pytest.raises(RenameRefused, match="unknown request"):
        rename([("a.exo", found)], SpecSymbol("request", "m.b"), FRESH)


def test_a_new_name_that_another_name_would_mean_is_refused() -> None:
    text = "spec s; poster x: bool = false; module m { request a(p: bool) { check p or not x; } }"
    found = analyse_spec(Source("a.exo", text))
    with pytest.raises(RenameRefused, match="would mean something else"):
        rename([("a.exo", found)], SpecSymbol("parameter", "m.a.p"), "x")


SCOPES = [
    (
        "poster x: int in 0 .. 9 = 0; module m { poster x: int in 0 .. 9 = 0; request a() { check @x < 3; } }",
        "poster m.x",
    ),
    ("poster x: int in 0 .. 9 = 0; module m { request a(x: int in 0 .. 9) { check @x < 3; } }", "parameter m.a.x"),
    ("poster x: bool = false; module m { request a(); } forbid active(m.a) and @x;", "poster x"),
    ("module m { request a(x: bool); } forbid f: active(m.a with @x);", "parameter m.a.x"),
    ("module m { request a() returns (x: bool); request b() { check past(m.a with @x); } }", "result m.a.x"),
    ("module m { request a(x: bool) { check not active(m.a with x == self.@x); } }", "parameter m.a.x"),
    ("module m { state x: {u, v} = u; request x() { on ok set @x = v; } }", "state m.x"),
    ("module m { state x: {u, v} = u; request a() { on ok set x = @v; } }", "value v"),
    ("const x = 3; module m { request a(p: int in 0 .. 9) { check p < @x; } }", "const x"),
    ("define x = active(m.a); module m { request a(); request b() { check not @x; } }", "define x"),
    ("group x = m.a; module m { request a(); request b(); } mutex @x, m.b;", "group x"),
    ("enum x { u, v } module m { request a(p: @x); }", "enum x"),
    ("resource x: 3; module m { request a() { uses @x 2; } }", "resource x"),
    ("latch x: when p until m.a; poster p: bool = false; module m { request a() { check not @x; } }", "latch x"),
    ("module m { request a(); } context @m.a { check true == false; }", "module m"),
]


@pytest.mark.parametrize(("text", "meant"), SCOPES, ids=[text for text, _ in SCOPES])
def test_a_name_means_what_stands_nearest(text: str, meant: str) -> None:
    offset = len("spec s; ") + text.index("@")
    found = analyse_spec(Source("a.exo", "spec s; " + text.replace("@", ""))).index.at(offset)
    assert found is not None and f"{found.symbol.sort} {found.symbol.name}" == meant


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
@pytest.mark.parametrize("text", ["", "a", "a\nb", "ä🤖b\r\n🤖c\rd\n", "\u2028x\x0cy\x85z\n", "\n\n"])
def test_places_and_offsets_are_each_others_inverse(text: str, encoding: str) -> None:
    seen = EditorText(text, encoding)  # type: ignore[arg-type]
    for offset in range(len(text) + 1):
        if text[max(offset - 1, 0) : offset + 1] != "\r\n":
            assert seen.offset(seen.place(offset)) == offset
    assert seen.offset((10**9, 0)) == len(text)
    for line in range(5):
        assert 0 <= seen.offset((line, 10**9)) <= len(text)


def test_lines_end_as_the_protocol_has_it() -> None:
    seen = EditorText("a\u2028b\x0c\rc\r\nd\n")
    assert [seen.place(offset)[0] for offset in range(len(seen.text) + 1)] == [0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 3]


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (Diagnostic("E201", "m", Span(1, 2), help="did you mean `battery`?"), "battery"),
        (Diagnostic("E101", "m", Span(1, 2), help="write `and`"), "and"),
        (Diagnostic("E107", "m", Span(1, 1)), ";"),
        (Diagnostic("E101", "m", Span(1, 2), help="write `>=`, or `implies` between conditions"), None),
        (Diagnostic("E206", "m", Span(1, 2), help="write `forbid CONDITION;`"), None),
        (Diagnostic("E201", "m", Span(1, 2), help="known here: `a`"), None),
        (Diagnostic("E001", "m", None, help="did you mean `a`?"), None),
    ],
)
def test_only_one_clear_change_is_offered(found: Diagnostic, text: str | None) -> None:
    mended = fix(found, Source("a.exo", "a b c"))
    assert (mended and mended.text) == text
