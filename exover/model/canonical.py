"""A digest of a model: equal for texts that differ only in blanks, comments, places and shorthand."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from exover.model.model import Model

TEXTS = frozenset({"because"})
"""Names of fields that appear in answers but influence no decision."""


def digest(model: Model) -> bytes:
    """Return the SHA-256 of a canonical text of the model, without the places of the declarations."""
    return hashlib.sha256(json.dumps(_plain(model), separators=(",", ":")).encode()).digest()


def essence(value: Any) -> str:
    """Return a canonical text of a value of the model, without places and without the texts after `because`.

    Values of equal essence differ at most in their `because` texts and in fields that equality does not compare.
    """
    return json.dumps(_plain(value, TEXTS), separators=(",", ":"))


def _plain(value: Any, without: frozenset[str] = frozenset()) -> Any:
    """Return a value as nested lists, numbers and strings, without the fields named in `without`.

    Values that differ in a compared field that is kept have different results.
    """
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
    """Return the fields of a dataclass that equality compares, less those of `without`; None for any other class."""
    if not is_dataclass(kind):
        return None
    return tuple(field.name for field in fields(kind) if field.compare and field.name not in without)
