"""Audits one mission: reads it, asks the tables, and returns what was found (docs/audit.md)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from exover.audit import sources
from exover.audit.binary import NoMission, RecordReader, read_description
from exover.audit.checkers import ReferenceChecker, TableChecker
from exover.audit.follow import Follower
from exover.audit.mission import Noted, Unread, read_line
from exover.audit.native import MOST, NativeAuditor
from exover.audit.result import MOST_MISTAKES, MOST_ROWS, MissionResult, Mistake
from exover.audit.trail import AuditRow, MissionFigures
from exover.dataclass import dataclass
from exover.gate.binding import Binding
from exover.model.model import Model
from exover.model.wire_reading import is_blank
from exover.model.wording import counted
from exover.ocrd.tables import Tables

if TYPE_CHECKING:
    from exover.audit.table import RowTable


@dataclass(frozen=True)
class Job:
    """What missions are audited by: a spec, an engine and a binding; it can be sent to other processes.

    `library`: the audit in C (`compile_library`). Without it the tables are walked in Python, or with `reference` the
    reference interpreter answers.
    """

    model: Model
    tables: Tables
    library: bytes | None = None
    reference: bool = False
    binding: Binding | None = None
    folder: str | None = None
    """The folder for all rows as Parquet files; empty: the rows come with the result; None: no rows are wanted."""


class MissionAuditor:
    """Audits missions one after the other, in one thread."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._native = None if job.library is None else NativeAuditor(job.model, job.tables, job.library)

    def close(self) -> None:
        """Free the memory of the audit in C."""
        if self._native:
            self._native.close()

    def audit(self, path: str, name: str, number: int = 0) -> MissionResult:
        """Return the audit of the mission at `path`, called `name`; `number` tells the files of rows apart."""
        try:
            with self._table(name, number) as table:
                reading = _Reading(self._job, self._native, table)
                error = reading.read(path)
                figures = reading.figures()
                error = error or reading.fault(figures)
        except OSError as problem:
            return MissionResult(name, error=f"it cannot be read: {problem.strerror or problem}")
        if error:
            return MissionResult(name, error=error)
        notes = tuple(_notes(figures, reading.notes))
        found = reading.found
        return MissionResult(
            name,
            figures.plain(),
            tuple(found.rows),
            tuple(found.mistakes),
            found.mistake_count,
            notes,
            table=table.made,
        )

    def _table(self, name: str, number: int) -> RowTable | _NoTable:
        if self._job.folder is None:
            return _NoTable()
        from exover.audit.table import RowTable

        return RowTable(name, self._job.folder, number)


class _NoTable:
    """Discards rows."""

    made: None = None
    wanted = False

    def __enter__(self) -> _NoTable:
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""

    def add(self, row: AuditRow) -> None:
        """Do nothing."""


@dataclass(slots=True)
class _Found:
    """Divergences and mistakes of a mission that are kept with their lines."""

    rows: list[AuditRow] = field(default_factory=list)
    mistakes: list[Mistake] = field(default_factory=list)
    mistake_count: int = 0
    none: bool = False
    """Whether a line is neither an event nor a deed of any spec."""

    def mistake(self, line: int, text: str) -> None:
        self.mistake_count += 1
        if len(self.mistakes) < MOST_MISTAKES:
            self.mistakes.append(Mistake(line, text))


