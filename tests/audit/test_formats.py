"""Missions as binary records and as tables: the same as their lines; what is damaged, and what is of another spec."""

import json
import struct
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from exover.audit import sources
from exover.audit.auditor import Job, MissionAuditor
from exover.audit.binary import LENGTH, MissionWriter, RecordReader
from exover.audit.mission import LaunchDeed, LostLines, Unread, Void, read_line
from exover.audit.result import MissionResult
from exover.model.event import Ask, Invalid, Observe
from exover.model.wire_reading import MAX_LINE
from exover.run.records import RecordCodec
from tests.audit.missions import CRANE, FREE, LOOSE, built, library, mixed, simulated, told, write

OTHER = FREE.replace("poster wind", "enum zone { near, far } poster place: zone = near; poster wind").replace(
    "request lift(load: real in 0 .. 12)", "request fly(); request lift(way: zone, load: real in 0 .. 12)"
)


@pytest.fixture(scope="module", params=("c", "tables"))
def auditor(request: pytest.FixtureRequest) -> MissionAuditor:
    model, tables = built(CRANE)
    return MissionAuditor(Job(model, tables, library(CRANE) if request.param == "c" else None))


def as_records(path: Path, lines: list[bytes], text: str = CRANE) -> Path:
    """Write the lines as records; what has none is left out."""
    model, _ = built(text)
    with path.open("wb") as file:
        writer = MissionWriter(model, file)
        for line in lines:
            noted = read_line(model, line)
            writer.at(noted.time)
            for item in noted.items:
                if not isinstance(item, Unread | Void | LostLines):
                    writer.write(item)
    return path


def findings(result: MissionResult) -> list[tuple[object, ...]]:
    """Return the divergences without their lines, which are others in another format."""
    return [(row.kind, row.request, row.instance, row.answer, row.rule, str(row.time)) for row in result.rows]


@pytest.mark.parametrize("old", (LOOSE, FREE))
def test_records_say_what_lines_say(tmp_path: Path, auditor: MissionAuditor, old: str) -> None:
    lines = [line for line in mixed(old, 3, 300) if b'"invalid"' not in line]
    items = [read_line(built(CRANE)[0], line).items for line in lines]
    lines = [line for line, found in zip(lines, items, strict=True) if not any(isinstance(i, Unread) for i in found)]
    by_line = auditor.audit(str(write(tmp_path, "m.jsonl", lines)), "m")
    by_record = auditor.audit(str(as_records(tmp_path / "m.exor", lines)), "m")
    assert findings(by_line) and findings(by_line) == findings(by_record)
    assert by_line.figures == by_record.figures


def test_a_bool_that_is_neither_0_nor_1_is_out_of_range() -> None:
    """A broken sensor reads the worst, and its record is no mistake."""
    posters = "poster clear: bool = true else false; poster lit: bool = true;"
    model, _ = built(f"spec s; {posters} module m {{ request a(b: bool); }}")
    codec = RecordCodec(model)
    reader = RecordReader(model, codec.description())
    records = [struct.pack("<BHq", *numbers) for numbers in ((2, 0, 2), (2, 1, -1), (0, 0, 2))]
    clear, lit, asked = map(codec.event, records)
    assert clear == Observe("clear", False, broken=True)
    assert isinstance(lit, Invalid) and lit.code == "out-of-range" and "lit is -1" in lit.detail
    assert isinstance(asked, Invalid) and asked.code == "out-of-range"
    assert [reader.read(each).items for each in records] == [
        (clear,),
        (Unread(lit, "event"),),
        (Unread(asked, "ask", "m.a"),),
    ]


def test_records_of_a_spec_with_other_numbers_are_read_by_name(tmp_path: Path, auditor: MissionAuditor) -> None:
    path = tmp_path / "m.exor"
    model, _ = built(OTHER)
    with path.open("wb") as file:
        writer = MissionWriter(model, file)
        for line in (
            '{"observe": "place", "value": "far"}',
            '{"ask": "hoist.fly"}',
            '{"ask": "hoist.lift", "args": {"way": "far", "load": 3}}',
            '{"ask": "slew.turn"}',
            '{"launch": "slew.turn"}',
        ):
            for item in read_line(model, line.encode()).items:
                writer.write(item)
    found = auditor.audit(str(path), "m")
    assert [(mistake.line, mistake.text.split(":")[0]) for mistake in found.mistakes] == [
        (1, "unknown-poster"),
        (2, "unknown-request"),
        (3, "unknown-argument"),
    ]
    assert found.figures.asks == {("slew.turn", "launch"): 1, ("hoist.lift", "invalid"): 1}


