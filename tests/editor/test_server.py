"""`exover lsp` asked by a real client over standard input and output."""

import ctypes
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.protocol import JsonRPCProtocol

import exover
from tests.support.editing import Editor, at, place
from tests.support.sleeping import await_sleep
from tests.support.warm import SERVER
from tests.support.warm import command as warm

ROOT = Path(__file__).resolve().parents[2]
ROVER = (ROOT / "specs" / "rover.exo").read_text(encoding="utf-8")
PROPERTIES = (ROOT / "properties" / "rover.prop").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("editor")
    (found / "rover.exo").write_text(ROVER, encoding="utf-8")
    (found / "rover.prop").write_text(PROPERTIES, encoding="utf-8")
    return found


@pytest.fixture
def rover(editor: Editor) -> Iterator[str]:
    uri = editor.open("rover.exo", ROVER)
    assert editor.diagnostics(uri) == []
    yield uri
    editor.close(uri)


def test_mistakes_are_told_while_they_are_there(editor: Editor, rover: str) -> None:
    editor.change(rover, ROVER.replace("battery < 10", "batery < 10"))
    (found,) = editor.diagnostics(rover, bool)
    assert (found.code, found.severity, found.source) == ("E201", types.DiagnosticSeverity.Error, "exover")
    assert "unknown name `batery`" in found.message and "did you mean `battery`?" in found.message
    start = place(ROVER, "battery < 10")
    assert found.range == types.Range(start, types.Position(start.line, start.character + len("batery")))
    editor.change(rover, ROVER)
    assert editor.diagnostics(rover, lambda each: not each) == []


def test_a_did_you_mean_is_a_change(editor: Editor, rover: str) -> None:
    editor.change(rover, ROVER.replace("battery < 10", "batery < 10"))
    (found,) = editor.diagnostics(rover, bool)
    context = types.CodeActionContext([found])
    actions = editor.run(
        editor.client.text_document_code_action_async(types.CodeActionParams(at(rover), found.range, context))
    )
    (action,) = actions or []
    assert action.title == "replace with `battery`" and action.kind == types.CodeActionKind.QuickFix
    assert {uri: list(edits) for uri, edits in action.edit.changes.items()} == {
        rover: [types.TextEdit(found.range, "battery")]
    }
    elsewhere = types.Range(types.Position(0, 0), types.Position(0, 0))
    nothing = types.CodeActionParams(at(rover), elsewhere, context)
    assert not editor.run(editor.client.text_document_code_action_async(nothing))


def hovered(editor: Editor, uri: str, where: types.Position) -> str:
    found = editor.run(editor.client.text_document_hover_async(types.HoverParams(at(uri), where)))
    return found.contents.value if found else ""


def test_hover_tells_types_rules_and_what_shorthand_means(editor: Editor, rover: str) -> None:
    told = hovered(editor, rover, place(ROVER, "battery < 15"))
    assert "poster `battery`" in told and "poster battery: int in 0 .. 100 = 100;" in told
    told = hovered(editor, rover, place(ROVER, "nd.stop over", 4))
    assert "request `nd.stop`" in told and "request stop()" in told and "- `drive`" in told
    told = hovered(editor, rover, place(ROVER, "mutex drive"))
    assert "- `drive`: `forbid active(nd.stop) and active(nd.goto) by kill nd.goto`" in told
    told = hovered(editor, rover, place(ROVER, "launch go_home"))
    assert "`go_home`: `launch arm.move(base) when " in told
    told = hovered(editor, rover, place(ROVER, "after pom"))
    assert "- `nd.goto.after.pom.localize`: `check past(pom.localize)`" in told
    assert hovered(editor, rover, types.Position(0, 0)) == ""


