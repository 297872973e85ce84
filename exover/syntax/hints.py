"""Advice on what newcomers write as in other languages, and how it is written here."""

from collections.abc import Mapping

from exover.syntax.lex import INT, NAME, NUMBER, SIGNS, STRING, Token
from exover.syntax.unexpected import Unexpected

_GOES = "a rule begins with `mutex`, `limit`, `forbid` or `launch`, then its name: `forbid NAME: CONDITION;`"
_ACTS = (
    "`launch MODULE.REQUEST() when CONDITION;` starts a request, `forbid CONDITION by kill MODULE.REQUEST;` ends one"
)
_KEPT = "write `forbid` and what must not be, or a `property` in a properties file"
_REQUEST = "write `request NAME(NAME: TYPE);` in the block of a module"
_POSTER = "a value that is observed is declared as `poster NAME: TYPE = VALUE;`"
_MODULE = "write `module NAME { … }`"
_INCLUDE = 'write `include "FILE";`'
_PROPERTY = "write `property NAME: FORM;`, as in `property NAME: never CONDITION;`"
_TYPE_LAST = "a type stands behind the name: `poster NAME: TYPE = VALUE;` or `const NAME = VALUE;`"

_STATEMENTS: Mapping[str, str] = {
    **dict.fromkeys(("rule", "constraint", "safety"), _GOES),
    **dict.fromkeys(("whenever", "when", "if", "on", "upon", "while", "unless", "then"), _ACTS),
    **dict.fromkeys(("never", "always", "invariant", "assert", "require", "ensure", "must", "possible"), _KEPT),
    **dict.fromkeys(("action", "task", "skill", "command", "service", "def", "function", "void"), _REQUEST),
    **dict.fromkeys(("sensor", "input", "topic", "signal", "var", "variable", "let", "observe"), _POSTER),
    **dict.fromkeys(("component", "node", "class", "struct", "subsystem", "package"), _MODULE),
    **dict.fromkeys(("import", "use", "using"), _INCLUDE),
    **dict.fromkeys(("int", "bool", "real", "float", "double", "string"), _TYPE_LAST),
    **dict.fromkeys(("priority", "preempt", "override"), "write `mutex WINNER over LOSER;`"),
    **dict.fromkeys(("exclusive", "exclude", "conflict", "interlock"), "write `mutex MODULE.REQUEST, MODULE.REQUEST;`"),
    **dict.fromkeys(
        ("allow", "permit", "grant"), "whatever no rule forbids is allowed: write `forbid` and what must not be"
    ),
    **dict.fromkeys(("deny", "prevent", "disallow"), "write `forbid CONDITION;`"),
    "consumable": "write `resource NAME: CAPACITY consumable = LEVEL;`",
}
_CLAUSES: Mapping[str, str] = {
    **dict.fromkeys(
        ("requires", "require", "needs", "pre", "precondition", "guard", "if", "when"), "write `check CONDITION;`"
    ),
    "set": "write when it is set: `on ok set STATE = VALUE;`, or on `launch`, `failed`, `interrupted`",
    "forget": "write when it is forgotten: `on ok forget MODULE.REQUEST;`",
    "until": "write `wait until CONDITION;`",
    "because": "`because` stands before the `;` of its clause",
    **dict.fromkeys(("kill", "stop", "interrupt", "preempts"), "write `interrupts MODULE.REQUEST;`"),
    **dict.fromkeys(("depends", "follows"), "write `after MODULE.REQUEST;`"),
}
TYPES: Mapping[str, str] = {
    **dict.fromkeys(
        ("float", "double", "number", "float32", "float64", "decimal"), "write `real`, or `real in 0 .. 1`"
    ),
    **dict.fromkeys(
        (
            "integer",
            "uint",
            "long",
            "short",
            "byte",
            "int8",
            "int16",
            "int32",
            "int64",
            "uint8",
            "uint16",
            "uint32",
            "uint64",
        ),
        "write `int in 0 .. 100`: an int has a range",
    ),
    **dict.fromkeys(("boolean", "flag"), "write `bool`"),
    **dict.fromkeys(("string", "str", "text", "char", "enum"), "write the values that it can have: `{idle, busy}`"),
}
"""What to write instead of type names of other languages."""
ALIKE = "that both or neither holds is `(a and b) or (not a and not b)`; of two bools `a == b`"
DIFFERENT = "write `(a and not b) or (not a and b)`; of two bools `a != b`"
_WORDS: Mapping[str, str] = {
    **dict.fromkeys(("is", "equals", "eq"), "compare with `==`"),
    "xor": DIFFERENT,
    **dict.fromkeys(("iff", "equiv", "equivalent", "same"), ALIKE),
    "between": "write `in LOW .. HIGH`",
    "not": "`not` stands before the comparison: `not (a in {b, c})`",
    **dict.fromkeys(("then", "do"), "what is done about it stands behind `by`: `by kill MODULE.REQUEST`"),
    **dict.fromkeys(("kill", "reject", "wait"), "a remedy stands behind `by`, as in `by kill MODULE.REQUEST`"),
    **dict.fromkeys(("if", "when", "while"), "join conditions with `and`"),
    **dict.fromkeys(("after", "within", "for", "since"), "rules know no time: let a poster tell that it has passed"),
}
"""Advice on words in a condition where an operator is expected; of other languages, or out of place."""
RELATIONS = frozenset({"==", "!=", "<", "<=", ">", ">="})
_UNTIL = "`until` lists the requests that end it as they end well: `until MODULE.REQUEST, MODULE.REQUEST`"
_OVER = "what stands behind `over` is killed anyway: only `by wait` can be added, for what cannot be"
_REMEDIES = "remedies are joined by `or`: `by reject or kill MODULE.REQUEST`"
_VALUED = frozenset({"on", "poster", "state", "const", "launch", "request"})
_CONSTANT = "a value is a constant: a number, `true`, `false` or a name of one; nothing is computed or read there"
_COUNTED = (
    "a value is a constant; what is counted is a `resource NAME: CAPACITY consumable;`, with `consumes` and `produces`"
)
HEAD = ("returns", "fails", "instances")
"""What may stand in the head of a request behind its parameters, in this order."""
_STATES = frozenset({"active", "running", "stopping", "waiting", "past"})
_WITH = "arguments are asked for with `with`: `active(MODULE.REQUEST with PARAMETER == VALUE)`"


