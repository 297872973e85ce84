"""Shorter runs, made of the steps of longer ones."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.simulation.evaluation import Evaluator, evaluator
from exover.engines.aig.simulation.lanes import LaneWord, differing, initial, numbers
from exover.engines.aig.simulation.replay import replay
from exover.model.lasso import moves

T = TypeVar("T")
MOVED = 32
"""Up to this length, runs are tried with any step in the place of another."""
WIDEST = 4096
"""How many runs are followed at once, at most."""


def shorten(circuit: Circuit, runs: Mapping[int, Inputs], cone: Evaluator | None = None) -> dict[int, Inputs]:
    """Return, by index of bad literals, runs made of steps of the given ones that make the literals true at their end.

    Steps that change no state are dropped, then blocks of steps, of half a run first (Zeller, Hildebrandt 2002), all
    blocks of a size and those of all runs side by side, and of those that can be dropped as many as can together. Then
    a step takes the place of another, and is left out where it was. From the result no single step can be dropped, none
    can take the place of another, and no step but the last makes the literal true. A run that never makes its literal
    true is a ValueError. `cone`: an evaluator of all bad literals and latches, if there is one already.
    """
    found = _Shortening(circuit, runs, cone)
    found.settle()
    _drop_blocks(found, {index: len(run) // 2 for index, run in found.runs.items()})
    moved = found.move(found.runs)
    while moved:
        found.runs |= moved
        _drop_blocks(found, dict.fromkeys(moved, 1))
        moved = found.move(moved)
    return found.runs


def _drop_blocks(found: "_Shortening", sizes: dict[int, int]) -> None:
    """Drop blocks of steps of runs, of such a size first, until no single step can be dropped."""
    while any(sizes.values()):
        tried = {index: size for index, size in sizes.items() if size}
        shorter = found.drop_more(tried, found.drop(tried))
        for index in tried:
            if index in shorter:
                found.runs[index] = shorter[index]
                sizes[index] = min(sizes[index], len(shorter[index]) // 2)
            else:
                sizes[index] //= 2


def at_once(tried: Sequence[T]) -> Iterator[Sequence[T]]:
    """Return an iterator of parts of at most `WIDEST` candidates, in order."""
    return (tried[first : first + WIDEST] for first in range(0, len(tried), WIDEST))


class _Shortening:
    """Runs, each the shortest that is known so far, and their evaluator."""

    def __init__(self, circuit: Circuit, runs: Mapping[int, Inputs], cone: Evaluator | None) -> None:
        self.circuit, self.runs = circuit, dict(runs)
        roots = [circuit.bad[index] for index in runs]
        self.latches = circuit.latches if cone else circuit.support(roots)
        self.cone: Evaluator = cone or evaluator(circuit, roots, self.latches)

    def settle(self) -> None:
        """Cut each run where its literal is true first, and drop the steps that change nothing."""
        everywhere = (1 << len(self.runs)) - 1
        state = initial(self.latches, everywhere)
        kept: dict[int, list[frozenset[int]]] = {index: [] for index in self.runs}
        done: dict[int, Inputs] = {}
        for step, (_, values, after) in enumerate(replay(self.cone, state, tuple(self.runs.values()))):
            changed = differing(after, state)
            for lane, (index, run) in enumerate(self.runs.items()):
                if index not in done and step < len(run):
                    if changed >> lane & 1:
                        kept[index].append(run[step])
                    if self.cone.read(values, self.circuit.bad[index], everywhere) >> lane & 1:
                        done[index] = (*kept[index][: len(kept[index]) - (changed >> lane & 1)], run[step])
            state = after
        if len(done) < len(self.runs):
            raise ValueError("a run does not make its literal true")
        self.runs = {index: done[index] for index in self.runs}

    def drop(self, sizes: Mapping[int, int]) -> dict[int, tuple[Inputs, list[int]]]:
        """Return, where there is one, the shortest run that is left when a block of so many steps is dropped, and where
        all blocks begin that leave as short a one.

        A run of `n` steps has `n - size + 1` lanes, by where the block begins.
        """
        first: dict[int, int] = {}
        lanes = 0
        for index, size in sizes.items():
            first[index] = lanes
            lanes += len(self.runs[index]) - size + 1
        everywhere = (1 << lanes) - 1
        state = initial(self.latches, everywhere)
        shorter: dict[int, tuple[Inputs, list[int]]] = {}
        for step in range(max(len(self.runs[index]) - size for index, size in sizes.items())):
            values = self.cone.values(state, self._words(step, first, sizes, shorter))
            for index, size in sizes.items():
                run = self.runs[index]
                if index not in shorter and step < len(run) - size:
                    mine = (1 << len(run) - size + 1) - 1 << first[index]
                    seen = self.cone.read(values, self.circuit.bad[index], everywhere) & mine
                    if seen:
                        places = list(numbers(seen >> first[index]))
                        at = places[0]
                        shorter[index] = (run[:at] + run[at + size :])[: step + 1], places
            if len(shorter) == len(sizes):
                break
            state = self.cone.after(values, everywhere)
        return shorter

    def drop_more(
        self, sizes: Mapping[int, int], found: Mapping[int, tuple[Inputs, Sequence[int]]]
    ) -> dict[int, Inputs]:
        """Return the shortest runs seen when many blocks that can each be dropped are dropped together."""
        tried: list[tuple[int, Inputs]] = []
        for index, (_, places) in found.items():
            apart = _apart(places, sizes[index])
            for count in doublings(len(apart)):
                tried.append((index, _without(self.runs[index], apart[:count], sizes[index])))
        shorter = {index: run for index, (run, _) in found.items()}
        for (index, _), ends in zip(tried, self._ends(tried), strict=True):
            if ends and len(ends) < len(shorter[index]):
                shorter[index] = ends
        return shorter

    def move(self, asked: Iterable[int]) -> dict[int, Inputs]:
        """Return, where there is one, the shortest run in which a step takes the place of another."""
        short = ((index, self.runs[index]) for index in asked if len(self.runs[index]) <= MOVED)
        tried = list(dict.fromkeys((index, moved) for index, run in short for _, _, moved in moves(run)))
        found = [ends for part in at_once(tried) for ends in self._ends(part)]
        shorter: dict[int, Inputs] = {}
        for (index, _), ends in zip(tried, found, strict=True):
            if ends and (index not in shorter or len(ends) < len(shorter[index])):
                shorter[index] = ends
        return shorter

    def _ends(self, tried: Sequence[tuple[int, Inputs]]) -> list[Inputs]:
        """Return each run up to where it first makes the literal of its index true; `()` if it never does."""
        runs = [run for _, run in tried]
        everywhere = (1 << len(runs)) - 1
        found: list[Inputs] = [()] * len(runs)
        lanes: dict[int, LaneWord] = {}
        for lane, (index, _) in enumerate(tried):
            lanes[index] = lanes.get(index, 0) | 1 << lane
        steps = replay(self.cone, initial(self.latches, everywhere), runs)
        for length, (going, values, _) in enumerate(steps, 1):
            for index, mine in lanes.items():
                for lane in numbers(self.cone.read(values, self.circuit.bad[index], mine & going)):
                    found[lane] = found[lane] or runs[lane][:length]
        return found

    def _words(
        self, step: int, first: Mapping[int, int], sizes: Mapping[int, int], done: Collection[int]
    ) -> dict[int, LaneWord]:
        """Return the inputs of a step: lanes whose block begins later have the run's own, the others later ones."""
        words: dict[int, LaneWord] = {}
        for index, size in sizes.items():
            run = self.runs[index]
            if index in done or step >= len(run) - size:
                continue
            early = (1 << step + 1) - 1
            late = (1 << len(run) - size + 1) - 1 ^ early
            for nodes, where in ((run[step + size], early), (run[step], late)):
                for node in nodes:
                    words[node] = words.get(node, 0) | where << first[index]
        return words


def doublings(most: int) -> list[int]:
    """Return how many of `most` are tried together: 2, 4, 8, … and all; nothing if there are not two."""
    return [*(1 << k for k in range(1, most.bit_length()) if 1 << k < most), most] if most > 1 else []


def _apart(places: Sequence[int], size: int) -> list[int]:
    """Return places, in order, at which blocks of a size do not overlap."""
    found: list[int] = []
    for place in places:
        if not found or place >= found[-1] + size:
            found.append(place)
    return found


def _without(run: Inputs, places: Sequence[int], size: int) -> Inputs:
    """Return a run without the blocks of a size that begin at some places, which are in order and do not overlap."""
    kept: list[frozenset[int]] = []
    end = 0
    for place in places:
        kept += run[end:place]
        end = place + size
    return (*kept, *run[end:])
