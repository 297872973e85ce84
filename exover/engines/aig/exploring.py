"""Many runs at once that prefer what was not seen before: to find runs to moments that are hard to come by.

Lanes run side by side. Every few steps each lane goes on from one of the states that were kept: those in which two
latches first had their values together (pairwise coverage, after Kuhn, Wallace, Gallo 2004; kept as a fuzzer keeps its
inputs, Zalewski 2014). A kept state knows from which other one, and by which inputs, it was reached.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

from exover.engines.aig.answer import Inputs
from exover.engines.aig.encoder import Encoding, Event
from exover.engines.aig.graph import Circuit, Literal
from exover.engines.aig.simulation import Word, evaluator

State = frozenset[int]
"""The nodes of the latches that are true."""
LANES = 1024
BURST = 6
"""So many steps a lane goes before it begins anew."""


@dataclass(frozen=True, slots=True)
class Kept:
    """A state that showed something new: reached from another, or a first one, by these inputs."""

    state: State
    before: "Kept | None"
    inputs: Inputs

    @property
    def path(self) -> Inputs:
        """The inputs that lead here from the first state."""
        found: list[Inputs] = []
        here: Kept | None = self
        while here is not None:
            found.append(here.inputs)
            here = here.before
        return tuple(step for part in reversed(found) for step in part)


@dataclass
class Stimuli:
    """Random events for all lanes: for half of them a report of something active, where the event can be chosen."""

    encoding: Encoding
    lanes: int
    source: Random
    refused: Callable[[Event], bool] = lambda event: False
    """Events that are not raised."""
    _codes: list[tuple[int, ...]] = field(default_factory=list)

    def __post_init__(self) -> None:
        encoding = self.encoding
        self.everywhere = (1 << self.lanes) - 1
        self.asks = [k for k, e in enumerate(encoding.events) if e.kind.verb == "ask" and not self.refused(e)]
        self.watches = [
            k for k, e in enumerate(encoding.events) if e.kind.verb.startswith("observe") and not self.refused(e)
        ]
        self.reports: dict[int, list[int]] = {}
        for k, event in enumerate(encoding.events):
            if event.kind.verb == "report" and not self.refused(event):
                active = encoding.latches.slots[event.kind.name, event.kind.slot].active
                self.reports.setdefault(encoding.latches.literals[active][0] >> 1, []).append(k)
        self.free = [n for n in encoding.graph.inputs if n not in set(encoding.code) | set(encoding.shifts)]

    def words(self, state: Mapping[int, Word]) -> dict[int, Word]:
        """Return a word for each input."""
        source, lanes = self.source, self.lanes
        words = {node: source.getrandbits(lanes) for node in self.free}
        words |= dict.fromkeys((*self.encoding.code, *self.encoding.shifts), 0)
        left = self.everywhere
        for active, kinds in source.sample(sorted(self.reports.items()), len(self.reports)):
            here = left & state.get(active, 0) & source.getrandbits(lanes)
            here &= source.getrandbits(lanes) | source.getrandbits(lanes)
            if here:
                left ^= here
                good = here & (source.getrandbits(lanes) | source.getrandbits(lanes))
                self._choose(words, kinds[0], good)
                self._choose(words, source.choice(kinds), here ^ good)
        groups = [group for group in (self.asks, self.watches) if group]
        for number, group in enumerate(groups):
            here = left & source.getrandbits(lanes) if number + 1 < len(groups) else left
            left ^= here
            for kind in self._shares(group):
                mine = here & kind[1]
                self._choose(words, kind[0], mine)
        return words

    def _shares(self, group: Sequence[int]) -> list[tuple[int, Word]]:
        """Return disjoint sets of lanes for the kinds of a group, about equally many each."""
        shares = dict.fromkeys(group, 0)
        for lane in range(self.lanes):
            shares[self.source.choice(group)] |= 1 << lane
        return list(shares.items())

    def _choose(self, words: dict[int, Word], kind: int, where: Word) -> None:
        for place, node in enumerate(self.encoding.code):
            if kind >> place & 1:
                words[node] |= where


@dataclass
class Exploring:
    """Runs from some states; `goals`: literals to be made true. `runs`: by goal the states from which, and how."""

    encoding: Encoding
    circuit: Circuit
    goals: Sequence[Literal]
    first: Sequence[State]
    lanes: int = LANES
    seed: int = 0
    refused: Callable[[Event], bool] = lambda event: False
    kept: list[Kept] = field(default_factory=list)
    found: dict[int, tuple[Kept, Inputs]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.source = Random(f"{self.seed}")
        self.stimuli = Stimuli(self.encoding, self.lanes, self.source, self.refused)
        wanted = list(self.goals)
        self.latches = self.circuit.support(wanted)
        self.cone = evaluator(self.circuit, wanted + [latch.next for latch in self.latches])
        layout = self.encoding.latches
        nodes = {latch.node for latch in self.latches}
        names = [s.active for s in layout.slots.values()] + [p.taken for p in layout.places.values()]
        names += [m.known for m in layout.memories.values()]
        self.control = sorted({layout.literals[s.active][0] >> 1 for s in layout.slots.values()} & nodes)
        self.sets: set[int] = set()
        names += [v.name for v in layout.model.variables]
        names += [n for n in layout.vars if n.endswith(" level")]
        self.watched = sorted({bit >> 1 for name in names for bit in layout.literals[name]} & nodes)
        self.kept = [Kept(state, None, ()) for state in self.first]
        self.seen: set[tuple[int, int]] = set()
        self.left = set(range(len(wanted)))

    def round(self) -> int:
        """Let each lane run once; return how much was new."""
        lanes, everywhere = self.lanes, (1 << self.lanes) - 1
        late = self.kept[-64:]
        origin = [self.source.choice(late if self.source.random() < 0.5 else self.kept) for _ in range(lanes)]
        state = self._packed(origin)
        taken: list[Mapping[int, Word]] = []
        new = 0
        for _ in range(BURST):
            words = self.stimuli.words(state)
            values = self.cone.values({**state, **words})
            taken.append(words)
            for goal in sorted(self.left):
                seen = self.cone.read(values, self.goals[goal], everywhere)
                if seen:
                    lane = (seen & -seen).bit_length() - 1
                    self.found[goal] = origin[lane], self._inputs(taken, lane)
                    self.left.discard(goal)
            state = {latch.node: self.cone.read(values, latch.next, everywhere) for latch in self.latches}
            for lane in self._novel(state):
                new += 1
                true = frozenset(node for node, word in state.items() if word >> lane & 1)
                self.kept.append(Kept(true, origin[lane], self._inputs(taken, lane)))
        return new

    def _packed(self, origin: Sequence[Kept]) -> dict[int, Word]:
        words = {latch.node: 0 for latch in self.latches}
        where: dict[int, Word] = {}
        for lane, kept in enumerate(origin):
            where[id(kept)] = where.get(id(kept), 0) | 1 << lane
        for kept in {id(k): k for k in origin}.values():
            for node in kept.state:
                if node in words:
                    words[node] |= where[id(kept)]
        return words

    def _inputs(self, taken: Sequence[Mapping[int, Word]], lane: int) -> Inputs:
        return tuple(frozenset(node for node, word in words.items() if word >> lane & 1) for words in taken)

    def _novel(self, state: Mapping[int, Word]) -> set[int]:
        """Return lanes in which a pair of latches has values that it had in none before."""
        everywhere = (1 << self.lanes) - 1
        literals = [(2 * n + sign, state[n] ^ (everywhere if sign else 0)) for n in self.watched for sign in (0, 1)]
        found = set()
        for index, (one, word) in enumerate(literals):
            if not word:
                continue
            for other, also in literals[:index]:
                if (one, other) not in self.seen:
                    both = word & also
                    if both:
                        self.seen.add((one, other))
                        found.add((both & -both).bit_length() - 1)
        columns = [state[node] for node in self.control]
        for lane in range(self.lanes):
            key = 0
            for column in columns:
                key = key << 1 | column >> lane & 1
            if key not in self.sets:
                self.sets.add(key)
                found.add(lane)
        return found
