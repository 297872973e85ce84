"""Shorter lassos near a known one, of its steps in any order and of reports of what they ask for.

Random runs come to long lassos, and often no step of these can be dropped though other loops are shorter. The states
around the lasso are visited breadth first, and become a graph; a fair loop is a closed walk in a strongly connected
component that makes all signals true.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from itertools import groupby
from operator import itemgetter

from exover.components import strong_components
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.liveness.k_liveness import Staying
from exover.engines.aig.liveness.random_lassos import InputLasso, SimulatedCircuit
from exover.engines.aig.simulation.evaluation import evaluator
from exover.engines.aig.simulation.lanes import LaneWord, PackedState, StateBits, initial, packed, turned
from exover.engines.aig.simulation.shorten import at_once
from exover.engines.aig.ways.home_states import inputs_of

TAKEN = 1_000
"""How many steps are taken at most to visit states, for each step of the given lasso."""
WALKED = 100_000
"""How many steps of walks are kept at most to find a loop."""
Edge = tuple[int, int, int]
"""A step by number, the state by number that it leads to, and by bit the signals that it makes true."""
Walk = tuple[int, int, int]
"""Where a walk began, where it is, and by bit the signals that it has made true."""


def nearby(machine: SimulatedCircuit, index: int, lasso: InputLasso) -> InputLasso | None:
    """Return a shorter lasso of a question, none if none is found near the given one.

    Variables that the question does not look at need not return to their values.
    """
    graph = _StateGraph(machine, machine.staying[index], machine.looked_at[index], _steps(machine, lasso))
    graph.visit(lasso)
    return graph.shortest(lasso.length)


def _steps(machine: SimulatedCircuit, lasso: InputLasso) -> Inputs:
    """Return the steps of a lasso, then all reports, with the least results, of what it asks for."""
    encoding, found = machine.encoding, dict.fromkeys(lasso.steps)
    kinds = [encoding.chosen(step).kind for step in found]
    asked = {kind.name for kind in kinds if kind.verb == "ask"}
    reports = [number for (name, _), numbers in encoding.reports.items() if name in asked for number in numbers]
    return tuple(dict.fromkeys((*found, *(inputs_of(encoding, number) for number in reports))))


class _StateGraph:
    """States by number, the start first, and the steps from those that were visited."""

    def __init__(self, machine: SimulatedCircuit, staying: Staying, looked_at: Collection[int], steps: Inputs) -> None:
        self.machine, self.staying, self.steps = machine, staying, steps
        self.latches = tuple(latch for latch in machine.latches if latch.node in looked_at)
        roots = [machine.encoding.legal, staying.step, *staying.signals]
        self.cone = evaluator(machine.circuit, roots, self.latches)
        start = initial(self.latches, 1)
        self.states = [bytes(start.values())]
        """By latch 1 where it is true."""
        self.numbers = {self.states[0]: 0}
        self.after: dict[int, list[tuple[int, int]]] = {}
        """By visited state the steps from it, each with the state that it leads to."""
        self.staying_after: dict[int, list[Edge]] = {}
        """By visited state the steps by which the run stays."""

    def visit(self, lasso: InputLasso) -> None:
        """Visit states breadth first: those of a lasso, then those that are one step away, and so on."""
        new: Sequence[int] = self._states_of(lasso)
        left = TAKEN * lasso.length
        for _ in range(lasso.length - 1):
            tried = [*self._possible(new)][: max(left, 0)]
            left -= len(tried)
            known = len(self.states)
            for part in at_once(tried):
                self._take(part)
            new = range(known, len(self.states))

    def _states_of(self, lasso: InputLasso) -> list[int]:
        states = (bytes(state[latch.node] for latch in self.latches) for state in self.machine.states(lasso.steps))
        return list(dict.fromkeys([0, *map(self._number, states)]))

    def _number(self, state: StateBits) -> int:
        number = self.numbers.setdefault(state, len(self.states))
        if number == len(self.states):
            self.states.append(state)
        return number

    @cached_property
    def _enabling(self) -> list[int | None]:
        """By step the place of the latch without which it is impossible, if there is one."""
        places, encoding = {latch.node: place for place, latch in enumerate(self.latches)}, self.machine.encoding
        found = [encoding.enabling(encoding.number_of(step)) for step in self.steps]
        return [None if literal is None else places.get(literal >> 1) for literal in found]

    def _possible(self, states: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield states, each with the steps by number that may be possible there."""
        for state in states:
            bits = self.states[state]
            yield from ((state, step) for step, place in enumerate(self._enabling) if place is None or bits[place])

    def _take(self, tried: Sequence[tuple[int, int]]) -> None:
        """Take steps side by side, and note where they lead."""
        tried = sorted(tried, key=itemgetter(1))
        state = turned([self.states[number] for number, _ in tried], [latch.node for latch in self.latches])
        values = self.cone.values(state, self._inputs([step for _, step in tried]))
        everywhere = (1 << len(tried)) - 1
        asked = (self.machine.encoding.legal, self.staying.step, *self.staying.signals)
        truths = _columns([self.cone.read(values, literal, everywhere) for literal in asked], len(tried))
        after = self.cone.after(values, everywhere)
        led_to = after if isinstance(after, PackedState) else packed(after, len(tried))
        for lane, ((number, step), true) in enumerate(zip(tried, truths, strict=True)):
            if true & 1:
                end = self._number(led_to.bits_at(lane))
                self.after.setdefault(number, []).append((step, end))
                if true & 2:
                    self.staying_after.setdefault(number, []).append((step, end, true >> 2))

    def _inputs(self, steps: Sequence[int]) -> dict[int, LaneWord]:
        """Return the inputs of steps in order, a lane for each."""
        words: dict[int, LaneWord] = {}
        lanes = 0
        for step, group in groupby(steps):
            more = lanes + len(list(group))
            for node in self.steps[step]:
                words[node] = words.get(node, 0) | (1 << more) - (1 << lanes)
            lanes = more
        return words

    # ---- the shortest lasso ----

    @cached_property
    def _stems(self) -> dict[int, tuple[int, int]]:
        """By state the state before it on a shortest run, and the step from there; the nearest states first."""
        found = {0: (0, 0)}
        order = [0]
        for state in order:
            for step, end in self.after.get(state, ()):
                if end not in found:
                    found[end] = state, step
                    order.append(end)
        return found

    def _stem(self, state: int) -> list[int]:
        """Return the steps of a shortest run to a state."""
        found: list[int] = []
        while state:
            state, step = self._stems[state]
            found.append(step)
        return found[::-1]

    @cached_property
    def _fair(self) -> dict[int, list[Edge]]:
        """By state the steps that stay and remain in its component, if the steps there make all signals true."""
        following = [[end for _, end, _ in self.staying_after.get(n, ())] for n in range(len(self.states))]
        component = strong_components(following)
        within = {
            state: [edge for edge in edges if component[edge[1]] == component[state]]
            for state, edges in self.staying_after.items()
        }
        seen: dict[int, int] = {}
        for state, edges in within.items():
            for _, _, signals in edges:
                seen[component[state]] = seen.get(component[state], 0) | signals
        every = (1 << len(self.staying.signals)) - 1
        return {state: edges for state, edges in within.items() if edges and seen[component[state]] == every}

    def shortest(self, length: int) -> InputLasso | None:
        """Return the shortest lasso of less than so many steps, none if there is none or it takes too much to find.

        A loop begins where it is nearest to the start, so walks go to no state that is nearer.
        """
        rank = {state: place for place, state in enumerate(self._stems)}
        every = (1 << len(self.staying.signals)) - 1
        begun = [(len(self._stem(state)), state) for state in rank if state in self._fair]
        back: dict[Walk, tuple[Walk, int]] = {}
        reached: list[Walk] = []
        for steps in range(length - 1):
            walks = [*reached, *((state, state, 0) for depth, state in begun if depth == steps)]
            reached = []
            for walk in walks:
                first, state, seen = walk
                for step, end, signals in self._fair.get(state, ()):
                    after = (first, end, seen | signals)
                    if end == first and after[2] == every:
                        return self._lasso(back, walk, step)
                    if rank[end] >= rank[first] and after not in back:
                        back[after] = walk, step
                        reached.append(after)
            if len(back) > WALKED:
                return None
        return None

    def _lasso(self, back: dict[Walk, tuple[Walk, int]], walk: Walk, last: int) -> InputLasso:
        """Return the lasso of a walk that returns to its beginning by the last step."""
        first, loop = walk[0], [last]
        while walk != (first, first, 0):
            walk, step = back[walk]
            loop.append(step)
        return InputLasso(
            tuple(self.steps[step] for step in self._stem(first)), tuple(self.steps[step] for step in loop[::-1])
        )


def _columns(words: Sequence[LaneWord], lanes: int) -> list[int]:
    """Return by lane the bits that words have there, that of the first word lowest."""
    digits = [f"{word:0{lanes}b}" for word in reversed(words)]
    return [int("".join(column), 2) for column in zip(*digits, strict=True)][::-1]
