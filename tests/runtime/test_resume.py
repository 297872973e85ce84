"""State goes out in a record and comes back: nothing is forgotten, and nothing comes back that the rules forbid."""

import struct
import zlib
from pathlib import Path

import pytest

from exover.bounds.sizes import record_bytes
from exover.pipeline import build
from exover.swap.bytes import packed
from exover.swap.carry import Carry
from tests.runtime.compiling import (
    BAD_MAP,
    BAD_RECORD,
    BAD_VALUE,
    BROKEN_RULE,
    FAULT_STATE,
    LIVE,
    NO_MEMORY,
    NO_TABLES,
    OTHER_BUILD,
    OTHER_TABLES,
    READY,
    ROOT,
    SPECS,
    STALE,
    built,
    model_of,
)
from tests.runtime.resuming import Host, host_of, lines_of, needs_rustc, rust_host_of

HEAD = 56
AS_EMITTED = ("corners", "rover")
"""Vectors whose runtime takes no other tables, in C; for the others one takes all."""
RUNNING, STOPPING, WAITING = 1, 2, 3


def changed(record: bytes, numbers: dict[int, int]) -> bytes:
    """Return a record with other numbers in these places, its checksum put right."""
    data = bytearray(record)
    for place, number in numbers.items():
        struct.pack_into("<q", data, HEAD + 8 * place, number)
    return sealed(bytes(data))


def sealed(data: bytes) -> bytes:
    clean = data[:8] + bytes(4) + data[12:]
    return clean[:8] + struct.pack("<I", zlib.crc32(clean)) + clean[12:]


def bits(real: float) -> int:
    """Return the bits of a double, as a number."""
    return int.from_bytes(struct.pack("<d", real), "little")


