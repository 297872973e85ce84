"""Writes all rows of missions as Parquet (extra `exover[audit]`)."""

import math
import os
from collections.abc import Iterable
from io import BytesIO
from types import TracebackType
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from exover.audit.trail import AuditRow
from exover.model.wire import escaped

BATCH = 65_536
"""The rows of a row group."""
SCHEMA = pa.schema(
    [
        ("mission", pa.string()),
        ("line", pa.int64()),
        ("time", pa.float64()),
        ("kind", pa.string()),
        ("request", pa.string()),
        ("instance", pa.int32()),
        ("answer", pa.string()),
        ("rule", pa.string()),
    ]
)


class RowTable:
    """Writes the rows of a mission to a file in `folder` or, if that is empty, into memory; raises `OSError`."""

    wanted = True

    def __init__(self, mission: str, folder: str, number: int) -> None:
        self._mission = escaped(mission)
        self._memory = BytesIO()
        self._path = os.path.join(folder, f"{number}.parquet") if folder else None
        self._columns: list[list[Any]] = [[] for _ in SCHEMA]

    def __enter__(self) -> "RowTable":
        """Open the file."""
        self._writer = pq.ParquetWriter(self._path or self._memory, SCHEMA)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write the remaining rows, and close the file."""
        self._flush()
        self._writer.close()

    @property
    def made(self) -> bytes | str:
        """The path of the file, or the bytes that were written."""
        return self._path or self._memory.getvalue()

    def add(self, row: AuditRow) -> None:
        """Add a row."""
        time = None if math.isnan(row.time) else row.time
        answer = None if row.answer == "none" else row.answer
        found = (self._mission, row.line, time, row.kind, row.request, row.instance, answer, row.rule)
        for column, value in zip(self._columns, found, strict=True):
            column.append(value)
        if len(self._columns[0]) >= BATCH:
            self._flush()

    def _flush(self) -> None:
        if self._columns[0]:
            arrays = [pa.array(values, kind.type) for values, kind in zip(self._columns, SCHEMA, strict=True)]
            self._writer.write_table(pa.table(arrays, SCHEMA))
            self._columns = [[] for _ in SCHEMA]


def merge(tables: Iterable[bytes | str | None], path: str) -> None:
    """Write the rows of all missions, in this order, to one file; raises `OSError`."""
    with pq.ParquetWriter(path, SCHEMA) as writer:
        for table in tables:
            if table is None:
                continue
            source = pq.ParquetFile(BytesIO(table) if isinstance(table, bytes) else table)
            for batch in source.iter_batches(BATCH):
                writer.write_batch(batch)