def test_that_a_client_listened_is_passed_over(tmp_path: Path, auditor: MissionAuditor) -> None:
    whole = as_records(tmp_path / "m.exor", told(CRANE, 1, 20))
    without = auditor.audit(str(whole), "m")
    with whole.open("ab") as file:
        file.write(b"".join(LENGTH.pack(len(record)) + record for record in (b"\5\0", b"\5\1\7", b"\5\2", b"\5")))
    found = auditor.audit(str(whole), "m")
    assert (found.figures, found.rows) == (without.figures, without.rows)
    assert [mistake.text.split(":")[0] for mistake in found.mistakes] == ["bad-event", "bad-event"]


def test_damaged_records(tmp_path: Path, auditor: MissionAuditor) -> None:
    whole = as_records(tmp_path / "m.exor", told(CRANE, 1, 20)).read_bytes()
    odd = [b"", b"\x63", b"\x00", b"\x00\xff\xff", b"\x02\x09\x00", b"\x02\x01\x00" + struct.pack("<d", float("nan"))]
    odd += [
        b"\x02\x01\x00" + struct.pack("<d", -0.0),
        b"\x01\x00\x00\x00\x00\x07\x00\x00",
        b"\x06\x00\x00\x00\x00\x01\x00",
    ]
    path = tmp_path / "odd.exor"
    path.write_bytes(whole + b"".join(LENGTH.pack(len(record)) + record for record in odd) + b"\x09\x00")
    found = auditor.audit(str(path), "m")
    assert not found.error
    assert [mistake.text.split(":")[0] for mistake in found.mistakes] == [
        "bad-event",
        "bad-event",
        "bad-event",
        "unknown-request",
        "unknown-poster",
        "bad-event",
        "bad-event",
        "its last record is cut short",
    ]
    path.write_bytes(whole + LENGTH.pack(MAX_LINE + 1) + b"x" * 100)
    assert [mistake.text for mistake in auditor.audit(str(path), "m").mistakes] == [
        f"a record of {MAX_LINE + 1} bytes, and at most {MAX_LINE} are read"
    ]


@pytest.mark.parametrize(
    "content",
    (
        b"EXO1",
        b"EXO",
        b"EXO1\xff\xff\xff\xff{}",
        b"EXO1\x02\0\0\0[]",
        b"EXO1\x10\0\0\0{}",
        b'EXO1\x0f\0\0\0{"requests":[1]}',
    ),
)
def test_what_is_no_file_of_records(tmp_path: Path, auditor: MissionAuditor, content: bytes) -> None:
    path = tmp_path / "m.exor"
    path.write_bytes(content)
    assert auditor.audit(str(path), "m").error.startswith("it is no mission: ")


def test_a_description_without_ranges_is_of_the_same_numbers() -> None:
    model, _ = built(CRANE)
    wider, _ = built(CRANE.replace("int in 0 .. 40 = 0 else 40", "int in 0 .. 90 = 0 else 40"))
    from exover.run.records import RecordCodec

    assert RecordReader(model, RecordCodec(wider).description()).same
    assert not RecordReader(model, RecordCodec(built(OTHER)[0]).description()).same


def test_pieces_of_lines_that_are_too_long(tmp_path: Path, auditor: MissionAuditor) -> None:
    long = b'{"ask": "slew.turn", "note": "' + b"x" * (3 * MAX_LINE) + b'"}'
    fits = b'{"ask": "slew.turn", "note": "' + b"x" * (MAX_LINE - 33) + b'"}'
    assert len(fits) == MAX_LINE - 1
    lines = [b"", long, b'{"ask": "slew.turn"}', fits, b'{"ask": "slew.park"}', long]
    found = auditor.audit(str(write(tmp_path, "m.jsonl", lines)), "m")
    assert [mistake.line for mistake in found.mistakes] == [2, 6]
    assert found.figures.events == 3
    (tmp_path / "cut.jsonl").write_bytes(b'{"ask": "slew.turn"}\r\n{"ask": "slew.park"}')
    assert auditor.audit(str(tmp_path / "cut.jsonl"), "m").figures.events == 2
    (tmp_path / "cut.jsonl").write_bytes(b'{"ask": "slew.turn"}\n{"ask": "slew.pa')
    assert [mistake.line for mistake in auditor.audit(str(tmp_path / "cut.jsonl"), "m").mistakes] == [2]


