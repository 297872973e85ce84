"""ROS 2 types as DDS types, whose samples stay bytes; needs `cyclonedds`.

DDS needs the whole type to announce the topic, to drop samples of other types, and to convert their byte order.
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


class SampleTypes:
    """Makes the classes that describe a type to DDS; they are never instantiated."""

    def __init__(self, interfaces: Interfaces) -> None:
        self._interfaces = interfaces
        self.message = cache(lambda name: _class(name, self._fields(name)))
        """Returns the class of a topic's messages. Raises `UnknownType`."""
        self.service = cache(lambda name: _class(name, {**HEADER, **self._fields(name)}))
        """Returns the class of a service's requests, or responses: the type behind the header. Raises `UnknownType`."""

    def _fields(self, name: str) -> dict[str, Any]:
        return {key: self._kind(name, kind) for key, kind in self._interfaces.fields(name)}

    def _kind(self, owner: str, kind: Any) -> Any:
        match kind:
            case Nodetype.BASE, ("string", bound):
                return idl.bounded_str[bound] if bound else str
            case Nodetype.BASE, (base, _) if base in _BASES:
                return _BASES[base]
            case Nodetype.NAME, name:
                return self.message(name)
            case Nodetype.ARRAY, (part, length):
                return idl.array[self._kind(owner, part), length]
            case Nodetype.SEQUENCE, (part, bound):
                inner = self._kind(owner, part)
                return idl.sequence[inner, bound] if bound else idl.sequence[inner]
            case _:
                raise UnknownType(f"{owner} has a {kind[1][0]}, which the DDS library cannot carry")


def _class(name: str, fields: dict[str, Any]) -> type[IdlStruct]:
    return make_idl_struct(name.replace("/", "_"), dds_type(name), fields)
