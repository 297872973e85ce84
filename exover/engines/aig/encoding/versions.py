"""Two versions of a spec in one graph: one event comes to both at once, and they stay together as long as they agree.

What is the same variable in both is held once, as long as it stays equal in every step that both answer alike: that is
an induction over registers that correspond (van Eijk 1998), and what rules do not touch is the same node then.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.words import Word, Words
from exover.engines.aig.encoding.common_events import NEW, OLD, CommonEvent, Stimuli, common_events
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.range_allocation import Family, RangeAllocation, allocate_ranges
from exover.engines.aig.encoding.state import Given, Latches, Reembedding
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.loop.exact.events import Kind
from exover.loop.exact.layout import Layout
from exover.loop.exact.term import Term
from exover.model.property import Properties
from exover.model.versions import Versions
from exover.ocrd.compile import Compiled


@dataclass
class Version(Encoding):
    """One of two versions as a transition system in the graph of both."""

    stimuli: Stimuli = field(kw_only=True)
    side: int = field(kw_only=True)
    grids: RangeAllocation = field(kw_only=True)
    shared: Mapping[str, tuple[Literal, ...]] = field(kw_only=True)
    """By variable its latches, where it has those of OLD."""
    shifted: Mapping[str, list[Literal]] = field(kw_only=True)

    def _declare(self) -> None:
        self.terms = self.stimuli.terms
        self.latches = Latches(self.compiled.model, self.terms, grids=self.grids, shared=self.shared)
        self._reembedding = Reembedding(self.latches, self.shifted)

    def _choices(self) -> Iterator[tuple[Kind, Literal, tuple[Given, ...]]]:
        for place, event in enumerate(self.stimuli.events):
            kind = event.kinds[self.side]
            if kind is not None:
                yield kind, self.stimuli.here[place], self.stimuli.values(place, self.side, self.latches)

    @cached_property
    def steps(self) -> Literal:
        """Where the event is one of this version."""
        events = zip(self.stimuli.events, self.stimuli.here, strict=True)
        return self.graph.any(here for event, here in events if event.kinds[self.side] is not None)

    @cached_property
    def goes(self) -> Literal:
        """Where the version takes part in the step: it can happen and is assumed, or it is nothing for this version."""
        return self.graph.choose(self.steps, self.legal, self._reembedding.legal)

    @cached_property
    def can_go(self) -> Literal:
        """The same, whether it is assumed or not."""
        return self.graph.choose(self.steps, self.possible, self._reembedding.legal)

    @cached_property
    def then(self) -> dict[str, Term]:
        """The variables after the step, also if the event is none of this version."""
        steps = self.terms.bit(self.steps)
        return {name: self.terms.choose(steps, value, self._present[name]) for name, value in self.after.items()}

    @cached_property
    def before(self) -> dict[str, Term]:
        """The variables before the step."""
        return {name: self._present[name] for name in self.after}


@dataclass(frozen=True, slots=True)
class ComparedLoops:
    """What is compared: the versions, the tables of each, and the properties of each, whose assumptions count."""

    versions: Versions
    compiled: tuple[Compiled, Compiled]
    properties: tuple[Properties, Properties]


@dataclass
class VersionPair:
    """Two versions in one graph; `apart`: variables of NEW that are not held as those of OLD.

    `agree` says, once the graph is made, where a step is answered alike (see `exover.engines.aig.differences`).
    """

    loops: ComparedLoops
    passes: int
    apart: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        self.terms = Words()
        self.graph = self.terms.graph
        grids = _common_grids(self.loops)
        versions = self.loops.versions
        self.stimuli = Stimuli(versions, self.terms, tuple(common_events(versions, self.loops.compiled)))
        self.old = self._version(OLD, grids[OLD], {}, {})
        self.same = dict(self._same(self.old.latches, grids[NEW]))
        self.new = self._version(
            NEW,
            grids[NEW],
            {its: self.old.latches.literals[mine] for its, mine in self.same.items()},
            {its: self.old._reembedding.shifts.get(mine, []) for its, mine in self.same.items()},
        )

    def _version(
        self,
        side: int,
        grids: RangeAllocation,
        shared: Mapping[str, tuple[Literal, ...]],
        shifted: Mapping[str, list[Literal]],
    ) -> Version:
        return Version(
            self.loops.compiled[side],
            self.loops.properties[side],
            self.passes,
            stimuli=self.stimuli,
            side=side,
            grids=grids,
            shared=shared,
            shifted=shifted,
        )

    def _same(self, mine: Latches, grids: RangeAllocation) -> Iterator[tuple[str, str]]:
        """Yield the variables of NEW that OLD has as well, with the same values and start, and what OLD calls them."""
        versions = self.loops.versions
        its = Latches(versions.new, Words(), grids=grids)
        for old, new in called(versions, mine).items():
            if new in its.vars and new not in self.apart and mine.types[old] == its.types[new]:
                first = [_start(layout, name) for layout, name in ((mine, old), (its, new))]
                if mine.spans[old] == its.spans[new] and first[OLD] == first[NEW]:
                    yield new, old

    # ---- what exploration asks ----

    @property
    def sides(self) -> tuple[Version, Version]:
        """OLD and NEW."""
        return self.old, self.new

    @property
    def events(self) -> tuple[CommonEvent, ...]:
        """The events by number."""
        return self.stimuli.events

    @property
    def code(self) -> tuple[int, ...]:
        """The nodes of the inputs that are the number of the event."""
        return self.stimuli.code

    @cached_property
    def shifts(self) -> tuple[int, ...]:
        """The nodes of the inputs that give reals other positions."""
        return tuple(dict.fromkeys((*self.old.shifts, *self.new.shifts)))

    def enabling(self, number: int) -> Literal | None:
        """Return the latch that is true where the event of a number can come, None if it always can."""
        side = NEW if self.events[number].kinds[NEW] else OLD
        return self.sides[side].enabling(self._own[side][number])

    @cached_property
    def _own(self) -> tuple[dict[int, int], dict[int, int]]:
        """By version and number of an event its number among those of the version."""
        old, new = (
            {at: own for own, at in enumerate(at for at, event in enumerate(self.events) if event.kinds[side])}
            for side in (OLD, NEW)
        )
        return old, new

    # ---- the product ----

    @cached_property
    def legal(self) -> Literal:
        """Where something comes that can happen in each version that knows of it, and is assumed by both."""
        return self.graph.conjunction(self.old.goes, self.new.goes)

    @cached_property
    def unsettled_parts(self) -> tuple[Literal, ...]:
        """Where one of the versions would need one more pass."""
        possible = self.graph.conjunction(self.old.can_go, self.new.can_go)
        found = [self.graph.all((possible, side.steps, part)) for side in self.sides for part in side.unsettled_parts]
        return tuple(dict.fromkeys(found))

    def unequal(self, agree: Literal) -> Iterator[tuple[str, Literal]]:
        """Yield the variables that are held once, each with where they are not the same after a step of both."""
        moves = self.graph.conjunction(self.legal, agree)
        for new, old in self.same.items():
            mine = self.old.state_bits(old, self.old.then[old])
            its = self.new.state_bits(new, self.new.then[new])
            differ = self.graph.any(map(self.graph.differ, mine, its))
            yield new, self.graph.conjunction(moves, differ)

    def circuit(self, agree: Literal, bad: Sequence[Literal]) -> Circuit:
        """Return the transition system of both; a step that they do not answer alike leaves the state as it is."""
        moves = self.graph.conjunction(self.legal, agree)
        following = self.old.following | self.new.following
        for side in (self.new, self.old):  # shared latches follow OLD
            for name, bits in side.latches.literals.items():
                after = side.state_bits(name, side.then[name])
                following |= {bit: self.graph.choose(moves, then, bit) for bit, then in zip(bits, after, strict=True)}
        return self.graph.circuit([following[2 * node] for node, _ in self.graph.latches], bad)

    def goals(self) -> CoverageGoals:
        """Return the coverage goals of random runs of both."""
        return coverage_goals(*(side.latches for side in self.sides))


def _start(layout: Latches, name: str) -> object:
    value = layout.initial[name]
    return value.bits if isinstance(value, Word) and value.sort == "Bool" else value.number


def called(versions: Versions, old: Layout) -> dict[str, str]:
    """Return by variable of OLD what it would be called in NEW."""
    found = {name: name for name in old.vars}
    for request in old.model.requests:
        name, other = request.name, versions.called(request.name)
        memory, place = old.memories[name], old.places[name]
        mine = [memory.known, *memory.values, memory.last, place.taken, place.clearing, *place.args]
        for (owner, _), slot in old.slots.items():
            mine += [slot.active, slot.stopping, *slot.args] if owner == name else []
        found |= {each: other + each[len(name) :] for each in mine}
    return found


def _common_grids(loops: ComparedLoops) -> tuple[RangeAllocation, RangeAllocation]:
    """Return grids on which both versions tell the same reals apart."""
    versions = loops.versions
    made = [allocate_ranges(each, asked) for each, asked in zip(loops.compiled, loops.properties, strict=True)]
    extra = [allocate_ranges(each, asked) for each, asked in zip(loops.compiled, loops.properties, strict=True)]
    back = {new: old for old, new in versions.renamed.items()}

    def into_new(family: Family) -> Family:
        return (family[0] and versions.called(family[0]), family[1])

    def into_old(family: Family) -> Family:
        return (family[0] and back.get(family[0], family[0]), family[1])

    made[OLD].absorb(extra[NEW], into_old)
    made[NEW].absorb(extra[OLD], into_new)
    return made[OLD], made[NEW]
