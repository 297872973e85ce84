"""Packs a map from OLD to NEW as `exover_swap` reads it (docs/runtime.md, "Restarts, and other tables")."""

import struct
import zlib
from collections.abc import Iterable

from exover.ocrd.packing import HEADER, pack
from exover.ocrd.tables import Tables
from exover.swap.carry import AS_IT_IS, Carry
from exover.swap.record import CarriedPhase

MAGIC, VERSION = b"EXOM", 1
NONE = 0xFFFFFFFF


def packed(carry: Carry, ended: Iterable[str]) -> bytes:
    """Return the bytes of the map from OLD to NEW; the requests `ended` of OLD have to be idle."""
    gone = set(ended)
    idle = [at for number, at in carry.before.items() if isinstance(number, CarriedPhase) and number.request in gone]
    pairs: list[int] = []
    lists: list[int] = []
    places: dict[tuple[int, ...], int] = {AS_IT_IS: NONE}
    for way in carry.ways():
        source, becomes = way or (NONE, AS_IT_IS)
        if becomes not in places:
            places[becomes] = len(lists)
            lists += [len(becomes), *becomes]
        pairs += [source, places[becomes]]
    words = [len(idle), len(pairs) // 2, len(lists), *idle, *pairs, *(word & NONE for word in lists)]
    body = _tables(carry.old.tables) + _tables(carry.new.tables) + struct.pack(f"<{len(words)}I", *words)
    length = 16 + len(body)

    def head(crc: int) -> bytes:
        return MAGIC + struct.pack("<III", VERSION, crc, length)

    return head(zlib.crc32(head(0) + body)) + body


def _tables(tables: Tables) -> bytes:
    _, _, _, _, crc, _, spec = HEADER.unpack_from(pack(tables))
    return bytes(spec) + struct.pack("<I", crc)
