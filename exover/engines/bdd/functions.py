"""What a program does, as functions: each bit that it may change, after it, in terms of the bits before it.

All operations but `Choose` are deterministic, so a step is a vector of Boolean functions, and a preimage one
substitution (Coudert, Berthet, Madre 1989); a choice is an input. Only bits that change have a function, and those stay
on the few bits that decide them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.bdd.space import Set, Space
from exover.loop.finite.execution import SymbolicExecution
from exover.loop.finite.program import Program
from exover.model.property import Label
from exover.ocrd.tables import Node, Tables


@dataclass(frozen=True)
class Function:
    """A program: where it can be run, the bits after it, from where it passes a mark, the inputs that it chooses."""

    enabled: Set
    bits: Mapping[str, Set]
    marks: Mapping[Label, Set]
    inputs: frozenset[str]


class Functions:
    """Makes functions of programs, composes them, and takes preimages."""

    def __init__(self, space: Space) -> None:
        self.space = space
        self._made: dict[int, Function] = {}

    def of(self, program: Program, family: str) -> Function:
        """Return the function of a program of the loop, which lives as long as that; its inputs are of this family.

        Programs of one step have inputs of different families.
        """
        found = self._made.get(id(program))
        if found is None:
            execution = _Execution(self.space, self.space.all, family)
            execution.run(program, self.space.all)
            marks = {label: states & execution.enabled for label, states in execution.marks.items()}
            found = Function(execution.enabled, execution.bits, marks, frozenset(execution.inputs))
            self._made[id(program)] = found
        return found

    def then(self, first: Function, second: Function) -> Function:
        """Return the function of running one program after the other; the second can always be run."""
        bits = dict(first.bits) | {name: self.after(value, first) for name, value in second.bits.items()}
        return Function(first.enabled, bits, self._marks(first, second), first.inputs | second.inputs)

    def past(self, first: Function, second: Function) -> Function:
        """Return the function of the first program, with the marks of the second, which changes nothing after it."""
        return Function(first.enabled, first.bits, self._marks(first, second), first.inputs)

    def _marks(self, first: Function, second: Function) -> dict[Label, Set]:
        """Return from where one program, or the other after it, passes a mark."""
        marks = dict(first.marks)
        for label, states in second.marks.items():
            marks[label] = marks.get(label, self.space.none) | (self.after(states, first) & first.enabled)
        return marks

    def after(self, states: Set, function: Function) -> Set:
        """Return where `states` is true once the function was applied, wherever it can be, for given inputs."""
        return _after(self.space, states, function.bits)

    def changing(self, function: Function) -> Set:
        """Return the states in which the function may change something."""
        found = self.space.none
        for name, value in function.bits.items():
            found |= self.space.bdd.apply("^", value, self.space.bdd.var(name))
        return self.chosen(found & function.enabled, function)

    def pre(self, states: Set, function: Function) -> Set:
        """Return the states from which the function leads into `states`."""
        return self.chosen(self.after(states, function) & function.enabled, function)

    def chosen(self, states: Set, function: Function) -> Set:
        """Return the states for which some inputs are as in `states`."""
        return self.space.bdd.exist(function.inputs, states) if function.inputs else states


def _after(space: Space, states: Set, bits: Mapping[str, Set]) -> Set:
    """Return where `states` is true once these bits have their values, those of the state before."""
    return space.bdd.let(bits, states) if bits else states


@dataclass
class _Execution(SymbolicExecution[Set]):
    """Symbolic execution of one program; `enabled`: where it has not been stopped so far."""

    space: Space
    enabled: Set
    family: str
    bits: dict[str, Set] = field(default_factory=dict)
    marks: dict[Label, Set] = field(default_factory=dict)
    inputs: list[str] = field(default_factory=list)

    @property
    def tables(self) -> Tables:
        """The tables that walks follow."""
        return self.space.loop.tables

    @property
    def none(self) -> Set:
        """No state."""
        return self.space.none

    def assign(self, var: int, value: int, where: Set) -> None:
        """Give a variable a value."""
        self._set(var, [(self.space.all, value)], where)

    def apply(self, var: int, mapping: tuple[int | None, ...], where: Set) -> None:
        """Give a variable the image of the value that it has."""
        images = [(self._now(self.space.is_value(var, v)), image) for v, image in enumerate(mapping)]
        self._set(var, [(guard, image) for guard, image in images if image is not None], where)

    def choose(self, var: int, values: tuple[int, ...], where: Set) -> None:
        """Give a variable one of these values, by an input."""
        self._set(var, self._choices(values), where)

    def require(self, var: int, values: frozenset[int], where: Set) -> None:
        """Stop where a variable has none of these values."""
        self.enabled &= ~where | self._now(self.space.among(var, values))

    def switch(self, var: int, cases: tuple[Program, ...], where: Set) -> None:
        """Run the case of the value that a variable has."""
        here = [where & self._now(self.space.is_value(var, value)) for value in range(len(cases))]
        for part, case in zip(here, cases, strict=True):
            self.run(case, part)

    def mark(self, label: Label, where: Set) -> None:
        """Pass a mark."""
        self.marks[label] = self.marks.get(label, self.space.none) | where

    def _now(self, states: Set) -> Set:
        """Return where a condition is true at this point of the program, in terms of the state before it."""
        return _after(self.space, states, self.bits)

    def _set(self, var: int, cases: Iterable[tuple[Set, int]], where: Set) -> None:
        """Give a variable in `where` the value of the case whose condition is true."""
        bdd = self.space.bdd
        before = {name: self.bits[name] if name in self.bits else bdd.var(name) for name in self.space.bits[var]}
        for name in before:
            value = self.space.none
            left = where
            for guard, number in cases:
                if self.space.literals(var, number)[name]:
                    value |= guard
                left &= ~guard
            self.bits[name] = bdd.ite(where & ~left, value, before[name])

    def _choices(self, values: tuple[int, ...]) -> list[tuple[Set, int]]:
        """Return each value with the inputs that choose it, the last with all that are left."""
        bdd = self.space.bdd
        names = [
            self.space.passenger(f"{self.family}_{len(self.inputs) + k}") for k in range((len(values) - 1).bit_length())
        ]
        self.inputs += names
        found, rest = [], self.space.all
        for number, value in enumerate(values):
            guard = bdd.cube({name: bool(number >> k & 1) for k, name in enumerate(names)})
            found.append((rest if number == len(values) - 1 else guard, value))
            rest &= ~guard
        return found

    def disjunction(self, conditions: list[Set]) -> Set:
        """Return the states in one of these sets."""
        return self.space.disjunction(conditions)

    def joined(self, number: int, conditions: list[Set]) -> Set | None:
        """Return the states from which a walk comes to a node; None if there is none."""
        found = self.space.disjunction(conditions)
        return None if found == self.space.none else found

    def branched(self, number: int, node: Node, fixed: dict[int, int], here: Set) -> tuple[Set, Set]:
        """Return where the test of a node is true, and where it is not."""
        low = here & self._now(self.space.test(node.code, node.bound, fixed))
        return low, here & ~low