@pytest.mark.parametrize("path", SPECS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_what_is_taken_away_before_each_event_and_resumed_answers_as_before(path: Path, tmp_path: Path) -> None:
    """Not all of these specs hold: the tables say so, and a rule that nothing can restore is no reason to refuse."""
    host = host_of(build(built(path).model, unchecked=True), tmp_path, path.stem in AS_EMITTED)
    assert host.run("trip", lines=lines_of(host.found, 150)) == ["150 0 0 0"]


TWO = "spec two; module m { request a(); request b(); } mutex m.a, m.b;"
RICH = """spec rich; poster speed: real in 0 .. 2 = 0; poster battery: int in 0 .. 100 = 50; resource power: 3;
    resource ink: 5 consumable;
    module m {
        request a(v: real in 0 .. 1) instances 2 { uses power 2; }
        request b(n: int in 1 .. 3) { uses power 2; wait until not active(m.c); fail low: when battery < 10; }
        request c() { check past(m.b) or m.speed_ok; on ok forget m.b; consumes ink 1; }
        request d();
        state speed_ok: bool = true;
    }
    limit few: at most 1 of m.c, m.d; forbid fast: active(m.c) and speed > 1 by kill m.c;"""


def test_a_live_checker_is_not_loaded_and_a_faulty_one_comes_back_by_its_last_record_alone(two: Host) -> None:
    """Loaded twice; resumed while sound; with something running; the pair is kept apart; then a fault; what exports
    then; the record of a step before; the last one; the pair is still kept apart; after its end the other starts.
    """
    wanted = [LIVE, LIVE, LIVE, 1, FAULT_STATE, LIVE, 0, STALE, READY, 1, 1, LIVE, LIVE, 1]
    assert [int(word) for word in two.run("live")[0].split()] == wanted


def test_a_record_is_as_long_as_announced_and_only_written_whole(rich: Host) -> None:
    whole = record_bytes(rich.found.tables)
    assert len(rich.record()) == whole
    assert rich.run("show", "0")[1] == f"0 0 {whole}"


def test_a_flipped_bit_of_any_byte_of_a_record_and_every_cut_is_refused(two: Host) -> None:
    record = two.record()
    flips = [bytes([*record[:i], record[i] ^ 1 << i % 8, *record[i + 1 :]]) for i in range(len(record))]
    assert two.outcome(record) == [(READY, False)]
    assert set(two.outcome(*flips)) == {(BAD_RECORD, True)}
    cuts = [sealed(record[:length]) for length in (0, 8, HEAD - 1, HEAD, len(record) - 8)] + [sealed(record + bytes(8))]
    assert set(two.outcome(*cuts)) == {(BAD_RECORD, True)}
    assert two.outcome(sealed(record[:20] + b"!" + record[21:])) == [(OTHER_TABLES, True)]


PLACES = {
    "speed": 0, "battery": 1, "speed_ok": 2, "ink": 3,
    "a.last": 4, "a0": 5, "a0.v": 6, "a1": 7, "a1.v": 8, "a waiting": 9, "a waiting.v": 10,
    "b.last": 11, "b.past": 12, "b0": 13, "b0.n": 14, "b waiting": 15, "b waiting.n": 16,
    "c.last": 17, "c0": 18, "c waiting": 19, "d.last": 20, "d0": 21, "d waiting": 22,
}  # fmt: skip
"""Which number of a record of `RICH` is what."""


CASES: list[tuple[dict[str, int], int]] = [
    ({}, READY),
    ({"a0": RUNNING}, READY),
    ({"a0": STOPPING, "a1": RUNNING}, BROKEN_RULE),
    ({"a0": RUNNING, "b0": RUNNING, "b0.n": 1}, BROKEN_RULE),
    ({"b0": RUNNING, "b0.n": 1}, READY),
    ({"b0": RUNNING, "b0.n": 0}, BAD_VALUE),
    ({"b0": RUNNING, "b0.n": 4}, BAD_VALUE),
    ({"b0": RUNNING, "b0.n": 1, "battery": 5}, BROKEN_RULE),
    ({"b0": STOPPING, "b0.n": 1, "battery": 5}, READY),
    ({"c0": RUNNING, "d0": RUNNING}, BROKEN_RULE),
    ({"c0": RUNNING, "d0": RUNNING + 8 * 77}, BROKEN_RULE),
    ({"c0": RUNNING}, READY),
    ({"c0": RUNNING, "speed": 2}, BROKEN_RULE),
    ({"speed": 3}, BAD_VALUE),
    ({"battery": 101}, BAD_VALUE),
    ({"battery": -1}, BAD_VALUE),
    ({"speed_ok": 2}, BAD_VALUE),
    ({"ink": 6}, BAD_VALUE),
    ({"ink": -1}, BAD_VALUE),
    ({"b.past": 2}, BAD_VALUE),
    ({"b.past": 1}, READY),
    ({"a0": WAITING}, BAD_VALUE),
    ({"b waiting": WAITING, "b waiting.n": 2}, READY),
    ({"b waiting": WAITING, "b waiting.n": 7}, BAD_VALUE),
    ({"b waiting": RUNNING, "b waiting.n": 2}, BAD_VALUE),
    ({"c0": 7}, BAD_VALUE),
    ({"c0": RUNNING + 8 * 0xFFFFFFFF}, READY),
    ({"c0": RUNNING + 8 * 0x100000000}, BAD_VALUE),
    ({"c0": 1 << 40}, BAD_VALUE),
]


def changes(record: bytes) -> list[bytes]:
    """Return the records of `CASES`."""
    return [changed(record, {PLACES[name]: number for name, number in numbers.items()}) for numbers, _ in CASES]


@pytest.fixture(scope="module")
def outcomes(rich: Host) -> list[tuple[int, bool]]:
    return rich.outcome(*changes(rich.record()))


@pytest.mark.parametrize("case", range(len(CASES)), ids=lambda case: str(CASES[case][0]))
def test_what_comes_back_is_held_against_ranges_and_rules(case: int, outcomes: list[tuple[int, bool]]) -> None:
    _, status = CASES[case]
    assert outcomes[case] == (status, status != READY)


OTHERS = " ".join(f"request a{number}();" for number in range(2, 18))
HELD = f"""spec held; poster top: real in 0 .. 2 = 1; poster low: real in 0 .. 2 = 0.5; poster p: bool = false;
module m {{ request a0() {{ check low <= top; }} request a1() instances 2 {{ interrupts self; }} {OTHERS} }}
mutex near: m.a0, m.a4; mutex far: m.a0, m.a17; launch m.a2() when p; forbid x: p and active(m.a3);"""
TOP, P, A0, A0_ORIGIN, A1_0, A1_1, A3, A4, A17, REFUSED = 0, 2, 4, 6, 8, 9, 17, 21, 73, 76
"""Which number of a record of `HELD` is what."""
HELD_CASES: list[tuple[dict[int, int], int]] = [
    ({}, READY),
    ({TOP: bits(1.5)}, READY),
    ({TOP: bits(3.0)}, BAD_VALUE),
    ({A0_ORIGIN: 1}, READY),
    ({A0_ORIGIN: 1000}, BAD_VALUE),
    ({REFUSED: 2}, READY),
    ({REFUSED: 1}, BAD_VALUE),
    ({REFUSED: 2000}, BAD_VALUE),
    ({A0: RUNNING}, READY),
    ({A17: RUNNING}, READY),
    ({A0: RUNNING, A17: RUNNING}, BROKEN_RULE),
    ({A0: RUNNING, A4: RUNNING}, BROKEN_RULE),
    ({A1_0: RUNNING}, READY),
    ({A1_0: RUNNING, A1_1: RUNNING}, BROKEN_RULE),
    ({A3: RUNNING}, READY),
    ({A3: RUNNING, P: 1}, BROKEN_RULE),
]


def test_what_bit_rows_and_rules_without_kills_forbid_does_not_come_back(held: Host) -> None:
    """Across the blocks of a bit row, in the slots of one request; reals, origins and refusals in their ranges."""
    record = held.record()
    records = [changed(record, numbers) for numbers, _ in HELD_CASES]
    assert held.outcome(*records) == [(status, status != READY) for _, status in HELD_CASES]


def test_a_record_is_of_a_sound_checker_alone(held: Host) -> None:
    """None of a copy, of a faulty one, or of one of which a bit has changed that is met on the way."""
    assert held.run("exports") == ["0 0 0 0 0 0"]


def test_calls_that_no_host_should_make_are_refused(two: Host) -> None:
    """Resumed and swapped in turn; after a fault a checker that was resumed in vain stays live."""
    refused = [NO_TABLES] * 4 + [OTHER_BUILD] * 4 + [BAD_RECORD] * 2 + [NO_MEMORY, LIVE]
    assert two.run("calls") == [" ".join(map(str, refused))]


def test_a_map_that_says_what_no_proof_has_made_is_refused(rich: Host, tmp_path: Path) -> None:
    """Its checksum is right: lengths, places and lists that do not fit, and what is no record beside each."""
    content = packed(Carry(rich.found.compiled, rich.found.compiled), ("m.d",))
    idle, numbers, lists = struct.unpack_from("<III", content, 88)
    pairs, words = 100 + 4 * idle, 100 + 4 * idle + 8 * numbers
    assert idle == 2  # its slot and its waiting place

    def told(at: int, *what: int, cut: slice = slice(0, 0), more: bytes = b"") -> bytes:
        data = bytearray(content)
        struct.pack_into(f"<{len(what)}I", data, at, *what)
        del data[cut]
        data += more
        struct.pack_into("<I", data, 12, len(data))
        return sealed(bytes(data))

    longer = bytearray(told(pairs + 4, lists, more=struct.pack("<2I", 1000, 0)))
    struct.pack_into("<I", longer, 96, lists + 2)
    cases = [
        (content, READY),
        (told(92, numbers + 1), BAD_MAP),
        (told(92, numbers - 1, cut=slice(words - 8, words)), BAD_MAP),
        (told(100, 10_000), BAD_MAP),
        (told(pairs, 10_000), BAD_MAP),
        (told(pairs + 4, 10_000), BAD_VALUE),
        (sealed(bytes(longer)), BAD_VALUE),
        (told(20, 0), OTHER_TABLES),
    ]
    for number, (data, _) in enumerate(cases):
        (tmp_path / f"{number}.map").write_bytes(data)
    files = [str(tmp_path / f"{number}.map") for number in range(len(cases))]
    assert rich.run("maps", *files) == [f"{status} {BAD_RECORD}" for _, status in cases]


# ---- in Rust ----


@needs_rustc
@pytest.mark.parametrize("name", ["corners", "mixed2", "rover"])
def test_rust_goes_on_as_before_and_writes_what_c_writes(name: str, tmp_path: Path) -> None:
    found = built(ROOT / "tests/vectors" / f"{name}.exo")
    if name not in AS_EMITTED:
        found = build(found.model, unchecked=True)
    for language in ("c", "rust"):
        (tmp_path / language).mkdir()
    lines = lines_of(found, 150)
    in_rust, in_c = rust_host_of(found, tmp_path / "rust"), host_of(found, tmp_path / "c", name in AS_EMITTED)
    assert in_rust.run("trip", lines=lines) == ["150 0 0 0"]
    record, refused = in_rust.run("show", lines=lines)
    assert bytes.fromhex(record) == in_c.record(150, lines)
    assert refused == f"None ({LIVE}, {LIVE})"


@needs_rustc
def test_a_newcomer_that_supersedes_what_waits_has_the_place_since_its_own_step(tmp_path: Path) -> None:
    """Also of a request without parameters; in C wherever its arguments would stand, which an ask before tells."""
    text = "spec newer; module m { request a(); request b() { interrupts self; wait until not active(m.a); } }"
    found, (in_rust, in_c) = build(model_of(text)), (tmp_path / "rust", tmp_path / "c")
    for folder in (in_rust, in_c):
        folder.mkdir()
    hosts = {"rust": rust_host_of(found, in_rust), "c": host_of(found, in_c)}
    for before in ("w 1\n", "a 1 1 0000000000000000\n"):
        told = {name: host.run("show", "4", lines=f"{before}a 0 0\na 1 0\na 1 0\n") for name, host in hosts.items()}
        places = {name: struct.unpack_from("<q", bytes.fromhex(lines[0]), HEAD + 8 * 5) for name, lines in told.items()}
        assert places == {"rust": (WAITING + 8 * 4,), "c": (WAITING + 8 * 4,)}


@needs_rustc
def test_rust_holds_what_comes_back_against_ranges_and_rules(rich: Host, tmp_path: Path) -> None:
    host = rust_host_of(rich.found, tmp_path)
    record = rich.record()
    cases = list(zip(changes(record), (status for _, status in CASES), strict=True))
    cases += [(bytes([*record[:i], record[i] ^ 1 << i % 8, *record[i + 1 :]]), BAD_RECORD) for i in range(len(record))]
    cases += [(sealed(record[:-8]), BAD_RECORD), (sealed(record[:20] + b"!" + record[21:]), OTHER_TABLES)]
    assert host.outcome(*(data for data, _ in cases)) == [(status, status != READY) for _, status in cases]


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """Return a host of `TWO`."""
    return host_of(build(model_of(TWO)), tmp_path_factory.mktemp("two"))


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """Return a host of `HELD`."""
    return host_of(build(model_of(HELD)), tmp_path_factory.mktemp("held"))


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> Host:
    """Return a host of `RICH`."""
    return host_of(build(model_of(RICH)), tmp_path_factory.mktemp("rich"))
