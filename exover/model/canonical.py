"""The identity of a spec: equal for texts that differ in blanks, comments, places and shorthand only."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from exover.model.model import Model


def digest(model: Model) -> bytes:
    """Return the sha256 of a canonical text of the model; where a thing was declared is no part of it."""
    return hashlib.sha256(json.dumps(_plain(model), separators=(",", ":")).encode()).digest()


def _plain(value: Any) -> Any:
    """Return lists, numbers and strings that tell a value from every other one."""
    kind: Any = type(value)
    if kind is str or kind is int or value is None:
        return value
    if kind is tuple:
        return [_plain(part) for part in value]
    names = _compared(kind)
    return value if names is None else [type(value).__name__, *[_plain(getattr(value, name)) for name in names]]


@cache
def _compared(kind: type) -> tuple[str, ...] | None:
    """Return the names of the fields by which values of a dataclass are equal; None for what is no dataclass."""
    return tuple(field.name for field in fields(kind) if field.compare) if is_dataclass(kind) else None
