"""Programs as vectors of Boolean functions: each bit that a program may change, as a function of the bits before it.

All operations but `Choose` are deterministic, so a preimage is one substitution (Coudert, Berthet, Madre 1989); a
choice is an input. Only bits that change have a function, which depends only on the bits that decide it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.loop.finite.execution import SymbolicExecution
from exover.loop.finite.program import Program, SwitchCase
from exover.model.property import Label
from exover.ocrd.tables import Node, Tables


@dataclass(frozen=True)
class Function:
    """A program: the states in which it is enabled, the bits after it, the states from which it passes each mark, and
    the inputs of its choices."""

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
        """Return the function of a program of the loop (computed once); its inputs are named after `family`.

        Programs that run in the same step need different families.
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
        """Return the composition `second` after `first`; the second must be enabled everywhere."""
        bits = dict(first.bits) | {name: self.after(value, first) for name, value in second.bits.items()}
        return Function(first.enabled, bits, self._marks(first, second), first.inputs | second.inputs)

    def past(self, first: Function, second: Function) -> Function:
        """Return the function of the first program with the marks of the second, which must change nothing after it."""
        return Function(first.enabled, first.bits, self._marks(first, second), first.inputs)

    def _marks(self, first: Function, second: Function) -> dict[Label, Set]:
        """Return, for each mark, the states from which the first program or the second after it passes it."""
        marks = dict(first.marks)
        for label, states in second.marks.items():
            marks[label] = marks.get(label, self.space.none) | (self.after(states, first) & first.enabled)
        return marks

    def after(self, states: Set, function: Function) -> Set:
        """Return the states and inputs from which the function leads into `states`, if it is enabled."""
        return _after(self.space, states, function.bits)

    def changing(self, function: Function) -> Set:
        """Return the states in which the function may change something."""
        bdd = self.space.bdd
        found = self.space.disjunction(bdd.apply("^", value, bdd.var(name)) for name, value in function.bits.items())
        return self.chosen(found & function.enabled, function)

    def pre(self, states: Set, function: Function) -> Set:
        """Return the states from which the function leads into `states`."""
        return self.chosen(self.after(states, function) & function.enabled, function)

    def chosen(self, states: Set, function: Function) -> Set:
        """Return `states` with the inputs of the function existentially quantified."""
        return self.space.bdd.exist(function.inputs, states) if function.inputs else states


def _after(space: Space, states: Set, bits: Mapping[str, Set]) -> Set:
    """Return `states` with each of these bits replaced by its function of the state before."""
    return space.bdd.let(bits, states) if bits else states


@dataclass
class _Execution(SymbolicExecution[Set]):
    """Symbolic execution of one program; `enabled`: the states from which no `Require` has failed so far."""

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

    def switch(self, var: int, branches: tuple[SwitchCase, ...], where: Set) -> None:
        """Run the case of the value that a variable has."""
        here = [(case, where & self._now(self.space.among(var, values))) for case, values in branches]
        for case, part in here:
            self.run(case, part)

    def mark(self, label: Label, where: Set) -> None:
        """Pass a mark."""
        self.marks[label] = self.marks.get(label, self.space.none) | where

    def _now(self, states: Set) -> Set:
        """Return the states before the program from which a condition is true at this point of it."""
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
        """Return each value with the input combination that chooses it; the last has all remaining combinations."""
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
