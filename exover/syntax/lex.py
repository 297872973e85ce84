"""The lexer: from text to tokens.

A word is a `<name>` unless it is reserved; the parser decides which other words are keywords at a place.
"""

import re
from collections.abc import Iterator, Mapping
from itertools import islice
from typing import NamedTuple

from exover.diagnostics import Diagnostic, quote
from exover.source import Span

NAME = "<name>"
INT = "<int>"
NUMBER = "<number>"
STRING = "<string>"
END = "<end>"

RESERVED = frozenset({"true", "false", "and", "or", "not", "implies", "with", "in", "self"})

MAX_NUMBER = 1000
"""The most characters of a number: more than any double or 64-bit integer needs, few enough for exact arithmetic."""
MAX_EXPONENT = 4
"""The most digits of an exponent, without leading zeros."""

MAX_MISTAKES = 500
"""The number of lexical errors after which the rest of a text is not read."""

FOREIGN = {"&&": "and", "&": "and", "||": "or", "|": "or", "!": "not", "->": "implies"}
"""Operators of other languages, and the reserved words that they mean."""

_QUOTES = 'a text stands between `"` and `"`'
_BRACKETS = "a range is written `0 .. 9`, a set `{a, b}`"
SIGNS: Mapping[str, str] = {
    "#": "a comment begins with `//`",
    **dict.fromkeys("'`“”„‘’«»", _QUOTES),
    **dict.fromkeys("[]", _BRACKETS),
    "%": "numbers have no units: write the number alone",
    "/": "there is no division: multiply the other side; a comment begins with `//`",
    "^": "there is no power; of two bools that differ write `a != b`",
    "~": "write `not`",
    "≤": "write `<=`",
    "≥": "write `>=`",
    "≠": "write `!=`",
    "¬": "write `not`",
    "∧": "write `and`",
    "∨": "write `or`",
    "→": "write `implies`",
    "…": "a range is written `0 .. 9`",
    "–": "write `-`",
    "−": "write `-`",
}
"""The beginnings of texts that are no tokens, mostly of other languages, and the advice on them."""

_FORMULA_SYMBOLS = r"<-> | -> | &(?!&) | \|(?!\|) | ! (?!=) | [\[\]] |"
"""Tokens that only raw formulas of a properties file use."""

_PATTERN = r"""
    (?: (?s:/\*.*?\*/) | //[^\n]*+ | [ \t\r\n\f]++ )*+
    (?: (?P<word>   [A-Za-z_][A-Za-z0-9_]*+ )
      | (?P<symbol> FORMULA_SYMBOLS == | != | <= | >= | \.\. | \.(?![0-9]) | (?<=\.)\. | [{}();:,=<>*+-] )
      | (?P<number> [0-9]++ (?P<part> (?: \.[0-9]++ )? (?: [eE][+-]?[0-9]++ )? ) (?! [A-Za-z0-9_] | \.(?!\.) ) )
      | (?P<string> " (?: \\[^\x00-\x1f\x7f-\x9f] | [^"\\\x00-\x1f\x7f-\x9f]++ )*+ " )
      | (?P<end>    \Z )
      | (?P<digits> \.? [0-9] (?: \.(?!\.) | [A-Za-z0-9_]++ )*+ )
      | (?P<quote>  "[^\r\n]*+ )
      | (?P<open>   /\* )
      | (?P<bad>    [&|]{1,2} | !
                  | (?: /(?![/*]) | [\x01-\x08\x0b\x0e-\x1f\x7f\#$%'?@\[\\\]^`~] | [^\x00-\x7f]++ [A-Za-z0-9_]*+ )++
                  | \x00++ )
    )"""
"""Blanks and comments, then a token. The last alternative of a possessive group begins with a possessive set: before
Python 3.11.5 such a group ends wherever its last attempt ended (CPython issue 100061), but a set fails at its start."""

_TOKEN = {
    formulas: re.compile(_PATTERN.replace("FORMULA_SYMBOLS", _FORMULA_SYMBOLS if formulas else ""), re.VERBOSE)
    for formulas in (False, True)
}
CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")
"""A control character, which stands in no string and no path."""
_ESCAPE = re.compile(r"\\(.)")
_ESCAPES = {'"': '"', "\\": "\\", "n": "\n"}


class Token(NamedTuple):
    """A token, ``text[start:end]``; ``tainted`` iff a lexical error in it or just before it was reported.

    ``kind`` is one of the five in angle brackets, or the text itself (reserved words, punctuation).
    """

    kind: str
    text: str
    start: int
    end: int
    tainted: bool = False