def test_definition_and_references_span_spec_and_properties(editor: Editor, rover: str, folder: Path) -> None:
    prop = editor.open("rover.prop", PROPERTIES)
    editor.diagnostics(prop)
    asked = types.DefinitionParams(at(prop), place(PROPERTIES, "nd.goto", 3))
    (found,) = editor.run(editor.client.text_document_definition_async(asked))
    assert found.uri == rover and found.range.start == place(ROVER, "request goto", len("request "))
    context = types.ReferenceContext(include_declaration=True)
    asked = types.ReferenceParams(context, at(rover), place(ROVER, "request goto", len("request ")))
    found = editor.run(editor.client.text_document_references_async(asked))
    assert [each.uri for each in found] == [rover] * 3 + [prop] * PROPERTIES.count("nd.goto")
    editor.close(prop)


def test_rename_changes_every_place_and_nothing_else(editor: Editor, rover: str) -> None:
    prop = editor.uri("rover.prop")
    asked = types.RenameParams(at(rover), place(ROVER, "request goto", len("request ")), "drive_to")
    found = editor.run(editor.client.text_document_rename_async(asked))
    spec = changed(ROVER, found.changes[rover])
    assert exover.loads(spec).requests == tuple(
        name.replace("nd.goto", "nd.drive_to") for name in exover.loads(ROVER).requests
    )
    assert changed(PROPERTIES, found.changes[prop]) == PROPERTIES.replace("nd.goto", "nd.drive_to")


@pytest.mark.parametrize(
    ("words", "name", "reason"),
    [
        ("request goto", "stop", "would have a mistake: request `stop` is declared twice"),
        ("request goto", "not", "is no name"),
        ("request goto", "a b", "is no name"),
    ],
)
def test_a_rename_that_would_break_something_is_refused(
    editor: Editor, rover: str, words: str, name: str, reason: str
) -> None:
    asked = types.RenameParams(at(rover), place(ROVER, words, len("request ")), name)
    with pytest.raises(JsonRpcException, match=reason):
        editor.run(editor.client.text_document_rename_async(asked))


def changed(text: str, edits: list[types.TextEdit]) -> str:
    """Return a text of one unit for each character after edits."""
    lines = text.split("\n")
    for edit in sorted(edits, key=lambda each: (each.range.start.line, each.range.start.character), reverse=True):
        line, start, end = edit.range.start.line, edit.range.start.character, edit.range.end.character
        assert edit.range.end.line == line
        lines[line] = lines[line][:start] + edit.new_text + lines[line][end:]
    return "\n".join(lines)


def completed(editor: Editor, uri: str, text: str) -> dict[str, types.CompletionItem]:
    """Return what is proposed at the `|` of a text."""
    editor.change(uri, text.replace("|", "", 1))
    asked = types.CompletionParams(at(uri), place(text, "|"))
    return {item.label: item for item in editor.run(editor.client.text_document_completion_async(asked))}


def test_completion_knows_what_can_stand(editor: Editor, rover: str) -> None:
    assert {"localize"} == set(completed(editor, rover, ROVER.replace("after pom.", "after pom.|")))
    found = completed(editor, rover, ROVER.replace("uses power 60", "uses |"))
    assert set(found) == {"power"} and "resource power: 100 by wait;" in found["power"].documentation.value
    found = completed(editor, rover, ROVER.replace("check calm: v", "check calm: |"))
    assert {"v", "x", "speed", "battery", "nd", "not", "active"} <= set(found)
    assert "mutex" not in found and "tool" not in found
    found = completed(editor, rover, ROVER + "|")
    assert {"mutex", "module", "forbid"} <= set(found) and "battery" not in found
    assert completed(editor, rover, ROVER.replace("// A rover", "// A rover | ")) == {}


def test_symbols_are_the_outline(editor: Editor, rover: str) -> None:
    found = editor.run(editor.client.text_document_document_symbol_async(types.DocumentSymbolParams(at(rover))))
    outline = {each.name: [below.name for below in each.children] for each in found}
    assert outline["nd"] == ["speed", "goto", "stop"] and outline["arm"] == ["tool", "calibrate", "mount", "move"]
    assert {"zone", "battery", "power", "still", "drive", "crush", "go_home"} <= set(outline)
    goto = next(each for each in found if each.name == "nd").children[1]
    assert [each.name for each in goto.children] == ["calm", "low_battery"]


