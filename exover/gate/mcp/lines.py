"""JSON-RPC messages, one a line: cuts streams into lines, reads them strictly, writes them."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any, Literal

from exover.dataclass import dataclass
from exover.model.wire import MAX_DEPTH, MAX_DIGITS, Json, is_too_deep

PARSE_ERROR, INVALID_REQUEST, METHOD_NOT_FOUND, INVALID_PARAMS, SERVER_GONE = -32700, -32600, -32601, -32602, -32000
DEEP = "the message is nested too deep"


class BadLine(Exception):
    """A line is no valid message; the text says why, `code` is the JSON-RPC error code."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


class LineCutter:
    """Cuts a stream into lines; keeps at most `longest` + 1 bytes of a line, so that its reader sees it is too long."""

    def __init__(self, longest: int) -> None:
        self._longest = longest
        self._parts: list[bytes] = []
        self._size = 0

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield the lines that are complete now, without line ends; a line that was cut has `longest` + 1 bytes."""
        *ends, rest = data.split(b"\n")
        for end in ends:
            self._keep(end)
            yield b"".join(self._parts)
            self._parts, self._size = [], 0
        self._keep(rest)

    def _keep(self, part: bytes) -> None:
        kept = part[: self._longest + 1 - self._size]
        if kept:
            self._parts.append(kept)
            self._size += len(kept)


@dataclass(frozen=True, slots=True)
class Message:
    """A JSON-RPC message; `body` is the whole object."""

    kind: Literal["request", "notification", "response"]
    body: Json

    @property
    def method(self) -> str:
        """The method of a request or notification."""
        return str(self.body["method"])

    @property
    def params(self) -> Json:
        """The parameters; an empty object if they are no object."""
        found = self.body.get("params")
        return found if isinstance(found, dict) else {}

    @property
    def id(self) -> Any:
        """The id of a request or response."""
        return self.body.get("id")


def read(line: bytes, longest: int) -> Message:
    """Return the message in a line of at most `longest` bytes; raises `BadLine`."""
    if len(line) > longest:
        raise BadLine(INVALID_REQUEST, f"the message is longer than {longest} bytes")
    try:
        body = _DECODER.decode(line.decode("utf-8").strip())
    except UnicodeDecodeError as error:
        raise BadLine(PARSE_ERROR, "the message is not UTF-8") from error
    except RecursionError as error:
        raise BadLine(PARSE_ERROR, DEEP) from error
    except json.JSONDecodeError as error:
        raise BadLine(PARSE_ERROR, f"the message is not JSON: {error.msg}, column {error.colno}") from error
    if line.count(b"[") + line.count(b"{") > MAX_DEPTH and is_too_deep(body):
        raise BadLine(PARSE_ERROR, DEEP)
    if isinstance(body, list):
        raise BadLine(INVALID_REQUEST, "the message is a batch; send one message a line")
    if not isinstance(body, dict):
        raise BadLine(INVALID_REQUEST, "the message is no object")
    return _message(body)


def _message(body: Json) -> Message:
    if body.get("jsonrpc") != "2.0":
        raise BadLine(INVALID_REQUEST, 'the message has no "jsonrpc": "2.0"')
    if "id" in body and not is_id(body["id"]) and not ("error" in body and body["id"] is None):
        raise BadLine(INVALID_REQUEST, "the id is neither a text nor a whole number")
    if isinstance(body.get("method"), str):
        return Message("request" if "id" in body else "notification", body)
    error = body.get("error")
    if "method" not in body and "id" in body and (error is None if "result" in body else isinstance(error, dict)):
        return Message("response", body)
    raise BadLine(INVALID_REQUEST, "the message is no request, notification or response")


def is_id(found: Any) -> bool:
    """Return whether this may be the id of a request: a string or an integer."""
    return isinstance(found, str | int) and not isinstance(found, bool)


def key_of_id(found: Any) -> tuple[bool, Any]:
    """Return a dictionary key for an id: 1 and "1" have different keys."""
    return isinstance(found, str), found


def write(body: Json) -> bytes:
    """Return a message as a line."""
    return text_of(body).encode() + b"\n"


@dataclass(frozen=True, slots=True)
class PreparedCall:
    """A tool call whose text is made beforehand, so that nothing can fail when it is sent."""

    params: str
    """The parameters as JSON text, without the closing brace."""

    def line(self, number: int, meta: str) -> bytes:
        """Return the call as a line with this id; `meta` is the JSON text of `_meta`, empty for none."""
        meta = f',"_meta":{meta}' if meta else ""
        return f'{{"jsonrpc":"2.0","method":"tools/call","params":{self.params}{meta}}},"id":{number}}}\n'.encode()


def prepared(tool: str, arguments: Mapping[str, Any]) -> PreparedCall:
    """Return the call of a tool; raises `TypeError` or `ValueError` if JSON cannot hold the arguments."""
    return PreparedCall(text_of({"name": tool, "arguments": dict(arguments)})[:-1])


def text_of(body: Json) -> str:
    """Return an object as JSON text on one line; raises `TypeError` or `ValueError` if JSON cannot hold it."""
    return json.dumps(body, separators=(",", ":"), allow_nan=False)


def result(id: Any, found: Any) -> Json:
    """Return the response with a result."""
    return {"jsonrpc": "2.0", "id": id, "result": found}


def error(id: Any, code: int, text: str) -> Json:
    """Return the response with a JSON-RPC error."""
    return {"jsonrpc": "2.0", "id": id, "error": {"code": code, "message": text}}


def notification(method: str, params: Json) -> Json:
    """Return a notification."""
    return {"jsonrpc": "2.0", "method": method, "params": params}


def _object(pairs: list[tuple[str, Any]]) -> Json:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise BadLine(INVALID_REQUEST, "an object has a key twice")
    return found


def _no_number(text: str) -> Any:
    raise BadLine(PARSE_ERROR, f"{text} is no number of JSON")


def _whole(text: str) -> int:
    if len(text) > MAX_DIGITS:
        raise BadLine(PARSE_ERROR, f"a number has more than {MAX_DIGITS} digits")
    return int(text)


def _fraction(text: str) -> float:
    found = float(text)
    return found if math.isfinite(found) else _no_number(text[:MAX_DIGITS])


_DECODER = json.JSONDecoder(
    object_pairs_hook=_object, parse_constant=_no_number, parse_int=_whole, parse_float=_fraction
)
