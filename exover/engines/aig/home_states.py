"""Home states: reports and observations lead from everywhere to where nothing is active, and the posters read so.

A home space is a set of states that can be reached from every reachable one (Memmi, Vautherin 1987). A report makes one
slot idle; what its step does beside kills, launches what waited or was owed by a required launch, or drops it, so that
what waits, is owed and is active shrinks with every report, as long as no launch becomes due but by the launch of what
waited, with which it is counted. The posters are first observed to read as at the start, which as a rule disables the
launch rules.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.answer import Inputs
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.graph import FALSE, TRUE, Graph, Literal
from exover.engines.aig.solver import Solver
from exover.engines.aig.symbolic_simulation import substituted
from exover.loop.exact.layout import level_name
from exover.model.index import ModelIndex


def inputs_of(encoding: Encoding, kind: int, values: tuple[int, ...] = ()) -> frozenset[int]:
    """Return the inputs that are an event: its number, and what its values are above the least ones."""
    true = {node for place, node in enumerate(encoding.code) if kind >> place & 1}
    for given, value in zip(encoding.events[kind].given, values, strict=False):
        true |= {bit >> 1 for place, bit in enumerate(given.bits) if value >> place & 1}
    return frozenset(true)


@dataclass(frozen=True)
class HomeSpace:
    """The home states of an encoding, and which steps lead to them."""

    encoding: Encoding
    readings: frozenset[int] | None = None
    """The state whose readings and levels home states have; without it that of the start."""

    @cached_property
    def _like(self) -> dict[int, bool]:
        initial = dict(self.encoding.graph.latches)
        if self.readings is None:
            return initial
        nodes = {bit >> 1 for name in self._observed for bit in self.encoding.latches.literals[name]}
        return initial | {node: node in self.readings for node in nodes}

    @cached_property
    def fixed(self) -> dict[int, bool]:
        """By node of a latch its value in every home state: slots are idle, posters read as at the start."""
        layout = self.encoding.latches
        names = [name for slot in layout.slots.values() for name in (slot.active, slot.stopping, *slot.args)]
        names += self._observed
        initial = self._like
        return {bit >> 1: initial[bit >> 1] for name in names for bit in layout.literals[name]}

    @cached_property
    def observations(self) -> tuple[frozenset[int], ...]:
        """The events by which posters and levels come to read as at the start."""
        initial, found = self._like, []
        for kind, event in enumerate(self.encoding.events):
            if event.kind.verb.startswith("observe"):
                name = event.kind.name if event.kind.verb == "observe" else level_name(event.kind.name)
                bits = self.encoding.latches.literals[name]
                start = sum(initial[bit >> 1] << place for place, bit in enumerate(bits))
                found.append(inputs_of(self.encoding, kind, (start,)))
        return tuple(found)

    def reports(self) -> Iterator[tuple[str, tuple[frozenset[int], ...]]]:
        """Yield, by the variable that says whether a slot is active, its reports, each with the least results."""
        layout, found = self.encoding.latches, dict[str, list[frozenset[int]]]()
        for kind, event in enumerate(self.encoding.events):
            if event.kind.verb == "report":
                active = layout.slots[event.kind.name, event.kind.slot].active
                found.setdefault(active, []).append(inputs_of(self.encoding, kind))
        for active, events in found.items():
            yield active, tuple(events)

    @cached_property
    def run(self) -> Inputs:
        """Events that as a rule lead home: observations, and reports of every slot, twice."""
        reports = tuple(events[0] for _, events in self.reports())
        return (*self.observations, *reports, *self.observations, *reports)

    # ---- that they can be reached ----

    def failures(self, graph: Graph, allowed: Literal, most: int = 1000) -> list[Literal] | None:
        """Return literals over a state: if no reachable one makes any true, home is reached by allowed steps.

        What is true of every state, reachable or not, is not among them. None if there are more than `most`.
        """
        layout = self.encoding.latches
        step = graph.conjunction(self.encoding.legal, allowed)
        good = graph.conjunction(step, self._shrinks(graph, None))
        less = {active: graph.conjunction(step, self._shrinks(graph, active)) for active, _ in self.reports()}
        bits = {bit >> 1 for name in self._observed for bit in layout.literals[name]}
        still = [2 * node + (not value) for node, value in self.fixed.items() if node in bits]
        domain = self.encoding.domain
        posters = {bit >> 1 for name in self._posters for bit in layout.literals[name]}
        read = [literal for literal in still if literal >> 1 in posters]
        cases: list[tuple[tuple[Literal, ...], Literal, tuple[frozenset[int], ...]]] = []
        cases += [((domain,), step, (event,)) for event in self.observations]
        cases += [
            ((layout.literals[active][0], domain, *still), less[active], events) for active, events in self.reports()
        ]
        solver = Solver(graph.within_step())
        count = len(self._posters)
        levels = dict(zip(self._observed[count:], self.observations[count:], strict=True))
        while levels:
            shrinking = (n for n, event in levels.items() if self._always(solver, (domain, *read), event, good))
            name = next(shrinking, next(iter(levels)))
            cases.append(((domain, *read), good, (levels.pop(name),)))
            read += [literal for literal in still if literal >> 1 in {b >> 1 for b in layout.literals[name]}]
        failing = []
        for state, wanted, events in cases:
            if not any(self._always(solver, state, event, wanted) for event in events):
                failing.append((state, wanted, events))
                if len(failing) > most:
                    break
        solver.close()
        if len(failing) > most:
            return None
        return [self._missed(graph, *case) for case in failing]

    def _missed(
        self, graph: Graph, state: Sequence[Literal], wanted: Literal, events: Sequence[frozenset[int]]
    ) -> Literal:
        """Return in which states of a cube none of the events does what is wanted."""
        leaves = {x >> 1: 1 - (x & 1) for x in state if graph.fanins[x >> 1] is None}
        ways = [substituted(graph, [wanted], self._constant(event) | leaves)[0] for event in events]
        return graph.all((*state, graph.any(ways) ^ 1))

    def _always(self, solver: Solver, state: Sequence[Literal], event: frozenset[int], wanted: Literal) -> bool:
        """Return True iff an event does what is wanted in all states of a cube."""
        inputs = [2 * node + (node not in event) for node in self.encoding.graph.inputs]
        return not solver.satisfiable([solver.literal(each) for each in (*state, *inputs, wanted ^ 1)])

    @cached_property
    def _posters(self) -> list[str]:
        return [poster.name for _, poster in ModelIndex(self.encoding.latches.model).posters]

    @cached_property
    def _observed(self) -> list[str]:
        """The posters and levels."""
        return [*self._posters, *map(level_name, ModelIndex(self.encoding.latches.model).stocks)]

    def _constant(self, true: frozenset[int]) -> dict[int, Literal]:
        return {node: int(node in true) for node in self.encoding.graph.inputs}

    def _shrinks(self, graph: Graph, reported: str | None) -> Literal:
        """Return where what is to come and what is active weighs less afterwards, or as much if nothing has happened.

        A request is to come while it waits or a required launch of it is owed. An active slot weighs one, a required
        request that is to come two, any other request that is to come two and three for each that is required: when it
        no longer is, it may have become active, and each of the required ones to come and active. What is active in the
        slot that was reported became so.
        """
        layout, following = self.encoding.latches, self.encoding.following
        required = {launch.request for launch in layout.model.launches}
        fresh, come, left = dict[str, list[Literal]](), dict[str, Literal](), dict[str, Literal]()
        for name, place in layout.places.items():
            (taken,) = layout.literals[place.taken]
            owed, owes = self.encoding.owed.get(name, (FALSE, FALSE))
            before, after = graph.any((taken, owed)), graph.any((following[taken], owes))
            come[name], left[name] = graph.conjunction(after, before ^ 1), graph.conjunction(before, after ^ 1)
            fresh[name] = []
            for slot in range(layout.model.request[name].instances):
                flag = layout.slots[name, slot].active
                (active,) = layout.literals[flag]
                idle = TRUE if flag == reported else active ^ 1
                fresh[name].append(graph.conjunction(following[active], idle))
        paid = graph.any(literal for name, literal in left.items() if name not in required)
        good = []
        for name, slots in fresh.items():
            lighter = paid if name in required else FALSE
            good.append(graph.any((come[name] ^ 1, lighter)))
            good.append(graph.any((graph.any(slots) ^ 1, left[name], lighter)))
            good += [graph.conjunction(a, b) ^ 1 for i, a in enumerate(slots) for b in slots[:i]]
        return graph.all(good)
