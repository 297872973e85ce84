"""What an event does to the loop, as small steps: the language in which the closed loop is given to engines.

A program is a sequence of operations on variables with finite domains `0 .. size - 1`; guards are nodes of the decoded
tables. Every operation but `Choose` is deterministic.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import assert_never


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the loop; `key` says what it is, for people and for reading concrete states."""

    key: tuple[object, ...]
    size: int
    initial: int


@dataclass(frozen=True, slots=True)
class Assign:
    """`var := value`."""

    var: int
    value: int


@dataclass(frozen=True, slots=True)
class Apply:
    """`var := mapping[var]`; a value mapped to None cannot occur here."""

    var: int
    mapping: tuple[int | None, ...]


@dataclass(frozen=True, slots=True)
class Choose:
    """`var :=` any of `values`."""

    var: int
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Require:
    """Only runs on which `var` is one of `values` go on."""

    var: int
    values: frozenset[int]


@dataclass(frozen=True, slots=True)
class Switch:
    """Go on with `cases[var]`."""

    var: int
    cases: tuple["Program", ...]


@dataclass(frozen=True, slots=True)
class Walk:
    """Follow the tables from `root`, entries of `fixed` having these values.

    At an action node do what `on` has for it; a path that meets no action does `end`.
    """

    root: int
    fixed: tuple[tuple[int, int], ...]
    on: tuple[tuple[int, "Program"], ...]
    end: "Program" = ()


@dataclass(frozen=True, slots=True)
class Mark:
    """Something happens here that checks ask for.

    `launch r`; an action that names `rule x`; what x demands is taken: `reject x`, `wait x`, `settle x`; or a slot of r
    is killed, or what waits there given up, for x: `kill x r`.
    """

    label: tuple[str, ...]


Op = Assign | Apply | Choose | Require | Switch | Walk | Mark
Program = tuple[Op, ...]


def writes(program: Program) -> Iterator[int]:
    """Yield the variables that a program may change."""
    for op in program:
        match op:
            case Assign(var) | Apply(var) | Choose(var):
                yield var
            case Switch(_, cases):
                for case in cases:
                    yield from writes(case)
            case Walk(_, _, on, end):
                for _, part in on:
                    yield from writes(part)
                yield from writes(end)
            case Require() | Mark():
                pass
            case _:
                assert_never(op)


def marks(program: Program) -> Iterator[tuple[str, ...]]:
    """Yield the marks that a program may pass."""
    for op in program:
        match op:
            case Mark(label):
                yield label
            case Switch(_, cases):
                for case in cases:
                    yield from marks(case)
            case Walk(_, _, on, end):
                for _, part in on:
                    yield from marks(part)
                yield from marks(end)
            case Assign() | Apply() | Choose() | Require():
                pass
            case _:
                assert_never(op)


def walks(program: Program) -> Iterator[Walk]:
    """Yield the walks of a program, those within others too."""
    for op in program:
        match op:
            case Walk(_, _, on, end):
                yield op
                for _, part in on:
                    yield from walks(part)
                yield from walks(end)
            case Switch(_, cases):
                for case in cases:
                    yield from walks(case)
            case Assign() | Apply() | Choose() | Require() | Mark():
                pass
            case _:
                assert_never(op)


def switched(program: Program) -> Iterator[int]:
    """Yield the variables that a program looks at, those in the guards of walks left out."""
    for op in program:
        match op:
            case Switch(var, cases):
                yield var
                for case in cases:
                    yield from switched(case)
            case Walk(_, _, on, end):
                for _, part in on:
                    yield from switched(part)
                yield from switched(end)
            case Require(var) | Apply(var):
                yield var
            case Assign() | Choose() | Mark():
                pass
            case _:
                assert_never(op)
