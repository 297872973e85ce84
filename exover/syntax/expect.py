"""Messages of syntax errors: the expected tokens in words, and advice on the one that was found."""

from collections.abc import Iterable
from typing import NamedTuple

from exover.diagnostics import Diagnostic, did_you_mean, quote
from exover.source import Span
from exover.syntax.conditions import PREDICATES, STEPS
from exover.syntax.grammar import Start
from exover.syntax.hints import (
    ALIKE,
    DIFFERENT,
    HEAD,
    RELATIONS,
    argument_hint,
    condition_hint,
    head_hint,
    list_hint,
    part_hint,
    range_hint,
    remedy_hint,
    statement_hint,
    type_hint,
    value_hint,
)
from exover.syntax.lex import END, INT, NAME, NUMBER, STRING, Token
from exover.syntax.properties import BINARY, QUANTIFIERS, UNARY
from exover.syntax.temporal import (
    ENDED,
    FORMS,
    LOGICS,
    TEMPORAL,
    behind_leads,
    form_hint,
    leads_hint,
    predicate_hint,
    temporal_hint,
)
from exover.syntax.unexpected import Unexpected

CLAUSES = frozenset(
    {"check", "wait", "settle", "fail", "after", "before", "interrupts", "uses", "consumes", "produces", "on"}
)
MEMBERS = frozenset({"request", "poster", "state"})
RULES = frozenset({"mutex", "limit", "forbid", "launch"})
ITEMS = RULES | {"enum", "const", "define", "group", "module", "poster", "latch", "resource", "context", "include"}

PROPERTY_ITEMS = frozenset({"property", "assume", "define"})

_TERM = PREDICATES | STEPS | {*UNARY, *QUANTIFIERS} | {"true", "false", "self", "-", INT, NUMBER, NAME}
_OPERATORS = RELATIONS | {"+", "-", "*", ".", ":", "in", "and", "or", "implies"}
_FORMULA_OPERATORS = _OPERATORS | {"&", "|", "->", "<->", *BINARY}

_CATEGORIES: tuple[tuple[frozenset[str], frozenset[str], tuple[str, ...]], ...] = (
    (frozenset({"enum", "mutex"}), ITEMS, ("a declaration", "a rule")),
    (PROPERTY_ITEMS, PROPERTY_ITEMS, ("a property", "an assumption", "a define")),
    (CLAUSES, CLAUSES, ("a clause",)),
    (MEMBERS, MEMBERS, ("a request", "a poster", "a state")),
    (FORMS, FORMS | _TERM | {"not", "("}, ("a form of property",)),
    (frozenset({"!", "("}), _TERM | {"not", "!", "("}, ("a formula",)),
    (frozenset({"not", "("}), _TERM | {"not", "("}, ("a condition",)),
    (frozenset({"self", INT}), _TERM, ("a term",)),
    (frozenset({"true", INT, NAME}), frozenset({"true", "false", "-", INT, NUMBER, NAME}), ("a value",)),
    (frozenset({"-", INT, NAME}), frozenset({"-", INT, NUMBER, NAME}), ("a number", "a constant")),
    (frozenset({INT, NUMBER}), frozenset({INT, NUMBER}), ("a number",)),
    (frozenset({"bool", "real"}), frozenset({"bool", "int", "real", "{", NAME}), ("a type",)),
    (frozenset({"&", "->"}), _FORMULA_OPERATORS, ("an operator",)),
    (RELATIONS, _OPERATORS, ("an operator",)),
    (frozenset({"and", "+"}), _OPERATORS, ("an operator",)),
)
"""If all kinds of token of the first set are expected, the words stand for all kinds of the second set."""

_SYNOPSES = {
    "spec": "spec NAME;",
    "part": "part NAME;",
    "include": 'include "FILE";',
    "for": "for NAME;",
    "property": 'property NAME "TEXT": FORM;',
    "assume": "assume fair reports; or assume always CONDITION; or assume never CONDITION;",
    "enum": "enum NAME { NAME, NAME }",
    "const": "const NAME = VALUE;",
    "define": "define NAME = CONDITION;",
    "group": "group NAME = REQUESTS;",
    "module": "module NAME { … }",
    "request": "request NAME(NAME: TYPE) returns (NAME: TYPE) fails (NAME) instances NUMBER;",
    "poster": "poster NAME: TYPE = VALUE else VALUE;",
    "state": "state NAME: TYPE = VALUE;",
    "latch": "latch NAME: when CONDITION until REQUESTS;",
    "resource": "resource NAME: NUMBER consumable = NUMBER by REMEDIES;",
    "context": "context MODULE.REQUEST { … }",
    "check": "check LABEL: CONDITION;",
    "wait": "wait LABEL: until CONDITION;",
    "settle": "settle LABEL: until CONDITION;",
    "fail": "fail LABEL: when CONDITION else wait;",
    "after": "after REQUESTS;",
    "before": "before REQUESTS;",
    "interrupts": "interrupts REQUESTS else wait;",
    "uses": "uses RESOURCE NUMBER when CONDITION;",
    "consumes": "consumes RESOURCE NUMBER when CONDITION;",
    "produces": "produces RESOURCE NUMBER when CONDITION;",
    "on": "on OUTCOME set STATE = VALUE;",
    "mutex": "mutex LABEL: REQUESTS over REQUESTS else wait;",
    "limit": "limit LABEL: at most NUMBER of REQUESTS by REMEDIES;",
    "forbid": "forbid LABEL: CONDITION by REMEDIES;",
    "launch": "launch LABEL: MODULE.REQUEST(VALUE) when CONDITION;",
}
"""The full form of each statement, with all optional parts."""

