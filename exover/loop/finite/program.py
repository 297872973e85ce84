"""Programs: the language of small operations in which the closed loop is given to engines.

A program is a sequence of operations on variables with finite domains `0 .. size - 1`; guards are nodes of the decoded
tables. Every operation but `Choose` is deterministic.
"""

from collections.abc import Iterator
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.property import Label


@dataclass(frozen=True, slots=True)
class FiniteVariable:
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
    branches: "tuple[SwitchCase, ...]" = field(init=False, repr=False, compare=False)
    """The different cases, each with the values for which it is done."""
    _hash: int = field(init=False, repr=False, compare=False)
    """Made once: programs share their parts, so that the paths through them are many more than these."""

    def __post_init__(self) -> None:
        found: dict[Program, tuple[int, ...]] = {}
        for value, case in enumerate(self.cases):
            found[case] = (*found.get(case, ()), value)
        object.__setattr__(self, "branches", tuple(found.items()))
        object.__setattr__(self, "_hash", hash((self.var, self.cases)))

    def __hash__(self) -> int:
        return self._hash


@dataclass(frozen=True, slots=True)
class Walk:
    """Follow the tables from `root`, entries of `fixed` having these values.

    At an action node do what `on` has for it; a path that meets no action does `end`.
    """

    root: int
    fixed: tuple[tuple[int, int], ...]
    on: tuple[tuple[int, "Program"], ...]
    end: "Program" = ()
    _hash: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((self.root, self.fixed, self.on, self.end)))

    def __hash__(self) -> int:
        return self._hash


@dataclass(frozen=True, slots=True)
class Mark:
    """An occurrence that checks ask for.

    `launch r`: r is launched. `rule x`: an action names x. `reject x`, `wait x`, `settle x`: the demand of x is taken.
    `kill x r`: a slot of r is killed, or the waiting r given up, for x. `left r`: r no longer waits. `abort`: the
    environment aborts something.
    """

    label: Label


Op = Assign | Apply | Choose | Require | Switch | Walk | Mark
Program = tuple[Op, ...]
SwitchCase = tuple[Program, tuple[int, ...]]


def operations(program: Program) -> Iterator[Op]:
    """Yield the operations of a program, nested ones included; those of a shared part once."""
    seen: set[int] = set()
    stack = [program]
    while stack:
        part = stack.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        for op in part:
            yield op
            match op:
                case Switch(_, cases):
                    stack += cases
                case Walk(_, _, on, end):
                    stack += [each for _, each in on]
                    stack.append(end)
                case Assign() | Apply() | Choose() | Require() | Mark():
                    pass
                case _:
                    assert_never(op)


def writes(program: Program) -> Iterator[int]:
    """Yield the variables that a program may change."""
    return (op.var for op in operations(program) if isinstance(op, Assign | Apply | Choose))


def walks(program: Program) -> Iterator[Walk]:
    """Yield the walks of a program."""
    return (op for op in operations(program) if isinstance(op, Walk))


def switched(program: Program) -> Iterator[int]:
    """Yield the variables that a program reads, except those that walks test."""
    return (op.var for op in operations(program) if isinstance(op, Switch | Require | Apply))
