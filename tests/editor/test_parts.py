"""Specs of several files in an editor: each place in its own document, texts as the editor has them."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from lsprotocol import types

from tests.support.editing import Editor, at, place

SPEC = 'spec demo;\ninclude "parts/arm.exo";\nmodule nd { request goto(); }\nmutex still: nd.goto, arm.home;\n'
ARM = "// the arm\npart arm;\nmodule arm {\n    poster v: int in 0 .. 3 = 0;\n    request home();\n}\n"
DEAF = ARM.replace("home();", "home() { check bad: v > 3; }")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("parts").resolve()
    (found / "parts").mkdir()
    (found / "demo.exo").write_text(SPEC, encoding="utf-8")
    (found / "parts" / "arm.exo").write_text(ARM, encoding="utf-8")
    return found


@pytest.fixture
def both(editor: Editor) -> Iterator[tuple[str, str]]:
    uris = editor.open("demo.exo", SPEC), editor.open("parts/arm.exo", ARM)
    for uri in uris:
        assert editor.diagnostics(uri) == []
    yield uris
    for uri in uris:
        editor.close(uri)


def start(found: types.Diagnostic) -> tuple[int, int]:
    return found.range.start.line, found.range.start.character


def test_mistakes_stand_in_the_document_that_has_them(editor: Editor, both: tuple[str, str]) -> None:
    spec, arm = both
    editor.change(arm, ARM.replace("home()", "rest()"))
    (found,) = editor.diagnostics(spec, bool)
    assert (found.code, start(found)) == ("E203", (3, 22))
    assert editor.diagnostics(arm) == []
    editor.change(arm, ARM.replace("0 .. 3", "0 .. x"))
    (found,) = editor.diagnostics(arm, bool)
    assert start(found) == (3, 26)
    assert editor.diagnostics(spec, lambda told: not told) == []


def test_a_part_is_read_with_its_spec_on_disk(editor: Editor) -> None:
    arm = editor.open("parts/arm.exo", ARM.replace("home();", "home() { check nd.v; }"))
    (found,) = editor.diagnostics(arm, bool)
    assert (found.code, start(found)) == ("E207", (4, 27))
    editor.close(arm)


def test_a_part_that_nothing_includes_is_looked_at_alone(editor: Editor) -> None:
    lonely = editor.open("parts/lonely.exo", "part lonely;\nmutex a.b, c.d;\n")
    assert editor.diagnostics(lonely) == []
    editor.change(lonely, "part lonely;\nmutex a.b c.d;\n")
    (found,) = editor.diagnostics(lonely, bool)
    assert str(found.code).startswith("E1")
    editor.close(lonely)


def test_mistakes_of_a_part_that_is_not_open_are_told_and_forgotten(editor: Editor, folder: Path) -> None:
    spec, arm = editor.uri("demo.exo"), editor.uri("parts/arm.exo")
    editor.versions[arm] = None  # the server has no number of it
    (folder / "parts" / "arm.exo").write_text(ARM.replace("int", "integer"), encoding="utf-8")
    editor.open("demo.exo", SPEC)
    (found,) = editor.diagnostics(arm, bool)
    assert (str(found.code)[:2], start(found)) == ("E1", (3, 22))
    (folder / "parts" / "arm.exo").write_text(ARM, encoding="utf-8")
    editor.change(spec, SPEC + "\n")
    assert editor.diagnostics(arm, lambda told: not told) == []
    editor.close(spec)
    editor.versions.pop(arm)


def test_what_was_not_saved_is_forgotten_with_its_document(editor: Editor, both: tuple[str, str]) -> None:
    spec, arm = both
    editor.change(arm, ARM.replace("home()", "rest()"))
    assert editor.diagnostics(spec, bool)
    editor.close(arm)
    assert editor.diagnostics(spec, lambda told: not told) == []


def test_definition_and_references_go_across_files(editor: Editor, both: tuple[str, str]) -> None:
    spec, arm = both
    params = types.DefinitionParams(at(spec), place(SPEC, "arm.home", 5))
    (found,) = editor.run(editor.client.text_document_definition_async(params))
    assert (found.uri, found.range.start) == (arm, place(ARM, "home"))
    asked = types.ReferenceParams(types.ReferenceContext(True), at(arm), place(ARM, "home"))
    places = editor.run(editor.client.text_document_references_async(asked))
    assert {(each.uri, each.range.start.line) for each in places} == {(spec, 3), (arm, 4)}


def test_the_definition_of_a_path_is_the_file(editor: Editor, both: tuple[str, str]) -> None:
    spec, arm = both
    for word, shift in (("parts/arm", 4), ('"parts', 0), ('exo";', 4)):
        params = types.DefinitionParams(at(spec), place(SPEC, word, shift))
        (found,) = editor.run(editor.client.text_document_definition_async(params))
        assert (found.uri, found.range.start) == (arm, types.Position(0, 0))
    editor.change(spec, SPEC.replace("arm.exo", "leg.exo"))
    params = types.DefinitionParams(at(spec), place(SPEC, "parts/arm", 4))
    assert not editor.run(editor.client.text_document_definition_async(params))
    editor.change(spec, SPEC)


def test_a_new_name_is_given_in_all_files(editor: Editor, both: tuple[str, str]) -> None:
    spec, arm = both
    params = types.RenameParams(at(arm), place(ARM, "home"), "rest")
    edits = editor.run(editor.client.text_document_rename_async(params)).changes
    assert {uri: [each.range.start for each in found] for uri, found in edits.items()} == {
        spec: [place(SPEC, "home")],
        arm: [place(ARM, "home")],
    }
    prepared = types.PrepareRenameParams(at(arm), place(ARM, "home"))
    assert editor.run(editor.client.text_document_prepare_rename_async(prepared)).placeholder == "home"


def test_hover_outline_completion_and_layout_are_about_the_document(editor: Editor, both: tuple[str, str]) -> None:
    _, arm = both
    hovered = editor.run(editor.client.text_document_hover_async(types.HoverParams(at(arm), place(ARM, "home"))))
    assert "request home()" in hovered.contents.value and "`still`" in hovered.contents.value
    assert hovered.range.start == place(ARM, "home")
    outline = types.DocumentSymbolParams(at(arm))
    (module,) = editor.run(editor.client.text_document_document_symbol_async(outline))
    assert (module.name, module.range.start.line, [each.name for each in module.children]) == ("arm", 2, ["v", "home"])
    text = ARM + "mutex nd."
    editor.change(arm, text)
    offered = types.CompletionParams(at(arm), place(text, "mutex nd.", 9))
    names = [each.label for each in editor.run(editor.client.text_document_completion_async(offered))]
    assert "goto" in names
    editor.change(arm, ARM.replace("    request", "request"))
    options = types.FormattingOptions(4, True)
    laid_out = types.DocumentFormattingParams(at(arm), options)
    (edit,) = editor.run(editor.client.text_document_formatting_async(laid_out))
    assert edit.new_text.replace("\n\n", "\n") == ARM
    assert edit.range.start == types.Position(0, 0)


def test_findings_stand_in_the_part_as_the_editor_has_it(folder: Path) -> None:
    editor = Editor(folder, seconds=60.0)
    spec, arm = editor.open("demo.exo", SPEC), editor.open("parts/arm.exo", DEAF)
    found = editor.diagnostics(arm, bool)
    assert {(each.code, start(each)) for each in found} >= {("reachability", (4, 12))}
    assert all(each.code != "reachability" for each in editor.diagnostics(spec, bool))
    editor.stop()


def test_findings_stand_in_a_part_that_is_not_open(folder: Path) -> None:
    (folder / "parts" / "arm.exo").write_text(DEAF, encoding="utf-8")
    editor = Editor(folder, seconds=60.0)
    arm = editor.uri("parts/arm.exo")
    editor.versions[arm] = None  # the server has no number of it
    editor.open("demo.exo", SPEC)
    found = editor.diagnostics(arm, bool)
    assert {(each.code, start(each)) for each in found} >= {("reachability", (4, 12))}
    editor.stop()
    (folder / "parts" / "arm.exo").write_text(ARM, encoding="utf-8")


def test_the_paths_of_an_include_are_those_of_parts(editor: Editor, both: tuple[str, str], folder: Path) -> None:
    spec, arm = both
    (folder / "parts" / "deep" / ".hidden").mkdir(parents=True)
    for name in ("parts/deep/leg.exo", "parts/deep/.hidden/no.exo", "beside.exo"):
        (folder / name).write_text("// one\npart p;\n", encoding="utf-8")
    (folder / "parts" / "deep" / "other.exo").write_text("spec other;\n", encoding="utf-8")
    below = {"beside.exo", "parts/arm.exo", "parts/deep/leg.exo"}
    for uri, text, paths, replaced in (
        (spec, 'spec demo;\ninclude "|parts/arm.exo";\n', {*below, "../"}, "parts/arm.exo"),
        (spec, 'spec demo;\ninclude "be| ; module m { }', {*below, "../"}, "be"),
        (spec, 'spec demo;\ninclude "be|; module m "x" { }', {*below, "../"}, "be"),
        (spec, 'spec demo;\ninclude "parts/|"', {"parts/arm.exo", "parts/deep/leg.exo"}, "parts/"),
        (arm, 'part arm; include "|"', {"deep/leg.exo", "../"}, ""),
        (
            arm,
            'part arm; enum e { a } include "../b|e"',
            {f"../{path}" for path in below} - {"../parts/arm.exo"},
            "../be",
        ),
        (spec, 'spec demo;\ninclude "/|"', set(), ""),
        (spec, 'spec demo;\ninclude "nowhere/|"', set(), ""),
        (spec, 'spec demo;\nmodule include "|"', set(), ""),
        (spec, 'spec demo;\ninclude "parts/arm.exo"|;', set(), ""),
    ):
        editor.change(uri, text.replace("|", ""))
        asked = types.CompletionParams(at(uri), place(text, "|"))
        items = [each for each in editor.run(editor.client.text_document_completion_async(asked)) if each.text_edit]
        assert {each.label for each in items} - {"../../"} == paths
        for each in items:
            line = text.replace("|", "").split("\n")[each.text_edit.range.start.line]
            edited = each.text_edit.range.start.character, each.text_edit.range.end.character
            assert (line[slice(*edited)], each.text_edit.new_text) == (replaced, each.label)