def tokens(text: str, reports: list[Diagnostic], formulas: bool = False, base: int = 0) -> Iterator[Token]:
    """Yield the tokens of ``text``, `<end>` last; append a diagnostic for each lexical error to ``reports``.

    ``formulas``: the operators of raw formulas are tokens too; the parser decides where they may stand.
    A NUL character ends the text, for one report on a binary file is enough; so do MAX_MISTAKES reports.
    ``base`` is the offset of the first character.
    """
    tainted, comment = False, 0  # the end of a comment as in another language
    for match in _TOKEN[formulas].finditer(text):
        group = match.lastgroup
        if match.start(group or 0) < comment:
            continue
        if group == "word" or group == "symbol":
            word, end = match[group], base + match.end()
            kind = NAME if group == "word" and word not in RESERVED else word
            yield Token(kind, word, end - len(word), end, tainted)
            tainted = False
            continue
        if group == "part":
            group = "number"
        assert group is not None
        token, found = _other(group, match[group], Span(base + match.start(group), base + match.end()))
        reports.extend(found)
        if found and len(reports) >= MAX_MISTAKES:
            token = Token(END, "", base + match.end(), base + match.end())
        if token is None:
            comment = _comment(text, match.start(group))
            tainted = not comment
            continue
        yield token._replace(tainted=tainted or bool(found))
        tainted = False
        if token.kind == END:
            return


def _comment(text: str, start: int) -> int:
    """Return the end of the line if a `#` comment, as in other languages, begins at `start`; else 0."""
    before = text[text.rfind("\n", 0, start) + 1 : start].rstrip()
    if text[start] != "#" or before[-1:] not in ("", ";", "{", "}"):
        return 0
    end = text.find("\n", start)
    return len(text) if end < 0 else end


def _other(group: str, text: str, span: Span) -> tuple[Token | None, list[Diagnostic]]:
    """Return the token, None if there is none, and the lexical errors of a match that is no word and no symbol."""
    kind: str | None
    match group:
        case "number":
            kind, found = (INT if text.isdigit() else NUMBER), _number_mistakes(text, span)
        case "digits":
            kind, found = INT, [_digit_mistake(text, span)]
        case "string":
            kind, found = STRING, _escape_mistakes(text, span)
        case "quote":
            kind, found = STRING, [_open_string(text, span)]
        case "open":
            start = Span(span.start, span.start + 2)
            kind, found = END, [Diagnostic("E103", "the comment is not closed", start, help="close it with `*/`")]
        case "end":
            kind, found = END, []
        case _:
            kind, found = _bad(text, span)
    return (None if kind is None else Token(kind, text, span.start, span.end)), found


def _digit_mistake(text: str, span: Span) -> Diagnostic:
    advice = "write a number without a unit; a name begins with a letter or `_`"
    if "." in (text[0], text[-1]):
        advice = "a fraction has digits on both sides of its point"
    return Diagnostic("E105", f"{quote(text)} is neither a number nor a name", span, help=advice)


def _number_mistakes(text: str, span: Span) -> list[Diagnostic]:
    if len(text) > MAX_NUMBER:
        return [Diagnostic("E105", f"the number has more than {MAX_NUMBER} characters", span)]
    _, _, exponent = text.lower().partition("e")
    if len(exponent.lstrip("+-").lstrip("0")) > MAX_EXPONENT:
        return [Diagnostic("E105", f"the exponent has more than {MAX_EXPONENT} digits", span)]
    return []


def _escape_mistakes(text: str, span: Span) -> list[Diagnostic]:
    if "\\" not in text:
        return []
    unknown = (match for match in _ESCAPE.finditer(text) if match[1] not in _ESCAPES)
    return [
        Diagnostic(
            "E104",
            f"unknown escape {quote(match[0])}",
            Span(span.start + match.start(), span.start + match.end()),
            help='the escapes are `\\"`, `\\\\` and `\\n`',
        )
        for match in islice(unknown, MAX_MISTAKES)
    ]


def _open_string(text: str, span: Span) -> Diagnostic:
    control = CONTROL.search(text)
    if control:
        place = Span(span.start + control.start(), span.start + control.end())
        return Diagnostic(
            "E101", "a control character stands in a string", place, help="leave it out, or spell it in letters"
        )
    return Diagnostic("E102", "the string is not closed on its line", span, help='close it with `"`')


def _bad(text: str, span: Span) -> tuple[str | None, list[Diagnostic]]:
    if text[0] == "\0":
        return END, [Diagnostic("E101", "a NUL character: this is no text", span, help="save the file as UTF-8 text")]
    word = FOREIGN.get(text)
    if word is not None:
        return word, [foreign(text, word, span)]
    return None, [Diagnostic("E101", f"unexpected {quote(text)}", span, help=_sign_hint(text))]


def _sign_hint(text: str) -> str:
    """Return the advice on characters that begin no token."""
    known = next((hint for sign, hint in SIGNS.items() if text.startswith(sign)), "")
    letters = "names are made of the letters `A` to `Z`, digits and `_`" if any(map(str.isalpha, text)) else ""
    return known or letters


def foreign(text: str, word: str, span: Span) -> Diagnostic:
    """Return the diagnostic on an operator of other languages that means ``word``."""
    return Diagnostic("E101", f"unknown operator {quote(text)}", span, help=f"write `{word}`")


def string_value(literal: str) -> str:
    """Return the value of a string literal, which is given with its quotes."""
    inside = literal[1:-1]
    return _ESCAPE.sub(lambda match: _ESCAPES.get(match[1], match[1]), inside) if "\\" in inside else inside


def string_literal(value: str) -> str:
    """Return the literal of a string: ``string_value(string_literal(v)) == v``."""
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
