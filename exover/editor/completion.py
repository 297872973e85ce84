"""Completion: the keywords that the grammar takes at a place, and the names that may stand there."""

import re
from collections import deque
from itertools import islice

from exover.dataclass import dataclass
from exover.editor.analysis import TextAnalysis
from exover.editor.symbols import Declared, Index, SpecSymbol, SymbolSort
from exover.syntax import tree
from exover.syntax.conditions import STEPS
from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import END, NAME, Token, tokens
from exover.syntax.machine import ParserState
from exover.syntax.parse import MAX_TOKENS

_WORD = re.compile(r"(?<![A-Za-z0-9_])[A-Za-z_][A-Za-z0-9_]*\Z")
_UNREAD = re.compile(r'"(?:\\.|[^"\\\r\n])*(?P<closed>"?)|//[^\n]*|/\*.*?(?P<ended>\*/|\Z)', re.DOTALL)
"""Matches a text and a comment, also those that are not closed."""
_NUMBER = re.compile(r"(?<![A-Za-z0-9_.])[0-9]+(?:\.[0-9]+)?\.?[A-Za-z0-9_]*\Z")
_OF_RESOURCES = frozenset({"uses", "consumes", "produces", "used", "level"})
_INSIDE_WITH = frozenset({"true", "false", "not", "self"})
_CONSTANT: tuple[SymbolSort, ...] = ("const", "value")
_READ: tuple[SymbolSort, ...] = ("poster", "state")
_EVERYWHERE: tuple[SymbolSort, ...] = ("module", "group", "const", "define", "latch", "value", "enum", *_READ)


@dataclass(frozen=True, slots=True)
class Proposal:
    """A word that is proposed: a name, or a keyword of the grammar (`symbol` is None)."""

    text: str
    symbol: SpecSymbol | None = None


def proposals(analysis: TextAnalysis, offset: int, start: Start, spec: TextAnalysis | None = None) -> list[Proposal]:
    """Return proposals for the word at an offset, of which a part may be typed; names first, then keywords.

    There are none where the text before is too large to be read.
    """
    before = analysis.document.text[: offset - analysis.document.base]
    before = before[: len(before) - len(found[0])] if (found := _WORD.search(before)) else before
    if _inside(before) or _NUMBER.search(before):
        return []
    read = [each for each in islice(tokens(before, [], start == "properties"), MAX_TOKENS) if each.kind != END]
    if len(read) == MAX_TOKENS:
        return []
    declared = (spec.index.declared if spec else {}) | analysis.index.declared
    symbols, place = _symbols(analysis.index, spec.index if spec else None), _place(read, start)
    symbols = _opposite(symbols, declared, _compared(read), place)
    if read and read[-1].text == ".":
        module = read[-2].text if len(read) > 1 else ""
        return _members(symbols, module, place)
    names = _names(symbols, place) if NAME in place.words else []
    return [*names, *(Proposal(word) for word in sorted(place.words) if word.isalpha())]


@dataclass(frozen=True, slots=True)
class _Place:
    """The context of a word: it stands behind the word `last`, in a clause of `request` (or of a module alone).

    `words`: the kinds of token that may stand there; `then`: those that may follow a name there, None if the text
    before cannot be parsed. `subject`: the request whose `with` it stands in; `past`: whether that is of a `past`.
    """

    last: str
    request: str
    words: frozenset[str]
    then: frozenset[str] | None
    subject: str = ""
    past: bool = False


def _place(read: list[Token], start: Start) -> _Place:
    last = next((token.text for token in reversed(read[-2:]) if token.text != "("), "")
    request, (subject, past) = _around(read), _subject(read)
    machine = ParserState(grammar(), start)
    machine.building = False
    if not all(map(machine.feed, read)):
        return _Place(last, request, frozenset({NAME}), None, subject, past)
    words, then = machine.expected(), _behind(machine, NAME)
    if NAME in words:
        words -= {word for word in words - {"self"} if word.isalpha() and _is_name(_behind(machine, word), then)}
    words -= STEPS if start == "file" else frozenset()
    words -= frozenset() if "." in request else {"self"}
    return _Place(last, request, words & _INSIDE_WITH | words & {NAME} if subject else words, then, subject, past)


def _is_name(behind: frozenset[str], then: frozenset[str]) -> bool:
    """Return whether a word can only be a name here: whatever may follow it may also follow a name."""
    return "." in behind and behind <= then


def _behind(machine: ParserState, kind: str) -> frozenset[str]:
    """Return the kinds of token that may follow one of this kind here; empty if it may not stand here."""
    states = machine.after([Token(kind, kind, 0, 0)])
    here = machine.grammar.actions[states[-1]] if states else {}
    return frozenset(each for each in here if machine.after([Token(each, each, 0, 0)], states) is not None)


def _subject(read: list[Token]) -> tuple[str, bool]:
    """Return the full name of the request in whose `with` the text ends, empty if in none, and whether it is `past`."""
    depth = 0
    for place in range(len(read) - 1, 3, -1):
        text = read[place].text
        if text == ";":
            break
        depth += (text in (")", "}")) - (text in ("(", "{") and depth > 0)
        if text == "with" and depth == 0:
            return "".join(token.text for token in read[place - 3 : place]), read[place - 5].text == "past"
    return "", False


