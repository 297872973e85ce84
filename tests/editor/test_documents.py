"""Documents that are opened and closed, shared by specs, changed on disk: what is told is of the texts as they are."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException

from tests.support.editing import Editor, at, place

ONE = 'spec one;\ninclude "arm.exo";\nmodule nd { request goto(); }\nmutex m: nd.goto, arm.home;\n'
OTHER = 'spec other;\ninclude "arm.exo";\nmodule we { request go(); }\nmutex m: we.go, arm.home;\n'
ARM = "part arm;\nmodule arm { request home(); }\n"
OPEN = "mutex ;\n"


@pytest.fixture
def editor(tmp_path: Path) -> Iterator[Editor]:
    """Return a client of a server, in a folder of its own whose name must be escaped in a URI."""
    folder = tmp_path / "a ü"
    folder.mkdir()
    found = Editor(folder)
    yield found
    found.stop()


def written(editor: Editor, **files: str) -> None:
    """Write files to disk; the server has no numbers of their texts."""
    for name, text in files.items():
        (editor.folder / f"{name}.exo").write_text(text, encoding="utf-8")
        editor.versions.setdefault(editor.uri(f"{name}.exo"), None)  # type: ignore[arg-type]


def open_(editor: Editor, name: str, text: str) -> str:
    editor.versions[editor.uri(name)] = 0
    return editor.open(name, text)


def closed(editor: Editor, uri: str) -> None:
    editor.close(uri)
    editor.versions[uri] = None  # type: ignore[assignment]


def nothing(found: list[types.Diagnostic]) -> bool:
    return not found


def lines(number: int) -> Callable[[list[types.Diagnostic]], bool]:
    return lambda found: [each.range.start.line for each in found] == [number]


def test_a_document_whose_name_is_escaped_is_changed(editor: Editor) -> None:
    uri = open_(editor, "one.exo", "spec one;\nmodule m { request a(); }\n")
    assert editor.diagnostics(uri) == []
    editor.change(uri, "spec one;\nmutex ;\n")
    assert editor.diagnostics(uri, lines(1))


def test_what_is_wrong_with_a_part_of_two_specs_is_told_as_long_as_one_has_it(editor: Editor) -> None:
    written(editor, arm=ARM + OPEN)
    arm = editor.uri("arm.exo")
    one, other = open_(editor, "one.exo", ONE), open_(editor, "other.exo", OTHER)
    assert editor.diagnostics(arm, lines(2))
    editor.change(one, ONE.replace('include "arm.exo";', "module arm { request home(); }"))
    assert editor.diagnostics(one) == []
    closed(editor, one)
    editor.change(other, OTHER + "\n")
    assert editor.diagnostics(other, nothing) == []
    assert lines(2)(editor.published[arm])
    closed(editor, other)
    assert editor.diagnostics(arm, nothing) == []


def test_a_part_that_is_closed_counts_as_on_disk_for_all_its_specs(editor: Editor) -> None:
    written(editor, arm=ARM)
    one, other = open_(editor, "one.exo", ONE), open_(editor, "other.exo", OTHER)
    arm = open_(editor, "arm.exo", ARM.replace("home", "rest"))
    assert editor.diagnostics(one, lines(3)) and editor.diagnostics(other, lines(3))
    closed(editor, arm)
    assert editor.diagnostics(one, nothing) == editor.diagnostics(other, nothing) == []


def test_files_that_change_on_disk_are_read_when_the_editor_says_so(editor: Editor) -> None:
    written(editor, arm=ARM)
    one = open_(editor, "one.exo", ONE)
    assert editor.diagnostics(one) == []
    (editor.folder / "arm.exo").unlink()
    changed = types.DidChangeWatchedFilesParams([types.FileEvent(editor.uri("arm.exo"), types.FileChangeType.Deleted)])
    editor.tell(editor.client.workspace_did_change_watched_files, changed)
    assert editor.diagnostics(one, lines(1))
    written(editor, arm=ARM)
    editor.tell(editor.client.workspace_did_change_watched_files, changed)
    assert editor.diagnostics(one, nothing) == []


def test_a_spec_that_becomes_a_part_is_read_as_one(editor: Editor) -> None:
    written(editor, arm=ARM, one=ONE)
    one = open_(editor, "one.exo", ONE)
    assert editor.diagnostics(one) == []
    editor.change(one, ONE.replace("spec", "part", 1))
    assert editor.diagnostics(one) == []
    editor.change(one, ONE.replace("spec", "part", 1) + OPEN)
    assert editor.diagnostics(one, lines(4))


def test_a_part_is_read_with_the_spec_that_was_opened_last(editor: Editor) -> None:
    arm = open_(editor, "arm.exo", ARM + "mutex x: arm.home, nd.stop;\n")
    one = open_(editor, "one.exo", OPEN)
    assert editor.diagnostics(arm) == []
    editor.change(one, ONE)
    assert editor.diagnostics(arm, lines(2))
    editor.change(one, "spec one;\nmodule arm { request home(); }\n")
    assert editor.diagnostics(arm, nothing) == []


def test_what_is_said_of_documents_that_are_not_open_is_passed_over(editor: Editor) -> None:
    nowhere = editor.uri("nowhere.exo")
    editor.tell(editor.client.text_document_did_save, types.DidSaveTextDocumentParams(at(nowhere)))
    editor.tell(editor.client.text_document_did_close, types.DidCloseTextDocumentParams(at(nowhere)))
    one = open_(editor, "one.exo", OPEN)
    assert editor.diagnostics(one, bool)
    assert nowhere not in editor.published


@pytest.mark.parametrize("there", [True, False])
def test_a_name_in_a_part_of_several_specs_is_not_renamed(editor: Editor, there: bool) -> None:
    written(editor, arm=ARM, other=OTHER, **({"one": ONE} if there else {}))
    uri = open_(editor, "arm.exo", ARM) if there else open_(editor, "one.exo", ONE)
    word = place(ARM, "home") if there else place(ONE, "home")
    reason = "a part of no spec that is known, or of several" if there else "belongs to"
    with pytest.raises(JsonRpcException, match=reason):
        editor.run(editor.client.text_document_rename_async(types.RenameParams(at(uri), word, "rest")))


def test_a_part_in_a_folder_behind_a_link_is_read_with_its_spec(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    editor = Editor(tmp_path / "link")
    written(editor, arm=ARM, one=ONE)
    arm = open_(editor, "arm.exo", ARM + "mutex x: arm.home, nd.stop;\n")
    assert editor.diagnostics(arm, lines(2))
    editor.change(arm, ARM.replace("home", "rest"))
    assert editor.diagnostics(editor.uri("one.exo"), lines(3))
    editor.stop()