_OUTCOMES = frozenset({"ok", "failed", "interrupted"})
_PARENTHESES = "parentheses group conditions, not terms"
_TWO_SIDES = "a comparison has two sides: join two with `and`, or write `in LOW .. HIGH`"

_WORDS = {NAME: "a name", INT: "a whole number", STRING: "a string", END: "the end of the file"}


def expectation(expected: frozenset[str]) -> str:
    """Return the expected kinds of token in words: "a clause or `}`"."""
    rest = set(expected)
    phrases: list[str] = []
    for marks, covered, words in _CATEGORIES:
        if marks <= rest:
            phrases += words
            rest -= covered
    phrases += [_WORDS[kind] for kind in (NAME, INT, STRING) if kind in rest]
    phrases += [f"`{kind}`" for kind in sorted(rest - _WORDS.keys(), key=_rank)]
    if END in rest:
        phrases.append(_WORDS[END])
    return phrases[0] if len(phrases) == 1 else ", ".join(phrases[:-1]) + " or " + phrases[-1]


def _rank(kind: str) -> tuple[bool, str]:
    """Return a sort key: words come before punctuation, both in alphabetical order."""
    return not kind.isalpha(), kind


def found(token: Token) -> str:
    """Return the found token in words."""
    return "the end of the file" if token.kind == END else "a string" if token.kind == STRING else quote(token.text)


def advice(at: Unexpected) -> str:
    """Return the help line for a token that is not expected; empty if there is no advice."""
    if at.expected & {"enum", "check", "request", "assume"}:
        return _beginning(at)
    if at.expected & {"and", "self"}:
        return _in_condition(at)
    hint = _in_part(at) if at.before else ""
    if hint:
        return hint
    hint = type_hint(at) or list_hint(at) or _resembled(at)
    return hint or (f"it reads `{_SYNOPSES[at.keyword]}`" if at.keyword in _SYNOPSES else "")


def _resembled(at: Unexpected) -> str:
    """Return the advice on a word that resembles an expected one."""
    return did_you_mean(at.text, words(at.expected)) if at.token.kind == NAME and len(at.text) > 1 else ""


def _in_part(at: Unexpected) -> str:
    """Return the advice on a token in a part of a statement that is no condition."""
    return (
        part_hint(at)
        or (leads_hint(at.keyword, at.opened) if at.text == "leads" else "")
        or ("`leads to` is written in two words" if at.expected == {"to"} else "")
        or behind_leads(at)
        or form_hint(at)
        or remedy_hint(at)
        or argument_hint(at)
        or head_hint(at)
        or value_hint(at)
        or range_hint(at)
    )


def _beginning(at: Unexpected) -> str:
    """Return the advice on a token where a statement may begin."""
    if at.text in ITEMS and "assume" in at.expected:
        return f"`{at.text}` stands in a spec"
    if at.text in HEAD and not at.expected & {"enum", "assume"} and (at.ahead == "(" or at.text == "instances"):
        return f"`{at.text}` stands in the head of a request, before its block"
    return _elsewhere(at.text) or statement_hint(at.token, at.following, at.expected) or _resembled(at)


def _in_condition(at: Unexpected) -> str:
    """Return the advice on a token where a term or an operator of a condition is expected."""
    text, expected, keyword = at.text, at.expected, at.keyword
    behind = at.named and bool(expected & {"and", "&"})
    hint = (temporal_hint(at) if behind else "") or _compared(at) or condition_hint(at)
    if hint:
        return hint
    if text == "=" and "==" in expected:
        return "compare with `==`"
    if text == "(" and "self" in expected and "not" not in expected:
        return _PARENTHESES
    if text in RELATIONS | {"+", "-", "*"} and "and" in expected:
        return _PARENTHESES if at.previous == ")" else _TWO_SIDES
    if text == "leads" or (text == "lead" and "leads" not in expected):
        return leads_hint(keyword, at.opened)
    if text == "leads_to":
        return "write `leads to`, in two words"
    form = misspelt_form(at.before, expected)
    called = predicate_hint(at.previous, keyword) if text == "(" and behind else ""
    if called or form:
        return called or form or ""
    hint = form_hint(at)
    if hint:
        return hint
    if text == "(" and at.before is not None:
        return did_you_mean(at.previous, PREDICATES | STEPS) or (_called(keyword) if behind and form is None else "")
    return _resembled(at) if form is None else form


