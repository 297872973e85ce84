"""What may be written at a place: the words that the grammar takes there, and the names that are known."""

import re

from exover.dataclass import dataclass
from exover.editor.analysis import TextAnalysis
from exover.editor.symbols import Index, SpecSymbol, SymbolSort
from exover.syntax.grammar import Start, grammar
from exover.syntax.lex import END, NAME, Token, tokens
from exover.syntax.machine import ParserState

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_COMMENT = re.compile(r"//[^\n]*\Z")
_OF_RESOURCES = frozenset({"uses", "consumes", "produces", "used", "level"})
_OF_REQUESTS = frozenset({"mutex", "of", "over", "after", "before", "interrupts", "kill", "forget", "group", "context"})
_LISTED: tuple[SymbolSort, ...] = ("module", "group")
_EVERYWHERE: tuple[SymbolSort, ...] = ("module", "group", "const", "define", "latch", "value", "enum")


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
    if read and read[-1].text == ".":
        module = read[-2].text if len(read) > 1 else ""
        return _members(symbols, module, read)
    words = _expected(read, start)
    names = _names(symbols, read) if NAME in words else []
    return [*names, *(Proposal(word) for word in sorted(words) if word.isalpha())]


def _in_string(before: str) -> bool:
    line = before.rpartition("\n")[2].replace('\\"', "")
    return line.count('"') % 2 == 1


def _symbols(own: Index, known: Index | None) -> list[SpecSymbol]:
    return list(dict.fromkeys([*own.declared, *(known.declared if known else ())]))


def _expected(read: list[Token], start: Start) -> frozenset[str]:
    """Return the kinds of token that may stand behind these; all words, if these cannot stand themselves."""
    machine = ParserState(grammar(), start)
    machine.building = False
    for token in read:
        if not machine.feed(token):
            return frozenset({NAME})
    return machine.expected()


def _members(symbols: list[SpecSymbol], module: str, read: list[Token]) -> list[Proposal]:
    """Return what stands behind `m.`: requests, and readings where a condition may stand; of self its parameters."""
    if module == "self":
        request = _around(read)
        return [_short(each) for each in symbols if each.sort == "parameter" and each.name.startswith(f"{request}.")]
    wanted = ("request", "poster", "state")
    return [_short(each) for each in symbols if each.sort in wanted and each.name.rpartition(".")[0] == module]


def _short(symbol: SpecSymbol) -> Proposal:
    return Proposal(symbol.name.rpartition(".")[2], symbol)


def _names(symbols: list[SpecSymbol], read: list[Token]) -> list[Proposal]:
    last = [token.text for token in read[-2:] if token.text != "("]
    if last and last[-1] in _OF_RESOURCES:
        return [_short(each) for each in symbols if each.sort == "resource"]
    if last and last[-1] in _OF_REQUESTS:
        return [_short(each) for each in symbols if each.sort in _LISTED]
    request, module = _around(read), _around(read).partition(".")[0]
    found = []
    for each in symbols:
        owner = each.name.rpartition(".")[0]
        own = each.sort in ("poster", "state") and owner in ("", module)
        if own or each.sort in _EVERYWHERE or (each.sort == "parameter" and owner == request):
            found.append(_short(each))
    return found


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
