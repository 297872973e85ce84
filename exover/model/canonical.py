"""The identity of a spec: equal for texts that differ in blanks, comments, places and shorthand only."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from exover.model.model import Model

TEXTS = frozenset({"because"})
"""Fields that answers tell, and that nothing is decided by."""


def digest(model: Model) -> bytes:
    """Return the sha256 of a canonical text of the model; where a thing was declared is no part of it."""
    return hashlib.sha256(json.dumps(_plain(model), separators=(",", ":")).encode()).digest()


def essence(value: Any) -> str:
    """Return a canonical text of a value of the model, which tells no places and none of the texts after `because`.

    Values of equal essence differ at most in these, and in what the fields hold that do not count for equality.
    """
    return json.dumps(_plain(value, TEXTS), separators=(",", ":"))


def _plain(value: Any, without: frozenset[str] = frozenset()) -> Any:
    """Return lists, numbers and strings that tell a value from every other one, but for fields of these names."""
    kind: Any = type(value)
    if kind is str or kind is int or value is None:
        return value
    if kind is tuple:
        return [_plain(part, without) for part in value]
    names = _compared(kind, without)
    if names is None:
        return value
    return [type(value).__name__, *[_plain(getattr(value, name), without) for name in names]]


@cache
def _compared(kind: type, without: frozenset[str]) -> tuple[str, ...] | None:
    """Return the names of the fields by which values of a dataclass are equal, but for some; None for what is none."""
    if not is_dataclass(kind):
        return None
    return tuple(field.name for field in fields(kind) if field.compare and field.name not in without)