def test_a_mission_without_events_and_a_file_that_is_none(tmp_path: Path, auditor: MissionAuditor) -> None:
    empty = auditor.audit(str(write(tmp_path, "m.jsonl", [])), "m")
    assert (empty.figures.events, empty.notes, empty.error) == (0, ("it has no events",), "")
    none = auditor.audit(str(write(tmp_path, "n.jsonl", ["spec crane;", "module m {}"])), "n")
    assert none.error == "no line of it is an event: write one JSON object a line"
    for name in ("missing.jsonl", "missing.mcap"):
        assert auditor.audit(str(tmp_path / name), "m").error == "it cannot be read: No such file or directory"


def test_a_line_that_is_no_event_is_not_counted_as_one(tmp_path: Path, auditor: MissionAuditor) -> None:
    lines = [
        '{"ask": "slew.turn", "actions": 5}',
        '{"lost": "x"}',
        "{",
        '{"launch": 5}',
        '{"kill": null}',
        '{"event": 5}',
    ]
    found = auditor.audit(str(write(tmp_path, "m.jsonl", lines)), "m")
    assert (found.mistake_count, found.figures.events, found.figures.deeds, found.figures.invalid) == (6, 1, 2, 0)
    deeds = auditor.audit(str(write(tmp_path, "d.jsonl", ['{"launch": 5}', "{"])), "d")
    assert (deeds.error, deeds.figures.events, deeds.mistake_count) == ("", 0, 2)
    unread = auditor.audit(str(write(tmp_path, "u.jsonl", ['{"ask": "nobody"}', '{"report": "slew.turn"}'])), "u")
    assert (unread.error, unread.figures.events, unread.figures.invalid) == ("", 2, 2)


def test_a_line_with_more_deeds_than_are_handed_in_at_once(tmp_path: Path, auditor: MissionAuditor) -> None:
    actions = [{"launch": "hoist.hold", "instance": 0, "args": {"side": "left", "grip": True, "n": 1}}] * 6000
    line = json.dumps({"event": {"observe": "wind", "value": 25}, "actions": actions}).encode()
    found = auditor.audit(str(write(tmp_path, "m.jsonl", [line, line])), "m")
    assert found.figures.diverged == {"launched": 12000}
    assert len(found.rows) == 1000


# ---- tables ----


def as_table(path: Path, lines: list[bytes]) -> Path:
    """Write events and deeds as a table, values as text."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    rows: list[dict[str, Any]] = []
    for line in lines:
        entries = json.loads(line)
        event = entries.pop("event", entries)
        kind = next(
            (k for k in ("ask", "report", "observe", "abort", "launch", "kill", "wait", "reject") if k in event), None
        )
        if kind is None:
            continue
        row = {"time": entries.get("time"), "kind": kind, "name": event[kind]}
        row |= {key: event[key] for key in ("instance", "outcome", "status", "waiting") if key in event}
        row |= {key: json.dumps(event[key]) for key in ("args", "results", "value") if key in event}
        rows.append(row | ({"actions": json.dumps(entries["actions"])} if "actions" in entries else {}))
    names = list(dict.fromkeys(key for row in rows for key in row))
    pq.write_table(pa.table({name: [row.get(name) for row in rows] for name in names}), path, row_group_size=50)
    return path


def test_a_table_says_what_lines_say(tmp_path: Path, auditor: MissionAuditor) -> None:
    lines = told(LOOSE, 4, 200)
    by_line = auditor.audit(str(write(tmp_path, "m.jsonl", lines)), "m")
    by_row = auditor.audit(str(as_table(tmp_path / "m.parquet", lines)), "m")
    assert by_line.figures.diverged and by_line.rows == by_row.rows
    assert by_line.figures == by_row.figures


def test_columns_with_values_of_their_own_types(tmp_path: Path, auditor: MissionAuditor) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    from datetime import UTC, datetime

    table = {
        "time": [datetime(2026, 5, 1, 12, tzinfo=UTC)] * 4,
        "kind": ["ask", "launch", "sleep", "ask"],
        "name": ["hoist.hold", "hoist.hold", "x", "hoist.lift"],
        "args": [{"side": "left", "grip": True, "n": 2}, {"side": "left", "grip": True, "n": 2}, None, {"load": 3}],
        "instance": [None, 1, None, None],
        "actions": [None, None, None, [{"launch": "hoist.lift", "rule": None}, {"launch": None, "rule": "x"}]],
        "remark": [1, 2, 3, 4],
    }
    pq.write_table(pa.table(table), tmp_path / "m.parquet")
    found = auditor.audit(str(tmp_path / "m.parquet"), "m")
    assert found.figures.asks == {("hoist.hold", "launch"): 1, ("hoist.lift", "launch"): 1} and not found.rows
    assert found.figures.told == 1
    kinds = "ask, report, observe, abort, launch, kill, wait, reject"
    assert [(mistake.line, mistake.text) for mistake in found.mistakes] == [
        (3, f"bad-event: `kind` is `sleep`, none of {kinds}")
    ]


def timed(path: Path, time: Any, **columns: Any) -> Path:
    """Write a table of two lifts that are too heavy in this wind, with these times."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    lifts = {"kind": ["observe", "launch"], "name": ["wind", "hoist.lift"], "value": ["30", None]}
    pq.write_table(pa.table({"time": time, **lifts, "args": [None, '{"load": 11}'], **columns}), path)
    return path


