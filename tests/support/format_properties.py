"""The tree of a properties file to its canonical text, as `format_spec.py` does it for a spec."""

from typing import assert_never

from exover.syntax import tree
from exover.syntax.format import format_condition
from exover.syntax.lex import string_literal

_WORDS: dict[tree.Connective, str] = {"not": "!", "and": "&", "or": "|", "implies": "->", "iff": "<->"}
_STRENGTHS: dict[tree.Connective, int] = {"iff": 0, "implies": 1, "or": 2, "and": 3, "not": 5}
_PATH = 4
_PREFIXED = 5


def format_properties(properties: tree.Properties) -> str:
    """Return the text of a properties file, with a newline at its end; an empty line stands between kinds of items."""
    lines = [f"for {properties.spec.text};"]
    before: type | None = None
    for item in properties.items:
        kind = tree.Assume if isinstance(item, tree.AssumeFair) else type(item)
        if kind is not before:
            lines.append("")
        lines.append(_item(item))
        before = kind
    return "\n".join(lines) + "\n"


def _item(item: tree.PropertyItem) -> str:
    match item:
        case tree.Define(name, condition):
            return f"define {name.text} = {format_condition(condition)};"
        case tree.Property(name, text, form):
            shown = "" if text is None else " " + string_literal(text)
            return f"property {name.text}{shown}: {format_form(form)};"
        case tree.AssumeFair():
            return "assume fair reports;"
        case tree.Assume(never, condition):
            return f"assume {'never' if never else 'always'} {format_condition(condition)};"
        case _:
            assert_never(item)


def format_form(form: tree.Form) -> str:
    """Return what a property demands, as text; a condition of several words stands in parentheses."""
    match form:
        case tree.Never(condition):
            return f"never {_enclosed(condition)}"
        case tree.Always(condition):
            return f"always {_enclosed(condition)}"
        case tree.Possible(condition):
            return f"possible {_enclosed(condition)}"
        case tree.AlwaysPossible(condition):
            return f"always possible {_enclosed(condition)}"
        case tree.FromPossible(premise, goal):
            return f"from {_enclosed(premise)} possible {_enclosed(goal)}"
        case tree.LeadsTo(premise, goal):
            return f"always ({format_condition(premise)} leads to {format_condition(goal)})"
        case tree.Precedes(first, second):
            return f"{_enclosed(first)} precedes {_enclosed(second)}"
        case tree.Until(kept, goal):
            return f"{_enclosed(kept)} until {_enclosed(goal)}"
        case tree.Raw(logic, formula):
            return f"{logic} {format_formula(formula)}"
        case _:
            assert_never(form)


def _enclosed(condition: tree.Cond) -> str:
    """Return a condition, in parentheses if it is joined of others or a word that could be taken for a keyword."""
    text = format_condition(condition)
    return f"({text})" if isinstance(condition, tree.Implies | tree.Or | tree.And | tree.Term) else text


def format_formula(formula: tree.Formula) -> str:
    """Return the text of a raw formula, with no more parentheses than its shape needs."""
    match formula:
        case tree.Connected("not", (part,)):
            return f"!{_inside(part, _PREFIXED)}"
        case tree.Connected("implies" | "iff" as connective, (left, right)):
            least = _STRENGTHS[connective]
            return f"{_inside(left, least + 1)} {_WORDS[connective]} {_inside(right, least)}"
        case tree.Connected(connective, parts):
            return f" {_WORDS[connective]} ".join(_inside(part, _STRENGTHS[connective] + 1) for part in parts)
        case tree.Temporal(operator, part):
            return f"{operator} {_inside(part, _PREFIXED)}"
        case tree.TemporalBinary(left, operator, right):
            return f"{_inside(left, _PREFIXED)} {operator} {_inside(right, _PATH)}"
        case tree.Quantified(quantifier, part):
            return f"{quantifier} [{format_formula(part)}]"
        case _:
            return format_condition(formula)


def _inside(formula: tree.Formula, least: int) -> str:
    """Return the text of a part, in parentheses if it binds less than ``least``."""
    text = format_formula(formula)
    return f"({text})" if _strength(formula) < least else text


def _strength(formula: tree.Formula) -> int:
    match formula:
        case tree.Connected(connective):
            return _STRENGTHS[connective]
        case tree.TemporalBinary():
            return _PATH
        case _:
            return _PREFIXED
