"""Documents that are opened and closed, shared by specs, changed on disk: what is told is of the texts as they are."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lsprotocol import types

from tests.support.editing import Editor, at

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


def test_what_is_said_of_documents_that_are_not_open_is_passed_over(editor: Editor) -> None:
    nowhere = editor.uri("nowhere.exo")
    editor.tell(editor.client.text_document_did_save, types.DidSaveTextDocumentParams(at(nowhere)))
    editor.tell(editor.client.text_document_did_close, types.DidCloseTextDocumentParams(at(nowhere)))
    one = open_(editor, "one.exo", OPEN)
    assert editor.diagnostics(one, bool)
    assert nowhere not in editor.published