def test_formatting_is_that_of_fmt(editor: Editor, rover: str) -> None:
    options = types.FormattingOptions(4, True)
    asked = types.DocumentFormattingParams(at(rover), options)
    (edit,) = editor.run(editor.client.text_document_formatting_async(asked))
    again = editor.open("tidy.exo", edit.new_text)
    tidy = types.DocumentFormattingParams(at(again), options)
    assert not editor.run(editor.client.text_document_formatting_async(tidy))
    editor.close(again)
    editor.change(rover, ROVER + "mutex ;")
    assert not editor.run(editor.client.text_document_formatting_async(asked))


def test_a_properties_file_is_read_with_its_spec(editor: Editor, rover: str) -> None:
    prop = editor.open("rover.prop", PROPERTIES)
    assert editor.diagnostics(prop) == []
    editor.change(rover, ROVER.replace("request stop()", "request halt()").replace("nd.stop", "nd.halt"))
    (found,) = editor.diagnostics(prop, bool)
    assert found.code == "E203" and "unknown request `nd.stop`" in found.message
    editor.change(prop, PROPERTIES.replace("nd.stop", "nd.halt"))
    assert editor.diagnostics(prop, lambda each: not each) == []
    editor.close(prop)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_places_count_the_units_of_the_client(folder: Path, encoding: str) -> None:
    editor = Editor(folder, (encoding,))
    try:
        assert editor.server.capabilities.position_encoding == encoding
        line = 'module m "äöü 🤖" { request r(a: bol); }'
        uri = editor.open("units.exo", f"spec s;\r\n{line}\r\n")
        (found,) = editor.diagnostics(uri)
        units = {"utf-8": 1, "utf-16": 2, "utf-32": 4}[encoding]
        codec = {"utf-16": "utf-16-le", "utf-32": "utf-32-le"}.get(encoding, encoding)
        start = len(line[: line.index("bol")].encode(codec)) // units
        assert found.range == types.Range(types.Position(1, start), types.Position(1, start + 3))
        editor.change(uri, "\ufeffspec s; poster p: bol = true;")
        (found,) = editor.diagnostics(uri, bool)
        start = len("\ufeffspec s; poster p: ".encode(codec)) // units
        assert found.range == types.Range(types.Position(0, start), types.Position(0, start + 3))
    finally:
        editor.stop()


# ---- bad input ----


def test_half_a_file_has_names_all_the_same(editor: Editor, rover: str) -> None:
    half = ROVER[: ROVER.index("poster battery")] + "mutex x: nd."
    editor.change(rover, half)
    assert editor.diagnostics(rover, bool)[0].code == "E106"
    assert {"goto", "stop"} <= set(completed(editor, rover, half + "|"))
    for length in range(0, len(ROVER), 97):
        editor.change(rover, ROVER[:length])
    assert editor.diagnostics(rover, bool)


def test_ten_megabytes_do_not_stop_it(editor: Editor, rover: str) -> None:
    big = editor.open("big.exo", "spec big;\n" + "mutex a.b, c.d; // 10 MB\n" * 420_000)
    editor.change(big, "spec big;\n" + "mutex a.b, c.d; // 10 MB\n" * 420_001)
    assert editor.diagnostics(big)[0].code == "E003"
    end = types.Position(420_002, 0)
    assert editor.run(editor.client.text_document_completion_async(types.CompletionParams(at(big), end))) == []
    assert not editor.run(editor.client.text_document_definition_async(types.DefinitionParams(at(big), end)))
    huge = editor.open("huge.exo", "x" * (16 * 1024 * 1024 + 1))
    assert editor.diagnostics(huge)[0].code == "E003"
    editor.close(big)
    editor.close(huge)
    editor.change(rover, ROVER.replace("battery < 10", "batery < 10"))
    assert editor.diagnostics(rover, bool)[0].code == "E201"


async def asked(protocol: JsonRPCProtocol) -> object:
    return await protocol.send_request_async("exover/unknown", {"a": 1})


