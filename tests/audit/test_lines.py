"""The reader of lines in C reads a line as the one in Python does, or not at all."""

import ctypes
import json
from collections.abc import Iterator
from random import Random

import pytest

from exover.audit.binary import RecordWriter
from exover.audit.mission import Item, Unread, read_line
from exover.audit.native import NativeAuditor
from exover.model.event import Observe
from exover.run.codec import Codec
from tests.audit.missions import CRANE, built, library, mixed, told

LIFT = '{"ask": "hoist.lift", "args": {"load": %s}}'
HOLD = '{"ask": "hoist.hold", "args": {"side": %s, "grip": %s, "n": %s}}'
HEIGHT = '{"report": "hoist.hold", "outcome": "ok", "results": {"height": %s}}'
NUMBERS = (
    "0",
    "-0",
    "1",
    "12",
    "00",
    "01",
    "+1",
    "1.",
    ".5",
    "1.5",
    "-0.0",
    "0.1",
    "0.30000000000000004",
    "3e0",
    "3E+0",
    "3e-1",
    "1e400",
    "-1e400",
    "1e-400",
    "1e-310",
    "5e-324",
    "2.5e-323",
    "11.999999999999998",
    "12.000000000000002",
    "1" * 18,
    "1" * 19,
    "1" * 500,
    "0." + "1" * 60,
    "0." + "0" * 40 + "1",
    "9007199254740993",
    "9007199254740993.0",
    "0.000000000000000000000012",
    "NaN",
    "Infinity",
    "-Infinity",
    "1e",
    "1e+",
    "- 1",
    "1_0",
    "0x1",
    "1d",
    "true",
    "null",
    '"1"',
    "[1]",
    "{}",
    "1 1",
)
HOSTILE = (
    b"",
    b" ",
    b"\r",
    b"\t \r",
    b"\x0b",
    b"{",
    b"}",
    b"[]",
    b"null",
    b"1",
    b'"x"',
    b"{}",
    b"{},",
    b"{} {}",
    b'{"ask"}',
    b'{"ask":}',
    b'{"ask": "slew.turn"',
    b'{"ask": "slew.turn"}x',
    b'{"ask": "slew.turn",}',
    b'{,"ask": "slew.turn"}',
    b'{"ask": "slew.turn"}\r',
    b'\xef\xbb\xbf{"ask": "slew.turn"}',
    b'{"ask": "slew.turn"}\xef\xbb\xbf',
    b'{"ask": "slew.t\\u0075rn"}',
    b'{"\\u0061sk": "slew.turn"}',
    b'{"ask": "slew.turn", "note": "\\ud800"}',
    b'{"ask": "slew.turn", "note": "\xc3\xa9 \xe2\x82\xac \xf0\x9f\xa4\x96"}',
    b'{"ask": "slew.turn", "note": "\xc0\xaf"}',
    b'{"ask": "slew.turn", "note": "\xed\xa0\x80"}',
    b'{"ask": "slew.turn", "note": "\xf4\x90\x80\x80"}',
    b'{"ask": "slew.turn", "note": "\xe2\x82"}',
    b'{"ask": "slew.turn", "note": "\x1f"}',
    b'{"ask": "slew.turn", "note": "\x7f"}',
    b'{"ask": "slew.turn", "ask": "slew.park"}',
    b'{"ask": "nobody", "ask": "slew.park"}',
    b'{"ask": "slew.park", "ask": 3}',
    b'{"ask": "slew.turn", "args": {}}',
    b'{"ask": "slew.turn", "args": {"x": 1}}',
    b'{"ask": "slew.turn", "args": []}',
    b'{"ask": "slew.turn", "args": null}',
    b'{"ask": "hoist.lift"}',
    b'{"ask": "hoist.lift", "args": {"load": 1, "load": 2}}',
    b'{"ask": "hoist.lift", "args": {"load": "x", "load": 2}}',
    b'{"ask": "hoist.lift", "args": {"load": 2, "load": 99}}',
    b'{"ask":"hoist.hold","args":{"n":1,"grip":false,"side":"right"}}',
    b'{"ask":"hoist.hold","args":{"n":1,"grip":false,"n":2}}',
    b'{"ask": "slew.turn", "deep": ' + b"[" * 7 + b"]" * 7 + b"}",
    b'{"ask": "slew.turn", "deep": ' + b"[" * 500 + b"]" * 500 + b"}",
    b'{"ask": "slew.turn", "more": [1, {"a": [], "b": {}}, "x"], "n": null}',
    b'{"ask": "slew.turn", "more": [1,]}',
    b'{"ask": "slew.turn", "t": tru}',
    b'{"report": "slew.turn"}',
    b'{"report": "slew.turn", "outcome": "OK"}',
    b'{"report": "slew.turn", "outcome": "ok", "status": 3}',
    b'{"report": "slew.turn", "outcome": "failed", "status": null}',
    b'{"report": "hoist.hold", "outcome": "failed", "status": "lost"}',
    b'{"report": "hoist.hold", "outcome": "failed", "status": "found"}',
    b'{"report": "hoist.hold", "outcome": "interrupted", "status": "found"}',
    b'{"report": "hoist.hold", "instance": 1, "outcome": "failed", "results": 3}',
    b'{"report": "hoist.hold", "instance": 2, "outcome": "failed"}',
    b'{"report": "hoist.hold", "instance": -1, "outcome": "failed"}',
    b'{"report": "hoist.hold", "instance": 1.0, "outcome": "failed"}',
    b'{"report": "hoist.hold", "instance": null, "outcome": "failed"}',
    b'{"observe": "wind"}',
    b'{"observe": "wind", "value": 41}',
    b'{"observe": "wind", "value": 3.0}',
    b'{"observe": "wind", "value": true}',
    b'{"observe": "calm", "value": 2}',
    b'{"observe": "slew.turn", "value": 2}',
    b'{"abort": "slew.turn"}',
    b'{"abort": "slew.turn", "waiting": true}',
    b'{"abort": "hoist.hold", "waiting": true, "instance": 9}',
    b'{"abort": "hoist.hold", "waiting": 1, "instance": 1}',
    b'{"abort": "hoist.hold", "waiting": false, "instance": 9}',
    b'{"launch": "slew.turn"}',
    b'{"launch": "slew.turn", "args": {}}',
    b'{"launch": "hoist.lift", "args": {"load": 99}}',
    b'{"launch": 1}',
    b'{"launch": "hoist.hold", "instance": 1, "args": {"side": "left", "grip": true, "n": 0}, "kill": "x"}',
    b'{"kill": "hoist.hold", "instance": 5}',
    b'{"kill": "hoist.hold", "instance": 1}',
    b'{"wait": "slew.turn", "rule": "one"}',
    b'{"reject": "slew.turn"}',
    b'{"reject": "nobody"}',
    b'{"actions": []}',
    b'{"actions": {}}',
    b'{"actions": [1]}',
    b'{"actions": [{}]}',
    b'{"actions": [{"violation": "one"}, {"launch": "slew.turn"}]}',
    b'{"actions": [{"launch": "nobody"}]}',
    b'{"step": 3, "actions": [{"kill": "slew.turn", "instance": 0, "rule": "one", "because": "x"}]}',
    b'{"event": {"ask": "slew.turn"}}',
    b'{"event": {}}',
    b'{"event": null}',
    b'{"event": {"launch": "slew.turn"}}',
    b'{"event": {"ask": "slew.turn"}, "ask": "slew.park"}',
    b'{"event": {"report": "slew.turn", "outcome": "ok"}, "actions": [{"invalid": "not-active"}]}',
    b'{"event": {"ask": "slew.turn"}, "actions": [{"invalid": "out-of-range"}]}',
    b'{"time": 1.5, "alarm": "stray", "request": "slew.turn"}',
    b'{"time": 1, "refused": "slew.turn", "rule": "starting"}',
    b'{"time": 1, "lost": 4}',
    b'{"lost": -1}',
    b'{"lost": 3, "actions": []}',
    b'{"lost": 3, "launch": "slew.turn"}',
    b'{"launch": "slew.turn", "actions": []}',
    b'{"refused": "x", "actions": []}',
    b'{"refused": 1, "lost": 4}',
    b'{"time": "x", "ask": "slew.turn"}',
    b'{"time": true, "ask": "slew.turn"}',
    b'{"time": 1e999, "ask": "slew.turn"}',
    b'{"time": 1700000000.123456789, "ask": "slew.turn"}',
    b'{"time": -0.0, "ask": "slew.turn"}',
    b'{"time": 99999999999999999999, "ask": "slew.turn"}',
)


