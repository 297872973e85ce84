"""Reads single values out of an XCDR1 message without building the whole message as an object."""

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from rosbags.interfaces import Nodetype

from exover.gate.fields import MISSING, FieldPath, Located, UnreadableField
from exover.gate.ros2.cdr import ORDER

Fields = Callable[[str], Sequence[tuple[str, Any]]]
"""Returns the fields of a type, as `Interfaces.fields` does."""
Step = Callable[[bytes, int, list[Any]], int]
"""Reads a body from an offset, appends the values found to the list, and returns the next offset."""
_CODES = {"byte": "B", "octet": "B", "char": "B", "bool": "?", "float32": "f", "float64": "d"}
_CODES |= {
    f"{sign}int{bits}": code
    for bits, codes in ((8, "bB"), (16, "hH"), (32, "iI"), (64, "qQ"))
    for sign, code in zip(("", "u"), codes, strict=True)
}
_COUNT = struct.Struct(f"{ORDER}I")
_WIDEST = 8


class Picked(Located):
    """The values of a message at the paths that were picked."""

    def __init__(self, found: Mapping[FieldPath, Any]) -> None:
        self._found = found

    def at(self, path: FieldPath) -> Any:
        """Return the value at a picked path, or `MISSING`."""
        return self._found.get(path, MISSING)


class Picker:
    """Reads the values at some paths of messages of a type; walks the whole message, so a malformed one is unreadable.

    Raises `LookupError` if the type has lists of texts or messages, or no single value at a path.
    """

    def __init__(self, fields: Fields, name: str, paths: Iterable[FieldPath]) -> None:
        plan = _Plan(frozenset(paths))
        for path, kind in _leaves(fields, name):
            plan.add(path, kind)
        plan.close()
        if len(plan.order) < len(plan.wanted):
            raise LookupError(name)
        self._name, self._steps, self._order = name, plan.steps, plan.order

    def __call__(self, body: bytes) -> Picked:
        """Return the values at the paths of a message body. Raises `UnreadableField`."""
        at, found = 0, list[Any]()
        try:
            for step in self._steps:
                at = step(body, at, found)
        except (struct.error, ValueError) as error:
            raise UnreadableField(f"{self._name}: {error}") from error
        if at + 3 < len(body):
            raise UnreadableField(f"{self._name}: {len(body) - at} bytes are too many")
        return Picked(dict(zip(self._order, found, strict=True)))


def _leaves(fields: Fields, name: str, path: FieldPath = ()) -> Iterator[tuple[FieldPath, Any]]:
    for key, kind in fields(name):
        node, argument = kind
        if node == Nodetype.NAME:
            yield from _leaves(fields, argument, (*path, key))
        else:
            yield (*path, key), kind


class _Plan:
    """Builds the steps that read a message. Adjacent numbers whose padding is known are read in one step."""

    def __init__(self, wanted: frozenset[FieldPath]) -> None:
        self.wanted = wanted
        self.steps: list[Step] = []
        self.order: list[FieldPath] = []
        """The wanted paths in the order of the message."""
        self._open = ORDER
        """The `struct` format of the open step: numbers that are no step yet."""
        self._align = self._known = _WIDEST
        """The alignment in bytes of the open step, and the alignment that its start is known to have."""

    def add(self, path: FieldPath, kind: Any) -> None:
        match kind:
            case Nodetype.BASE, ("string", _):
                self.close()
                self.steps.append(_string(self._takes(path)))
            case Nodetype.BASE, (base, _):
                self._number(_CODES[base], self._takes(path))
            case Nodetype.ARRAY, ((Nodetype.BASE, (base, _)), length):
                self._number(_CODES[base], False, length)
            case Nodetype.SEQUENCE, ((Nodetype.BASE, (base, _)), _):
                self.close()
                self.steps.append(_sequence(struct.calcsize(_CODES[base])))
            case _:
                raise LookupError(kind)

    def _takes(self, path: FieldPath) -> bool:
        if path in self.wanted:
            self.order.append(path)
        return path in self.wanted

    def _number(self, code: str, wanted: bool, count: int = 1) -> None:
        size = struct.calcsize(code)
        if size > self._known:
            self.close(size)
        padding = -struct.calcsize(self._open) % size
        self._open += f"{padding}x" + (code if wanted else f"{count * size}x")

    def close(self, known: int = 1) -> None:
        """End the open step; the next one is aligned to `known` bytes."""
        if len(self._open) > len(ORDER):
            self.steps.append(_numbers(self._align, struct.Struct(self._open)))
        self._open, self._align, self._known = ORDER, known, known


def _numbers(align: int, layout: struct.Struct) -> Step:
    def step(body: bytes, at: int, found: list[Any]) -> int:
        at = (at + align - 1) & -align
        found += layout.unpack_from(body, at)
        return at + layout.size

    return step


def _string(wanted: bool) -> Step:
    def step(body: bytes, at: int, found: list[Any]) -> int:
        at = ((at + 3) & -4) + _COUNT.size
        length: int = _COUNT.unpack_from(body, at - _COUNT.size)[0]
        end = at + length
        if not length or end > len(body) or body[end - 1]:
            raise ValueError(f"a text of {length} bytes does not end")
        text = str(body[at : end - 1], "utf-8")
        if wanted:
            found.append(text)
        return end

    return step


def _sequence(size: int) -> Step:
    def step(body: bytes, at: int, found: list[Any]) -> int:
        at = (at + 3) & -4
        count: int = _COUNT.unpack_from(body, at)[0]
        at += _COUNT.size
        end = ((at + size - 1) & -size) + count * size if count else at
        if end > len(body):
            raise ValueError(f"{count} numbers are too many")
        return end

    return step