def _called(keyword: str) -> str:
    """Return the advice on a name before a `(` that is none of a predicate."""
    steps = ", of steps `asked`, `launched`, `rejected`, `killed`, `ended`" if keyword in PROPERTY_ITEMS else ""
    known = "`active`, `running`, `stopping`, `waiting`, `past`, `last`, `used`, `level`"
    return f"no name has brackets but the predicates {known}{steps}"


def _compared(at: Unexpected) -> str:
    """Return the advice on a comparison of conditions."""
    text, told, expected, closed = at.text, at.ahead, at.expected, at.closed
    if text not in RELATIONS | {"+", "-", "<->"} or "and" not in expected or text + told == "->":
        return ""
    if closed and text in RELATIONS and told in _OUTCOMES:
        return ENDED
    if closed and text in RELATIONS and told in ("true", "false"):
        return f"a condition is compared with nothing: leave out `{text} {told}`, or write `not` before it"
    right = told in PREDICATES | STEPS or told == "not"
    if closed == "term" or not (closed == "condition" or right):
        return ""
    if text in ("==", "<->") or (text, told) in (("<=", ">"), ("<", "-")):
        if told.isdigit():
            return "a condition is no number: write it alone, or `not` before it"
        return "equivalence is `<->` in a formula" if "<->" in expected else ALIKE
    if text == "!=":
        return "in a formula it is `not (a <-> b)`" if "<->" in expected else DIFFERENT
    return "a condition is no number: how many are active at once is limited by `limit at most NUMBER of REQUESTS;`"


def misspelt_form(before: Token | None, expected: frozenset[str]) -> str | None:
    """Return the advice on ``before``, a word that may be a misspelt form of property: "" if it resembles none.

    None if the place is another: ``before`` is no name, or `precedes` cannot follow it.
    """
    if before is None or before.kind != NAME or "precedes" not in expected:
        return None
    if before.text in LOGICS:
        return TEMPORAL
    if before.text in ("precedes", "until"):
        return f"`{before.text}` stands between two conditions: `CONDITION {before.text} CONDITION`"
    return did_you_mean(before.text, FORMS)


def words(expected: Iterable[str]) -> list[str]:
    """Return the keywords among the kinds in alphabetical order; not `part`, which resembles `import` too much."""
    return sorted(kind for kind in expected if kind.isalpha() and kind != "part")


def _elsewhere(word: str) -> str:
    """Return a sentence on where a statement that begins with ``word`` may stand; "" if none does."""
    if word in CLAUSES:
        return f"`{word}` is a clause: it stands in the block of a request or of a context"
    if word in MEMBERS:
        return f"`{word}` stands in the block of a module"
    if word in ITEMS:
        return f"`{word}` stands outside all blocks"
    if word in PROPERTY_ITEMS:
        return f"`{word}` stands in a properties file"
    return ""


def statement(keyword: str) -> str:
    """Return what a message calls the statement that ``keyword`` begins."""
    if keyword in CLAUSES:
        return f"the `{keyword}` clause"
    if keyword in RULES:
        return f"the `{keyword}` rule"
    if keyword in ("property", "assume"):
        return {"property": "the property", "assume": "the assumption"}[keyword]
    if keyword in ("spec", "for", "part"):
        return f"the name of the {'part' if keyword == 'part' else 'spec'}"
    return f"the `{keyword}`" if keyword == "include" else f"the `{keyword}` declaration"


class Opening(NamedTuple):
    """How a text begins: the keyword before the name of the spec, and the keywords of the statements that follow."""

    word: str
    items: frozenset[str]
    what: str


OPENINGS: dict[Start, Opening] = {
    "file": Opening("spec", ITEMS, "spec"),
    "properties": Opening("for", PROPERTY_ITEMS, "properties"),
}


def nothing_there(start: Start, at: int) -> Diagnostic:
    """Return the diagnostic on a text without tokens."""
    word, _, what = OPENINGS[start]
    begins = "a spec begins" if start == "file" else "a properties file begins"
    return Diagnostic("E004", f"the file holds no {what}", Span(at, at), help=f"{begins} with `{word} NAME;`")
