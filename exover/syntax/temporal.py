"""Advice on properties: operators of time and predicates as other languages have them, and where `leads to` stands."""

from collections.abc import Mapping

from exover.syntax.conditions import STEPS
from exover.syntax.lex import NAME
from exover.syntax.properties import QUANTIFIERS, UNARY
from exover.syntax.unexpected import Unexpected

FORMS = frozenset({"never", "always", "possible", "from", "ctl", "ltl"})
"""The words that begin a form of property."""
LOGICS = frozenset({*UNARY, *QUANTIFIERS, "eventually"})
"""What `ltl` and `ctl` have, and no other place; with `eventually`, as others write `F`."""
TEMPORAL = "temporal operators stand behind `ltl` or `ctl`: `property NAME: ltl G (CONDITION -> F CONDITION);`"

_OPERATORS: Mapping[str, str] = {
    **dict.fromkeys(("F", "eventually", "finally", "sometimes", "sometime", "someday"), "F"),
    **dict.fromkeys(("G", "globally", "henceforth", "always", "forever"), "G"),
    **dict.fromkeys(("X", "next", "nexttime"), "X"),
    "never": "G not",
    "possible": "EF",
    **{operator: operator for operator in UNARY if len(operator) == 2},
}
"""The operators of formulas by the words that are written for them."""
_ALONE: Mapping[str, str] = {
    "F": "write `ltl F CONDITION`: every run comes to it; that some run does is `possible CONDITION`",
    "G": "write `always CONDITION`, or the formula `ltl G CONDITION`",
    "X": "write `ltl X CONDITION`: it is true after the first step",
    "G not": "write `never CONDITION`, or the formula `ltl G not CONDITION`",
    "EF": "write `possible CONDITION`, or the formula `ctl EF CONDITION`",
}
"""Advice on an operator at the beginning of a form."""
_NESTED: Mapping[str, str] = {
    "F": "write `always (CONDITION leads to CONDITION)`, or the formula `ltl G (CONDITION -> F CONDITION)`",
    "G": "a form stands alone: with `always` inside it is the formula `ltl G (CONDITION -> G CONDITION)`",
    "X": "the next moment is told by a formula: `ltl G (CONDITION -> X CONDITION)`",
    "G not": "a form stands alone: with `never` inside it is the formula `ltl G (CONDITION -> G not CONDITION)`",
    "EF": "write `from CONDITION possible CONDITION`, or the formula `ctl AG (CONDITION -> EF CONDITION)`",
}
"""Advice on an operator behind `implies`."""
_AFTER = "from a moment on: `ltl G (CONDITION -> G CONDITION)`, or with `G not` for `never`"
_WHENEVER = "write `always (CONDITION implies CONDITION)`, or `leads to` for what may come later"
_BEFORE = "one before the other: `CONDITION precedes CONDITION`; until it comes: `CONDITION until CONDITION`"
_SOME_RUN = "that some run comes to it is `possible CONDITION`, that every run does `ltl F CONDITION`"
_SCOPES: Mapping[str, str] = {
    **dict.fromkeys(("after", "since", "once"), _AFTER),
    **dict.fromkeys(("when", "whenever", "while", "if", "during"), _WHENEVER),
    **dict.fromkeys(("before", "prior"), _BEFORE),
    **dict.fromkeys(("exists", "reachable", "can", "may"), _SOME_RUN),
    **dict.fromkeys(
        ("previously", "yesterday", "historically"),
        "no operator looks back: `past(MODULE.REQUEST)` and `last(MODULE.REQUEST)` tell what has ended",
    ),
    "infinitely": "write `ltl G F CONDITION`: again and again",
}
"""Advice on words of other languages before a condition."""

ENDED = "`ended(MODULE.REQUEST)` is true of a step in which it ends; `last(MODULE.REQUEST)` tells how"
_ABORTED = (
    "no predicate tells of aborts: `rejected(MODULE.REQUEST)` is also true of a waiting one that is given up, "
    "`killed(MODULE.REQUEST)` of a running one"
)
_OBSERVED = "no predicate tells of observations: a poster is read by its name, as in `battery < 10`"
_PREDICATES: Mapping[str, str] = {
    **dict.fromkeys(("reported", "finished", "done", "completed", "succeeded", "failed", "interrupted"), ENDED),
    **dict.fromkeys(("abort", "aborted", "aborts", "aborting", "cancelled", "canceled", "cancel"), _ABORTED),
    **dict.fromkeys(("observe", "observed", "observes"), _OBSERVED),
    **dict.fromkeys(
        ("violated", "violation"), "no predicate tells of rules: that none is ever broken is the check `safety`"
    ),
    **dict.fromkeys(
        ("refused", "denied", "superseded", "dismissed"), "a step that refuses it is `rejected(MODULE.REQUEST)`"
    ),
    **dict.fromkeys(("started", "starts", "start"), "a step that starts it is `launched(MODULE.REQUEST)`"),
    **dict.fromkeys(("requested", "called"), "a step in which it is asked for is `asked(MODULE.REQUEST)`"),
    **dict.fromkeys(("idle", "inactive"), "write `not active(MODULE.REQUEST)`"),
    **dict.fromkeys(("busy", "executing", "ongoing"), "write `active(MODULE.REQUEST)`"),
    **dict.fromkeys(("pending", "queued", "clearing"), "write `waiting(MODULE.REQUEST)`"),
}
"""Advice on words used as predicates."""

_LEADS = "it reads `always (CONDITION leads to CONDITION)`"
_WHOLE = "`always (CONDITION leads to CONDITION)` is the whole form: what else is said stands inside, or in a property"