class LineReader:
    """The reader of lines in C alone, for comparing it with that in Python."""

    ROOM = 1 << 14

    def __init__(self, auditor: NativeAuditor) -> None:
        self._auditor = auditor
        self._room = ctypes.create_string_buffer(self.ROOM)

    def read(self, line: bytes) -> bytes | None:
        """Return the records of a line without its end, None if it is odd."""
        library, audit = self._auditor._library, self._auditor._audit
        count = library.audit_line(audit, line, len(line), self._room, self.ROOM)
        return None if count < 0 else self._room.raw[:count]


@pytest.fixture(scope="module")
def reader() -> Iterator[LineReader]:
    auditor = NativeAuditor(*built(CRANE), library(CRANE))
    yield LineReader(auditor)
    auditor.close()


OUT_OF_RANGE = b"a reading out of range, which the checker itself answers so: the tests of whole missions compare it"


def _is_out_of_range(item: Item) -> bool:
    unread = isinstance(item, Unread) and item.kind == "event" and item.fault.code == "out-of-range"
    return unread or (isinstance(item, Observe) and item.broken)


def in_python(line: bytes) -> bytes | None:
    """Return the records that Python makes of a line; None if it has a fault."""
    if not line.strip():
        return b""
    model, tables = built(CRANE)
    noted = read_line(model, line)
    if any(_is_out_of_range(item) for item in noted.items):
        return OUT_OF_RANGE
    if any(isinstance(item, Unread) for item in noted.items):
        return None
    return b"".join(RecordWriter(model, Codec(model, tables)).noted(noted))


