"""What a step runs, found without running it: the components of a pass that an event can wake, in their order.

Between steps every component is stable: it would do nothing. A component has to run in a step only if something that
was written can make it unstable, which is a question on the few variables that the component reads. So a step is a
short sequence of programs, the same from every state, and its preimage is taken on sets that stay small.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import assert_never

from exover.ocrd.tables import NONE, Node
from exover.verify.bdd.image import Image
from exover.verify.bdd.space import Set, Space
from exover.verify.loop import Component
from exover.verify.program import Apply, Assign, Choose, Mark, Program, Require, Switch, Walk, writes

Chain = tuple[int, ...]
"""Components that woke one another, in increasing order."""
LONGEST, MOST_CHAINS = 400, 32
"""How many programs of a step, and chains up to a component, are followed: some rules wake each other on paper only."""


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
            at[number] = at[node.low] | changing(space, on.get(number, ()))
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


def _shortest(chains: set[Chain]) -> set[Chain]:
    """Return the chains that have no other one in them: whatever a longer one can wake, that one can."""
    counted = [(chain, Counter(chain)) for chain in sorted(chains, key=lambda chain: (len(chain), chain))]
    found: list[tuple[Chain, Counter[int]]] = []
    for chain, counts in counted:
        if not any(shorter <= counts for _, shorter in found):
            found.append((chain, counts))
    return {chain for chain, _ in found}


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

    def __init__(self, image: Image) -> None:
        space, self._image, self._space = image.space, image, image.space
        self._body = space.loop.body
        self._sizes = [variable.size for variable in space.loop.variables]
        self._changing = [changing(space, component.program) for component in self._body]
        self.stable = [~unstable for unstable in self._changing]
        self.always = frozenset(
            number
            for number, component in enumerate(self._body)
            if component.always or self.stable[number] & space.initial == space.none
        )
        """Components that may be unstable before anything is written in a step."""
        self._reading: dict[int, list[int]] = {}
        for number, stable in enumerate(self.stable):
            for var in space.support(stable):
                self._reading.setdefault(var, []).append(number)
        self._next: dict[int, frozenset[int]] = {}
        self.most = [self._most(component) for component in self._body]

    def _most(self, component: Component) -> int:
        """Return how often a component can change something in one step.

        A slot is killed at most once. A request in its place may be cleared for, fall from that and leave the place,
        once for each time it comes there: by then or by the event, and by each of its launch rules.
        """
        loop = self._space.loop
        keys = [loop.variables[var].key for var in component.writes]
        if any(key[0] == "tried" for key in keys):
            return 1
        places = {int(str(key[1])) for key in keys if key[0] == "place"}
        moves = 0
        for request in places & set(self._settled(component)):
            fills = 1 + sum(launch.request == request for launch in loop.tables.launches)
            moves += fills * (3 if loop.may_fall[request] else 1)
        return moves + sum(key[0] == "phase" for key in keys)

    def _settled(self, component: Component) -> list[int]:
        """Return the request whose waiting place the component looks at first, if it is one that settles."""
        match component.program:
            case (Switch(var, _),) if self._space.loop.variables[var].key[0] == "place":
                return [int(str(self._space.loop.variables[var].key[1]))]
            case _:
                return []

    def _woken(self, program: Program, first: Set) -> frozenset[int]:
        """Return the components that are stable in some state of `first` and not after the program."""
        space, nodes, found = self._space, self._space.loop.tables.nodes, set()
        changed = set(written(program, nodes, self._sizes))
        for number in sorted({number for write in changed for number in self._reading.get(write.var, ())}):
            if any(self._harms(number, write) for write in changed):
                after = self._image.pre(self._changing[number], program)
                states = first & self.stable[number] & after
                if states != space.none and states & space.local_domain(states) != space.none:
                    found.add(number)
        return frozenset(found)

    def _harms(self, number: int, write: Write) -> bool:
        """Return whether a write may lead from a state in which the component is stable to one in which it is not."""
        space, stable = self._space, self.stable[number]
        before = stable & space.among(write.var, write.before)
        return bool((before & ~space.before_assigned(stable, write.var, write.after)) != space.none)

    def wakes(self, number: int) -> frozenset[int]:
        """Return the components that a component may wake: itself, if it may be unstable after it has run."""
        if number not in self._next:
            space, program, unstable = self._space, self._body[number].program, self._changing[number]
            again = unstable & self._image.pre(unstable, program)
            itself = {number} if again & space.local_domain(again) != space.none else set()
            self._next[number] = (self._woken(program, unstable) - {number}) | itself
        return self._next[number]

    def due(self, program: Program) -> set[int]:
        """Return the components that may be unstable after an event's program."""
        return set(self.always | self._woken(program, self._space.all))

    def trail(self, program: Program) -> tuple[Program, ...] | None:
        """Return the programs of a step that an event with this program begins; None if it is too long to be of use.

        A component is due for each chain of components that wake one another up to it; no chain has a component more
        often than it can change something.
        """
        due: dict[int, set[Chain]] = {number: {()} for number in self.due(program)}
        trail = [program]
        while due:
            for number, component in enumerate(self._body):
                chains = due.pop(number, set())
                if not chains:
                    continue
                trail.append(component.program)
                for chain in chains:
                    if chain.count(number) < self.most[number]:
                        longer = tuple(sorted((*chain, number)))
                        for woken in self.wakes(number):
                            due[woken] = _shortest({*due.get(woken, ()), longer})
                            if len(due[woken]) > MOST_CHAINS:
                                return None
            if len(trail) > LONGEST:
                return None
        return tuple(trail)
