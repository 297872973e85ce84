"""Finds mission files, tells their formats apart, and reads lines and records piece by piece."""

import os
from collections.abc import Callable, Iterator
from io import BufferedReader
from typing import BinaryIO

from exover.audit.binary import MAGIC, NoMission, RecordReader, refuse_overlong, split
from exover.audit.mission import Noted, read_line
from exover.model.model import Model
from exover.model.wire_reading import MAX_LINE, TOO_LONG, is_blank
from exover.run.simulate import lines_of

LINES = (".jsonl", ".json", ".ndjson", ".log")
RECORDS = (".exor",)
TABLES = (".parquet",)
BAGS = (".mcap", ".db3")
SUFFIXES = (*LINES, *RECORDS, *TABLES, *BAGS)
METADATA = "metadata.yaml"
PIECE = 1 << 20


def is_bag(path: str) -> bool:
    """Return whether a path is that of a bag, by its suffix or its `metadata.yaml`."""
    return path.endswith(BAGS) or os.path.isfile(os.path.join(path, METADATA))


def missions_in(path: str) -> Iterator[str]:
    """Yield the path itself if it is no folder or is a bag, else the missions in and below the folder, by name.

    A folder or link that cannot be read is yielded as well: to read it as a mission tells why.
    """
    return _missions_in(path, frozenset())


def _missions_in(path: str, above: frozenset[str]) -> Iterator[str]:
    """Yield what `missions_in` does; `above`: the folders that this one is in, which links may lead back to."""
    if not os.path.isdir(path) or is_bag(path):
        yield path
        return
    here = os.path.realpath(path)
    if here in above:
        return
    try:
        names = sorted(os.listdir(path))
    except OSError:
        yield path
        return
    for name in names:
        inside = os.path.join(path, name)
        if os.path.isdir(inside) and not name.startswith("."):
            yield from _missions_in(inside, above | {here})
        elif name.endswith(SUFFIXES) and (os.path.isfile(inside) or not os.path.exists(inside)):
            yield inside


def has_records(path: str, file: BufferedReader) -> bool:
    """Return whether an open file holds records and not lines, without consuming bytes. Raises `OSError`."""
    return path.endswith(RECORDS) or file.peek(len(MAGIC))[: len(MAGIC)] == MAGIC


def whole_lines(model: Model, file: BinaryIO) -> Iterator[tuple[int, Noted]]:
    """Yield number, from 1, and content of each line that is not blank."""
    held: tuple[int, bytes] | None = None
    distance = 0
    for number, line in enumerate(lines_of(file), 1):
        distance += len(line)
        if not is_blank(line):
            if held:
                yield held[0], read_line(model, held[1], line if distance <= MAX_LINE else b"")
            held, distance = (number, line), 0
    if held:
        yield held[0], read_line(model, held[1])


def line_behind(data: bytes, start: int, last: bool) -> bytes | None:
    """Return the first line from `start` on that is not blank and ends within `MAX_LINE` bytes; empty if there is none.

    None if that is not known before more is read; `last` iff these are the last bytes of the file.
    """
    end = min(len(data), start + MAX_LINE)
    last = last and end == len(data)
    at = start
    while at < end:
        newline = data.find(b"\n", at, end)
        if newline < 0 and not last:
            break
        line = data[at : end if newline < 0 else newline]
        if not is_blank(line):
            return line
        at += len(line) + 1
    return b"" if last or end == start + MAX_LINE else None


def pieces(file: BinaryIO, take: Callable[[bytes, bool], int], overlong: Callable[[bytes], None]) -> None:
    """Give a file to `take` in pieces; it returns how many bytes it has taken, and gets the rest with the next piece.

    The first `TOO_LONG` bytes of a line that is too long go to `overlong`; the rest of the line is skipped.
    """
    rest, skips = b"", False
    while True:
        piece = file.read(PIECE)
        data = rest + piece
        if skips:
            end = data.find(b"\n")
            skips = end < 0
            data = b"" if skips else data[end + 1 :]
        rest = data[take(data, not piece) :] if data else b""
        if not piece:
            return
        if len(rest) >= TOO_LONG and b"\n" not in rest:
            overlong(rest[:TOO_LONG])
            rest, skips = b"", True


def records(reader: RecordReader, file: BinaryIO) -> Iterator[tuple[int, Noted]]:
    """Yield number, from 1, and content of each record; raises `NoMission` where no more can be read."""
    rest, number = b"", 0
    while piece := file.read(PIECE):
        found, rest = split(rest + piece)
        for record in found:
            number += 1
            yield number, reader.read(record)
        refuse_overlong(rest)
    if rest:
        raise NoMission("its last record is cut short")


def record_pieces(file: BinaryIO, take: Callable[[bytes], int]) -> None:
    """Give records to `take` in pieces, as `pieces` does; raises `NoMission` where no more can be read."""
    rest = b""
    while piece := file.read(PIECE):
        data = rest + piece
        rest = data[take(data) :]
        refuse_overlong(rest)
    if rest:
        raise NoMission("its last record is cut short")
