"""GenoM3 descriptions as parts of specs (docs/imports.md). The descriptions were written for these tests."""

import shutil
from pathlib import Path

import pytest

from exover.imports import preprocess as preprocessing
from exover.imports.genom import import_genom
from exover.imports.part import Imported, UnreadableDescription
from exover.imports.preprocess import preprocess
from exover.pipeline import load
from exover.source import Source
from exover.syntax.layout import formatted
from tests.support.breaking import broken

HERE = Path(__file__).parent
ARM = HERE / "arm" / "arm.gen"


def imported(text: str, head: str = "part p;") -> Imported:
    return import_genom(preprocessing.Preprocessed("t.gen", text, (), ((1, "t.gen", 1),)), head)


def module(body: str, before: str = "") -> str:
    """Return the module of a component with this body, without comments, on one line."""
    text = imported(f"{before}\ncomponent c {{ {body} }};").text
    lines = [line.strip() for line in text.splitlines() if not line.strip().startswith("//")]
    return " ".join(" ".join(lines).split()).removeprefix("part p; ")


@pytest.fixture(scope="module")
def arm() -> Imported:
    return import_genom(preprocess(str(ARM), ARM.read_text()), "part arm;")


def test_the_whole_part(arm: Imported) -> None:
    assert arm.text == (HERE / "arm" / "arm.exo").read_text()


def test_a_part_is_canonical_and_has_no_mistake(arm: Imported) -> None:
    assert formatted(Source("arm.exo", arm.text)) == (arm.text, ())
    assert load(Source("arm.exo", arm.text.replace("part arm;", "spec arm;"))).diagnostics == ()


def test_what_is_left_open_is_told_and_stands_in_a_comment(arm: Imported) -> None:
    assert len(arm.remarks) > 15
    for remark in arm.remarks:
        assert f"// {str(remark).removeprefix(str(ARM.parent) + '/')}".replace("iface/", "") in arm.text, remark
        assert remark.place.startswith(str(ARM.parent))


def test_places_are_those_of_the_files_before_the_preprocessor(arm: Imported) -> None:
    lines = ARM.read_text().splitlines()
    numbers = {int(remark.place.rpartition(":")[2]): remark.text for remark in arm.remarks if ".gen:" in remark.place}
    for number, text in numbers.items():
        if "`" in text and "`goal`" not in text and "`moving`" not in text:
            named = text.split("`")[1].split()[-1].rstrip("_")
            assert named in lines[number - 1], (number, text)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("activity a();", "module c { request a(); }"),
        ("function a(in boolean x, out double y);", "module c { request a(x: bool) returns (y: real); }"),
        (
            "activity a(in octet x, in short y);",
            "module c { request a(x: int in 0 .. 255, y: int in -32768 .. 32767); }",
        ),
        (
            "activity a(in unsigned long x, in long y);",
            "module c { request a(x: int in 0 .. 4294967295, y: int in -2147483648 .. 2147483647); }",
        ),
        ("activity a(in string x, in any y, in char z, out fixed f);", "module c { request a(); }"),
        ("exception e, f; activity a() { throw e, f, e; };", "module c { request a() fails (e, f); }"),
        (
            "activity a() { interrupts a, b; }; activity b() { interrupt b; };",
            "module c { request a() { interrupts self, c.b; } request b() { interrupts self; } }",
        ),
        (
            "activity a() { interrupts all; }; activity b(); function f(); attribute g();",
            "module c { request a() { interrupts self, c.b; } request b(); request f(); request g(); }",
        ),
        (
            "activity a() { after b; }; activity b() { before a; };",
            "module c { request a() { after c.b; } request b() { before c.a; } }",
        ),
        (
            "activity a() { after all; }; function f(); attribute g();",
            "module c { request a() { after c.f, c.g; } request f(); request g(); }",
        ),
        ("port out boolean b; port in double d;", "module c { poster b: bool = false; }"),
        ("port out e p; ", "enum e { x, y } module c { poster p: e = x; }"),
        ("port out f p; activity a(in f x);", "enum f { in_, y } module c { poster p: f = in_; request a(x: f); }"),
        ("activity in(in double not);", "module c { request in_(not_: real); }"),
        ('doc "say \\"so\\"" " and so"; activity a();', 'module c "say \\"so\\" and so" { request a(); }'),
        ("ids { s v; }; attribute a(in v.x::n, out v.x);", "module c { request a(n: bool) returns (x: bool); }"),
        ("ids { s v[N]; }; attribute a(in v[N].x);", "module c { request a(x: bool); }"),
        ("ids { double v[2]; }; attribute a(in v[N - 1]);", "module c { request a(v: real); }"),
        ("ids { t v[2]; }; attribute a(in v[0][1]::y);", "module c { request a(y: real); }"),
        ('doc "a\x1b\x01b"; activity a();', 'module c "a\ufffd\ufffdb" { request a(); }'),
    ],
)
def test_what_maps_to_what(body: str, said: str) -> None:
    before = "enum e { x, y }; enum f { in, y }; struct s { boolean x; }; typedef double t[2];"
    assert module(body, before) == said


