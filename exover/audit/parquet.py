"""Reads missions from Parquet tables (docs/audit.md, "Tables"; extra `exover[audit]`)."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from exover.audit.binary import NoMission
from exover.audit.mission import DEEDS, KINDS, Noted, Unread, read_noted, read_time
from exover.model.event import Invalid
from exover.model.model import Model
from exover.model.wire import Json
from exover.model.wire_reading import read_object

COLUMNS = ("time", "kind", "name", "instance", "args", "results", "outcome", "status", "value", "waiting", "actions")
VALUES = ("args", "results", "value", "actions")
"""Columns that may hold JSON as text."""


def rows(model: Model, path: str) -> Iterator[tuple[int, Noted]]:
    """Yield number, from 1, and content of each row; raises `NoMission` and `OSError`."""
    try:
        with pq.ParquetFile(path) as file:
            known = [name for name in COLUMNS if name in file.schema_arrow.names]
            missing = [name for name in ("kind", "name") if name not in known]
            if missing:
                raise NoMission(f"it has no column {' and no column '.join(missing)}")
            number = 0
            for batch in file.iter_batches(columns=known):
                for row in batch.to_pylist():
                    number += 1
                    yield number, _noted(model, row)
    except pa.ArrowException as error:
        raise NoMission(f"it is no Parquet: {str(error).splitlines()[0]}") from error


def _noted(model: Model, row: Mapping[str, Any]) -> Noted:
    kind = row["kind"]
    if kind not in (*KINDS, *DEEDS):
        return Noted((Unread(Invalid("bad-event", f"the kind is {kind!r}, none of {', '.join((*KINDS, *DEEDS))}")),))
    entries: Json = {kind: row["name"]}
    for name, found in row.items():
        if name in ("kind", "name", "time") or found is None:
            continue
        entries[name] = _json(found) if name in VALUES else found
    return Noted(read_noted(model, entries).items, *_seconds(row.get("time")))


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
    if isinstance(found, datetime):
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp(), None
    return read_time(found)
