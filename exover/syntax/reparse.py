"""Incremental parsing: the tree of a changed text from its previous tree (Ghezzi, Mandrioli 1979), by statements.

Statements before the change are reused as they are, those after it with their spans moved; the text between is parsed.
"""

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import takewhile
from typing import Any, NamedTuple

from exover.diagnostics import Diagnostic
from exover.source import Source, Span
from exover.syntax.parse import MAX_TOKENS, parse, parse_items
from exover.syntax.tree import Include, Item, Spec


class SpecTree(NamedTuple):
    """A text without mistakes, and its tree."""

    source: Source
    tree: Spec


def reparse(source: Source, before: SpecTree | None) -> tuple[Spec | None, tuple[Diagnostic, ...]]:
    """Return the result of `parse`, mostly faster, by reuse of the tree of the text before the change."""
    found = _from(source, before) if before and len(source.text) < MAX_TOKENS and "\0" not in source.text else None
    return parse(source) if found is None else (found, ())


def _from(source: Source, before: SpecTree) -> Spec | None:
    """Return the tree; None if the change is not within statements, or has a mistake."""
    old, new = before.source.text, source.text
    first = _common(old, new)
    last = len(old) - _common(old[first:][::-1], new[first:][::-1])
    moved = len(new) - len(old)
    items, base = before.tree.items, source.base
    if base != before.source.base or not items or first < items[0].span.start - base:
        return None
    above = tuple(takewhile(lambda item: item.span.end - base <= first, items))
    below = tuple(item for item in items[len(above) :] if item.span.start - base >= last)
    # The first statement below is parsed again: it shows that the parsed text ends where it did before.
    start = above[-1].span.end if above else items[0].span.start
    end = below[0].span.end + moved if below else source.end
    between = parse_items(Source(source.name, new[start - base : end - base], start))
    if between is None or (below and (not between or between[-1].span.end != end)):
        return None
    rest = below[1:] if moved == 0 else tuple(_moved(item, moved) for item in below[1:])
    together: tuple[Item | Include, ...] = (*above, *between, *rest)
    if not together:
        return None
    return replace(before.tree, items=together, span=Span(before.tree.span.start, together[-1].span.end))


def _common(one: str, other: str) -> int:
    """Return the length of the longest common prefix of two texts."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _moved(value: Any, by: int) -> Any:
    """Return a node with all spans moved by so many characters."""
    kind: Any = type(value)
    if kind is Span:
        return Span(value[0] + by, value[1] + by)
    if kind is tuple:
        return tuple([_moved(part, by) for part in value])
    mover = _mover(kind)
    return value if mover is None else mover(value, by)


@cache
def _mover(kind: type) -> Callable[[Any, int], Any] | None:
    """Return the function that moves nodes of a dataclass; None for another class, whose values have no spans."""
    if not is_dataclass(kind):
        return None
    names = [field.name for field in fields(kind)]
    return lambda node, by: kind(*[_moved(getattr(node, name), by) for name in names])