def statement_hint(token: Token, following: Token | None, expected: frozenset[str]) -> str:
    """Return the advice on a token where a statement may begin, "" if there is none."""
    if token.text == ";":
        return "leave it out: a statement ends with one `;`, a block with `}` alone"
    if _comment(token, following):
        return SIGNS["#"]
    known = (_CLAUSES if "check" in expected else _STATEMENTS).get(token.text.lower(), "")
    return _PROPERTY if known == _KEPT and "assume" in expected else known


def _comment(token: Token, following: Token | None) -> bool:
    """Return whether these two tokens are `--`, a comment in other languages."""
    return token.text == "-" and following is not None and (following.text, following.start) == ("-", token.end)


def type_hint(at: Unexpected) -> str:
    """Return the advice on a token behind a word in the place of a type."""
    if at.before is None:
        return ""
    if at.previous == "int" and at.expected == {"in"}:
        return "an int has a range: `int in 0 .. 100`"
    if at.previous in ("bool", "int", "real", *TYPES) and at.token.kind == NAME:
        return "a type stands behind the name and `:`; a `const` has none"
    return TYPES.get(at.previous, "") if at.text in ("in", "(") else ""


def list_hint(at: Unexpected) -> str:
    """Return the advice on a token in a list of requests."""
    if at.keyword == "const":
        return ""  # it has a value and no list
    if at.keyword == "latch" and at.text in RELATIONS:
        return _UNTIL
    if at.text == "with" and {",", ")"} <= at.expected:
        return "`with` asks of a single request: `active(MODULE.REQUEST) or active(MODULE.REQUEST with …)`"
    if "over" in at.expected and at.text in RELATIONS:
        return "write `mutex WINNER over LOSER;`"
    if ("with" in at.expected and at.text == "(") or ("," in at.expected and at.text in RELATIONS):
        return _WITH
    if at.text == "(" and at.named:
        return "requests are listed without parentheses and arguments"
    if at.text == "or" and at.keyword == "after":
        return (
            "each that is listed is needed; that one of them is enough: `check past(MODULE.REQUEST, MODULE.REQUEST);`"
        )
    return "requests are listed with `,`" if at.text in ("and", "or", "&", "+") else ""