@pytest.mark.parametrize(
    ("unit", "zone", "count", "seconds"),
    (
        ("ns", None, 1_700_000_000_123_456_789, 1_700_000_000.123_456_789),
        ("us", None, -(10**17), -(10.0**11)),
        ("us", "UTC", 3 * 10**18, 3e12),
        ("s", None, 10**15, 1e15),
        ("ms", "Mars/Phobos", 1500, 1.5),
    ),
)
def test_any_timestamp_is_read(
    tmp_path: Path, auditor: MissionAuditor, unit: str, zone: str | None, count: int, seconds: float
) -> None:
    pa = pytest.importorskip("pyarrow")
    times = pa.array([None, count], pa.timestamp(unit, zone))
    found = auditor.audit(str(timed(tmp_path / "m.parquet", times)), "m")
    assert (found.error, found.mistakes) == ("", ())
    assert [(row.line, row.kind, row.time) for row in found.rows] == [(2, "launched", seconds)]


def test_cells_that_cannot_be_read(tmp_path: Path, auditor: MissionAuditor) -> None:
    pa = pytest.importorskip("pyarrow")
    ends = pa.py_buffer(struct.pack("<3i", 0, 3, 5))
    text = pa.Array.from_buffers(pa.string(), 2, [None, ends, pa.py_buffer(b"\xff\xfe\xfd30")])
    at = pa.array([{"at": 1}, None], pa.struct([("at", pa.timestamp("ns"))]))
    for column in ("name", "value"):
        found = auditor.audit(str(timed(tmp_path / "m.parquet", [1, 2], **{column: text})), "m")
        assert found.mistakes[0].line == 1
        assert found.mistakes[0].text == f"bad-event: `{column}` is not UTF-8: invalid start byte at byte 1"
        assert (found.error, found.figures.deeds) == ("", 1)
    found = auditor.audit(str(timed(tmp_path / "m.parquet", [1, 2], value=at)), "m")
    assert [(each.line, each.text) for each in found.mistakes] == [
        (1, "bad-event: `value` is `struct<at: timestamp[ns]>`, with a value that cannot be read")
    ]
    found = auditor.audit(str(timed(tmp_path / "m.parquet", text)), "m")
    assert [(each.line, each.text) for each in found.mistakes] == [
        (1, "bad-event: `time` is not UTF-8: invalid start byte at byte 1"),
        (2, "wrong-type: `time` is `30`, not a number of seconds"),
    ]


@pytest.mark.parametrize("kind", ("string", "bool", "duration"))
def test_a_column_of_times_that_are_no_numbers(tmp_path: Path, auditor: MissionAuditor, kind: str) -> None:
    pa = pytest.importorskip("pyarrow")
    times = {
        "string": pa.array(["x", None]),
        "bool": pa.array([True, None]),
        "duration": pa.array([5, None], "duration[s]"),
    }
    found = auditor.audit(str(timed(tmp_path / "m.parquet", times[kind])), "m")
    ((line, text),) = ((each.line, each.text) for each in found.mistakes)
    assert line == 1 and text.startswith("wrong-type: `time` is ") and len(found.rows) == 1


def test_a_table_may_be_called_anything(tmp_path: Path, auditor: MissionAuditor) -> None:
    path = as_table(tmp_path / "m.parquet", told(LOOSE, 4, 200))
    plain = auditor.audit(str(path), "m")
    assert plain.rows and str(auditor.audit(str(path.rename(tmp_path / "m\udcff.parquet")), "m")) == str(plain)


