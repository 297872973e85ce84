"""Values out of the bytes of messages, against the whole messages that `rosbags` makes of them."""

import random
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("rosbags")
import numpy
from rosbags.interfaces import Nodetype

from exover.gate.fields import FieldPath, UnreadableField
from exover.gate.ros2.interfaces import Interfaces
from exover.gate.ros2.picking import Picker

ODD = """float64[] a
uint8 b
float64[] c
string d
int64 e
uint16[3] f
float64[2] g
bool[] h
int16 i
uint8[<=3] j
float32 k
int64 l
"""
TYPES = Interfaces(lambda name: ODD)
TYPES.load("odd_msgs/msg/Odd")
STORE = TYPES._store
ARRAYS = {"byte": "uint8", "octet": "uint8", "char": "uint8"}


def value(kind: Any, pick: random.Random) -> Any:
    node, argument = kind
    if node == Nodetype.NAME:
        return message(argument, pick)
    if node != Nodetype.BASE:
        part, length = argument
        found = [value(part, pick) for _ in range(length if node == Nodetype.ARRAY else pick.randrange(4))]
        base = part[1][0]
        return numpy.array(found, ARRAYS.get(base, base)) if part[0] == Nodetype.BASE and base != "string" else found
    base = argument[0]
    if base == "string":
        return "".join(pick.choice("aé漢") for _ in range(pick.randrange(9)))
    if base == "bool":
        return pick.random() < 0.5
    return float(pick.randrange(-9, 9)) / 4 if "float" in base else pick.randrange(128)


def message(name: str, pick: random.Random) -> Any:
    return STORE.types[name](**{key: value(kind, pick) for key, kind in TYPES.fields(name)})


def paths(name: str, above: FieldPath = ()) -> Iterator[FieldPath]:
    """Yield where a message has something single."""
    for key, (node, argument) in TYPES.fields(name):
        if node == Nodetype.NAME:
            yield from paths(argument, (*above, key))
        elif node == Nodetype.BASE:
            yield (*above, key)


def read(reader: Any, body: bytes, wanted: list[FieldPath]) -> list[Any] | None:
    try:
        found = reader(body)
    except UnreadableField:
        return None
    return [found.at(path) for path in wanted]


@pytest.mark.parametrize("package", ["geometry_msgs", "sensor_msgs", "std_msgs", "nav_msgs", "odd_msgs"])
def test_it_reads_what_the_whole_message_has(package: str) -> None:
    pick, plans = random.Random(package), 0
    for name in sorted(each for each in STORE.fielddefs if each.startswith(f"{package}/msg/")):
        wanted = [path for path in paths(name) if pick.random() < 0.7]
        reader = TYPES.reader(name, wanted)
        plans += isinstance(reader, Picker)
        for _ in range(8):
            body = bytes(STORE.serialize_cdr(message(name, pick), name, little_endian=True))[4:]
            for cut in (len(body), *range(0, len(body), 1 + len(body) // 20)):
                whole = read(lambda part, name=name: TYPES.read(name, part), body[:cut], wanted)
                assert read(reader, body[:cut], wanted) == whole, (name, cut)
            assert read(reader, body + bytes(4), wanted) is None
    assert plans


def test_a_text_that_is_not_utf_8_is_unreadable() -> None:
    reader = TYPES.reader("std_msgs/msg/String", [("data",)])
    assert read(reader, b"\2\0\0\0\xe9\0", [("data",)]) is None
    assert read(reader, b"\2\0\0\0e\0", [("data",)]) == ["e"]
    assert read(reader, b"\2\0\0\0ee", [("data",)]) is None and read(reader, b"\0\0\0\0", [("data",)]) is None
