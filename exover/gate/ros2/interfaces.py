"""ROS 2 types by name: loads their definitions, reads and writes their messages; needs `rosbags`."""

import struct
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cache, partial
from operator import attrgetter
from typing import Any

import numpy
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from exover.gate.fields import FieldPath, Located, UnreadableField, walk
from exover.gate.ros2.cdr import ENCAPSULATION
from exover.gate.ros2.picking import Picker
from exover.imports.ros import RULER

Find = Callable[[str], str | None]
"""Returns the definition of a type `package/kind/Name` as text; None if there is none."""
PARTS = {"action": ("Goal", "Result", "Feedback"), "srv": ("Request", "Response")}
FILLER = ("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))
"""The field that ROS 2 adds to a message without fields."""
_DERIVED = """
unique_identifier_msgs/UUID goal_id
{name}_Goal goal
---
bool accepted
builtin_interfaces/Time stamp
---
unique_identifier_msgs/UUID goal_id
---
int8 status
{name}_Result result
---
unique_identifier_msgs/UUID goal_id
{name}_Feedback feedback
"""
_DERIVED_NAMES = (
    "SendGoal_Request",
    "SendGoal_Response",
    "GetResult_Request",
    "GetResult_Response",
    "FeedbackMessage",
)
_CANCEL = """action_msgs/GoalInfo goal_info
---
int8 return_code
action_msgs/GoalInfo[] goals_canceling
"""
CANCEL = "action_msgs/srv/CancelGoal"


class UnknownType(Exception):
    """A type is not found, or its definition cannot be used; the text says which type."""


_PLAIN = (float, int, str, bool)


class Seen(Mapping[str, Any], Located):
    """A read-only mapping over a message: field by name, with lists and nested messages wrapped on demand."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getitem__(self, key: str) -> Any:
        if key not in _names(self._message.__class__):
            raise KeyError(key)
        found = getattr(self._message, key)
        if found.__class__ in _PLAIN:
            return found
        if isinstance(found, numpy.ndarray):
            return found.tolist()
        if isinstance(found, list):
            return [Seen(each) if hasattr(each, "__dataclass_fields__") else each for each in found]
        return Seen(found)

    def at(self, path: FieldPath) -> Any:
        """Return the value at a path, or `MISSING`."""
        try:
            found = _getter(path)(self._message)
        except (AttributeError, TypeError):  # it is missing, or inside a list
            return walk(self, path)
        return found if found.__class__ in _PLAIN else walk(self, path)

    def __contains__(self, key: object) -> bool:
        return key in _names(self._message.__class__)

    def __iter__(self) -> Iterator[str]:
        return iter(_names(self._message.__class__))

    def __len__(self) -> int:
        return len(_names(self._message.__class__))


@cache
def _getter(path: FieldPath) -> Callable[[Any], Any]:
    return attrgetter(".".join(path))


@cache
def _names(type_: type) -> Mapping[str, None]:
    """Return the field names of a message type, without its constants, as the keys of a mapping."""
    return dict.fromkeys(each.name for each in fields(type_) if "ClassVar" not in str(each.type))


class Interfaces:
    """The types that were loaded, with all types that they contain; `find` gives their definitions."""

    def __init__(self, find: Find) -> None:
        self._find = find
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._sections(CANCEL, _CANCEL, PARTS["srv"])  # the cancel service, which all actions share

    # ---- which types there are ----

    def load(self, name: str) -> None:
        """Load a type `package/kind/Name` and all types that it contains. Raises `UnknownType`."""
        kind = name.split("/")[1]
        if kind == "msg":
            self._message(name, ())
        elif f"{name}_{PARTS[kind][0]}" not in self._store.fielddefs:
            self._sections(name, self._text(name), PARTS[kind])
            if kind == "action":
                texts = _DERIVED.format(name=name.split("/")[2]).split("---\n")
                for part, text in zip(_DERIVED_NAMES, texts, strict=True):
                    self._define(f"{name}_{part}", text, ())

    def _text(self, name: str) -> str:
        text = self._find(name)
        if text is None:
            raise UnknownType(f"the type {name} is found nowhere: say by --interfaces where its package is")
        return text.replace("\r\n", "\n")

    def _sections(self, name: str, text: str, parts: Sequence[str]) -> None:
        texts = RULER.split(text)
        if len(texts) != len(parts):
            raise UnknownType(f"{name} has {len(texts) - 1} lines `---`, and not {len(parts) - 1}")
        for part, section in zip(parts, texts, strict=True):
            self._define(f"{name}_{part}", section, ())

    def _message(self, name: str, above: tuple[str, ...]) -> None:
        if name in above:
            raise UnknownType(f"the type {name} is a part of itself")
        if name not in self._store.fielddefs:
            self._define(name, self._text(name), above)

    def _define(self, name: str, text: str, above: tuple[str, ...]) -> None:
        try:
            found: Any = next(iter(get_types_from_msg(text, name).values()))
        except (TypesysError, ValueError) as error:
            raise UnknownType(f"{name} is no definition of ROS: {' '.join(str(error).split())}") from error
        constants, members = found
        for _, (node, argument) in members:
            part = argument[0] if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) else (node, argument)
            if part[0] == Nodetype.NAME and part[1].split("/")[-1] in ("wstring", "wchar"):
                raise UnknownType(f"{name} has a {part[1].split('/')[-1]}, which the DDS library cannot carry")
            if part[0] == Nodetype.NAME and part[1] not in self._store.fielddefs:
                self._message(part[1], (*above, name))
        definition: Any = {name: (constants, members or [FILLER])}
        self._store.register(definition)

    def fields(self, name: str) -> Sequence[tuple[str, Any]]:
        """Return name and kind of each field of a loaded message type; the kind as `rosbags` represents it."""
        return self._store.fielddefs[name][1]

    def has(self, name: str, path: FieldPath) -> bool:
        """Return whether messages of a loaded type can have a value at a path."""
        return self._kind(name, path) is not None

    def base(self, name: str, path: FieldPath) -> str | None:
        """Return the basic type of the field at a path of a loaded type; None if there is none, or no such field."""
        match self._kind(name, path):
            case Nodetype.BASE, (base, _):
                return str(base)
            case _:
                return None

    def fits(self, name: str, path: FieldPath, value: Any) -> bool:
        """Return whether a text, number or bool is of the type of the field at a path of a loaded type."""
        match self._kind(name, path):
            case Nodetype.BASE, ("bool", _):
                return isinstance(value, bool)
            case Nodetype.BASE, ("string", _):
                return isinstance(value, str)
            case Nodetype.BASE, (base, _):
                return isinstance(value, (int, float) if "float" in base else int) and not isinstance(value, bool)
            case _:
                return False

    def _kind(self, name: str, path: FieldPath) -> Any:
        """Return the kind of the field at a path, as `rosbags` represents it; None if there is no such field."""
        kind: Any = (Nodetype.NAME, name)
        for key in path:
            node, argument = kind
            if node == Nodetype.NAME:
                kind = dict(self.fields(argument)).get(key)
            elif node in (Nodetype.ARRAY, Nodetype.SEQUENCE) and key.isdecimal():
                kind = argument[0]
            else:
                kind = None
            if kind is None:
                return None
        return kind

    # ---- messages ----

    def read(self, name: str, body: bytes) -> Seen:
        """Return the message in a body of XCDR1 in this machine's byte order. Raises `UnreadableField`."""
        try:
            return Seen(self._store.deserialize_cdr(ENCAPSULATION + body, name))
        except (SerdeError, ValueError, MemoryError, OverflowError) as error:
            raise UnreadableField(" ".join(str(error).split())) from error

    def reader(self, name: str, paths: Collection[FieldPath]) -> Callable[[bytes], Located]:
        """Return a function that reads these paths of bodies of a loaded type; it raises as `read` does."""
        try:
            return Picker(self.fields, name, paths)
        except LookupError:
            return partial(self.read, name)

    def write(self, name: str, values: Sequence[tuple[FieldPath, Any]] = ()) -> bytes:
        """Return the body of a message with these values at paths, all else zero. Raises `UnreadableField`."""
        message = self._zero(name)
        for path, value in values:
            self._put(message, path, value)
        try:
            found = bytes(self._store.serialize_cdr(message, name, little_endian=ENCAPSULATION[1] == 1))
        except (SerdeError, struct.error, ValueError, TypeError, AttributeError, OverflowError) as error:
            raise UnreadableField(f"{name}: {' '.join(str(error).split())}") from error
        return found[len(ENCAPSULATION) :]

    def _put(self, message: Any, path: FieldPath, value: Any) -> None:
        *way, last = path
        try:
            for key in way:
                message = message[int(key)] if key.isdecimal() else getattr(message, key)
            if last.isdecimal():
                message[int(last)] = value
            else:
                setattr(message, last, value)
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            raise UnreadableField(f"`{'.'.join(path)}` cannot be set") from error

    def _zero(self, name: str) -> Any:
        return self._store.types[name](**{key: self._nothing(kind) for key, kind in self.fields(name)})

    def _nothing(self, kind: Any) -> Any:
        match kind:
            case Nodetype.BASE, (base, _):
                return "" if base == "string" else False if base == "bool" else 0.0 if "float" in base else 0
            case Nodetype.NAME, name:
                return self._zero(name)
            case Nodetype.ARRAY, (part, length):
                return self._several(part, length)
            case _, (part, _):
                return self._several(part, 0)

    def _several(self, part: Any, length: int) -> Any:
        node, argument = part
        if node == Nodetype.BASE and argument[0] != "string":
            numbers = {"byte": "uint8", "octet": "uint8", "char": "uint8"}
            return numpy.zeros(length, numbers.get(argument[0], argument[0]))
        return [self._nothing(part) for _ in range(length)]
