"""The canonical layout of a text: the same tokens and comments in the same order, with new blanks and line ends.

Only blanks change, so the meaning stays; the result is scanned again to check that.
"""

from collections.abc import Iterable, Iterator

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.source import Source
from exover.syntax.conditions import PREDICATES, STEPS
from exover.syntax.grammar import Start
from exover.syntax.lex import END, INT, NAME, NUMBER, tokens
from exover.syntax.lexemes import Comment, Lexeme, lexemes
from exover.syntax.parse import parse_file, parse_properties

WIDTH = 100
"""The columns of a line; only a part that cannot be broken may be longer."""
INDENT = 4
_HEADS = frozenset({"spec", "part", "for"})
_BLOCKS = frozenset({"module", "context", "request"})
_LEFT_TIGHT = frozenset({",", ";", ")", ":", "."})
_RIGHT_TIGHT = frozenset({"(", ".", "!"})
_CALLED = PREDICATES | STEPS | {NAME}
"""Kinds of token after which a `(` opens arguments."""
_OPERANDS = _CALLED | {INT, NUMBER, ")"}
"""Kinds of token after which a `-` is subtraction; elsewhere it is a sign."""
_OPEN, _CLOSE = frozenset({"(", "[", "{"}), frozenset({")", "]", "}"})
_BREAKS = frozenset(
    {"returns", "fails", "instances", "over", "by", "else", "because", "when", "until", "precedes", "leads"}
    | {"and", "or", "implies", "&", "|", "->", "<->"}
)
"""Kinds of token before which a line may be broken; it may also be broken after a `,` and the head of a property."""


class Altered(Exception):
    """The result has other tokens or comments than the text: a fault of this module, never of the text."""


def formatted(source: Source) -> tuple[str | None, tuple[Diagnostic, ...]]:
    """Return a spec, part or properties file in the canonical layout and (), or None and its mistakes."""
    start = start_of(source)
    found, mistakes = parse_file(source)[:2] if start == "file" else parse_properties(source)
    return (None, mistakes) if found is None else (laid_out(source.text, start), ())


def start_of(source: Source) -> Start:
    """Return the start symbol of a text: by the suffix of its file name, else by its first token."""
    if source.name.endswith((".exo", ".prop")):
        return "properties" if source.name.endswith(".prop") else "file"
    return "properties" if next(tokens(source.text, [])).text == "for" else "file"


def laid_out(text: str, start: Start) -> str:
    """Return a text without mistakes in the canonical layout, with a newline at its end.

    Raises `Altered` if the result has not the same tokens and comments.
    """
    found = list(lexemes(text.replace("\r\n", "\n"), start))
    lines = _Lines()
    for statement in _statements(found):
        lines.add(statement)
    result = "\n".join(lines.done) + "\n"
    if _content(lexemes(result, start)) != _content(found):
        raise Altered("the layout of the text is another text")
    return result


def _content(found: Iterable[Lexeme]) -> list[tuple[str, str, tuple[str, ...]]]:
    return [(each.kind, each.text, tuple(comment.text for comment in each.comments)) for each in found]


@dataclass(slots=True)
class _Statement:
    """The tokens of one statement, on one line or several; `depth`: the number of blocks around it."""

    depth: int
    parts: list[Lexeme]

    @property
    def opens(self) -> bool:
        """Whether it begins a block."""
        return self.parts[-1].kind == "{"

    @property
    def closes(self) -> bool:
        """Whether it ends a block."""
        return self.parts[0].kind in ("}", END)


def _statements(found: list[Lexeme]) -> Iterator[_Statement]:
    """Yield what begins a new line: statements, heads of blocks, closing braces, and last the end of the text."""
    depth = lists = 0
    parts: list[Lexeme] = []
    for number, lexeme in enumerate(found):
        block = lexeme.kind == "}" and not parts
        parts.append(lexeme)
        if block:
            depth -= 1
        elif lexeme.kind == "{" and not _is_block(parts):
            lists += 1
        elif lexeme.kind == "}":
            lists -= 1
        enum = lexeme.kind == "}" and parts[0].kind == "enum" and found[number + 1].kind != ";"
        if block or enum or lexeme.kind in (";", END) or (lexeme.kind == "{" and not lists):
            statement = _Statement(depth, parts)
            depth += statement.opens
            parts = []
            yield statement


def _is_block(parts: list[Lexeme]) -> bool:
    """Return whether the last token, a `{`, opens a block, not a list of values."""
    return parts[0].kind in _BLOCKS and parts[-2].kind not in (":", "in")


