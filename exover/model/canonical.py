"""The identity of a spec: equal for texts that differ in blanks, comments, places and shorthand only."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from functools import cache

from exover.model.model import Model


def digest(model: Model) -> bytes:
    """Return the sha256 of a canonical text of the model; where a thing was declared is no part of it."""
    return hashlib.sha256(json.dumps(_plain(model), separators=(",", ":")).encode()).digest()


def _plain(value: object) -> object:
    """Return lists, numbers and strings that tell a value from every other one."""
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    if is_dataclass(value) and not isinstance(value, type):
        return [type(value).__name__, *[_plain(getattr(value, name)) for name in _compared(type(value))]]
    return value


@cache
def _compared(kind: type) -> tuple[str, ...]:
    """Return the names of the fields by which values of a dataclass are equal."""
    return tuple(field.name for field in fields(kind) if field.compare)