def test_what_is_no_table(tmp_path: Path, auditor: MissionAuditor) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "m.parquet"
    path.write_bytes(b"PAR1 or not")
    assert auditor.audit(str(path), "m").error.startswith("it is no mission: it is no Parquet: ")
    pq.write_table(pa.table({"kind": ["ask"]}), path)
    assert auditor.audit(str(path), "m").error == "it is no mission: it has no column name"
    named = [(name, pa.array(["ask"])) for name in ("kind", "name", "kind", "remark", "remark")]
    pq.write_table(pa.Table.from_arrays([each for _, each in named], names=[name for name, _ in named]), path)
    assert auditor.audit(str(path), "m").error == "it is no mission: it has more than one column kind"
    kinds = "ask, report, observe, abort, launch, kill, wait, reject"
    for kind in ("dance", b"ask", None, 7, ["ask"]):
        pq.write_table(pa.table({"kind": [kind], "name": ["slew.turn"]}), path)
        assert auditor.audit(str(path), "m").error == f"no row of it is an event: its column kind is none of {kinds}"
    pq.write_table(pa.table({"kind": ["ask"], "name": ["slew.turn"], "remark": [1]}), path, store_schema=False)
    path.write_bytes(path.read_bytes().replace(b"remark", b"rem\xffrk"))
    assert auditor.audit(str(path), "m").error == "it is no mission: it is no Parquet: it is damaged"
    whole = as_table(path, told(CRANE, 1, 50)).read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert auditor.audit(str(path), "m").error.startswith("it is no mission: it is no Parquet: ")


def test_what_has_no_record_is_not_written(tmp_path: Path) -> None:
    with (tmp_path / "m.exor").open("wb") as file:
        writer = MissionWriter(built(CRANE)[0], file)
        writer.write(Ask("slew.turn"))
        writer.write(LaunchDeed("slew.turn", 0, ()))
        with pytest.raises(ValueError, match="LostLines has no record"):
            writer.write(LostLines(1))


@pytest.mark.parametrize("piece", (1, 7, 100))
def test_an_answer_may_stand_in_the_next_piece(tmp_path: Path, auditor: MissionAuditor, piece: int) -> None:
    lines = [line for pair in simulated(CRANE, 5, 60) for line in pair]
    path = str(write(tmp_path, "m.jsonl", lines))
    whole = auditor.audit(path, "m")
    with patch.object(sources, "PIECE", piece):
        found = auditor.audit(path, "m")
    assert not found.rows and found.figures.passed and found.figures == whole.figures
    assert found.mistakes == whole.mistakes


def test_an_answer_that_is_too_far_away_is_about_no_event_before(tmp_path: Path, auditor: MissionAuditor) -> None:
    lines = [b'{"report": "slew.turn", "outcome": "ok"}', b" " * 1000, b'{"actions": [{"invalid": "not-active"}]}']
    assert not auditor.audit(str(write(tmp_path, "near.jsonl", lines)), "m").rows
    far = [lines[0], *([lines[1]] * 1100), lines[2]]
    assert [row.line for row in auditor.audit(str(write(tmp_path, "far.jsonl", far)), "m").rows] == [1]
    long = [lines[0], b'{"actions": [{"invalid": "not-active"}], "more": "' + b"x" * (1 << 20) + b'"}', lines[2]]
    assert [row.line for row in auditor.audit(str(write(tmp_path, "long.jsonl", long)), "m").rows] == [1]


def test_a_time_that_is_no_number_is_a_mistake(tmp_path: Path, auditor: MissionAuditor) -> None:
    lines = [f'{{"time": {time}, "ask": "slew.turn"}}' for time in ("1", '"x"', "true", "null", "[]", "1e999")]
    found = auditor.audit(str(write(tmp_path, "m.jsonl", lines)), "m")
    assert [(each.line, each.text) for each in found.mistakes] == [
        (2, "wrong-type: `time` is `x`, not a number of seconds"),
        (3, "wrong-type: `time` is true, not a number of seconds"),
        (5, "wrong-type: `time` is a list, not a number of seconds"),
        (6, "out-of-range: `time` is no finite number of seconds"),
    ]
    assert found.figures.events == 6


def test_the_time_of_a_record_is_finite_or_not_known(tmp_path: Path, auditor: MissionAuditor) -> None:
    path = tmp_path / "m.exor"
    with path.open("wb") as file:
        writer = MissionWriter(built(CRANE)[0], file)
        for time in (5.0, float("inf"), 6.0, float("nan")):
            writer.at(time)
            writer.write(LaunchDeed("hoist.lift", 0, (11.0,)))
            writer.write(Observe("wind", 30))
    found = auditor.audit(str(path), "m")
    said = "out-of-range: `time` is no finite number of seconds"
    assert [(each.line, each.text) for each in found.mistakes] == [(4, said)]
    assert [str(row.time) for row in found.rows] == ["nan", "6.0", "nan"]  # the first launch was before the wind
