"""What a step runs, found without running it: the components of a pass that an event can wake, in their order.

Between steps every component is stable: it would do nothing. A component has to run in a step only if something that
was written can make it unstable, which is a question on the few variables that the component reads. So a step is a
short sequence of programs, the same from every state, and its preimage is taken on sets that stay small.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import assert_never

from exover.ocrd.tables import NONE, Node
from exover.verify.bdd.functions import Function, Functions
from exover.verify.bdd.space import Set, Space
from exover.verify.program import Apply, Assign, Choose, Mark, Program, Require, Switch, Walk, writes


@dataclass(frozen=True, slots=True)
class Write:
    """A variable that had one of `before` may get the value `after`."""

    var: int
    before: frozenset[int]
    after: int


def changing(space: Space, program: Program) -> Set:
    """Return the states in which a program changes something; what reverts a change of its own counts as well.

    The union over its operations: a state that none of those before has changed is still the one it began in.
    """
    found, live = space.none, space.all
    for op in program:
        match op:
            case Assign(var, value):
                found |= live & ~space.is_value(var, value)
            case Apply(var, mapping):
                found |= live & space.among(var, [n for n, image in enumerate(mapping) if image != n])
            case Choose(var, values):
                found |= live & (~space.is_value(var, values[0]) if len(values) == 1 else space.all)
            case Require(var, required):
                live &= space.among(var, required)
            case Switch(var, cases):
                for value, case in enumerate(cases):
                    if case:
                        found |= live & space.is_value(var, value) & changing(space, case)
            case Walk():
                found |= live & _changing_walk(space, op)
            case Mark():
                pass
            case _:
                assert_never(op)
    return found


def _changing_walk(space: Space, walk: Walk) -> Set:
    nodes, on, fixed = space.loop.tables.nodes, dict(walk.on), dict(walk.fixed)
    at: dict[int, Set] = {NONE: changing(space, walk.end)}
    for number in reversed(space.loop.below(walk.root)):
        node = nodes[number]
        if node.code < 0:
            after = space.none if node.low == NONE else at[node.low]
            at[number] = after | changing(space, on.get(number, ()))
        else:
            at[number] = space.bdd.ite(space.test(node.code, node.bound, fixed), at[node.low], at[node.high])
    return at[walk.root]


def written(
    program: Program, nodes: Sequence[Node], sizes: list[int], known: Mapping[int, frozenset[int]] | None = None
) -> Iterator[Write]:
    """Yield what a program may write, with the values that the variable may have had; `known` restricts those."""
    values = dict(known or {})
    for op in program:
        match op:
            case Assign(var, value):
                yield Write(var, _had(values, sizes, var) - {value}, value)
                values[var] = frozenset({value})
            case Apply(var, mapping):
                for value, image in enumerate(mapping):
                    if image is not None and image != value:
                        yield Write(var, frozenset({value}), image)
                values.pop(var, None)
            case Choose(var, chosen):
                for value in chosen:
                    yield Write(var, _had(values, sizes, var) - {value}, value)
                values[var] = frozenset(chosen)
            case Require(var, required):
                values[var] = _had(values, sizes, var) & required
            case Switch(var, cases):
                for value in sorted(_had(values, sizes, var)):
                    yield from written(cases[value], nodes, sizes, {**values, var: frozenset({value})})
                values = _without(values, cases)
            case Walk(_, _, on, end):
                values = _without(values, [part for number, part in on if nodes[number].low != NONE])
                for _, part in on:
                    yield from written(part, nodes, sizes, values)
                yield from written(end, nodes, sizes, values)
                values = _without(values, [*(part for _, part in on), end])
            case Mark():
                pass
            case _:
                assert_never(op)


def _without(values: Mapping[int, frozenset[int]], programs: Iterable[Program]) -> dict[int, frozenset[int]]:
    """Return what is still known of the variables after one of the programs, or several, may have run."""
    lost = {var for program in programs for var in writes(program)}
    return {var: known for var, known in values.items() if var not in lost}


def _had(values: Mapping[int, frozenset[int]], sizes: list[int], var: int) -> frozenset[int]:
    return values.get(var) or frozenset(range(sizes[var]))


class Waking:
    """Which components of a pass an event or another component can wake: the question on what both of them read.

    Between the programs of a step every variable has one of its values, so only such states are asked about.
    """

    def __init__(self, functions: Functions) -> None:
        space = functions.space
        self._space, self._functions, self._body = space, functions, space.loop.body
        self._sizes = [variable.size for variable in space.loop.variables]
        self.unstable = [changing(space, component.program) for component in self._body]
        """By component the states in which it would do something."""
        self.always = frozenset(
            number
            for number, component in enumerate(self._body)
            if component.always or self.unstable[number] & space.initial != space.none
        )
        """Components that may be unstable before anything is written in a step."""
        self._reading: dict[int, list[int]] = {}
        for number, unstable in enumerate(self.unstable):
            for var in space.support(unstable):
                self._reading.setdefault(var, []).append(number)
        self._next: dict[int, frozenset[int]] = {}

    def component(self, number: int) -> Function:
        """Return what a component does."""
        return self._functions.of(self._body[number].program, f"component{number}")

    def due(self, event: Program) -> set[int]:
        """Return the components that may be unstable after an event's program."""
        return set(self.always | self._woken(event, self._functions.of(event, "event"), self._space.all))

    def wakes(self, number: int) -> frozenset[int]:
        """Return the components that a component may wake: itself, if it may be unstable after it has run."""
        if number not in self._next:
            function, unstable = self.component(number), self.unstable[number]
            again = unstable & self._functions.pre(unstable, function)
            itself = {number} if again & self._space.local_domain(again) != self._space.none else set()
            woken = self._woken(self._body[number].program, function, unstable)
            self._next[number] = (woken - {number}) | itself
        return self._next[number]

    def _woken(self, program: Program, function: Function, first: Set) -> frozenset[int]:
        """Return the components that are stable in some state of `first` and not after the program."""
        space, nodes, found = self._space, self._space.loop.tables.nodes, set()
        changed = set(written(program, nodes, self._sizes))
        for number in sorted({number for write in changed for number in self._reading.get(write.var, ())}):
            unstable = self.unstable[number]
            if any(self._harms(unstable, write) for write in changed):
                states = first & ~unstable & self._functions.pre(unstable, function)
                if states != space.none and states & space.local_domain(states) != space.none:
                    found.add(number)
        return frozenset(found)

    def _harms(self, unstable: Set, write: Write) -> bool:
        """Return whether a write may lead into `unstable` from elsewhere."""
        space = self._space
        before = space.among(write.var, write.before) & ~unstable
        return bool((before & space.before_assigned(unstable, write.var, write.after)) != space.none)