def test_what_is_not_understood_is_refused_and_no_more(editor: Editor, rover: str) -> None:
    protocol = editor.client.protocol
    with pytest.raises(JsonRpcException, match=r"Method Not Found"):
        editor.run(asked(protocol))
    editor.loop.call_soon_threadsafe(protocol.notify, "exover/unknown", {"a": 1})
    for raw in (b"{broken", b"[1, 2", b"\xff\xfe", b"null", b"12"):
        message = b"Content-Length: %d\r\n\r\n%s" % (len(raw), raw)
        editor.loop.call_soon_threadsafe(protocol.writer.write, message)
    far = types.Position(10**6, 10**6)
    assert hovered(editor, rover, far) == ""
    assert "poster `battery`" in hovered(editor, rover, place(ROVER, "battery < 15"))
    with pytest.raises(JsonRpcException, match="is not open"):
        hovered(editor, editor.uri("nowhere.exo"), far)


def test_a_document_with_nul_in_its_name_is_a_text_without_a_place(editor: Editor) -> None:
    uri = f"{editor.uri('a')}%00.exo"
    editor.versions[uri] = 1
    item = types.TextDocumentItem(uri, "exover", 1, 'spec s; include "b.exo";')
    editor.tell(editor.client.text_document_did_open, types.DidOpenTextDocumentParams(item))
    assert [each.code for each in editor.diagnostics(uri)] == ["E005"]


def test_it_ends_when_the_pipe_is_closed(tmp_path: Path) -> None:
    for said in (b"", b"Content-Length: 1000\r\n\r\n{", b"no header at all\r\n"):
        ended = subprocess.run(
            [warm(verbs=(SERVER,)), SERVER, "--stdio"],
            input=said,
            capture_output=True,
            timeout=60,
            cwd=tmp_path,
            check=False,
        )
        assert ended.returncode == 0, ended.stderr
        assert b"Traceback" not in ended.stderr


def test_a_header_that_cannot_be_read_takes_no_other_message_with_it(tmp_path: Path) -> None:
    headers = (
        b"Content-Lenth: 2",
        b"Content-Length: " + b"9" * 5000,
        b"Content-Length: 99999999999",
        b"Content-Length: -1",
    )
    given = [said("initialize", {"capabilities": {}}, 1)]
    for number, header in enumerate(headers, 2):
        given += [header, b"\r\n\r\n{}", said("exover/unknown", {}, number)]
    given += [said("shutdown", None, 9), said("exit", None)]
    ended = subprocess.run(
        [warm(verbs=(SERVER,)), SERVER],
        input=b"".join(given),
        capture_output=True,
        timeout=60,
        cwd=tmp_path,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, b"")
    answered = [int(number) for number in re.findall(rb'"id": ([0-9]+)', ended.stdout)]
    assert sorted(answered) == [1, 2, 3, 4, 5, 9]


def test_it_ends_quietly_when_nobody_reads_its_answers(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "exover", "lsp"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=tmp_path, **pipes) as process:
        process.stdin.write(said("initialize", {"capabilities": {}, "processId": None}, 1))
        process.stdin.flush()
        assert process.stdout.readline().startswith(b"Content-Length")
        process.stdout.close()
        for number in range(3):
            item = {"uri": f"file:///a{number}.exo", "version": 1, "languageId": "exo", "text": "spec s;"}
            process.stdin.write(said("textDocument/didOpen", {"textDocument": item}))
            process.stdin.flush()
        process.stdin.close()
        complaints = process.stderr.read()
        assert (process.wait(60), complaints) == (0, b"")


def said(method: str, params: object, number: int | None = None) -> bytes:
    message = {"jsonrpc": "2.0", "method": method, "params": params} | ({"id": number} if number else {})
    body = json.dumps(message).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


