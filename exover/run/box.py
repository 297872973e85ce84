"""Reads the bytes of a black box (docs/runtime.md): the runs that a checker recorded, in the numbers of exover.h.

The bytes come from a robot that had an accident: a line whose checksum is wrong does not count, and leaves a gap.
"""

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import pairwise

from exover.dataclass import dataclass

HEADER, LINE = struct.Struct("<4sIII32s12xI"), struct.Struct("<8I")
MAGIC, FORMAT = b"EXBX", 1
OPENED, ASK, REPORT, OBSERVE, LEVEL, ABORT, ABORT_WAITING, VALUES, ANSWER, END = range(1, 11)
EVENTS = range(ASK, VALUES)
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

    `damaged`: the number of lines with a wrong checksum; `lost`: of those, the ones that had been written whole.
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
    lines = sorted((_line(words) for words in places if _whole(words)), key=lambda line: line.number)
    newest = lines[-1].number if lines else 0
    damaged = [place for place, words in enumerate(places) if not _whole(words) and (any(words) or place < newest)]
    lost = sum(place != newest % count for place in damaged)  # the line behind the newest may be half written
    stretches = _stretches(lines)
    runs = [run for each in stretches for run in _runs(each, cut=each is not stretches[-1])]
    return Box(digest, tuple(runs), len(damaged), lost)


def _check(words: Iterable[int]) -> int:
    return reduce(lambda total, word: (total ^ word) * 16777619 & 0xFFFFFFFF, words, 2166136261)


def _whole(words: Sequence[int]) -> bool:
    return _check(words[:7]) == words[7]


def _line(words: Sequence[int]) -> Line:
    low, step, what, a, b, c, e, _ = words
    return Line(low | what >> 24 << 32, step, what & 255, what >> 8 & 0xFFFF, (a, b, c, e))


def _stretches(lines: Sequence[Line]) -> list[Sequence[Line]]:
    """Return lines, which are in order, parted at the gaps in their numbers."""
    gaps = [place for place, (left, right) in enumerate(pairwise(lines), 1) if right.number != left.number + 1]
    return [lines[start:end] for start, end in pairwise([0, *gaps, len(lines)])]


def _runs(lines: Iterable[Line], cut: bool) -> Iterator[tuple[BoxStep, ...]]:
    """Yield the runs: a new one begins at each opening, and where step numbers do not follow each other.

    Lines of a step whose event is lost are left out, and so is a last step without an end if the lines are `cut` off.
    """
    run: list[BoxStep] = []
    for line in lines:
        if run and (line.what == OPENED or (line.what in EVENTS and not _follows(line.step, run[-1].number))):
            yield tuple(run)
            run = []
        if line.what in EVENTS:
            run.append(BoxStep(line.step, line.what, tuple(map(_signed, line.words)), line.count))
        elif run and run[-1].fault is None:
            run[-1] = _more(run[-1], line)
    if run and cut and run[-1].fault is None:
        del run[-1]
    if run:
        yield tuple(run)


def _follows(step: int, before: int) -> bool:
    return step - before in (0, 1) or (before, step) in ANEW


def earlier(step: int) -> int:
    """Return the least number of steps before this one."""
    return (step - 1) % STEPS


def _more(step: BoxStep, line: Line) -> BoxStep:
    """Return a step with the values, answer or status of a line behind its event."""
    a, b, c, e = line.words
    if line.what == VALUES:
        return replace(step, values=(*step.values, *(a | b << 32, c | e << 32)[: line.count]))
    if line.what == ANSWER:
        return replace(step, answers=(*step.answers, (line.count, *map(_signed, line.words))))
    return replace(step, fault=b)


def _signed(word: int) -> int:
    return word - (word >> 31 << 32)
