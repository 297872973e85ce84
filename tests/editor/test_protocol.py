"""Every request has an answer, and what is no message has an error, as LSP 3.17 says."""

import json
import subprocess
from typing import Any

from tests.support.warm import SERVER, command

HOVER = "textDocument/hover"
NOWHERE = {"textDocument": {"uri": "file:///nowhere.exo"}, "position": {"line": 0, "character": 0}}
BEGIN = {"jsonrpc": "2.0", "id": "begin", "method": "initialize", "params": {"capabilities": {}}}
END = {"jsonrpc": "2.0", "id": "end", "method": "shutdown"}


def request(number: object, method: object = HOVER, params: object = NOWHERE) -> dict[str, Any]:
    return {"jsonrpc": "2.0", "id": number, "method": method, "params": params}


def answers(*messages: object) -> list[tuple[Any, int | None]]:
    """Return what is answered to messages, as number and code of the error, if it is one; bytes go as they are."""
    bodies = [each if isinstance(each, bytes) else json.dumps(each).encode() for each in messages]
    sent = b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) for body in bodies)
    ended = subprocess.run([command(verbs=(SERVER,)), SERVER], input=sent, capture_output=True, timeout=60, check=True)
    assert ended.stderr == b""
    found = [json.loads(each.partition(b"Content-Length")[0]) for each in ended.stdout.split(b"\r\n\r\n")[1:]]
    assert all("method" not in each for each in found), found
    return [(each["id"], each.get("error", {}).get("code")) for each in found]


def test_a_request_that_cannot_be_read_is_answered() -> None:
    far = {"textDocument": {"uri": "file:///a.exo"}, "position": {"line": -1, "character": 0}}
    wrong = [request(1, params=[1]), request(2, params=None), request(3, params=far), request("four", params={})]
    none = [request(5, ["x"]), {"jsonrpc": "2.0", "id": 6}, request([7]), {"id": 8, "method": HOVER}]
    unknown = {"jsonrpc": "2.0", "id": 9, "method": "exover/unknown"}
    assert answers(BEGIN, *wrong, *none, unknown) == [
        ("begin", None),
        *((number, -32602) for number in (1, 2, 3, "four")),
        *((number, -32600) for number in (5, 6, None, 8)),
        (9, -32601),
    ]


def test_what_is_no_message_is_answered_without_a_number() -> None:
    codes = {b"{broken": -32700, b"\xff\xfe": -32700, b"null": -32600, b"12": -32600, b"[1]": -32600}
    assert answers(BEGIN, *codes) == [("begin", None), *((None, code) for code in codes.values())]


def test_a_request_comes_after_initialize_and_before_shutdown() -> None:
    assert answers(request(1), BEGIN, request(2, "initialize", BEGIN["params"]), END, request(3)) == [
        (1, -32002),
        ("begin", None),
        (2, -32600),
        ("end", None),
        (3, -32600),
    ]


def test_a_notification_that_is_not_understood_is_passed_over() -> None:
    changed = {"textDocument": {"uri": "file:///a.exo", "version": 2}, "contentChanges": [{"text": "spec a;"}]}
    notes = [
        {"jsonrpc": "2.0", "method": "exover/unknown"},
        {"jsonrpc": "2.0", "method": "textDocument/didChange", "params": changed},
        {"jsonrpc": "2.0", "method": "textDocument/didOpen", "params": {}},
        {"jsonrpc": "2.0", "id": "stray", "result": None},
    ]
    assert answers(notes[1], BEGIN, *notes, END) == [("begin", None), ("end", None)]
