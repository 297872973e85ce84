"""The LALR(1) parse tables of grammar.lark, which lark constructs, in the form that machine.py uses.

Their construction takes longer than parsing most specs, so they are stored beside the grammar as grammar.json. The file
holds the digest of its grammar; if that differs, the tables are constructed again. To write the file:
``python -m exover.syntax.grammar``.
"""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args

from exover.dataclass import dataclass
from exover.syntax.lex import END, INT, NAME, NUMBER, STRING

_LARK = Path(__file__).with_name("grammar.lark")
_JSON = Path(__file__).with_name("grammar.json")

Start = Literal["file", "properties"]
"""The start symbols: `file` of a spec or a part, `properties` of a properties file."""

_KINDS = {"NAME": NAME, "INT": INT, "NUM": NUMBER, "STRING": STRING, "$END": END}


@dataclass(frozen=True, slots=True)
class Production:
    """A production: the symbol ``origin`` derives ``size`` symbols.

    A reduction applies ``action`` to the children whose indices are in ``keep``; there ``~i`` stands for the elements
    of the list of a repetition, and None for an optional part left out. ``action`` is "" for a repetition, whose
    value is a list. If ``single``, a lone child is the value itself; ``passes`` iff the production has only that child.
    """

    origin: str
    size: int
    action: str
    keep: tuple[int | None, ...]
    single: bool
    passes: bool


@dataclass(frozen=True, slots=True)
class Grammar:
    """The tables: ``actions[state][kind]`` is the state to shift to or the production to reduce by;
    ``gotos[state][origin]`` is the state after a reduction.

    ``ends``: for each start symbol the initial and the accepting state.
    """

    actions: tuple[dict[str, int | Production], ...]
    gotos: tuple[dict[str, int], ...]
    ends: dict[Start, tuple[int, int]]


@cache
def grammar() -> Grammar:
    """Return the tables; they are read or constructed once in a process."""
    text = _LARK.read_text("utf-8")
    if _JSON.is_file():
        data = json.loads(_JSON.read_text("utf-8"))
        if data["digest"] == _digest(text):
            return _unpacked(data)
    return make(text)


def make(text: str) -> Grammar:
    """Return the tables of the grammar ``text``, the same for the same text."""
    from lark import Lark
    from lark.lexer import Lexer
    from lark.parsers.lalr_analysis import Shift

    class NoLexer(Lexer):
        """Takes the place of lark's lexer, which is not needed: lex.py is the lexer."""

        def __init__(self, _conf: object) -> None: ...

        def lex(self, _state: object, _parser: object) -> Any:
            return iter(())

    starts = get_args(Start)
    lark = Lark(text, parser="lalr", lexer=NoLexer, start=list(starts), maybe_placeholders=True)
    confs = {start: lark.parse_interactive("", start).parser_state.parse_conf for start in starts}
    conf = confs["file"]  # all have the same states
    kinds = {terminal.name: _KINDS.get(terminal.name, terminal.pattern.value) for terminal in lark.terminals}
    kinds["$END"] = END
    productions = {rule: _production(rule) for rule in lark.rules}
    number = _numbering(conf.states, [conf.start_state for conf in confs.values()], Shift)
    actions: list[dict[str, int | Production]] = [{} for _ in number]
    gotos: list[dict[str, int]] = [{} for _ in number]
    for state, new in number.items():
        for symbol, (action, target) in sorted(conf.states[state].items()):
            if symbol not in kinds:
                gotos[new][symbol] = number[target]
            elif action is Shift:
                actions[new][kinds[symbol]] = number[target]
            else:
                actions[new][kinds[symbol]] = productions[target]
    ends = {start: (number[conf.start_state], number[conf.end_state]) for start, conf in confs.items()}
    return Grammar(tuple(actions), tuple(gotos), ends)


def _numbering(states: dict[int, dict[str, Any]], starts: list[int], shift: object) -> dict[int, int]:
    """Return canonical numbers of the states, breadth first from ``starts``; lark's depend on the order of its sets."""
    number = {start: index for index, start in enumerate(starts)}
    for state in (order := list(starts)):
        for _, (action, target) in sorted(states[state].items()):
            if action is shift and target not in number:
                number[target] = len(number)
                order.append(target)
    return number


def _production(rule: Any) -> Production:
    """Return a rule of lark as a production; tokens written as literals in the grammar are not kept as children."""
    options = rule.options
    origin = rule.origin.name
    keep: list[int | None] = []
    # lark marks the left-out optional parts of an expansion by True between its symbols.
    absent = iter(options.empty_indices or [False] * len(rule.expansion))
    index = 0
    for is_absent in absent:
        if is_absent:
            keep.append(None)
            continue
        symbol = rule.expansion[index]
        if symbol.is_term:
            if options.keep_all_tokens or not symbol.filter_out:
                keep.append(index)
        else:
            keep.append(~index if symbol.name.startswith("_") else index)
        index += 1
    action = "" if origin.startswith("_") else rule.alias or origin
    single = options.expand1 and not rule.alias
    passes = single and len(rule.expansion) == 1 and keep == [0]
    return Production(origin, len(rule.expansion), action, tuple(keep), single, passes)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def packed(text: str) -> str:
    """Return grammar.json for the grammar ``text``; a reduction by the production of number n is written ``~n``."""
    tables = make(text)
    numbers: dict[Production, int] = {}
    for row in tables.actions:
        for action in row.values():
            if isinstance(action, Production):
                numbers.setdefault(action, len(numbers))
    data = {
        "digest": _digest(text),
        "ends": tables.ends,
        "productions": [[one.origin, one.size, one.action, one.keep, one.single, one.passes] for one in numbers],
        "actions": [
            {kind: ~numbers[action] if isinstance(action, Production) else action for kind, action in row.items()}
            for row in tables.actions
        ],
        "gotos": tables.gotos,
    }
    return json.dumps(data, separators=(",", ":")) + "\n"


def _unpacked(data: dict[str, Any]) -> Grammar:
    productions = [
        Production(origin, size, action, tuple(keep), single, passes)
        for origin, size, action, keep, single, passes in data["productions"]
    ]
    actions = tuple(
        {kind: action if action >= 0 else productions[~action] for kind, action in row.items()}
        for row in data["actions"]
    )
    ends = {start: (first, last) for start, (first, last) in data["ends"].items()}
    return Grammar(actions, tuple(data["gotos"]), ends)


if __name__ == "__main__":
    _JSON.write_text(packed(_LARK.read_text("utf-8")), "utf-8")
