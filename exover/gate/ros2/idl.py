"""Types of ROS 2 as types of DDS, whose samples stay bytes; needs `cyclonedds`.

DDS has to know the whole type: by it, it announces the topic, drops samples that are none, and mends their byte order.
"""

from functools import cache
from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl import types as idl_types
from rosbags.interfaces import Nodetype

from exover.gate.ros2.interfaces import Interfaces, UnknownType
from exover.gate.ros2.names import dds_type

idl: Any = idl_types  # its generic types are known to it alone
_BASES: dict[str, Any] = {
    "bool": bool,
    "byte": idl.uint8,
    "octet": idl.uint8,
    "char": idl.uint8,
    "int8": idl.int8,
    "uint8": idl.uint8,
    "int16": idl.int16,
    "uint16": idl.uint16,
    "int32": idl.int32,
    "uint32": idl.uint32,
    "int64": idl.int64,
    "uint64": idl.uint64,
    "float32": idl.float32,
    "float64": idl.float64,
}
HEADER: dict[str, Any] = {"client_": idl.uint64, "number_": idl.int64}
"""The 16 bytes at the head of a service message; no field of ROS 2 ends with `_`."""


def _init(self: Any, data: bytes) -> None:
    self.data = data


def _serialize(self: Any, *_: Any, **__: Any) -> bytes:
    data: bytes = self.data
    return data


def _deserialize(cls: Any, data: bytes, *_: Any, **__: Any) -> Any:
    return cls(data)


class SampleTypes:
    """Makes classes of samples: each has the bytes of a message as `data`, with its encapsulation."""

    def __init__(self, interfaces: Interfaces) -> None:
        self._interfaces = interfaces
        self._struct = cache(self._make)
        self._topic = cache(lambda name: _opaque(self._fields(name), name))
        self._service = cache(lambda name: _opaque({**HEADER, **self._fields(name)}, name))

    def message(self, name: str) -> type[IdlStruct]:
        """Return the class of messages of a topic. Raises `UnknownType`."""
        return self._topic(name)

    def service(self, name: str) -> type[IdlStruct]:
        """Return the class of requests or of responses of a service. Raises `UnknownType`."""
        return self._service(name)

    def _make(self, name: str) -> type[IdlStruct]:
        return make_idl_struct(_class_name(name), dds_type(name), self._fields(name))

    def _fields(self, name: str) -> dict[str, Any]:
        return {key: self._kind(name, kind) for key, kind in self._interfaces.fields(name)}

    def _kind(self, owner: str, kind: Any) -> Any:
        match kind:
            case Nodetype.BASE, ("string", bound):
                return idl.bounded_str[bound] if bound else str
            case Nodetype.BASE, (base, _) if base in _BASES:
                return _BASES[base]
            case Nodetype.NAME, name:
                return self._struct(name)
            case Nodetype.ARRAY, (part, length):
                return idl.array[self._kind(owner, part), length]
            case Nodetype.SEQUENCE, (part, bound):
                inner = self._kind(owner, part)
                return idl.sequence[inner, bound] if bound else idl.sequence[inner]
            case _:
                raise UnknownType(f"{owner} has a {kind[1][0]}, which the DDS library cannot carry")


def _class_name(name: str) -> str:
    return name.replace("/", "_")


def _opaque(fields: dict[str, Any], name: str) -> type[IdlStruct]:
    found = make_idl_struct(_class_name(name), dds_type(name), fields, dataclassify=False)
    read = classmethod(_deserialize)
    for method, does in (
        ("__init__", _init),
        ("serialize", _serialize),
        ("deserialize", read),
        ("deserialize_key", read),
    ):
        setattr(found, method, does)
    return found
