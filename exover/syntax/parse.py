"""The parser: from a source to its tree, or to all its syntax errors."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from exover.diagnostics import Diagnostic, capped, quote
from exover.source import Source, Span
from exover.syntax.expect import nothing_there
from exover.syntax.grammar import Grammar, Start, grammar
from exover.syntax.lex import END, FOREIGN, MAX_MISTAKES, NAME, Token, tokens
from exover.syntax.machine import MAX_DEPTH, ParserState
from exover.syntax.recover import begin_anew, repair, too_deep
from exover.syntax.tree import (
    Clause,
    Context,
    Enum,
    Group,
    GroupName,
    Include,
    Interrupts,
    Item,
    Module,
    Name,
    Part,
    Properties,
    Request,
    Spec,
)

MAX_REPAIRS = 500
"""The number of syntax errors after which the rest of a text is not read: it is no spec, and repairs cost time."""
MAX_TOKENS = 500_000
"""The most tokens of a text: some seconds of parsing, and more than ten thousand rules."""


HEAD = (Token("spec", "spec", 0, 0), Token(NAME, "s", 0, 0), Token(";", ";", 0, 0))


class Parsed(NamedTuple):
    """The tree of a text, None iff it has mistakes; the mistakes in the order of the text; the number of tokens."""

    tree: Spec | Part | None
    mistakes: tuple[Diagnostic, ...]
    tokens: int


def parse(source: Source) -> tuple[Spec | None, tuple[Diagnostic, ...]]:
    """Return the tree of a spec and (), or None and its mistakes in the order of the text, at least one.

    There are at most MAX_REPORTS mistakes, and one more that counts the others. Never raises, for any text; the time is
    linear in its length.
    """
    tree, mistakes, _ = parse_file(source)
    if isinstance(tree, Part):
        message = f"{quote(source.name)} is a part: it is checked with a spec that includes it"
        return None, (Diagnostic("E009", message, tree.name.span),)
    return tree, mistakes


def parse_file(source: Source, before: int = 0) -> Parsed:
    """Return the tree or the mistakes of a spec or a part, as `parse`; `before`: the tokens read in other files."""
    reader = _Reader(source, grammar(), "file", before)
    tree = reader.read()
    reports = sorted(reader.reports, key=_place)
    if isinstance(tree, Spec | Part):
        reports = sorted(_misused_words(tree), key=_place)
        if not reports:
            return Parsed(tree, (), reader.count)
    return Parsed(None, capped(reports, reader.gave_up or len(reports) >= MAX_MISTAKES), reader.count)


def parse_items(source: Source) -> tuple[Item | Include, ...] | None:
    """Return the statements of a text without the head `spec NAME;`; None if there is any mistake."""
    machine = ParserState(grammar(), "file")
    reports: list[Diagnostic] = []
    for token in chain(HEAD, tokens(source.text, reports, base=source.base)):
        if not machine.feed(token) or reports or machine.too_deep():
            return None
    tree = machine.result()
    return tree.items if isinstance(tree, Spec) and not any(_misused_words(tree)) else None


def parse_properties(source: Source) -> tuple[Properties | None, tuple[Diagnostic, ...]]:
    """Return the tree of a properties file and (), or None and its mistakes; as `parse`."""
    reader = _Reader(source, grammar(), "properties")
    tree = reader.read()
    if isinstance(tree, Properties):
        return tree, ()
    reports = sorted(reader.reports, key=_place)
    return None, capped(reports, reader.gave_up or len(reports) >= MAX_MISTAKES)


def _place(diagnostic: Diagnostic) -> int:
    return diagnostic.span.start if diagnostic.span else 0


class _Reader:
    """The parse of one text, with error recovery."""

    def __init__(self, source: Source, tables: Grammar, start: Start, before: int = 0) -> None:
        self.reports: list[Diagnostic] = []
        self.gave_up = False
        self._tokens: Iterator[Token] = tokens(source.text, self.reports, start == "properties", source.base)
        self._base = source.base
        self._machine = ParserState(tables, start)
        self._before: Token | None = None
        self._here: Token | None = None
        self._ahead: list[Token] = []
        self.count = before
        self._repairs = 0
        # No report until a token is shifted: what follows a statement that was given up is most often part of it.
        self._quiet = False
        # Braces in strings and comments count too: this only helps to choose between repairs.
        self._unclosed = source.text.count("{") - source.text.count("}")

    def read(self) -> Spec | Part | Properties | None:
        """Return the tree; None iff there are mistakes."""
        token = self._advance()
        if token.kind == END and not self.reports:
            self.reports.append(nothing_there(self._machine.start, self._base))
            return None
        while not self.gave_up:
            if not self._machine.feed(token):
                token = self._mend(token)
            elif token.kind == END:
                return None if self.reports else self._machine.result()
            elif self._machine.too_deep():
                self._report(too_deep(token, MAX_DEPTH))
                token = self._give_up(token)
            else:
                self._quiet = False
                token = self._advance()
        return None

    def _advance(self) -> Token:
        """Return the next token."""
        self._before = self._here
        self._here = token = self._ahead.pop(0) if self._ahead else self._drawn(self._here)
        return token

    def _peek(self, distance: int) -> Token:
        """Return a token ahead of the present one; ``distance`` 0 is the next token."""
        while len(self._ahead) <= distance:
            self._ahead.append(self._drawn(self._ahead[-1] if self._ahead else self._here))
        return self._ahead[distance]

    def _drawn(self, last: Token | None) -> Token:
        """Return the token that follows ``last``; after `<end>` comes `<end>`, and a text of too many tokens is cut."""
        if last is not None and last.kind == END:
            return last
        token = next(self._tokens)
        self.count += token.kind != END
        if self.count <= MAX_TOKENS:
            return token
        self.gave_up = True
        if not self.reports:
            message = f"the file is too large: more than {MAX_TOKENS} words and symbols"
            self.reports.append(Diagnostic("E003", message, Span(token.start, token.end)))
        return Token(END, "", token.start, token.start)

    def _report(self, diagnostic: Diagnostic) -> None:
        if not self._quiet:
            self.reports.append(diagnostic)

    def _mend(self, token: Token) -> Token:
        """Report a syntax error at a token, repair it or give up the statement, and return the token to go on with."""
        self._repairs += 1
        self.gave_up = self.gave_up or self._repairs >= MAX_REPAIRS
        machine = self._machine
        machine.building = False
        plan = repair(machine, self._before, token, (self._peek(0), self._peek(1)), self._unclosed)
        # If the lexer has reported an error here, that of the parser is a consequence.
        if not token.tainted and not (self._before and self._before.tainted):
            self._report(plan.diagnostic)
        elif token.text in FOREIGN and plan.diagnostic.help:
            self._advise(token, plan.diagnostic.help)
        if not plan.insert and not plan.drop:
            return self._give_up(token)
        for inserted in plan.insert:
            machine.feed(inserted)
            self._unclosed -= inserted.text == "}"
        return self._advance() if plan.drop else token

    def _advise(self, token: Token, help: str) -> None:
        """Replace the help of the lexer's report on a token: the word that it advises is a syntax error here too."""
        span = Span(token.start, token.end)
        self.reports[:] = [replace(each, help=help) if each.span == span else each for each in self.reports]

    def _give_up(self, token: Token) -> Token:
        self._quiet = True
        return begin_anew(self._machine, self._before, token, self._advance)


def _misused_words(spec: Spec | Part) -> Iterator[Diagnostic]:
    """Yield the mistakes that the grammar accepts: a group called `all`, an enum `int`, `all` in a longer list."""
    for item in spec.items:
        match item:
            case Group(name=Name(text="all", span=span)):
                yield Diagnostic("E111", "no group may be called `all`", span)
            case Enum(name=Name(text="bool" | "int" | "real" as text, span=span)):
                yield Diagnostic("E110", f"`{text}` is the name of a type and cannot be that of an enum", span)
            case Context(clauses=clauses):
                yield from _misused_targets(clauses)
            case Module(members=members):
                for member in members:
                    if isinstance(member, Request):
                        yield from _misused_targets(member.clauses)


def _misused_targets(clauses: tuple[Clause, ...]) -> Iterator[Diagnostic]:
    for clause in clauses:
        if isinstance(clause, Interrupts) and len(clause.targets) > 1:
            for target in clause.targets:
                match target:
                    case GroupName(name=Name(text="all", span=span)):
                        yield Diagnostic("E111", "`all` stands alone: it is every other request of the module", span)
