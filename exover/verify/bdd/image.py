"""What a program does to a set of states, and from which states it leads into one.

No copy of the variables and no transition relation: every operation changes one variable in place (local updates, as
in Burch, Clarke, Long 1991, with disjunctive partitioning by event).
"""

from heapq import heapify, heappop, heappush
from typing import assert_never

from exover.ocrd.tables import NONE
from exover.verify.bdd.space import Set, Space
from exover.verify.program import Apply, Assign, Choose, Mark, Op, Program, Require, Switch, Walk

Label = tuple[str, str]


class Image:
    """Images and preimages of programs; notes which marks were met."""

    def __init__(self, space: Space) -> None:
        self.space = space
        self.met: set[Label] = set()
        self.moved = False
        """Whether some state was changed since this was last set to False."""

    def post(self, states: Set, program: Program) -> Set:
        """Return the states after the program, from `states`."""
        for op in program:
            if states == self.space.none:
                return states
            states = self._after(states, op)
        return states

    def _after(self, states: Set, op: Op) -> Set:
        space = self.space
        match op:
            case Assign(var, value):
                after = space.assigned(states, var, value)
                self.moved |= after != states  # equal sets: every state had this value already
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
            case Switch(var, cases):
                found = space.none
                for value, case in enumerate(cases):
                    part = states & space.is_value(var, value)
                    if part != space.none:
                        found |= self.post(part, case)
                return found
            case Walk():
                return self._walked(states, op)
            case Mark(label):
                self.met.add(label)
                return states
            case _:
                assert_never(op)

    def _walked(self, states: Set, walk: Walk) -> Set:
        """Follow a diagram with all states at once: a node's states are complete when it is the least one left."""
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
            for target, branch in self._branches(node.code, node.bound, node.low, node.high, fixed, part):
                if target == NONE:
                    done |= self.post(branch, walk.end)
                elif branch != self.space.none:
                    send(target, branch)
        return done

    def _branches(
        self, entry: int, bound: int, low: int, high: int, fixed: dict[int, int], part: Set
    ) -> list[tuple[int, Set]]:
        if entry in fixed:
            return [(low if fixed[entry] <= bound else high, part)]
        test = self.space.at_most(entry, bound)
        return [(low, part & test), (high, part & ~test)]

    def pre(self, states: Set, program: Program, goal: Label | None = None) -> Set:
        """Return the states from which the program can lead into `states`, or past the mark `goal`."""
        for op in reversed(program):
            states = self._before(states, op, goal)
        return states

    def _before(self, states: Set, op: Op, goal: Label | None) -> Set:
        space = self.space
        match op:
            case Assign(var, value):
                return space.before_assigned(states, var, value)
            case Apply(var, mapping):
                found = space.none
                for value, image in enumerate(mapping):
                    if image is not None:
                        found |= space.is_value(var, value) & space.before_assigned(states, var, image)
                return found
            case Choose(var, values):
                found = space.none
                for value in values:
                    found |= space.before_assigned(states, var, value)
                return found
            case Require(var, values):
                return states & space.among(var, values)
            case Switch(var, cases):
                found = space.none
                for value, case in enumerate(cases):
                    found |= space.is_value(var, value) & self.pre(states, case, goal)
                return found
            case Walk():
                return self._before_walk(states, op, goal)
            case Mark(label):
                return space.all if label == goal else states
            case _:
                assert_never(op)

    def _before_walk(self, states: Set, walk: Walk, goal: Label | None) -> Set:
        nodes, on, fixed = self.space.loop.tables.nodes, dict(walk.on), dict(walk.fixed)
        ended: Set = None
        memo: dict[int, Set] = {}

        def end() -> Set:
            nonlocal ended
            if ended is None:
                ended = self.pre(states, walk.end, goal)
            return ended

        for number in reversed(self._reached(walk.root, fixed)):
            node = nodes[number]
            if node.code < 0:
                after = states if node.low == NONE else memo[node.low]
                memo[number] = self.pre(after, on.get(number, ()), goal)
                continue
            if node.code in fixed:
                target = node.low if fixed[node.code] <= node.bound else node.high
                memo[number] = end() if target == NONE else memo[target]
                continue
            low = end() if node.low == NONE else memo[node.low]
            high = end() if node.high == NONE else memo[node.high]
            memo[number] = self.space.bdd.ite(self.space.at_most(node.code, node.bound), low, high)
        return end() if walk.root == NONE else memo[walk.root]

    def _reached(self, root: int, fixed: dict[int, int]) -> list[int]:
        """Return the nodes below `root` that the fixed entries leave, parents before children."""
        nodes = self.space.loop.tables.nodes
        found = set()
        stack = [root]
        while stack:
            number = stack.pop()
            if number == NONE or number in found:
                continue
            found.add(number)
            node = nodes[number]
            if node.code < 0:
                stack.append(node.low)
            elif node.code in fixed:
                stack.append(node.low if fixed[node.code] <= node.bound else node.high)
            else:
                stack += [node.low, node.high]
        return sorted(found)
