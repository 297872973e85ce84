"""The parse tables that lark's LALR(1) construction makes of grammar.lark, in the shape that machine.py walks."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from exover.syntax.lex import END, INT, NAME, NUMBER, STRING

_KINDS = {"NAME": NAME, "INT": INT, "NUM": NUMBER, "STRING": STRING, "$END": END}


@dataclass(frozen=True, slots=True)
class Production:
    """One way to make the symbol ``origin`` of ``size`` symbols.

    The node is ``action`` of the children that ``keep`` names by index; a negative index ``~i`` is the list of a
    repetition, put in flat, and None is a left-out optional part. ``action`` is "" for a repetition, whose value is the
    list itself. If ``single``, a lone child stands for itself.
    """

    origin: str
    size: int
    action: str
    keep: tuple[int | None, ...]
    single: bool


@dataclass(frozen=True, slots=True)
class Grammar:
    """``actions[state][kind]`` is the state to shift to or the production to reduce by; ``gotos[state][origin]``."""

    actions: tuple[dict[str, int | Production], ...]
    gotos: tuple[dict[str, int], ...]
    start: int
    accept: int


@cache
def grammar() -> Grammar:
    """Return the tables of the start rule `file`. Costs about 0.1 s, once a process."""
    from lark import Lark
    from lark.lexer import Lexer
    from lark.parsers.lalr_analysis import Shift

    class NoLexer(Lexer):
        """Spares lark the making of a lexer: lex.py is the lexer."""

        def __init__(self, _conf: object) -> None: ...

        def lex(self, _state: object, _parser: object) -> Any:
            return iter(())

    text = files("exover.syntax").joinpath("grammar.lark").read_text("utf-8")
    lark = Lark(text, parser="lalr", lexer=NoLexer, start="file", maybe_placeholders=True)
    conf = lark.parse_interactive("").parser_state.parse_conf
    kinds = {terminal.name: _KINDS.get(terminal.name, terminal.pattern.value) for terminal in lark.terminals}
    kinds["$END"] = END
    productions = {rule: _production(rule) for rule in lark.rules}
    actions: list[dict[str, int | Production]] = [{} for _ in conf.states]
    gotos: list[dict[str, int]] = [{} for _ in conf.states]
    for state, row in conf.states.items():
        for symbol, (action, target) in row.items():
            if symbol not in kinds:
                gotos[state][symbol] = target
            elif action is Shift:
                actions[state][kinds[symbol]] = target
            else:
                actions[state][kinds[symbol]] = productions[target]
    return Grammar(tuple(actions), tuple(gotos), conf.start_state, conf.end_state)


def _production(rule: Any) -> Production:
    """Return a rule of lark as a production; tokens written as text in the grammar carry nothing and are left out."""
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
    return Production(origin, len(rule.expansion), action, tuple(keep), options.expand1 and not rule.alias)
