"""Reads the bytes of a black box (docs/runtime.md): the runs that a checker recorded, in the numbers of exover.h.

The bytes come from a robot that had an accident: a line whose checksum is wrong does not count, and leaves a gap.
"""

import struct
from collections.abc import Iterable, Sequence
from functools import reduce
from itertools import pairwise

from exover.dataclass import dataclass

HEADER, LINE = struct.Struct("<4sIII32s12xI"), struct.Struct("<8I")
MAGIC, FORMAT = b"EXBX", 1
OPENED, ASK, REPORT, OBSERVE, LEVEL, ABORT, ABORT_WAITING, VALUES, ANSWER, END = range(1, 11)
EVENTS = range(ASK, VALUES)
SAID = {OPENED: 0, ASK: 1, REPORT: 4, OBSERVE: 1, LEVEL: 1, ABORT: 2, ABORT_WAITING: 1, ANSWER: 4, END: 2}
"""How many of its four last words a line of each kind uses, but of values."""
STEPS = 1 << 32
"""Step numbers are counted modulo this."""
ANEW = {(STEPS - 1, 0), (1 << 29, 1)}
"""Pairs of consecutive step numbers at which the count wraps. The second is of cells of 4 bytes, which tell the last
step modulo 2^29: the box adds 1."""


class NotABox(ValueError):
    """The bytes are no black box; the message says what is wrong with them."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line with a right checksum: its number, its step, its kind `what`, and its content."""

    number: int
    step: int
    what: int
    count: int
    words: tuple[int, int, int, int]


@dataclass(frozen=True, slots=True)
class BoxStep:
    """An event and its answers, in the numbers of exover.h; `number`: its step; `fault`: its status, None if no answer
    was recorded.
    """

    number: int
    what: int
    words: tuple[int, ...]
    count: int
    values: tuple[int, ...] = ()
    answers: tuple[tuple[int, ...], ...] = ()
    fault: int | None = None


@dataclass(frozen=True, slots=True)
class Box:
    """The recorded runs, the oldest first; a run is parted where lines of it are lost.

    `damaged`: the number of places that do not hold their line, and of steps whose lines do not fit; `lost`: of those,
    all but a line that may have been half written.
    """

    digest: bytes
    runs: tuple[tuple[BoxStep, ...], ...]
    damaged: int
    lost: int


# ---- the bytes ----


def read_box(data: bytes) -> Box:
    """Return the content of the memory of a black box; raises `NotABox`."""
    if len(data) < HEADER.size or data[:4] != MAGIC:
        raise NotABox("it does not begin as one, with EXBX")
    _, version, count, _, digest, check = HEADER.unpack_from(data)
    if version != FORMAT:
        raise NotABox(f"its format is {version}, and {FORMAT} is read")
    if _check(struct.unpack_from("<15I", data)) != check:
        raise NotABox("its header has changed")
    if len(data) < HEADER.size + count * LINE.size:
        raise NotABox(f"{HEADER.size + count * LINE.size} bytes belong to it, and {len(data)} are there")
    places = [LINE.unpack_from(data, HEADER.size + place * LINE.size) for place in range(count)]
    whole = {line.number: line for place, words in enumerate(places) if (line := _line(words, place, count))}
    newest = max(whole, default=0)
    lines = [whole[number] for number in range(max(newest - count, 0) + 1, newest + 1) if number in whole]
    held = {(line.number - 1) % count for line in lines}
    damaged = [place for place, words in enumerate(places) if place not in held and (any(words) or place < newest)]
    lost = sum(place != newest % count for place in damaged)  # the line behind the newest may be half written
    stretches = _stretches(lines)
    runs = [_Runs(each, cut=each is not stretches[-1]) for each in stretches]
    stray = sum(each.stray for each in runs)
    return Box(digest, tuple(run for each in runs for run in each.found), len(damaged) + stray, lost + stray)


def _check(words: Iterable[int]) -> int:
    return reduce(lambda total, word: (total ^ word) * 16777619 & 0xFFFFFFFF, words, 2166136261)


def _line(words: Sequence[int], place: int, count: int) -> Line | None:
    """Return the line in a place; None if its checksum is wrong, or if no checker writes such a line there."""
    low, step, what, a, b, c, e, check = words
    line = Line(low | what >> 24 << 32, step, what & 255, what >> 8 & 0xFFFF, (a, b, c, e))
    here = line.number > 0 and (line.number - 1) % count == place
    return line if check == _check(words[:7]) and here and _is_written(line) else None


