"""What may be written at a place: the words that the grammar takes there, and the names that are known."""

import re
from typing import get_args

from exover.dataclass import dataclass
from exover.editor.analysis import TextAnalysis
from exover.editor.symbols import Index, SpecSymbol, SymbolSort
from exover.syntax.conditions import StepKind
from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import END, NAME, Token, tokens
from exover.syntax.machine import ParserState

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_COMMENT = re.compile(r"//[^\n]*\Z")
_OF_RESOURCES = frozenset({"uses", "consumes", "produces", "used", "level"})
_STEPS = frozenset(get_args(StepKind))
_INSIDE_WITH = frozenset({"true", "false", "not", "self"})
_CONSTANT: tuple[SymbolSort, ...] = ("const", "value")
_READ: tuple[SymbolSort, ...] = ("poster", "state")
_EVERYWHERE: tuple[SymbolSort, ...] = ("module", "group", "const", "define", "latch", "value", "enum", *_READ)


@dataclass(frozen=True, slots=True)
class Proposal:
    """A word that may stand: a name, or a keyword of the grammar (`symbol` is None)."""

    text: str
    symbol: SpecSymbol | None = None


def proposals(analysis: TextAnalysis, offset: int, start: Start, spec: TextAnalysis | None = None) -> list[Proposal]:
    """Return what may stand at an offset, where a word may have been begun; keywords last, each in order."""
    before = analysis.document.text[: offset - analysis.document.base]
    before = before[: len(before) - len(found[0])] if (found := _WORD.search(before)) else before
    read = [token for token in tokens(before, [], start == "properties") if token.kind != END]
    if _COMMENT.search(before) or before.count("/*") > before.count("*/") or _in_string(before):
        return []
    symbols = _symbols(analysis.index, spec.index if spec else None)
    place = _place(read, start)
    if read and read[-1].text == ".":
        module = read[-2].text if len(read) > 1 else ""
        return _members(symbols, module, place)
    names = _names(symbols, place) if NAME in place.words else []
    return [*names, *(Proposal(word) for word in sorted(place.words) if word.isalpha())]


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a word may stand: behind a `last` word, among the clauses of a `request` (or in a module alone).

    `words` are the kinds of token that may stand, `then` those that may stand behind a name; None if what is before
    cannot be read. `subject`: the request within whose `with` it is, `past`: whether that tells of the past.
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
    words -= _STEPS if start == "file" else frozenset()
    words -= frozenset() if "." in request else {"self"}
    return _Place(last, request, words & _INSIDE_WITH | words & {NAME} if subject else words, then, subject, past)


def _is_name(behind: frozenset[str], then: frozenset[str]) -> bool:
    """Return whether a word is but a name here: nothing stands behind it that does not stand behind a name."""
    return "." in behind and behind <= then


def _behind(machine: ParserState, kind: str) -> frozenset[str]:
    """Return the kinds of token that may stand behind one that may stand here; none if it may not."""
    states = machine.after([Token(kind, kind, 0, 0)])
    here = machine.grammar.actions[states[-1]] if states else {}
    return frozenset(each for each in here if machine.after([Token(each, each, 0, 0)], states) is not None)


def _subject(read: list[Token]) -> tuple[str, bool]:
    """Return the full name of the request within whose `with` the text ends, if it does, and whether it is `past`."""
    depth = 0
    for place in range(len(read) - 1, 3, -1):
        text = read[place].text
        if text == ";":
            break
        depth += (text in (")", "}")) - (text in ("(", "{") and depth > 0)
        if text == "with" and depth == 0:
            return "".join(token.text for token in read[place - 3 : place]), read[place - 5].text == "past"
    return "", False


def _in_string(before: str) -> bool:
    line = before.rpartition("\n")[2].replace('\\"', "")
    return line.count('"') % 2 == 1


def _symbols(own: Index, known: Index | None) -> list[SpecSymbol]:
    return list(dict.fromkeys([*own.declared, *(known.declared if known else ())]))


def _members(symbols: list[SpecSymbol], module: str, place: _Place) -> list[Proposal]:
    """Return what stands behind `m.`: requests, or in a condition readings; of self the parameters of the request."""
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
    """Return the symbols of these sorts that a module or a request has; of none, those that stand alone."""
    return [_short(each) for each in symbols if each.sort in sorts and each.name.rpartition(".")[0] == owner]


def _short(symbol: SpecSymbol) -> Proposal:
    return Proposal(symbol.name.rpartition(".")[2], symbol)


def _names(symbols: list[SpecSymbol], place: _Place) -> list[Proposal]:
    """Return the names that may stand where a name may; none where it is a new one."""
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
    """Return what a clause of a request, or a module, may call by its name alone."""
    module = request.partition(".")[0]
    if not module:
        return []
    return [*_of(symbols, ("parameter",), request), *_of(symbols, _READ, module)]


def _around(read: list[Token]) -> str:
    """Return the full name of the request in whose clauses the text ends; of a module its name alone."""
    around: list[str] = []
    for place, token in enumerate(read):
        if token.text == "{":
            around.append(_opened(read, place))
        elif token.text == "}" and around:
            around.pop()
    return ".".join(filter(None, around))


def _opened(read: list[Token], brace: int) -> str:
    """Return the name of what a brace opens: a module, a request, or the request of a context; of another nothing."""
    for place in range(brace - 1, -1, -1):
        if read[place].text in (";", "{", "}"):
            return ""
        if read[place].text in ("module", "request"):
            return read[place + 1].text
        if read[place].text == "context":
            return "".join(token.text for token in read[place + 1 : brace])
    return ""
