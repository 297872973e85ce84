"""What a program does, as functions: each bit that it may change, after it, in terms of the bits before it.

All operations but `Choose` are deterministic, so a step is a vector of Boolean functions, and a preimage one
substitution (Coudert, Berthet, Madre 1989); a choice is an input. Only bits that change have a function, and those stay
on the few bits that decide them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import assert_never

from exover.engines.bdd.space import Set, Space
from exover.loop.finite.program import Apply, Assign, Choose, Mark, Op, Program, Require, Switch, Walk
from exover.ocrd.tables import NONE

Label = tuple[str, ...]


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
        """Return the function of running one program, and the other where it changes nothing: it only passes marks."""
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
    names = space.bdd.support(states) & bits.keys()
    return space.bdd.let({name: bits[name] for name in names}, states) if names else states


@dataclass
class _Execution:
    """Symbolic execution of one program; `enabled`: where it has not been stopped so far."""

    space: Space
    enabled: Set
    family: str
    bits: dict[str, Set] = field(default_factory=dict)
    marks: dict[Label, Set] = field(default_factory=dict)
    inputs: list[str] = field(default_factory=list)

    def run(self, program: Program, where: Set) -> None:
        """Run a program from the states `where`."""
        for op in program:
            self._do(op, where)

    def _do(self, op: Op, where: Set) -> None:
        space = self.space
        match op:
            case Assign(var, value):
                self._set(var, [(space.all, value)], where)
            case Apply(var, mapping):
                images = [(self._now(space.is_value(var, v)), image) for v, image in enumerate(mapping)]
                self._set(var, [(guard, image) for guard, image in images if image is not None], where)
            case Choose(var, values):
                self._set(var, self._choices(values), where)
            case Require(var, values):
                self.enabled &= ~where | self._now(space.among(var, values))
            case Switch(var, cases):
                here = [where & self._now(space.is_value(var, value)) for value in range(len(cases))]
                for part, case in zip(here, cases, strict=True):
                    if part != space.none:
                        self.run(case, part)
            case Walk():
                self._walk(op, where)
            case Mark(label):
                self.marks[label] = self.marks.get(label, space.none) | where
            case _:
                assert_never(op)

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

    def _walk(self, walk: Walk, where: Set) -> None:
        """Follow a diagram from all states at once; nodes come after their parents. `end` is for paths of no action."""
        space, on, fixed = self.space, dict(walk.on), dict(walk.fixed)
        nodes = space.loop.tables.nodes
        at: dict[int, Set] = {walk.root: where}
        for number in space.loop.tables.below(walk.root):
            node, part = nodes[number], at.pop(number, space.none)
            if part == space.none:
                continue
            if node.code < 0:
                self.run(on.get(number, ()), part)
                if node.low != NONE:
                    at[node.low] = at.get(node.low, space.none) | part
            else:
                low = part & self._now(space.test(node.code, node.bound, fixed))
                at[node.low] = at.get(node.low, space.none) | low
                at[node.high] = at.get(node.high, space.none) | (part & ~low)
        ended = at.get(NONE, space.none)
        if walk.end and ended != space.none:
            self.run(walk.end, ended)