@pytest.mark.parametrize(
    "body",
    [
        "provides i; activity stop(); activity go(in double v) { interrupts stop; };",
        "activity stop(); activity go(in double v) { interrupts stop; }; provides i;",
        "provides i; activity stop(); activity go(in double v); activity go(in double v) { interrupts stop; };",
    ],
)
def test_a_service_says_what_all_its_declarations_say(body: str) -> None:
    said = module(body, "interface i { activity go(in double v) { throw e; after stop; }; };")
    assert "request go(v: real) fails (e) { " in said
    assert "interrupts c.stop;" in said and "after c.stop;" in said


def test_an_interface_that_is_provided_twice_is_read_once() -> None:
    before = "interface a { port out double p; }; interface b { extends a; }; interface d { extends a; };"
    assert module("provides b, d, a;", before) == "module c { poster p: real = 0; }"


def test_each_component_has_ids_of_its_own() -> None:
    before = "component b { ids { long x; }; attribute a(in x); };"
    said = module("ids { double x; }; attribute a(in x);", before)
    assert "module b { request a(x: int in -2147483648 .. 2147483647); }" in said
    assert "module c { request a(x: real); }" in said


def test_words_of_genom_are_names_where_only_a_name_can_stand() -> None:
    body = "activity stop(); activity port(in double task, in double doc); function log(); port out double period;"
    assert "request port(task: real, doc: real);" in module(body)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("activity a(inout double x);", "`x` goes in and comes out: what comes out is left out"),
        ("activity a(inout double with);", "`with_` goes in and comes out: what comes out is left out"),
        ("activity a() { interrupts f; }; function f();", "`interrupts f` of `a` is left out: a function ends at once"),
        ("activity a() { after z; };", "`after z` of `a` is left out: no such service is declared in what was read"),
        ("activity a() { after a; };", "`after a` of `a` is left out: it is the service itself"),
        ("activity a(in m::t x);", "`x` is left out: its type `m::t` is declared in no file that was read"),
        ("activity a(in unsigned long long x);", "`x` is taken for `int in 0 .. 9223372036854775807`"),
        ("port out double p; activity a();", "`p` is taken to be 0 until it is first observed"),
        ("provides i; activity a();", "interface `i` is declared in no file that was read"),
        ("throw e; activity a();", "the component may throw e"),
        ("attribute a(in x.y);", "`y` is left out: it is no element of the IDS that was read"),
        ("typedef t t; activity a(in t x);", "`x` is left out"),
    ],
)
def test_what_is_left_open(body: str, said: str) -> None:
    found = imported(f"component c {{ {body} }};")
    assert [remark for remark in found.remarks if said in remark.text]
    assert said in found.text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "t.gen: the file describes no component"),
        ("interface i { };", "t.gen: the file describes no component"),
        ("component c {", "t.gen:1:"),
        ("component c {\n  activity a(in ) {};\n};", "t.gen:2:17: unexpected `)`; expected a name, "),
        ("component ;", "t.gen:1:11: unexpected `;`; expected a name"),
        ("component c { doc ; };", "t.gen:1:19: unexpected `;`; expected a text"),
        ("component c { ; };", "t.gen:1:15: unexpected `;`; expected `codels-require`, `clock-rate`, "),
        ("component c {\n  bogus a();\n};", "t.gen:2:3: unexpected"),
        ("component c { activity a(); \x01 };", "t.gen:1:29: unexpected"),
        ("component c { activity a(); activity a(); activity a; };", "t.gen:1:53: unexpected `;`"),
        ("component c { activity a(in double x, in double x); };", "t.gen: "),
        ("component c { } component c { activity a(); };", "t.gen: "),
        (
            "component c {\n  activity a();\n  activity a(in long x);\n};",
            "t.gen:3: `a` is declared with another kind or other parameters at t.gen:2",
        ),
        ("component c { activity a(); function a(); };", "t.gen:1: `a` is declared with another kind"),
        ("module m { " * 9999 + "};" * 9999 + "component c { };", "t.gen: modules or structs are nested too deep"),
    ],
)
def test_what_is_no_description_is_refused_with_its_place(text: str, said: str) -> None:
    with pytest.raises(UnreadableDescription) as raised:
        imported(text)
    assert str(raised.value).startswith(said)