def leads_hint(keyword: str, opened: tuple[str, ...]) -> str:
    """Return the advice on `leads` in the statement of the `keyword`, after the tokens ``opened``."""
    if keyword == "assume":
        return "`leads to` does not stand in an assumption: that is `fair reports`, or `always` or `never` a condition"
    if keyword == "define":
        return "`leads to` does not stand in a define: it is a form of property, and no condition"
    if "ltl" in opened:
        return "`leads to` does not stand in a formula: `ltl G (CONDITION -> F CONDITION)`"
    if "ctl" in opened:
        return "`leads to` does not stand in a formula: `ctl AG (CONDITION -> AF CONDITION)`"
    if "possible" in opened:
        return (
            "`leads to` does not stand behind `possible`: `always (CONDITION leads to CONDITION)` is a form of its own"
        )
    if "never" in opened:
        return "`leads to` does not stand behind `never`: `always (CONDITION leads to CONDITION)` is the whole form"
    if "leads" in opened:
        return "`leads to` stands once in a property: write another property for the next pair"
    return _WHOLE if "always" in opened and ("not" in opened or opened.count("(") > 1) else _LEADS


def behind_leads(at: Unexpected) -> str:
    """Return the advice on what follows `always (… leads to …)`; "" elsewhere."""
    return _WHOLE if at.previous == ")" and "leads" in at.opened and at.expected == {";"} else ""


def form_hint(at: Unexpected) -> str:
    """Return the advice on a form of property, or `precedes` or `until`, where a condition is to go on or to end."""
    text, expected = at.text, at.expected
    if at.keyword == "assume" and text in ("until", "precedes", "possible", "from"):
        return f"`{text}` does not stand in an assumption: that is `always` or `never` a condition"
    if at.keyword != "property":
        return ""
    if text in ("until", "precedes") and "precedes" not in expected:
        if "->" in expected and text == "until":
            return "in a formula `until` is `U`: `ltl CONDITION U CONDITION`, or `ctl A [CONDITION U CONDITION]`"
        return f"`{text}` stands between two conditions, alone: `CONDITION {text} CONDITION`"
    if text in ("never", "always") and expected & {"and", "&"}:
        return f"`{text}` stands at the beginning of a property; inside, a formula has `G`: `ltl G CONDITION`"
    if text == "before" and "and" in expected:
        return _BEFORE
    if "from" in at.opened and "possible" in expected and at.token.kind == NAME:
        return "write `from CONDITION possible CONDITION`; what must come is `always (CONDITION leads to CONDITION)`"
    return ""


def temporal_hint(at: Unexpected) -> str:
    """Return the advice on a word that was read as a name, before a token that can follow an operator but no name."""
    token, word, keyword, opened = at.token, at.previous, at.keyword, at.opened
    operand = token.kind == NAME or token.text in ("(", "not", "!")
    if word in _SCOPES and keyword == "property" and operand and token.text != "(":
        return _SCOPES[word]
    operator = _OPERATORS.get(word, "")
    if not operator or not operand:
        return ""
    if keyword == "assume":
        return "an assumption has no temporal operators: it is `fair reports`, or `always` or `never` a condition"
    if keyword not in ("property", "define"):
        return (
            "" if word in FORMS else "a rule has no temporal operators: they stand in a properties file, behind `ltl`"
        )
    if keyword == "define":
        return "a define has no temporal operators: they stand in a property, behind `ltl` or `ctl`"
    if "ltl" in opened or "ctl" in opened:
        return _in_formula(word, operator, "ltl" if "ltl" in opened else "ctl")
    if len(operator) == 2:
        if word != "possible":
            inner = f" {token.text}" if token.text in LOGICS else ""
            return f"it stands behind `ctl`: `property NAME: ctl {operator}{inner} CONDITION;`"
        return _NESTED["EF"] if "implies" in opened else _ALONE["EF"]
    if "leads" in opened and operator == "F":
        return f"leave out `{word}`: `leads to` means at that moment or later"
    if opened[-2:-1] == ("always",) and operator in ("F", "X"):
        return f"write `ltl G {operator} CONDITION`" + ": again and again" * (operator == "F")
    if opened[-2:-1] == ("never",) and operator in ("F", "G", "X"):
        return f"leave out `{word}`" if operator == "F" else f"write `ltl G not {operator} CONDITION`"
    if "implies" in opened or "leads" in opened:
        return _NESTED[operator]
    if opened[-2:-1] in (("and",), ("or",)):
        return "a form stands alone: write a property for each; or one formula, as `ltl G CONDITION & F CONDITION`"
    inner = _OPERATORS.get(token.text, "")
    if inner in ("F", "G", "X"):
        return f"write `ltl {operator} {inner} CONDITION`"
    return _ALONE[operator]


def _in_formula(word: str, operator: str, logic: str) -> str:
    """Return the advice on a word that no formula has."""
    if word == operator:
        return ""
    if operator == "EF":
        return "it is `EF` in a `ctl` formula: `ctl AG EF CONDITION`"
    if logic == "ctl":
        path, _, rest = operator.partition(" ")
        return f"it is `A{path}{' ' * bool(rest)}{rest}` or `E{path}{' ' * bool(rest)}{rest}` in a `ctl` formula"
    return f"it is `{operator}` in a formula: `ltl {operator} CONDITION`"


def predicate_hint(word: str, keyword: str) -> str:
    """Return the advice on ``word`` before a `(`, where it is no predicate; "" if it is not known."""
    hint = _PREDICATES.get(word, "")
    if hint and keyword not in ("property", "assume", "define") and any(f"`{step}(" in hint for step in STEPS):
        return "only a properties file tells what a step did"
    return hint