def _is_written(line: Line) -> bool:
    """Return whether a checker writes such a line: of this kind, and 0 in what says nothing."""
    if line.what == VALUES:
        return line.count in (1, 2) and not any(line.words[2 * line.count :])
    counted = line.what in (ASK, REPORT, ANSWER) or line.count == (line.what in (OBSERVE, LEVEL))
    return line.what in SAID and counted and not any(line.words[SAID[line.what] :])


def _stretches(lines: Sequence[Line]) -> list[Sequence[Line]]:
    """Return lines, which are in order, parted at the gaps in their numbers."""
    gaps = [place for place, (left, right) in enumerate(pairwise(lines), 1) if right.number != left.number + 1]
    return [lines[start:end] for start, end in pairwise([0, *gaps, len(lines)])]


class _Runs:
    """The runs in lines that follow each other: one begins at each opening, and where step numbers do not go on.

    Lines of a step whose event is lost are left out, and so is a last step without an end if the lines are `cut` off.
    `stray`: how many groups of lines are no step though no line before them is lost; a run is parted there.
    """

    def __init__(self, lines: Sequence[Line], cut: bool) -> None:
        self.found: list[tuple[BoxStep, ...]] = []
        self.stray = 0
        self._run: list[BoxStep] = []
        groups = _groups(lines)
        while groups and groups[0][0].what not in (OPENED, *EVENTS):
            del groups[0]
        for group in groups:
            self._add(group)
        if self._run and cut and self._run[-1].fault is None:
            del self._run[-1]
        self._part()

    def _add(self, group: Sequence[Line]) -> None:
        step = _step(group)
        if step is None or (self._run and not _follows(step.number, self._run[-1])):
            self._part()
        if step is not None:
            self._run.append(step)
        elif group[0].what != OPENED:
            self.stray += 1

    def _part(self) -> None:
        if self._run:
            self.found.append(tuple(self._run))
        self._run = []


def _groups(lines: Iterable[Line]) -> list[list[Line]]:
    """Return lines by step: an event and what follows it until its end; any other line is alone."""
    found: list[list[Line]] = []
    for line in lines:
        if line.what in (VALUES, ANSWER, END) and found and found[-1][0].what in EVENTS and found[-1][-1].what != END:
            found[-1].append(line)
        else:
            found.append([line])
    return found


def _step(lines: Sequence[Line]) -> BoxStep | None:
    """Return the step of an event and the lines behind it, perhaps without an end; None if they are none."""
    event, end = lines[0], lines[-1] if lines[-1].what == END else None
    values, answers = ([line for line in lines if line.what == what] for what in (VALUES, ANSWER))
    if event.what not in EVENTS or [event, *values, *answers, *([end] if end else ())] != list(lines):
        return None
    held = tuple(value for line in values for value in _values(line))
    said = tuple((line.count, *map(_signed, line.words)) for line in answers)
    words, fault = tuple(map(_signed, event.words)), end.words[1] if end else None
    if len(held) > event.count or not _fit(event, values, answers, end) or (end and len(held) not in (0, event.count)):
        return None
    return BoxStep(event.step, event.what, words, event.count, held, said, fault)


def _fit(event: Line, values: Iterable[Line], answers: Sequence[Line], end: Line | None) -> bool:
    """Return whether lines tell the same step, and an end the number of answers; the count of a faulty checker does not
    reach the step of the event.
    """
    least = earlier(event.step) if end is None or end.words[1] else event.step
    known = {event.step, least, 0 if event.step == 1 << 29 else event.step}
    steps = {line.step for line in (*answers, *([end] if end else ()))}
    same = len(steps) <= 1 and steps <= known and all(line.step == event.step for line in values)
    return same and (end is None or end.words[0] == len(answers))


def _values(line: Line) -> tuple[int, ...]:
    a, b, c, e = line.words
    return (a | b << 32, c | e << 32)[: line.count]


def _follows(step: int, before: BoxStep) -> bool:
    """Return whether a step goes on with the run; the count of a faulty checker stands still."""
    return step - before.number == 1 or (before.number, step) in ANEW or (step == before.number and before.fault != 0)


def earlier(step: int) -> int:
    """Return the least number of steps before this one."""
    return (step - 1) % STEPS


def _signed(word: int) -> int:
    return word - (word >> 31 << 32)
