"""Reads missions from Parquet tables (docs/audit.md, "Tables"; extra `exover[audit]`)."""

import math
from collections.abc import Iterator
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from exover.audit.binary import NoMission
from exover.audit.mission import DEEDS, KINDS, Noted, Unread, read_noted, read_time
from exover.diagnostics import quote
from exover.model.event import Invalid
from exover.model.model import Model
from exover.model.wire import Json
from exover.model.wire_reading import read_object, shown

COLUMNS = ("time", "kind", "name", "instance", "args", "results", "outcome", "status", "value", "waiting", "actions")
VALUES = ("args", "results", "value", "actions")
"""Columns that may hold JSON as text."""
KNOWN = ", ".join((*KINDS, *DEEDS))
UNITS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
"""Units of timestamps in a second."""


def rows(model: Model, path: str) -> Iterator[tuple[int, Noted]]:
    """Yield number, from 1, and content of each row; raises `NoMission` and `OSError`."""
    for number, row in enumerate(_rows(path), 1):
        yield number, _noted(model, row)


def _rows(path: str) -> Iterator[dict[str, Any]]:
    """Yield the cells of each row by column."""
    try:
        with open(path, "rb") as raw, pq.ParquetFile(raw) as file:  # of a path, pyarrow wants UTF-8
            names = file.schema_arrow.names
            known = [name for name in COLUMNS if name in names]
            missing = [name for name in ("kind", "name") if name not in known]
            if missing:
                raise NoMission(f"it has no column {' and no column '.join(missing)}")
            twice = [name for name in known if names.count(name) > 1]
            if twice:
                raise NoMission(f"it has more than one column {' and more than one column '.join(twice)}")
            for batch in file.iter_batches(columns=known):
                columns = [_cells(name, batch[name]) for name in known]
                for cells in zip(*columns, strict=True):
                    yield dict(zip(known, cells, strict=True))
    except NoMission:
        raise
    except Exception as error:  # a damaged file may raise anything
        if isinstance(error, OSError) and error.strerror:
            raise
        told = str(error).splitlines() if isinstance(error, pa.ArrowException | OSError) else []
        raise NoMission(f"it is no Parquet: {told[0] if told else 'it is damaged'}") from error


def _cells(name: str, column: pa.Array) -> list[Any]:
    """Return the values of a column: of a timestamp its seconds, and of what cannot be read an `Invalid`."""
    if name == "time" and pa.types.is_timestamp(column.type):
        units = UNITS[column.type.unit]
        return [None if each is None else each / units for each in column.cast(pa.int64()).to_pylist()]
    try:
        found: list[Any] = column.to_pylist()
    except (pa.ArrowException, ValueError, OverflowError):
        return [_cell(name, each) for each in column]
    return found


def _cell(name: str, cell: pa.Scalar) -> Any:
    try:
        return cell.as_py()
    except UnicodeDecodeError as error:
        return Invalid("bad-event", f"`{name}` is not UTF-8: {error.reason} at byte {error.start + 1}")
    except (pa.ArrowException, ValueError, OverflowError):  # a time, within other values, that Python cannot hold
        return Invalid("bad-event", f"`{name}` is {quote(str(cell.type))}, with a value that cannot be read")


def _noted(model: Model, row: dict[str, Any]) -> Noted:
    time = _seconds(row.pop("time", None))
    fault = next((found for found in row.values() if isinstance(found, Invalid)), None)
    kind = row["kind"]
    if fault:
        return Noted((Unread(fault, "event" if kind in KINDS else "deed" if kind in DEEDS else "other"),), *time)
    if kind not in (*KINDS, *DEEDS):
        return Noted((Unread(Invalid("bad-event", f"`kind` is {shown(kind)}, none of {KNOWN}")),), *time)
    entries: Json = {kind: row["name"]}
    for name, found in row.items():
        if name in ("kind", "name") or found is None:
            continue
        entries[name] = _json(found) if name in VALUES else found
    return Noted(read_noted(model, entries).items, *time)


def _json(found: Any) -> Any:
    """Return the value of a cell: JSON in a text is read; other text stays, as the name of an enum value."""
    if not isinstance(found, str):
        return _there(found)
    read = read_object(f'{{"value": {found}}}')
    return found if isinstance(read, Invalid) or read.keys() != {"value"} else read["value"]


def _there(found: Any) -> Any:
    """Return a value without the null fields of structs, which other rows have; a map becomes an object."""
    match found:
        case dict():
            return {key: _there(value) for key, value in found.items() if value is not None}
        case [(str(), _), *_] if all(isinstance(pair, tuple) for pair in found):
            return {key: _there(value) for key, value in found if value is not None}
        case list():
            return [_there(value) for value in found]
        case _:
            return found


def _seconds(found: Any) -> tuple[float, Invalid | None]:
    return (math.nan, found) if isinstance(found, Invalid) else read_time(found)
