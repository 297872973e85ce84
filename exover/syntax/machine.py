"""The LALR(1) automaton: stacks, shifts and reductions over the tables of grammar.py.

It is the loop of lark with three additions that error recovery and large files need: spans of nodes, a bound on
nesting, and trial parses of some tokens that leave the stacks unchanged (`after`).
"""

from collections.abc import Iterable, Sequence
from typing import Any

from exover.source import Span
from exover.syntax.build import ACTIONS, VALUES
from exover.syntax.grammar import Grammar, Production, Start
from exover.syntax.lex import END, NAME, Token
from exover.syntax.properties import BINARY, UNARY
from exover.syntax.tree import Part, Properties, Spec

MAX_DEPTH = 64
"""The most levels of brackets, `not`, `implies` and temporal operators. A level adds at most three nodes to the height
of the tree, so a recursive pass with four Python frames a node stays within the default limit of 1000."""

_OPENING = ("(", "{", "[", "not", "!", "implies", "->", "<->", *UNARY, *BINARY)
_LEVELS = dict.fromkeys(_OPENING, 1) | dict.fromkeys(")}]", -1)
"""How many levels a token opens, -1 if it closes one: closed brackets, as of parameters, may still be on the stack."""


class ParserState:
    """The state of a parse. The stacks ``states`` and ``depths`` are one longer than ``values`` and ``starts``.

    ``values``: the nodes, or None and tokens once ``building`` is off; ``starts``: the offset of each symbol;
    ``depths``: the number of open levels up to and including each symbol.
    """

    def __init__(self, grammar: Grammar, start: Start) -> None:
        self.grammar = grammar
        self.start = start
        first, self._accept = grammar.ends[start]
        self.states: list[int] = [first]
        self.values: list[Any] = []
        self.starts: list[int] = []
        self.depths: list[int] = [0]
        self.end = 0
        self.building = True

    def kind(self, token: Token) -> str:
        """Return the kind of a token in this state: the keyword, if that has an action here, else that of lex.py."""
        return _kind(self.grammar.actions[self.states[-1]], token)

    def feed(self, token: Token) -> bool:
        """Shift the token, after the reductions before it, and return True; return False if it is a syntax error.

        Reductions that the tables make before they detect the error (LALR) stay made.
        """
        actions, gotos, states = self.grammar.actions, self.grammar.gotos, self.states
        kind = _kind(actions[states[-1]], token)
        while True:
            action = actions[states[-1]].get(kind)
            if action is None:
                return False
            if isinstance(action, int):
                states.append(action)
                make = VALUES.get(kind)
                self.values.append(make(token) if make is not None and self.building else token)
                self.starts.append(token.start)
                self.depths.append(self.depths[-1] + _LEVELS.get(kind, 0))
                self.end = token.end
                return True
            if action.passes:
                # More than half of all reductions: the levels of precedence above a lone name.
                states[-1] = gotos[states[-2]][action.origin]
            else:
                self._reduce(action, token.start)
            if kind == END and states[-1] == self._accept:
                return True

    def _reduce(self, production: Production, next_start: int) -> None:
        size, states, values, starts, depths = production.size, self.states, self.values, self.starts, self.depths
        children: list[Any] = []
        if size:
            next_start, children = starts[-size], values[-size:]
            del states[-size:], values[-size:], starts[-size:], depths[-size:]
        states.append(self.grammar.gotos[states[-1]][production.origin])
        values.append(self._node(production, children, next_start) if self.building else None)
        starts.append(next_start)
        depths.append(depths[-1])

    def _node(self, production: Production, children: list[Any], start: int) -> Any:
        action, end = production.action, self.end
        if not action:
            return _repetition(production, children)
        parts: list[Any] = []
        for index in production.keep:
            if index is None:
                parts.append(None)
            elif index < 0:
                parts += children[~index]
            else:
                parts.append(children[index])
        if production.single and len(parts) == 1:
            return parts[0]
        return ACTIONS[action](*parts, Span(start, end if end > start else start))

    def result(self) -> Spec | Part | Properties:
        """Return the tree of a text whose `<end>` was accepted while building."""
        tree = self.values[-1]
        assert isinstance(tree, Spec | Part | Properties)
        return tree

    def too_deep(self) -> bool:
        """Return True iff more than MAX_DEPTH levels are open."""
        return self.depths[-1] > MAX_DEPTH

    def after(self, tokens: Iterable[Token], states: Sequence[int] | None = None) -> list[int] | None:
        """Return the stack of states after ``tokens``, from ``states`` (default: the present); None at an error."""
        stack = list(self.states if states is None else states)
        actions, gotos = self.grammar.actions, self.grammar.gotos
        for token in tokens:
            kind = _kind(actions[stack[-1]], token)
            while True:
                action = actions[stack[-1]].get(kind)
                if action is None:
                    return None
                if isinstance(action, int):
                    stack.append(action)
                    break
                if action.size:
                    del stack[-action.size :]
                stack.append(gotos[stack[-1]][action.origin])
                if kind == END and stack[-1] == self._accept:
                    break
        return stack

    def expected(self) -> frozenset[str]:
        """Return the kinds of token that can come next without a syntax error."""
        here = self.grammar.actions[self.states[-1]]
        return frozenset(kind for kind in here if self.after([Token(kind, kind, 0, 0)]) is not None)

    def cut(self, height: int) -> None:
        """Pop all symbols but the lowest ``height``, and build no nodes from now on."""
        del self.states[height + 1 :], self.values[height:], self.starts[height:], self.depths[height + 1 :]
        self.building = False


def _kind(actions: dict[str, int | Production], token: Token) -> str:
    return token.text if token.kind == NAME and token.text in actions else token.kind


def _repetition(production: Production, children: list[Any]) -> list[Any]:
    """Return the list of a repetition; the list of its first child is extended in place, so the cost is linear."""
    out: list[Any] = []
    for index in production.keep:
        assert index is not None
        if index < 0:
            out = children[~index]
        else:
            out.append(children[index])
    return out
