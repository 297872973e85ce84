"""Parsers of what ABC prints and writes."""

import re
from collections.abc import Iterator

from exover.dataclass import dataclass

COLOUR = re.compile(r"\x1b\[[0-9;]*m")
PROPERTIES = re.compile(
    r"^Properties:\s+All = (\d+)\. Proved = (\d+)\. Disproved = (\d+)\. Undecided = (\d+)\.", re.MULTILINE
)
TIMED_OUT = re.compile(r"^Timing out on output +(\d+) ", re.MULTILINE)
RUN = re.compile(r"^# CEX for output (\d+)$", re.MULTILINE)
LATCH = re.compile(r"l(\d+)")

LatchValues = dict[int, bool]
"""Values of latches, by their places."""
Steps = tuple[tuple[bool, ...], ...]
"""By step the values of the inputs."""


class NoOutput(ValueError):
    """The text is not what ABC writes; the message says where."""


@dataclass(frozen=True, slots=True)
class Tally:
    """How many outputs ABC says that it proved, disproved, and left undecided; `late`: the outputs that timed out."""

    proved: int
    disproved: int
    undecided: int
    late: frozenset[int] = frozenset()


def tally(printed: str) -> Tally | None:
    """Return what the last line `Properties:` of `pdr -a` says; None if there is none, or its sums are wrong."""
    printed = COLOUR.sub("", printed)
    found = PROPERTIES.findall(printed)
    if not found:
        return None
    every, proved, disproved, undecided = map(int, found[-1])
    late = frozenset(map(int, TIMED_OUT.findall(printed)))
    return Tally(proved, disproved, undecided, late) if proved + disproved + undecided == every else None


def clauses(text: str) -> list[LatchValues]:
    """Return the cubes that the clauses of `pdr -d` exclude; latches are named l0, l1, … Raises `NoOutput`."""
    names: list[int] = []
    found: list[LatchValues] = []
    for line in text.splitlines():
        if line.startswith(".ilb"):
            names = [_latch(name) for name in line.split()[1:]]
        elif line and line[0] in "01-":
            bits = line.split()[0]
            if len(bits) != len(names) or set(bits) - set("01-"):
                raise NoOutput("a clause of the invariant")
            found.append({place: bit == "1" for place, bit in zip(names, bits, strict=True) if bit != "-"})
    return found


def _latch(name: str) -> int:
    match = LATCH.fullmatch(name)
    if match is None:
        raise NoOutput("the name of a latch")
    return int(match[1])


def runs(text: str, inputs: int) -> dict[int, Steps]:
    """Return the runs that `write_cex -a` wrote, by output; `inputs`: how many a step has. Raises `NoOutput`."""
    return dict(_runs(text, inputs))


def _runs(text: str, inputs: int) -> Iterator[tuple[int, Steps]]:
    parts = RUN.split(text)
    for output, body in zip(parts[1::2], parts[2::2], strict=True):
        lines = [line for line in re.sub("#.*", "", body).splitlines() if line]
        steps = lines[1:]
        if not steps or any(len(line) != inputs or set(line) - set("01") for line in steps):
            raise NoOutput(f"the run for output {output}")
        yield int(output), tuple(tuple(bit == "1" for bit in line) for line in steps)