def _inside(before: str) -> bool:
    """Return whether a text ends inside a comment or a string."""
    last = deque(_UNREAD.finditer(before), 1)
    return any(each.end() == len(before) and not (each["closed"] or each["ended"]) for each in last)


def _compared(read: list[Token]) -> str:
    """Return the term that a text ends by comparing with something, or sets, as `m.s`; empty if it does neither."""
    place = len(read) - 1
    while place > 0 and read[place].text == "," and read[place - 1].kind == NAME:
        place -= 2
    place -= place > 0 and [each.text for each in read[place - 1 : place + 1]] == ["in", "{"]
    if place < 1 or read[place].text not in ("==", "!=", "=", "in"):
        return ""
    start = place - 3 if place > 2 and read[place - 2].text == "." else place - 1
    return "".join(each.text for each in read[start:place])


def _opposite(
    symbols: list[SpecSymbol], declared: dict[SpecSymbol, Declared], term: str, place: _Place
) -> list[SpecSymbol]:
    """Return the symbols without enum values that are of another type than a term."""
    scopes = [place.subject] if place.subject else [place.request, place.request.partition(".")[0], ""]
    if term.startswith("self."):
        scopes, term = [place.request], term.removeprefix("self.")
    full = [f"{scope}.{term}".removeprefix(".") for scope in scopes]
    sorts: tuple[SymbolSort, ...] = ("parameter", "result", *_READ)
    found = [declared[key] for name in full for sort in sorts if (key := SpecSymbol(sort, name)) in declared]
    if not found:
        return symbols
    kind = found[0].node.type
    if isinstance(kind, tree.NamedType):
        enum = declared.get(SpecSymbol("enum", kind.name.text))
        kind = enum.node if enum else None
    if not isinstance(kind, tree.Enum | tree.SetType):
        return symbols
    values = {value.text for value in kind.values}
    return [each for each in symbols if each.sort != "value" or each.name in values]


def _symbols(own: Index, known: Index | None) -> list[SpecSymbol]:
    return list(dict.fromkeys([*own.declared, *(known.declared if known else ())]))


def _members(symbols: list[SpecSymbol], module: str, place: _Place) -> list[Proposal]:
    """Return proposals behind `m.`: requests, or in a condition posters and states; behind `self.`, parameters."""
    if module == "self":
        return _of(symbols, ("parameter",), place.request)
    if place.then is None:
        return _of(symbols, ("request", *_READ), module)
    if "=" in place.then:
        return _of(symbols, ("state",), module)
    if "+" not in place.then:
        return _of(symbols, ("request",), module)
    return [] if place.subject else _of(symbols, _READ, module)


def _of(symbols: list[SpecSymbol], sorts: tuple[SymbolSort, ...], owner: str) -> list[Proposal]:
    """Return the symbols of these sorts in a module or request `owner`; if that is empty, those at the top level."""
    return [_short(each) for each in symbols if each.sort in sorts and each.name.rpartition(".")[0] == owner]


def _short(symbol: SpecSymbol) -> Proposal:
    return Proposal(symbol.name.rpartition(".")[2], symbol)


def _names(symbols: list[SpecSymbol], place: _Place) -> list[Proposal]:
    """Return the known names that may stand here; none where a new name is declared."""
    module, words, then = place.request.partition(".")[0], place.words, place.then
    if place.last in _OF_RESOURCES:
        return _of(symbols, ("resource",), "")
    if then is None:
        return [*_of(symbols, _EVERYWHERE, ""), *_own(symbols, place.request)]
    if place.last == "set":
        return _of(symbols, ("state",), module)
    if place.subject:
        told: tuple[SymbolSort, ...] = ("parameter", "result") if place.past else ("parameter",)
        return [*_of(symbols, told, place.subject), *_of(symbols, _CONSTANT, "")]
    if "+" in then:
        read = {each.name.partition(".")[0] for each in symbols if each.sort in _READ}
        modules = [each for each in _of(symbols, ("module",), "") if each.text in read]
        return [*_own(symbols, place.request), *modules, *_of(symbols, (*_CONSTANT, "define", "latch", "poster"), "")]
    if "bool" in words:
        return _of(symbols, ("enum",), "")
    if "-" in words:
        return _of(symbols, _CONSTANT if "true" in words else ("const",), "")
    if "." in then:
        return _of(symbols, ("module", "group") if then - {".", ":", "*"} else ("module",), "")
    return []


def _own(symbols: list[SpecSymbol], request: str) -> list[Proposal]:
    """Return what a clause of a request, or a module, may name without a prefix."""
    module = request.partition(".")[0]
    if not module:
        return []
    return [*_of(symbols, ("parameter",), request), *_of(symbols, _READ, module)]


def _around(read: list[Token]) -> str:
    """Return the full name of the request in whose clauses the text ends; or the module's name; or an empty text."""
    around: list[str] = []
    for place, token in enumerate(read):
        if token.text == "{":
            around.append(_opened(read, place))
        elif token.text == "}" and around:
            around.pop()
    return ".".join(filter(None, around))


def _opened(read: list[Token], brace: int) -> str:
    """Return the name of what a brace opens: a module, a request, or a context's request; else an empty text."""
    for place in range(brace - 1, -1, -1):
        if read[place].text in (";", "{", "}"):
            return ""
        if read[place].text in ("module", "request"):
            return read[place + 1].text
        if read[place].text == "context":
            return "".join(token.text for token in read[place + 1 : brace])
    return ""
