"""Symbolic execution of programs, from a condition under which a program is run."""

from abc import ABC, abstractmethod
from typing import Generic, assert_never

from exover.loop.diagram_walk import S, follow
from exover.loop.finite.program import Apply, Assign, Choose, Mark, Op, Program, Require, Switch, SwitchCase, Walk
from exover.ocrd.tables import Node, Tables


class SymbolicExecution(ABC, Generic[S]):
    """Runs the operations in order; conditions are about the state before the first of them."""

    @property
    @abstractmethod
    def tables(self) -> Tables:
        """The tables that walks follow."""

    @property
    @abstractmethod
    def none(self) -> S:
        """The condition that is never true."""

    def run(self, program: Program, where: S) -> None:
        """Run a program where a condition is true."""
        if where != self.none:
            for op in program:
                self._do(op, where)

    def _do(self, op: Op, where: S) -> None:
        match op:
            case Assign(var, value):
                self.assign(var, value, where)
            case Apply(var, mapping):
                self.apply(var, mapping, where)
            case Choose(var, values):
                self.choose(var, values, where)
            case Require(var, values):
                self.require(var, values, where)
            case Switch(var):
                self.switch(var, op.branches, where)
            case Walk():
                self.walk(op, where)
            case Mark(label):
                self.mark(label, where)
            case _:
                assert_never(op)

    def walk(self, walk: Walk, where: S) -> None:
        """Follow a diagram on all its paths; `end` is for those that meet no action."""
        on, fixed = dict(walk.on), dict(walk.fixed)

        def branched(number: int, node: Node, here: S) -> tuple[S, S]:
            return self.branched(number, node, fixed, here)

        def act(number: int, _: Node, here: S) -> None:
            self.run(on.get(number, ()), here)

        ended = follow(self.tables, walk.root, where, self.joined, branched, act)
        if walk.end and ended:
            self.run(walk.end, self.disjunction(ended))

    @abstractmethod
    def assign(self, var: int, value: int, where: S) -> None:
        """Give a variable a value."""

    @abstractmethod
    def apply(self, var: int, mapping: tuple[int | None, ...], where: S) -> None:
        """Give a variable the image of the value that it has."""

    @abstractmethod
    def choose(self, var: int, values: tuple[int, ...], where: S) -> None:
        """Give a variable one of these values, by an input."""

    @abstractmethod
    def require(self, var: int, values: frozenset[int], where: S) -> None:
        """Stop where a variable has none of these values."""

    @abstractmethod
    def switch(self, var: int, branches: tuple[SwitchCase, ...], where: S) -> None:
        """Run the case of the value that a variable has; `branches`: each case with its values."""

    @abstractmethod
    def mark(self, label: tuple[str, ...], where: S) -> None:
        """Pass a mark."""

    @abstractmethod
    def disjunction(self, conditions: list[S]) -> S:
        """Return the disjunction of the conditions."""

    @abstractmethod
    def joined(self, number: int, conditions: list[S]) -> S | None:
        """Return the condition under which a walk comes to the node of this number; None if that is never true."""

    @abstractmethod
    def branched(self, number: int, node: Node, fixed: dict[int, int], here: S) -> tuple[S, S]:
        """Return the states at a node in which its test is true, and the others; `fixed` has values of entries."""
