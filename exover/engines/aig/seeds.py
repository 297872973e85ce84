"""Random runs that get about: from time to time those go on that have come to where few have been.

What a run has come to is told by the flags of slots, waiting places and pasts and by the states of modules; one that
few runs have makes its run likely to be gone on with (after Ecoffet et al. 2021: "First return, then explore").
"""

from collections.abc import Iterator
from operator import itemgetter
from random import Random

from exover.engines.aig.answer import Inputs
from exover.engines.aig.chance import Chance
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.simulation import Word
from exover.engines.aig.wandering import Machine, Seed, Words
from exover.model.types import Bool

STRETCH = 16
"""How many steps runs go before it is decided which go on."""
SEEDS = 8
"""How many states are kept for a question."""
LATER = 0.05
"""How often a state takes the place of one that was found before; half of them are the first, found early in runs."""


class Exploring:
    """Runs side by side, and how each came to where it is."""

    def __init__(self, machine: Machine, lanes: int, seed: int) -> None:
        self.machine, self.lanes = machine, lanes
        self.everywhere = (1 << lanes) - 1
        self.source = Random(seed)
        self.chance = Chance(machine.encoding, self.source)
        start = machine.start(self.everywhere)
        self.state = {node: start[node] for node, _ in machine.latches}
        self.stretches: list[tuple[list[Words], list[int]]] = []
        """The inputs of each stretch, and for each of its lanes the lane of the stretch before that it goes on with."""
        self.features = [node for node in features(machine.encoding) if node in self.state]
        self.seen = {node: [1, 1] for node in self.features}
        self.found: dict[int, list[Seed]] = {}

    def run(self, steps: int) -> dict[int, list[Seed]]:
        """Return for questions, by index, states in which the run stays already."""
        parents = list(range(self.lanes))
        for _ in range(steps // STRETCH):
            self.stretches.append(([], parents))
            for _ in range(STRETCH):
                self._step()
            parents = self._chosen()
            for node, word in self.state.items():
                self.state[node] = _gathered(word, parents)
        return self.found

    def _step(self) -> None:
        machine, everywhere = self.machine, self.everywhere
        inputs = self.chance.inputs([self.chance.move() for _ in range(self.lanes)])
        self.stretches[-1][0].append(inputs)
        values = machine.cone.values({**self.state, **inputs})
        self.state = {node: machine.cone.read(values, literal, everywhere) for node, literal in machine.latches}
        for index, each in enumerate(machine.staying):
            here = self.state.get(each.begun >> 1, 0)
            found = self.found.setdefault(index, []) if here else []
            if here and (len(found) < SEEDS or self.source.random() < LATER):
                lane = self.source.choice([lane for lane in range(self.lanes) if here >> lane & 1])
                true = frozenset(node for node, word in self.state.items() if word >> lane & 1)
                if len(found) == SEEDS:
                    del found[self.source.randint(SEEDS // 2, SEEDS - 1)]
                found.append(Seed(self._path(lane), true))

    def _path(self, lane: int) -> Inputs:
        """Return the run of a lane."""

        def back(lane: int) -> Iterator[frozenset[int]]:
            for inputs, parents in reversed(self.stretches):
                for words in reversed(inputs):
                    yield frozenset(node for node, word in words.items() if word >> lane & 1)
                lane = parents[lane]

        return tuple(reversed(list(back(lane))))

    def _chosen(self) -> list[int]:
        """Return by lane the lane to go on with."""
        weights = [0.0] * self.lanes
        for node in self.features:
            text = _bits(self.state[node], self.lanes)
            count = self.seen[node]
            ones = text.count("1")
            count[0] += self.lanes - ones
            count[1] += ones
            rare = "1" if count[1] < count[0] else "0"
            worth = 1 / count[int(rare)]
            for lane, bit in enumerate(text):
                if bit == rare:
                    weights[lane] += worth
        return self.source.choices(range(self.lanes), [weight + 1e-9 for weight in weights], k=self.lanes)


def features(encoding: Encoding) -> list[int]:
    """Return the latches that tell where a run has come to, not what it has been told."""
    layout, model = encoding.latches, encoding.latches.model
    posters = {each.name for each in model.variables if each.kind == "poster"}
    told = posters | layout.held | {name for name in layout.vars if name.startswith("level ")}
    names = [name for name in layout.literals if name not in told or isinstance(layout.types[name], Bool)]
    return [literal >> 1 for name in names if name not in posters for literal in layout.literals[name]]


def _bits(word: Word, lanes: int) -> str:
    """Return the bits of a word, lane 0 first."""
    return format(word, f"0{lanes}b")[::-1]


def _gathered(word: Word, lanes: list[int]) -> Word:
    """Return a word whose lanes are those lanes of a word."""
    return int("".join(itemgetter(*lanes)(_bits(word, len(lanes))))[::-1], 2)
