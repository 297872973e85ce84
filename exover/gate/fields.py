"""Fields: where an outer object holds the values of a spec, and how these are scaled (docs/binding.md)."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import field
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal
from typing import Any

from exover.dataclass import dataclass
from exover.model.types import Bool, Enum, Int, Real, Type, Value, contains

FieldPath = tuple[str, ...]
"""Keys, and indices of elements as text, from the top of an object."""

CLOSE = 1e-9
"""How far a scaled number may be from a whole number, relative to its size, to be read as an int."""
ROUNDING = 1e-12
"""How far a number that is scaled back may be from a whole number, relative to its size, to be that one."""
LARGE = 10**16
"""The least whole number that is not written as an int."""
BOOLS = frozenset({"true", "false"})
DECIMAL = Context(prec=50, Emin=MIN_EMIN, Emax=MAX_EMAX, traps=[])
"""How numbers are scaled: as they are written, in digits, so that 57 × 0.01 is the double that 0.57 is."""


class Located:
    """An object with its own look-up of paths, which is faster than going key by key."""

    def at(self, path: "FieldPath") -> Any:
        """Return the value at a path, or `MISSING`."""
        raise NotImplementedError


class Missing:
    """The type of `MISSING`, which stands for a value that is not there."""


MISSING = Missing()


class UnreadableField(Exception):
    """A field is missing or has another type; the text says which field."""


@dataclass(frozen=True, slots=True)
class ValueField:
    """Where a parameter, result or poster is read: inner = scale × outer + offset; `values`: from outer to inner."""

    name: str
    type: Type
    path: FieldPath
    scale: Decimal = Decimal(1)
    offset: Decimal = Decimal(0)
    values: Mapping[Any, Value] = field(default_factory=dict)
    default: Any = MISSING

    def read(self, outer: Any) -> Any:
        """Return the inner value, as an event holds it; raises `UnreadableField`.

        It need not have the type of the field, nor be in its range: the reader of the event checks that.
        """
        found = select(outer, self.path)
        if isinstance(found, Missing):
            found = self.default
        if isinstance(found, Missing):
            raise UnreadableField(f"`{'.'.join(self.path)}` is missing")
        if self.values:
            return self._named(found)
        if (self.scale != 1 or self.offset) and isinstance(self.type, Int | Real):
            return self._scaled(found)
        return found

    def _named(self, found: Any) -> Value:
        key = str(found).lower() if isinstance(found, bool) else found
        if isinstance(key, str) and key in self.values:
            return self.values[key]
        known = ", ".join(f"`{each}`" for each in self.values)
        raise UnreadableField(f"`{'.'.join(self.path)}` is none of {known}")

    def _scaled(self, found: Any) -> int | float:
        if isinstance(found, bool) or not isinstance(found, int | float):
            raise UnreadableField(f"`{'.'.join(self.path)}` is no number")
        inner = DECIMAL.fma(self.scale, decimal(found), self.offset)
        if isinstance(self.type, Real) or not inner.is_finite():
            return float(inner)
        whole = inner.to_integral_value(context=DECIMAL)
        if abs(float(DECIMAL.subtract(inner, whole))) > CLOSE * max(1.0, abs(float(inner))):
            raise UnreadableField(f"`{'.'.join(self.path)}` is no whole number once it is scaled: {float(inner):g}")
        return int(whole)

    def write(self, value: Value) -> Any:
        """Return the outer value of an inner one, the inverse of `read`: whole numbers as int, `MISSING` if none is."""
        if self.values:
            return self._outer_name(value)
        if not isinstance(self.type, Int | Real):
            return value
        if self.scale == 1 and not self.offset:
            return _whole(value, 0.0)
        return _whole(self._outer(value), ROUNDING)

    def _outer(self, value: Any) -> int | float:
        outer = DECIMAL.divide(DECIMAL.subtract(decimal(value), self.offset), self.scale)
        is_int = isinstance(self.type, Int) and outer == outer.to_integral_value(context=DECIMAL)
        return int(outer) if is_int and math.isfinite(float(outer)) else float(outer)

    def _outer_name(self, value: Value) -> Any:
        found = next((outer for outer, inner in self.values.items() if inner == value), MISSING)
        return found == "true" if self.values.keys() <= BOOLS and found in BOOLS else found


def decimal(number: int | float) -> Decimal:
    """Return a number, exactly an int, and of a float what its shortest text says."""
    return Decimal(number if isinstance(number, int) else float.__repr__(number))


def _whole(number: Any, near: float) -> Any:
    """Return a number as an int if it is whole, or so near to that, relative to its size; else as it is."""
    if not math.isfinite(number) or abs(number) >= LARGE or not math.isclose(number, round(number), rel_tol=near):
        return number
    return round(number)


def is_value(kind: Type, inner: Any) -> bool:
    """Return whether a value that a field has read is one of this type, as the reader of events decides it."""
    if isinstance(kind, Bool | Enum):
        return isinstance(inner, bool if isinstance(kind, Bool) else str) and contains(kind, inner)
    if isinstance(inner, bool) or not isinstance(inner, int | float):
        return False
    if isinstance(inner, float) and not math.isfinite(inner):
        return False
    return (
        contains(kind, float(inner)) if isinstance(kind, Real) else inner == int(inner) and contains(kind, int(inner))
    )


def path_of(text: str) -> FieldPath:
    """Return the path that a text of keys joined by dots names."""
    return tuple(text.split("."))


def select(outer: Any, path: FieldPath) -> Any:
    """Return the value at a path of an object, or `MISSING`."""
    if isinstance(outer, Located):
        return outer.at(path)
    return walk(outer, path)


def walk(outer: Any, path: FieldPath) -> Any:
    """Return the value at a path, looked up key by key, or `MISSING`."""
    for key in path:
        if isinstance(outer, Mapping) and key in outer:
            outer = outer[key]
        elif isinstance(outer, Sequence) and not isinstance(outer, str) and key.isdecimal() and int(key) < len(outer):
            outer = outer[int(key)]
        else:
            return MISSING
    return outer


def same(found: Any, wanted: Any) -> bool:
    """Return whether two JSON values are equal; true is not 1."""
    return isinstance(found, bool) == isinstance(wanted, bool) and bool(found == wanted)


def place(outer: dict[str, Any], path: FieldPath, value: Any) -> None:
    """Put a value at a path of an object; missing objects on the path are made, lists as objects of 0, 1, …."""
    *way, last = path
    for key in way:
        outer = outer.setdefault(key, {})
    outer[last] = value


def with_lists(found: Any) -> Any:
    """Return a value in which objects whose keys are 0, 1, … are lists."""
    if not isinstance(found, dict):
        return found
    inner = {key: with_lists(value) for key, value in found.items()}
    return [inner[key] for key in indices(len(inner))] if inner and is_list(inner) else inner


def is_list(keys: Collection[str]) -> bool:
    """Return whether these are the keys of all elements of a list."""
    return all(key in keys for key in indices(len(keys)))


def indices(length: int) -> Iterable[str]:
    """Return the keys of the elements of a list."""
    return map(str, range(length))
