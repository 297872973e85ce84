"""Images of sets of states under programs.

There is no second copy of the variables and no transition relation: every operation updates one variable in place
(local updates, as in Burch, Clarke, Long 1991, with disjunctive partitioning by event).
"""

from heapq import heapify, heappop, heappush
from itertools import groupby
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.loop.finite.program import Apply, Assign, Choose, Mark, Op, Program, Require, Switch, Walk
from exover.ocrd.tables import NONE

PASS = 0
"""The key in `Image.noted`, beside the identities of walks, of the beginnings of passes of steps 3 to 5."""


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """The simultaneous assignment of some bits; `cube`: the states in which they have the assigned values."""

    bits: tuple[str, ...]
    cube: Set


class Image:
    """Images of programs."""

    def __init__(self, space: Space) -> None:
        self.space = space
        self._programs: dict[int, tuple[Op | Assignment, ...]] = {}
        self.moved = False
        """Whether some state was changed since this was last set to False."""
        self.noted: dict[int, Set] | None = None
        """If not None: maps the identity of a walk to the states that came to it, and `PASS` to those before a pass."""

    def note(self, which: int, states: Set) -> None:
        """Record states that came to a walk or began a pass, if `noted` is not None."""
        if self.noted is not None:
            self.noted[which] = self.noted.get(which, self.space.none) | states

    def post(self, states: Set, program: Program) -> Set:
        """Return the states after the program, from `states`."""
        for op in self._joined(program):
            if states == self.space.none:
                return states
            states = self._after(states, op)
        return states

    def _joined(self, program: Program) -> "tuple[Op | Assignment, ...]":
        """Return the operations, assignments that follow each other as one; programs live as long as the loop."""
        found = self._programs.get(id(program))
        if found is None:
            joined: list[Op | Assignment] = []
            for _, run in groupby(program, lambda op: isinstance(op, Assign)):
                ops = list(run)
                assigns = [op for op in ops if isinstance(op, Assign)]
                joined += [self._assignment(assigns)] if assigns else ops
            found = self._programs[id(program)] = tuple(joined)
        return found

    def _assignment(self, assigns: list[Assign]) -> "Assignment":
        literals: dict[str, bool] = {}
        for assign in assigns:
            literals |= self.space.literals(assign.var, assign.value)
        return Assignment(tuple(literals), self.space.bdd.cube(literals))

    def _after(self, states: Set, op: "Op | Assignment") -> Set:
        space = self.space
        match op:
            case Assignment(bits, cube):
                after = space.bdd.exist(bits, states) & cube if bits else states
                self.moved |= after != states  # equal sets: every state had these values already
                return after
            case Apply(var, mapping):
                self.moved = True
                found = space.none
                for value, image in enumerate(mapping):
                    if image is not None:
                        found |= space.assigned(states & space.is_value(var, value), var, image)
                return found
            case Choose(var, values):
                self.moved = True
                found = space.none
                for value in values:
                    found |= space.assigned(states, var, value)
                return found
            case Require(var, values):
                return states & space.among(var, values)
            case Switch(var):
                found = space.none
                for case, values in op.branches:
                    part = states & space.among(var, values)
                    if part != space.none:
                        found |= self.post(part, case)
                return found
            case Walk():
                self.note(id(op), states)
                return self._walked(states, op)
            case Mark():
                return states
            case Assign():
                raise AssertionError("assignments are joined")
            case _:
                assert_never(op)

    def _walked(self, states: Set, walk: Walk) -> Set:
        """Return the states after a walk of all states at once, through nodes in order: parents before children."""
        if walk.root == NONE:
            return self.post(states, walk.end)
        nodes, on, fixed = self.space.loop.tables.nodes, dict(walk.on), dict(walk.fixed)
        at = {walk.root: states}
        queue = [walk.root]
        heapify(queue)
        done = self.space.none

        def send(target: int, part: Set) -> None:
            if target in at:
                at[target] |= part
            else:
                at[target] = part
                heappush(queue, target)

        while queue:
            number = heappop(queue)
            node, part = nodes[number], at.pop(number)
            if node.code < 0:
                part = self.post(part, on.get(number, ()))
                if node.low == NONE:
                    done |= part
                else:
                    send(node.low, part)
                continue
            test = self.space.test(node.code, node.bound, fixed)
            for target, branch in ((node.low, part & test), (node.high, part & ~test)):
                if branch == self.space.none:
                    continue
                if target == NONE:
                    done |= self.post(branch, walk.end)
                else:
                    send(target, branch)
        return done