class _Reading:
    """The reading of one mission."""

    def __init__(self, job: Job, native: NativeAuditor | None, table: RowTable | _NoTable) -> None:
        self._job, self._native, self._table = job, native, table
        self.found = _Found()
        self.notes: list[str] = []
        self._none = ""
        """What is wrong if none of the lines is an event or a deed; empty if that is told of each."""
        if native:
            native.start(self._tell, table.wanted, MOST if table.wanted else MOST_ROWS)
            self._take: Callable[[int, Noted], None] = native.take
            self._figures: Callable[[], MissionFigures] = native.figures
        else:
            checker = ReferenceChecker(job.model) if job.reference else TableChecker(job.model, job.tables)
            follower = Follower(job.model, checker, self._tell, table.wanted)
            self._take, self._figures = follower.take, lambda: follower.figures

    def figures(self) -> MissionFigures:
        """Return the counts."""
        return self._figures()

    def fault(self, figures: MissionFigures) -> str:
        """Return what is wrong if lines were read and none of them is a line of a mission, else an empty text."""
        return self._none if self.found.none and not figures.events + figures.deeds else ""

    def _tell(self, row: AuditRow) -> None:
        self._table.add(row)
        if row.kind != "ask" and len(self.found.rows) < MOST_ROWS:
            self.found.rows.append(row)

    def read(self, path: str) -> str:
        """Read a mission to its end; return why it is no mission, or an empty text. Raises `OSError`."""
        if sources.is_bag(path):
            return self._read_bag(path)
        if os.path.isdir(path):
            os.listdir(path)  # raises what keeps the folder from being read
        if path.endswith(sources.TABLES):
            from exover.audit import parquet

            self._none = f"no row of it is an event: its column kind is none of {parquet.KNOWN}"
            return self._all(parquet.rows(self._job.model, path))
        with Path(path).open("rb") as file:
            if sources.has_records(path, file):
                return self._read_records(file)
            self._none = "no line of it is an event: write one JSON object a line"
            if self._native is None:
                return self._all(sources.whole_lines(self._job.model, file))
            native = self._native
            sources.pieces(
                file,
                lambda data, last: native.lines(data, last, self._line),
                lambda line: self._noted(native.place() + 1, read_line(self._job.model, line)),
            )
        return ""

    def _read_bag(self, path: str) -> str:
        from exover.audit import bags

        Path(path).stat()  # raises first if the path does not exist
        if self._job.binding is None:
            return "it is a bag, and nothing says which topics are which requests: give --bind"
        bag = bags.Bag(self._job.model, self._job.binding, path)
        error = self._all(bag.messages())
        self.notes += bag.notes()
        return error

    def _read_records(self, file: BinaryIO) -> str:
        try:
            reader = RecordReader(self._job.model, read_description(file))
        except NoMission as reason:
            return f"it is no mission: {reason}"
        native = self._native
        if native is None or not reader.same:
            return self._all(sources.records(reader, file))

        def odd(number: int, record: bytes, _: bytes) -> Noted:
            return self._seen(number, reader.read(record))

        try:
            sources.record_pieces(file, lambda data: native.records(data, odd))
        except NoMission as reason:
            self.found.mistake(native.place() + 1, str(reason))
        return ""

    def _all(self, noted: Iterator[tuple[int, Noted]]) -> str:
        number = 0
        try:
            for number, each in noted:
                self._noted(number, each)
        except NoMission as reason:
            if not number:
                return f"it is no mission: {reason}"
            self.found.mistake(number + 1, str(reason))
        return ""

    def _line(self, number: int, line: bytes, behind: bytes) -> Noted | None:
        return None if is_blank(line) else self._seen(number, read_line(self._job.model, line, behind))

    def _noted(self, number: int, noted: Noted) -> None:
        self._take(number, self._seen(number, noted))

    def _seen(self, number: int, noted: Noted) -> Noted:
        """Keep the mistakes of a line, and return it."""
        if noted.fault:
            self.found.mistake(number, f"{noted.fault.code}: {noted.fault.detail}")
        for item in noted.items:
            if isinstance(item, Unread) and item.foreign:
                self.found.mistake(number, f"{item.fault.code}: {item.fault.detail}")
                self.found.none |= item.kind == "other"
        return noted


def _notes(figures: MissionFigures, notes: list[str]) -> Iterator[str]:
    yield from notes
    if not figures.events + figures.deeds:
        yield "it has no events"
    if figures.undecided:
        yield f"{counted(figures.undecided, 'launch', 'launches')} undecided: no arguments are recorded"
    if figures.lost:
        yield f"{counted(figures.lost, 'line')} of it missing"
