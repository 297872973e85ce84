"""Home states: nothing is active but what rules launch again and again, and posters and levels read as in some state.

A home space is a set of states that can be reached from every reachable one (Memmi, Vautherin 1987). That reports and
observations lead there is shown in `home_ranking`.
"""

from collections.abc import Iterator, Mapping
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.encoding.encoder import Encoding
from exover.loop.exact.layout import level_name
from exover.model.index import ModelIndex

StepInputs = frozenset[int]
"""The nodes of the inputs that are true in a step."""
POSTERS, LEVELS = "observe", "observe level"
"""The verbs of the events that observe them."""


def inputs_of(encoding: Encoding, kind: int, values: tuple[int, ...] = ()) -> StepInputs:
    """Return the inputs of a kind of event, by its number; `values`: how far each lies above the least one, else 0."""
    true = {node for place, node in enumerate(encoding.code) if kind >> place & 1}
    for given, value in zip(encoding.events[kind].given, values, strict=False):
        true |= {bit >> 1 for place, bit in enumerate(given.bits) if value >> place & 1}
    return frozenset(true)


def rereadings(encoding: Encoding, state: Mapping[int, int], *verbs: str) -> Iterator[tuple[str, StepInputs]]:
    """Yield the events that observe the value which a state has already, by name, each made when it is asked for.

    `state`: by node of a latch whether it is true; `verbs`: posters, levels, or both, in this order.
    """
    for verb in verbs:
        for kind, event in enumerate(encoding.events):
            if event.kind.verb == verb:
                name = event.kind.name
                bits = encoding.latches.literals[name if verb == POSTERS else level_name(name)]
                read = sum(state.get(bit >> 1, 0) << place for place, bit in enumerate(bits))
                yield name, inputs_of(encoding, kind, (read,))


@dataclass(frozen=True, slots=True)
class Reports:
    """The reports of one slot, each with the least results; `active`: the variable that says whether it is active."""

    request: str
    active: str
    events: tuple[StepInputs, ...]


@dataclass(frozen=True)
class HomeSpace:
    """The home states of an encoding.

    `readings`: the state whose readings and levels they have; without it that of the start. `free`: requests that may
    be active there. `reports`: those that lead there, if that is known.
    """

    encoding: Encoding
    readings: frozenset[int] | None = None
    free: frozenset[str] = frozenset()
    reports: Inputs = ()

    @cached_property
    def _like(self) -> dict[int, bool]:
        initial = dict(self.encoding.graph.latches)
        if self.readings is None:
            return initial
        nodes = {bit >> 1 for name in self._observed for bit in self.encoding.latches.literals[name]}
        return initial | {node: node in self.readings for node in nodes}

    @cached_property
    def fixed(self) -> dict[int, bool]:
        """By node of a latch its value in every home state."""
        slots = self.encoding.latches.slots.items()
        idle = [slot for (request, _), slot in slots if request not in self.free]
        names = [name for slot in idle for name in (slot.active, slot.stopping, *slot.args)]
        return {literal >> 1: not literal & 1 for name in [*names, *self._observed] for literal in self.like(name)}

    def like(self, name: str) -> list[Literal]:
        """Return literals that are true together iff a variable is as in a home state where all slots are idle."""
        return [bit ^ (not self._like[bit >> 1]) for bit in self.encoding.latches.literals[name]]

    @cached_property
    def _observed(self) -> list[str]:
        """The posters and levels."""
        index = ModelIndex(self.encoding.latches.model)
        return [*(poster.name for _, poster in index.posters), *map(level_name, index.stocks)]

    @cached_property
    def posters(self) -> dict[str, StepInputs]:
        """By poster the event that observes its value in home states."""
        return dict(rereadings(self.encoding, self._like, POSTERS))

    @cached_property
    def levels(self) -> dict[str, StepInputs]:
        """By the variable of a level the event that observes its value in home states."""
        return {level_name(name): event for name, event in rereadings(self.encoding, self._like, LEVELS)}

    def slots(self) -> Iterator[Reports]:
        """Yield the reports of every slot."""
        for slot, numbers in self.encoding.reports.items():
            events = tuple(inputs_of(self.encoding, number) for number in numbers)
            yield Reports(slot[0], self.encoding.latches.slots[slot].active, events)

    @cached_property
    def run(self) -> Inputs:
        """Events that as a rule lead home: observations, and reports of every slot, twice."""
        reports = self.reports or tuple(slot.events[0] for slot in self.slots())
        return (*self.posters.values(), *self.levels.values(), *reports) * 2