class _Lines:
    """The lines so far."""

    def __init__(self) -> None:
        self.done: list[str] = []
        self._before: _Statement | None = None

    def add(self, statement: _Statement) -> None:
        """Add the comments before a statement, and the statement."""
        first, before = statement.parts[0], self._before
        comments = list(first.comments)
        while before is not None and comments and comments[0].newlines == 0:
            self.done[-1] += " " + comments.pop(0).text
        if before is not None and before.opens and first.kind == "}" and not first.comments:
            self.done[-1] += "}"
        else:
            self._set(statement, comments)
        self._before = statement

    def _set(self, statement: _Statement, comments: list[Comment]) -> None:
        first = statement.parts[0]
        gaps = self._gaps(statement, [comment.newlines for comment in comments] + [first.newlines])
        indent = " " * (INDENT * (statement.depth + (first.kind == "}")))
        for number, (gap, comment) in enumerate(zip(gaps, comments, strict=False)):
            if number and comment.newlines == 0:
                self.done[-1] += " " + comment.text
            else:
                self.done += [""] * gap + [indent + comment.text]
        if first.kind != END:
            self.done += [""] * gaps[-1] + _broken(statement)

    def _gaps(self, statement: _Statement, newlines: list[int]) -> list[bool]:
        """Return whether an empty line comes before each comment of a statement and, last, before the statement."""
        gaps = [number > 1 for number in newlines]
        if statement.closes:
            gaps[-1] = False
        if self._before is None or self._before.opens:
            gaps[0] = False
        elif _apart(self._before, statement) and not any(gaps):
            gaps[0] = True
        return gaps


def _apart(before: _Statement, statement: _Statement) -> bool:
    """Return whether an empty line is forced between two statements: around top-level blocks and after the head."""
    if before.depth or statement.depth or statement.closes:
        return False
    return before.parts[0].kind in _HEADS | {"}"} or statement.parts[0].kind in _BLOCKS


# ---- one statement ----


@dataclass(slots=True)
class _Unit:
    """A text that is not broken; `level`: the number of open brackets before it.

    `space`: a blank separates it from what is before it on a line; `new`: it must begin a line.
    """

    text: str
    level: int
    space: bool = False
    new: bool = False


def _broken(statement: _Statement) -> list[str]:
    """Return the lines of a statement."""
    indent = " " * (INDENT * statement.depth)
    lines = [indent]
    _fill(lines, indent + " " * (2 * INDENT if statement.opens else INDENT), _units(statement.parts))
    return lines


def _fill(lines: list[str], indent: str, units: list[_Unit]) -> None:
    """Append units to the last line, and to further lines, broken where the fewest brackets are open."""
    level = min((unit.level for unit in units[1:] if not unit.new), default=0)
    groups: list[list[_Unit]] = []
    for unit in units:
        if not groups or unit.new or unit.level == level:
            groups.append([unit])
        else:
            groups[-1].append(unit)
    for number, group in enumerate(groups):
        longer = lines[-1] + _joined(group, number > 0)
        if group[0].new:
            lines.append(indent + _joined(group, False))
        elif number and len(longer) > WIDTH:
            lines.append(indent)
            _put(lines, indent, group)
        elif len(longer) > WIDTH and len(group) > 1:
            _fill(lines, indent, group)
        else:
            lines[-1] = longer


def _put(lines: list[str], indent: str, group: list[_Unit]) -> None:
    """Append a group to an empty line."""
    if len(indent) + len(_joined(group, False)) > WIDTH and len(group) > 1:
        _fill(lines, indent, group)
    else:
        lines[-1] += _joined(group, False)


def _joined(units: list[_Unit], follows: bool) -> str:
    """Return units on one line; `follows`: the line has something before them."""
    text = "".join(" " * unit.space + unit.text for unit in units)
    return text if follows else text.removeprefix(" ")


def _units(parts: list[Lexeme]) -> list[_Unit]:
    """Return the units of a statement: a line may be broken between them, and must be after a `//` comment."""
    units = [_Unit(parts[0].text, 0)]
    level = 0
    for number, lexeme in enumerate(parts[1:], 1):
        before = parts[number - 1].kind
        level += (before in _OPEN) - (lexeme.kind in _CLOSE)
        new = False
        for comment in lexeme.comments:
            if comment.newlines or new:
                units.append(_Unit(comment.text, level, True, True))
            else:
                units[-1].text += " " + comment.text
            new = comment.ends_line
        space = _spaced(parts, number) or (bool(lexeme.comments) and lexeme.kind not in _LEFT_TIGHT)
        if new or lexeme.kind in _BREAKS or before == "," or (before == ":" and parts[0].kind == "property"):
            units.append(_Unit(lexeme.text, level, space, new))
        else:
            units[-1].text += " " * space + lexeme.text
    return units


def _spaced(parts: list[Lexeme], number: int) -> bool:
    """Return whether a blank comes before this token of a statement."""
    before, here = parts[number - 1].kind, parts[number].kind
    if here in _LEFT_TIGHT or before in _RIGHT_TIGHT:
        return False
    if here == "(":
        return before not in _CALLED
    if before == "-":
        return number > 1 and parts[number - 2].kind in _OPERANDS
    if before == "{" or here == "}":
        return parts[0].kind == "enum"
    return True