def value_hint(at: Unexpected) -> str:
    """Return the advice on what is computed, or read, where a value is written: in a `set`, a declaration, a launch."""
    text, expected = at.text, at.expected
    if at.before is None or at.keyword not in _VALUED or (at.keyword == "request" and text not in ("+", "-", "*")):
        return ""
    if at.token.kind == STRING and {"true", INT, NAME} <= expected:
        return "an enum value is written without quotes"
    behind = at.before.kind in (NAME, INT, NUMBER, "true", "false") and not expected & {":", "(", "..", "of"}
    computed = text in ("+", "-", "*", "/") or (text in ("and", "or", ".") and "->" not in expected)
    if behind and computed and "," in expected and text in ("and", "or", "&"):
        return ""
    if (behind and computed) or ({"true", INT, NAME} <= expected and text in ("not", "self", "(")):
        return _COUNTED if at.keyword == "on" and text in ("+", "-") else _CONSTANT
    return _CONSTANT if at.previous == "-" and INT in expected and at.token.kind == NAME else ""


def argument_hint(at: Unexpected) -> str:
    """Return the advice on the name of a parameter before an argument of a launch."""
    named = at.keyword == "launch" and {",", ")"} <= at.expected and at.named and at.text in ("=", "==", ":")
    return "arguments stand by position, without names: `MODULE.REQUEST(VALUE, VALUE)`" if named else ""


def range_hint(at: Unexpected) -> str:
    """Return the advice on what is no `..` behind the first end of a range, or on a set without braces."""
    if ".." not in at.expected or at.text == "..":
        return ""
    if at.keyword in ("poster", "state", "request"):
        return "a range is written `0 .. 9`"
    return "a set is written `in {a, b}`, a range `in 0 .. 9`"


def remedy_hint(at: Unexpected) -> str:
    """Return the advice on what joins remedies."""
    text, expected = at.text, at.expected
    if at.keyword == "mutex" and "over" in at.opened:
        joined = at.previous == "wait" and text in ("or", ",", "and")
        return _OVER if joined or (expected == {"wait"} and at.previous in ("by", "else")) else ""
    if expected == {"wait"} and at.previous == "else" and text in ("reject", "kill"):
        return f"leave out `else {text}`: only `wait` can be added"
    remedies = "or" in expected and not expected & {"and", "|"} and "by" in at.opened
    if remedies and text in (",", "and", "else", "then", "&"):
        return _REMEDIES if "," not in expected or at.ahead in ("kill", "reject", "wait") else ""
    if expected == {"kill", "reject", "wait"} and at.previous == "or" and at.token.kind == NAME:
        return "behind `or` stands a remedy, as `or wait`; the requests of a `kill` are listed with `,`"
    return ""


def head_hint(at: Unexpected) -> str:
    """Return the advice on a part of the head of a request, or of a resource, in the wrong order."""
    text, expected = at.text, at.expected
    if at.keyword == "resource" and text == "consumable" and "or" in expected:
        return "`consumable` stands before `by`"
    if text == "," and at.keyword == "request" and at.ahead in HEAD:
        return "leave out the `,`"
    if at.keyword != "request" or text not in HEAD or not expected & {";", "{"}:
        return ""
    later = HEAD[HEAD.index(text) + 1 :]
    if not later or later[0] in expected:
        return f"`{text}` stands once in the head of a request"
    return f"`{text}` stands before {' and '.join(f'`{word}`' for word in later)}"


