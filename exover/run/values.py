"""Values as the eight bytes that the emitted code and binary records have for them, little-endian."""

import struct

from exover.model.types import Real, Type, Value, ordinal


def packed(kind: Type, value: Value) -> bytes:
    """Return the eight bytes of a value: a real as a double (IEEE 754), any other as its ordinal, signed."""
    return struct.pack("<d", float(value)) if isinstance(kind, Real) else struct.pack("<q", ordinal(kind, value))


def unpacked(kind: Type, data: bytes) -> float | int:
    """Return the real, or the ordinal, that eight bytes are; more are not looked at, fewer are a `struct.error`."""
    number: float | int = struct.unpack_from("<d" if isinstance(kind, Real) else "<q", data)[0]
    return number
