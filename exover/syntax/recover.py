"""Error recovery: how the parse continues after a syntax error.

Local repairs are tried on the stack of states alone, in this order: insert a bracket or `;`, correct a keyword, insert
a token, delete the token. If none lets the parser continue, panic mode gives up the statement: the text is skipped to
its end, and the block of a request, module or context with a wrong head is parsed as if the head were right.
"""

from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches

from exover.dataclass import dataclass
from exover.diagnostics import MAX_NAME, Diagnostic, quote
from exover.source import Span
from exover.syntax.expect import (
    CLAUSES,
    ITEMS,
    MEMBERS,
    OPENINGS,
    PROPERTY_ITEMS,
    advice,
    expectation,
    found,
    misspelt_form,
    statement,
    words,
)
from exover.syntax.hints import statement_hint
from exover.syntax.lex import END, FOREIGN, NAME, RESERVED, Token, foreign
from exover.syntax.machine import ParserState
from exover.syntax.temporal import leads_hint
from exover.syntax.tree import Product, Sum, Unit
from exover.syntax.unexpected import Closed, Unexpected

_LISTS = ("check", "request", "enum", "assume")
"""A state with an action for one of these is in a list of statements, where the parser can resume."""
_STARTS = CLAUSES | MEMBERS | ITEMS | PROPERTY_ITEMS | {"spec", "part", "for"}
_CLOSING = {"(": ")", "[": "]", "{": "}"}
_HEADS = {"module": "module x", "request": "request x ( )", "context": "context x . x"}


@dataclass(frozen=True, slots=True)
class Repair:
    """A diagnostic and a repair: insert ``insert`` before the token, and then delete the token if ``drop``."""

    diagnostic: Diagnostic
    insert: tuple[Token, ...] = ()
    drop: bool = False


def repair(
    machine: ParserState, before: Token | None, token: Token, following: tuple[Token, Token], unclosed: int
) -> Repair:
    """Return the diagnostic on ``token`` and, if there is one, a repair after which the next tokens are no errors.

    If it neither inserts nor drops, there is none, and the statement has to be given up. ``unclosed``: how many more
    braces the text opens than it closes. If that is not positive, no `}` is inserted before a statement: the statement
    is in the wrong block.
    """
    span = Span(token.start, token.end)
    opening = OPENINGS[machine.start]
    if not machine.values and token.text in opening.items:
        message = f"expected `{opening.word} NAME;` first"
        help = f"begin the file with `{opening.word} NAME;`"
        return Repair(Diagnostic("E106", message, span, help=help), _written(f"{opening.word} x ;", token.start))
    word = FOREIGN.get(token.text, "")
    if word and machine.after([*_written(word, token.start), following[0]]) is not None:
        return Repair(foreign(token.text, word, span), _written(word, token.start), drop=True)
    for closers in _closers(machine, unclosed > 0 or token.kind == END):
        insert = _written(closers, token.start)
        if machine.after([*insert, token]) is not None:
            return Repair(_unclosed(machine, before, token, insert), insert)
    expected = machine.expected()
    report = _unexpected(machine, before, token, expected, following[0])
    if misspelt_form(before, expected) or (token.text == "(" and expected == {"="}):
        return Repair(report)  # what stands behind belongs to another form, or to parameters
    keyword = _misspelt(token, expected)
    if keyword:
        insert = _written(keyword, token.start)
        if machine.after([*insert, following[0]]) is not None:
            return Repair(report, insert, drop=True)
    if token.kind in RESERVED and NAME in expected and "true" not in expected:
        insert = _written("x", token.start)
        if machine.after([*insert, *following]) is not None:
            message = f"{quote(token.text)} is a reserved word and cannot be a name"
            return Repair(Diagnostic("E110", message, span), insert, drop=True)
    for insert in _insertions(expected, token.start):
        if machine.after([*insert, token, following[0]]) is not None:
            return Repair(report, insert)
    if token.kind not in (END, "{", "}", "(", ";") and machine.after(following) is not None:
        return Repair(report, drop=True)
    return Repair(report)


def _closers(machine: ParserState, braces: bool) -> Iterator[str]:
    """Yield the tokens that may be missing at the end of a part: `;`, brackets, or both; `}` only with ``braces``."""
    opened = [value.text for value in reversed(machine.values) if isinstance(value, Token) and value.text in ("(", "[")]
    yield ";"
    for count in sorted({1, 2, len(opened)} if len(opened) > 1 else {len(opened)} - {0}):
        yield _closed_all(opened[:count])
        yield _closed_all(opened[:count]) + ";"
    ends = ["", "; ", _closed_all(opened) + "; "] if opened else ["", "; "]
    for closing in ("}", "} }") if braces else ():
        yield from (end + closing for end in ends)


def _closed_all(opened: Iterable[str]) -> str:
    """Return what closes brackets, the innermost first, each followed by a blank."""
    return "".join(f"{_CLOSING[bracket]} " for bracket in opened)


def _insertions(expected: frozenset[str], at: int) -> Iterator[tuple[Token, ...]]:
    """Yield the tokens that may have been left out before a token; no keyword that begins a statement."""
    if "(" in expected:
        yield _written("( )", at)
    for kind in sorted(expected - _STARTS - {"}", END}, key=lambda kind: (kind.isalpha(), kind)):
        yield (Token(kind, kind, at, at),)


def too_deep(token: Token, limit: int) -> Diagnostic:
    """Return the diagnostic on a token that exceeds the limit of nesting."""
    message = f"brackets and operators are nested more than {limit} deep"
    return Diagnostic("E109", message, Span(token.start, token.end), help="give a part a name with `define`")