def agree(reader: LineReader, line: bytes) -> bool:
    """Hold both readers together on a line, and return whether that in C has read it."""
    read = reader.read(line)
    expected = in_python(line)
    assert read is None or expected == OUT_OF_RANGE or read == expected, line
    return read is not None


def test_hostile_lines(reader: LineReader) -> None:
    assert sum(agree(reader, line) for line in HOSTILE) > len(HOSTILE) / 3


@pytest.mark.parametrize(
    "form", (LIFT, HEIGHT, HOLD.replace("%s", '"left"', 1).replace("%s", "true", 1), '{"time": %s, "ask": "slew.turn"}')
)
def test_numbers(reader: LineReader, form: str) -> None:
    assert sum(agree(reader, (form % number).encode()) for number in NUMBERS)


def test_random_numbers(reader: LineReader) -> None:
    random = Random(7)
    texts = [repr(random.uniform(0, 12)) for _ in range(400)]
    texts += [f"{random.uniform(0, 12):.{random.randrange(25)}f}" for _ in range(200)]
    texts += [f"{random.uniform(0, 12):.{random.randrange(20)}e}" for _ in range(200)]
    texts += [f"{random.randrange(10**9)}e-{random.randrange(8, 30)}" for _ in range(200)]
    assert sum(agree(reader, (LIFT % text).encode()) for text in texts) > 900


def test_plain_lines_are_read_in_c(reader: LineReader) -> None:
    recorded = (*told(CRANE, 3, 200), *mixed(CRANE, 4, 200))
    lines = [line for line in recorded if in_python(line) not in (None, OUT_OF_RANGE)]
    assert len(lines) > 300
    assert [line for line in lines if not agree(reader, line)] == []


def test_damaged_lines(reader: LineReader) -> None:
    random = Random(11)
    read = 0
    for line in (*told(CRANE, 5, 60), *mixed(CRANE, 6, 60)):
        for _ in range(8):
            changed = bytearray(line)
            for _ in range(random.randrange(1, 3)):
                at = random.randrange(len(changed))
                kind = random.randrange(4)
                if kind == 0:
                    del changed[at : at + random.randrange(1, 4)]
                elif kind == 1:
                    changed[at:at] = random.choice((b" ", b",", b"}", b'"', b"0", b"e5", b"\\", b"\xc3"))
                elif kind == 2:
                    changed[at] = random.randrange(256)
                else:
                    del changed[at:]
                if not changed:
                    break
            if b"\n" not in changed:
                read += agree(reader, bytes(changed))
    assert read > 50


def test_a_request_is_no_poster(reader: LineReader) -> None:
    assert agree(reader, json.dumps({"ask": "slew.turn"}).encode())
    assert not agree(reader, json.dumps({"observe": "slew.turn", "value": 1}).encode())
    assert not agree(reader, json.dumps({"ask": "wind"}).encode())
