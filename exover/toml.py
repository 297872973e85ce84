"""TOML with places: the content of a file, and the span of each of its keys, which `tomllib` does not give."""

import re
import tomllib
from dataclasses import field
from typing import Any

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.source import Source, Span

KeyPath = tuple[str | int, ...]
"""The keys from the top of a file to a value; a number is an index into an array of tables or a list."""

BLANKS = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
KEY = re.compile(r"[A-Za-z0-9_-]+|\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*'")
DOT = re.compile(r"[ \t]*\.[ \t]*")
TEXT = re.compile(r'"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'', re.DOTALL)
PLAIN = re.compile(r"[^,\]}\n#]+")
INTEGER = re.compile(r"([+-]?)(?:0x([\dA-Fa-f_]+)|0o([0-7_]+)|0b([01_]+)|([\d_]+))")
BASES = (16, 8, 2, 10)
BITS = 64
"""The bits of an integer of TOML; a longer one is a mistake, as its standard says."""
TOLD = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


@dataclass(frozen=True, slots=True)
class Places:
    """The spans of keys, each from the key to the end of its value, and of headers, by path."""

    spans: dict[KeyPath, Span]

    def of(self, *path: str | int) -> Span | None:
        """Return the span of a key, or else of the nearest enclosing key or table that has one; None without any."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.spans:
                return self.spans[path[:length]]
        return None


def read_toml(source: Source) -> tuple[dict[str, Any], Places] | Diagnostic:
    """Return the content of a file and the places of its keys, or a diagnostic if it is no TOML."""
    try:
        content = _loads(source.text)
        return content, Places(_Scanner(source.text).scan())
    except _LongInteger as found:
        advice = f"write one from -2^{BITS - 1} to 2^{BITS - 1} - 1"
        return Diagnostic("E601", f"the file is not TOML: an integer of more than {BITS} bits", found.span, help=advice)
    except RecursionError:
        return Diagnostic("E601", "the file is nested too deep", None)
    except tomllib.TOMLDecodeError as error:
        return _not_toml(source, str(error))


class _LongInteger(Exception):
    """An integer has more than BITS bits."""

    def __init__(self, span: Span) -> None:
        super().__init__()
        self.span = span


def _loads(text: str) -> dict[str, Any]:
    """Return the content of a text; raises `_LongInteger` if `tomllib` fails at an integer of thousands of digits."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:
        _Scanner(text).scan()
        raise


def _not_toml(source: Source, message: str) -> Diagnostic:
    """Return the message of `tomllib` as a diagnostic, at the place that the message names."""
    found = TOLD.search(message)
    offset = len(source.text)
    if found and found[1]:
        lines = source.text.split("\n")
        offset = sum(len(line) + 1 for line in lines[: int(found[1]) - 1]) + int(found[2]) - 1
    text = TOLD.sub("", message)
    return Diagnostic("E601", f"the file is not TOML: {text[:1].lower()}{text[1:]}", Span(offset, offset))


@dataclass
class _Scanner:
    """Finds the spans of keys in a text that `tomllib` accepts, or rejects only for an integer that is too long.

    So it does not check the syntax. It raises `_LongInteger` at such an integer.
    """

    text: str
    offset: int = 0
    spans: dict[KeyPath, Span] = field(default_factory=dict)
    arrays: dict[KeyPath, int] = field(default_factory=dict)
    """The index of the last table so far of each array of tables."""

    def scan(self) -> dict[KeyPath, Span]:
        table: KeyPath = ()
        while self._more():
            if self._at("["):
                table = self._header()
            else:
                self._entry(table)
        return self.spans

    def _more(self) -> bool:
        found = BLANKS.match(self.text, self.offset)
        self.offset = found.end() if found else self.offset
        return self.offset < len(self.text)

    def _at(self, sign: str) -> bool:
        return self.text.startswith(sign, self.offset)

    def _header(self) -> KeyPath:
        of_array = self._at("[[")
        self.offset += 2 if of_array else 1
        keys, span = self._keys()
        self.offset = self.text.index("]", self.offset) + (2 if of_array else 1)
        path: KeyPath = ()
        for number, key in enumerate(keys):
            path = (*path, key)
            if of_array and number == len(keys) - 1:
                self.arrays[path] = self.arrays.get(path, -1) + 1
            self.spans.setdefault(path, span)
            if path in self.arrays:
                path = (*path, self.arrays[path])
                self.spans.setdefault(path, span)
        return path

    def _keys(self) -> tuple[list[str], Span]:
        """Return the parts of a dotted key, and its span."""
        self._more()
        start, keys = self.offset, []
        while found := KEY.match(self.text, self.offset):
            keys.append(_plain(found[0]))
            self.offset = found.end()
            dot = DOT.match(self.text, self.offset)
            if not dot:
                break
            self.offset = dot.end()
        return keys, Span(start, self.offset)

    def _entry(self, table: KeyPath) -> None:
        keys, span = self._keys()
        self.offset = self.text.index("=", self.offset) + 1
        path = (*table, *keys)
        self._value(path)
        for length in range(len(table) + 1, len(path) + 1):
            self.spans[path[:length]] = Span(span.start, self.offset)

    def _value(self, path: KeyPath) -> None:
        self._more()
        if self._at("[") or self._at("{"):
            self._several(path, "]" if self._at("[") else "}")
            return
        found = TEXT.match(self.text, self.offset)
        if found:
            self.offset = found.end()
        elif plain := PLAIN.match(self.text, self.offset):
            start, text = self.offset, plain[0].rstrip()
            self.offset += len(text)
            if _too_long(text):
                raise _LongInteger(Span(start, self.offset))

    def _several(self, path: KeyPath, end: str) -> None:
        self.offset += 1
        number = 0
        while self._more() and not self._at(end):
            if end == "}":
                self._entry(path)
            else:
                start = self.offset
                self._value((*path, number))
                self.spans[*path, number] = Span(start, self.offset)
                number += 1
            if self._more() and self._at(","):
                self.offset += 1
        self.offset += 1


def _too_long(text: str) -> bool:
    """Return whether a value is an integer that does not fit BITS bits in two's complement."""
    found = INTEGER.fullmatch(text)
    if not found:
        return False
    digits, base = next((digits, base) for digits, base in zip(found.groups()[1:], BASES, strict=True) if digits)
    shown = digits.replace("_", "").lstrip("0") or "0"
    return len(shown) > BITS or not -(1 << BITS - 1) <= int(found[1] + shown, base) < 1 << BITS - 1


def _plain(key: str) -> str:
    if key[0] == "'":
        return key[1:-1]
    return str(tomllib.loads(f"k = {key}")["k"]) if key[0] == '"' else key