def part_hint(at: Unexpected) -> str:
    """Return the advice on a token in a part of a statement that is neither a list nor a condition."""
    text, previous, expected = at.text, at.previous, at.expected
    if previous == "because":
        if at.token.kind == STRING:
            return "leave out the `,` before `because`"
        return 'a text stands between `"` and `"`: `because "TEXT"`'
    if expected == {INT} and at.token.kind == NAME:
        return "a whole number is written out here; no `const` can stand for it"
    if previous in RELATIONS and expected == {INT}:
        return "an amount of a resource is a whole number, written out"
    if previous in RELATIONS and "interrupted" in expected:
        return "`last` tells how the last instance ended: `none`, `ok`, `failed` or `interrupted`"
    if text == "(" and expected == {"="}:
        return "it has no parameters: `=` stands behind its name"
    if text == "==" and "=" in expected:
        return "a value is given with one `=`"
    if text == "*" and previous == "." and expected == {NAME}:
        return "one request is meant here: `MODULE.REQUEST`"
    if previous == ".." and text == ".":
        return "a range is written `0 .. 9`"
    if text == "-" and at.before is not None and at.named and at.before.end == at.token.start:
        return "names are made of the letters `A` to `Z`, digits and `_`"
    return ""


def condition_hint(at: Unexpected) -> str:
    """Return the advice on a token in a condition, where an operator or a term is expected."""
    token, text, previous, expected = at.token, at.text, at.previous, at.expected
    pair = text + (at.following.text if at.following and at.following.start == token.end else "")
    if pair == "=>":
        return "write `->`" if "->" in expected else "write `>=`, or `implies` between conditions"
    if pair == "->" and "implies" in expected:
        return "write `implies`"
    if pair == "=<":
        return "write `<=`"
    if text == "then" and "by" not in expected:
        return "write `implies` between conditions"
    if text == "=" and previous == "==":
        return "compare with `==`"
    if text == ">" and previous == "<":
        return "write `!=`"
    if text == "(" and previous == "in":
        return "a set is written `{a, b}`, a range `0 .. 9`"
    if token.kind == STRING and previous == ":" and "never" in expected:
        return 'the text stands before the `:`: `property NAME "TEXT": FORM;`'
    if token.kind == STRING and "self" in expected:
        return "an enum value is written without quotes"
    if token.kind == STRING:
        return "a text stands behind `because`; that of a property behind its name"
    if text == "," and at.before is not None and at.before.kind == INT:
        if at.following is None or at.following.start > token.end:
            return "one of several values is `in {a, b}`; conditions are joined with `and`"
        return "a fraction is written with a point: `0.5`"
    if text == "{" and previous in RELATIONS:
        return "a set stands behind `in`: `in {a, b}`"
    if text == "," and "and" in expected:
        return "join conditions with `and`; requests are listed inside a predicate, as in `active(m.a, m.b)`"
    if text == ":" and "self" in expected:
        return "leave out the `:`, or write a name before it"
    if text == ":":
        return (
            "a `:` stands behind one name, of the letters `A` to `Z`, digits and `_`"
            if "==" in expected
            else "an enum value is written alone, without its type"
        )
    if (text == "(" or token.kind == NAME) and previous in ("never", "always", "possible") and "by" in expected:
        return f"`{previous}` is no condition: `forbid` says what must not be"
    operand = token.kind in (NAME, INT, NUMBER) or text in ("(", "not")
    if at.named and previous in ("when", "if", "unless") and at.keyword in ("check", "forbid") and operand:
        return f"leave out `{previous}`: `{at.keyword}` takes the condition itself, `{at.keyword} LABEL: CONDITION;`"
    return _applied(at) or _WORDS.get(text.lower(), "")


def _applied(at: Unexpected) -> str:
    """Return the advice on a token behind a word used as a predicate or a temporal operator."""
    previous = at.previous
    if previous in ("A", "E") and "[" in at.expected:
        return (
            f"`ctl` has `{previous}F`, `{previous}G`, `{previous}X` and `{previous} [p U q]`, `ltl` is about all runs"
        )
    if previous in _STATES and "(" in at.expected and at.token.kind == NAME:
        return f"write `{previous}(MODULE.REQUEST)`"
    if previous == "count" and at.text == "(":
        return "write `limit at most NUMBER of REQUESTS;`"
    return ""