def test_without_a_preprocessor_nothing_is_included(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    found = import_genom(preprocess("t.gen", '#include "x.gen"\ncomponent c { activity a(); };'), "part p;")
    assert [remark.text for remark in found.remarks] == ["`x.gen` is not read: there is no C preprocessor"]


@pytest.mark.parametrize("name", ["-DX.gen", 'a"b.gen', "a\\b.gen", "a\nb.gen", "\u00e9.gen"])
@pytest.mark.parametrize("preprocessor", ["cpp", "clang"])
def test_a_file_may_be_called_anything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, preprocessor: str
) -> None:
    path = shutil.which(preprocessor)
    if path is None:
        pytest.skip(f"no {preprocessor}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(shutil, "which", lambda program: path if program == preprocessor else None)
    Path(name).write_text("#define T double\ncomponent c { activity a(in T x); };")
    found = import_genom(preprocess(name, Path(name).read_text()), "part p;")
    assert "request a(x: real);" in found.text


def test_a_preprocessor_that_refuses_is_told(tmp_path: Path) -> None:
    bad = tmp_path / "bad.gen"
    for text in ("#error no\n", '#include "/none/x.gen"\n', '#include "../../none/x.gen"\n', "#if 1\n"):
        bad.write_text(text + "component c { activity a(); };")
        with pytest.raises(preprocessing.NotPreprocessed):
            preprocess(str(bad), bad.read_text())


def test_folders_are_looked_at_for_includes(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "x.gen").write_text("enum e { a, b };")
    file = tmp_path / "t.gen"
    file.write_text('#include "x.gen"\ncomponent c { activity go(in e how); };')
    found = import_genom(preprocess(str(file), file.read_text(), [str(tmp_path / "there")]), "part p;")
    assert found.remarks == () and "request go(how: e);" in found.text


@pytest.mark.parametrize("seed", range(80))
def test_whatever_is_given_is_read_or_refused(seed: int) -> None:
    text = broken(ARM.read_text(), seed)
    try:
        imported(text)
    except UnreadableDescription as reason:
        assert str(reason).startswith("t.gen:")


def test_a_description_too_large_for_a_spec_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("exover.syntax.parse.MAX_TOKENS", 10)
    with pytest.raises(UnreadableDescription, match=r"^t.gen: the file is too large"):
        imported("component c { activity a(); activity b(); };")