def begin_anew(machine: ParserState, before: Token | None, token: Token, advance: Callable[[], Token]) -> Token:
    """Give up the present statement, skip tokens from ``token`` to its end, and return the token to resume with.

    ``advance`` returns the next token; `<end>` is never skipped.
    """
    height = _list_height(machine)
    if height is None:
        machine.cut(0)
        for header in _written(f"{OPENINGS[machine.start].word} x ;", token.start):
            machine.feed(header)
        height = len(machine.values)
    head = _head(machine, height)
    # One entry for each open brace of the statement: True for a block, False for the values of a type or a set.
    braces = [False for value in machine.values[height:] if isinstance(value, Token) and value.text == "{"]
    machine.cut(height)
    top = machine.after(_written("define", token.start)) is not None
    previous = before.text if before else ""
    while token.kind != END:
        if token.kind == "{":
            block = head != "enum" and previous not in (":", "in")
            if block and not braces and head in _HEADS:
                for header in _written(_HEADS[head], token.start):
                    machine.feed(header)
                return token
            braces.append(block)
        elif token.kind == "}" and not braces:
            return advance() if top else token
        elif token.kind == "}":
            block = braces.pop()
            if not braces and (block or head == "enum"):
                token = advance()
                return advance() if token.kind == ";" else token
        elif token.kind == ";" and not any(braces):
            return advance()
        previous = token.text
        token = advance()
    return token


def _written(text: str, at: int) -> tuple[Token, ...]:
    """Return the tokens of ``text``, which blanks separate, as tokens of no length at ``at``."""
    return tuple(
        Token(NAME if word.isalpha() and word not in RESERVED else word, word, at, at) for word in text.split()
    )


def _list_height(machine: ParserState) -> int | None:
    """Return how many symbols of the stack are below the innermost open statement; None before the file's head ends."""
    actions = machine.grammar.actions
    for height in range(len(machine.values), -1, -1):
        if any(keyword in actions[machine.states[height]] for keyword in _LISTS):
            return height
    return None


def _head(machine: ParserState, height: int) -> str:
    """Return the keyword that begins the statement above ``height``, or ""."""
    values = machine.values
    return values[height].text if len(values) > height and isinstance(values[height], Token) else ""


def _keyword(machine: ParserState) -> str:
    """Return the keyword of the innermost open statement, or ""; before the file's head ends, that of the head."""
    height = _list_height(machine)
    return OPENINGS[machine.start].word if height is None else _head(machine, height)


def _unclosed(machine: ParserState, before: Token | None, token: Token, insert: tuple[Token, ...]) -> Diagnostic:
    bracket = next((closer.kind for closer in insert if closer.kind in _CLOSING.values()), "")
    if not bracket:
        end = before.end if before else 0
        return Diagnostic("E107", f"expected `;` after {statement(_keyword(machine))}", Span(end, end))
    opening, opener = next(
        (value.text, start)
        for value, start in zip(reversed(machine.values), reversed(machine.starts), strict=True)
        if isinstance(value, Token) and _CLOSING.get(value.text) == bracket
    )
    where = f"`{bracket}` is missing before {found(token)}" if token.kind != END else f"`{bracket}` is missing"
    if token.text == "leads" and bracket == ")":
        where = leads_hint(_keyword(machine), _opened(machine))
    elif (
        token.text in ("and", "or")
        and bracket == ")"
        and {",", ")"} <= machine.expected()
        and "with" in machine.expected()
    ):
        where += "; a list is written with `,`, and is true of any: `active(MODULE.REQUEST, MODULE.REQUEST)`"
    return Diagnostic("E108", f"`{opening}` is not closed", Span(opener, opener + 1), help=where)


def _unexpected(
    machine: ParserState, before: Token | None, token: Token, expected: frozenset[str], following: Token
) -> Diagnostic:
    # An error at the end of the file is reported where the last token ends, not after blank lines.
    span = Span(token.start, token.end) if token.kind != END or before is None else Span(before.end, before.end)
    message = f"expected {expectation(expected)}, found {found(token)}"
    at = Unexpected(token, before, expected, _keyword(machine), following, _opened(machine), _closed(machine))
    return Diagnostic("E106", message, span, help=advice(at))


def _opened(machine: ParserState) -> tuple[str, ...]:
    """Return the texts of the symbols of the innermost open statement; "" for what has no text of its own."""
    values = machine.values[_list_height(machine) or 0 :]
    return tuple(value if isinstance(value, str) else getattr(value, "text", "") for value in values)


def _closed(machine: ParserState) -> Closed:
    """Return what the `)` on top of the stack closes."""
    values = machine.values
    if not values or not isinstance(values[-1], Token) or values[-1].text != ")":
        return ""
    opener = max((at for at, value in enumerate(values) if isinstance(value, Token) and value.text == "("), default=0)
    if opener and not isinstance(values[opener - 1], Token) and values[opener - 1] not in ("ctl", "ltl"):
        return "condition"  # a predicate: its kind has been reduced
    inner = values[opener + 1 : -1]
    if len(inner) != 1 or inner[0] is None:
        return ""
    return "term" if isinstance(inner[0], Unit | Product | Sum) else "condition"


def _misspelt(token: Token, expected: frozenset[str]) -> str:
    """Return the keyword that a misspelt token resembles, or ""; a keyword of another place is not misspelt."""
    text = token.text
    if token.kind != NAME or not 1 < len(text) <= MAX_NAME or text in _STARTS or statement_hint(token, None, expected):
        return ""
    return next(iter(get_close_matches(text.lower(), words(expected), n=1, cutoff=0.6)), "")