def test_without_pygls_it_says_what_to_install(tmp_path: Path) -> None:
    hidden = "import sys; sys.modules['pygls'] = None; from exover.cli.main import main; sys.exit(main(['lsp']))"
    ended = subprocess.run([sys.executable, "-c", hidden], capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "exover lsp needs pygls" in ended.stderr and "pip install 'exover[lsp]'" in ended.stderr


# ---- checks ----


@pytest.fixture(scope="module")
def checking(folder: Path) -> Iterator[Editor]:
    found = Editor(folder, seconds=60.0)
    yield found
    found.stop()


SMALL = "spec small;\nmodule m { request a(); request b(); }\nmutex x: m.a, m.b;\n"
NEVER = "forbid dead: active(m.a) and active(m.b);\n"


def test_checks_are_told_and_ended_by_the_next_key(checking: Editor, folder: Path) -> None:
    uri = checking.open("small.exo", SMALL + NEVER)
    assert checking.diagnostics(uri, lambda each: not each) == []
    (found,) = checking.diagnostics(uri, lambda each: any(one.code == "rule-use" for one in each))[:1]
    assert (found.code, found.source) == ("rule-use", "exover check")
    assert found.severity == types.DiagnosticSeverity.Warning and found.range.start == types.Position(3, 0)
    text = SMALL + NEVER
    assert "`dead` is not in use: " in hovered(checking, uri, place(text, "forbid dead", 2))
    assert "`x` is in use: " in hovered(checking, uri, place(text, "mutex x", 6))
    checking.change(uri, SMALL + NEVER + "mutex ;")
    found = checking.diagnostics(uri, bool)
    assert all(each.source == "exover" for each in found)
    checking.change(uri, SMALL)
    assert checking.diagnostics(uri, lambda each: not each) == []
    checking.close(uri)


def test_a_check_runs_no_module_that_stands_beside_the_spec(checking: Editor, folder: Path) -> None:
    (folder / "beside").mkdir()
    (folder / "beside" / "argparse.py").write_text("open('ran', 'w')")
    uri = checking.open("beside/small.exo", SMALL + NEVER)
    assert "rule-use" in {each.code for each in checking.diagnostics(uri, bool)}
    assert not (folder / "beside" / "ran").exists()
    checking.close(uri)


def test_a_property_is_checked_as_it_is_typed(checking: Editor, folder: Path) -> None:
    (folder / "typed.exo").write_text(SMALL.replace("small", "typed"))
    (folder / "typed.prop").write_text("for typed;\nproperty p: possible active(m.a);\n")
    uri = checking.open("typed.prop", "for typed;\n\nproperty p: never active(m.a);\n")
    (found,) = checking.diagnostics(uri, bool)
    assert (found.code, found.source) == ("property", "exover check")
    assert found.severity == types.DiagnosticSeverity.Error and found.range.start == types.Position(2, 9)
    checking.change(uri, "for typed;\nproperty p: possible active(m.a);\n")
    assert checking.diagnostics(uri) == []
    checking.close(uri)


def test_what_is_wrong_with_a_properties_file_is_told_though_it_is_not_open(checking: Editor, folder: Path) -> None:
    (folder / "shut.prop").write_text("for shut;\nproperty p: never actve(m.a);\n")
    prop, text = checking.uri("shut.prop"), SMALL.replace("small", "shut")
    checking.versions[prop] = None  # the server has no number of it
    (folder / "shut.exo").write_text(text)
    uri = checking.open("shut.exo", text)
    (found,) = checking.diagnostics(prop, bool)
    assert (str(found.code)[:2], found.range.start.line) == ("E1", 1)
    (folder / "shut.prop").write_text("for shut;\n\nproperty p: never active(m.a);\n")
    checking.change(uri, text + "\n")
    (found,) = checking.diagnostics(prop, lambda each: any(one.code == "property" for one in each))
    assert found.severity == types.DiagnosticSeverity.Error and found.range.start == types.Position(2, 9)
    checking.change(uri, text + "\n\nmutex ;")
    assert checking.diagnostics(prop, lambda each: not each) == []
    checking.change(uri, text)
    assert checking.diagnostics(prop, bool)
    checking.close(uri)
    assert checking.diagnostics(prop, lambda each: not each) == []


def test_a_properties_file_that_cannot_be_read_is_told_though_it_is_not_open(editor: Editor, folder: Path) -> None:
    place = folder / "apart"
    place.mkdir()
    text = SMALL.replace("small", "odd")
    (place / "odd.exo").write_text(text)
    prop = editor.uri("apart/odd.prop")
    editor.versions[prop] = None  # the server has no number of it
    uri = editor.open("apart/odd.exo", text)
    assert editor.diagnostics(uri, lambda each: not each) == []  # else the file might be read before it is written
    for make, code in (
        (lambda: (place / "odd.prop").write_bytes(b"for odd; // caf\xe9\n"), "E002"),
        (lambda: (place / "odd.prop").symlink_to("nowhere"), "E001"),
        ((place / "odd.prop").mkdir, "E001"),
    ):
        make()
        editor.change(uri, text)
        (found,) = editor.diagnostics(prop, bool)
        assert found.code == code
        (place / "odd.prop").rmdir() if (place / "odd.prop").is_dir() else (place / "odd.prop").unlink()
        editor.change(uri, text + "\n")
        assert editor.diagnostics(prop, lambda each: not each) == []
    editor.close(uri)


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_server_though_the_editor_keeps_the_pipe(number: int, status: int) -> None:
    ended_by(lambda server: server.send_signal(number), status)


def ended_by(signalled: Callable[[subprocess.Popen[bytes]], None], status: int) -> None:
    """See that a server that has answered ends soon, with a status and without a word."""
    command = [sys.executable, "-m", "exover", "lsp"]
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as server:
        assert server.stdin is not None and server.stdout is not None and server.stderr is not None
        server.stdin.write(said("initialize", {"capabilities": {}}, 1))
        server.stdin.flush()
        assert server.stdout.readline().startswith(b"Content-")
        signalled(server)
        try:
            assert (server.wait(20), server.stderr.read()) == (status, b"")
        finally:
            server.kill()


def test_a_signal_is_heard_though_the_main_thread_goes_on_waiting() -> None:
    """As it does if the signal comes when it is about to wait: here another thread is interrupted by it."""
    tell = getattr(ctypes.CDLL(None), "tgkill", None) if sys.platform == "linux" else None
    if tell is None:
        pytest.skip("no signal can be sent to one thread of another process")

    def signalled(server: subprocess.Popen[bytes]) -> None:
        await_sleep(server.pid)
        others = [int(name) for name in os.listdir(f"/proc/{server.pid}/task") if int(name) != server.pid]
        assert others and tell(server.pid, others[0], signal.SIGTERM) == 0

    ended_by(signalled, 143)


def test_a_check_that_goes_on_is_ended_with_the_session(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    if not Path("/proc").is_dir() or not hasattr(signal, "SIGKILL"):
        pytest.skip("no /proc to look at")
    shutil.copy(ROOT / "tests" / "specs" / "lab_automation.exo", folder / "lab_automation.exo")
    editor = Editor(folder, seconds=600.0)
    text = (folder / "lab_automation.exo").read_text(encoding="utf-8")
    uri = editor.open("lab_automation.exo", text)
    editor.diagnostics(uri)
    first = watched(editor, lambda each: each and len(list(tmp_path.rglob("exover-*"))) > 1)  # its own files, and ours
    editor.change(uri, text + "\n")
    watched(editor, lambda each: not set(first) & set(each))
    editor.stop()
    watched(editor, lambda each: not each)
    assert list(tmp_path.iterdir()) == []


def watched(editor: Editor, wanted: object) -> list[int]:
    """Return the processes of `exover check` that work in the folder, once they are as wanted."""
    import asyncio
    from time import monotonic

    until = monotonic() + 60
    while monotonic() < until:
        found = []
        for each in Path("/proc").iterdir():
            if each.name.isdigit():
                try:
                    words = (each / "cmdline").read_bytes().split(b"\0")
                    inside = os.readlink(each / "cwd") == str(editor.folder)
                except OSError:
                    continue
                if inside and b"check" in words:
                    found.append(int(each.name))
        if wanted(found):  # type: ignore[operator]
            return found
        asyncio.run(asyncio.sleep(0.05))
    raise TimeoutError("the processes are not as wanted")
