"""Lassos of a circuit: whether one is closed and fair, shorter ones, and the runs of the reference interpreter."""

from collections.abc import Mapping, Sequence

from exover.engines.aig.answer import Inputs
from exover.engines.aig.concretize import Concretizer
from exover.engines.aig.lanes import LaneWord, differing, initial, side_by_side
from exover.engines.aig.random_lassos import InputLasso, SimulatedCircuit
from exover.model.trace import Trace

Candidate = tuple[int, InputLasso]
"""The index of a question, and what may be a lasso of it."""
TURNS = 8
"""How often a loop is followed until everything is as it was, what no question looks at included."""


def closed(machine: SimulatedCircuit, candidates: Sequence[Candidate]) -> list[bool]:
    """Return which lassos come back to where their loop begins, stay all the way and see all signals."""
    if not candidates:
        return []
    whole = _Following(machine, [index for index, _ in candidates])
    whole.follow([lasso.stem for _, lasso in candidates])
    before = whole.state
    found = whole.follow([lasso.loop for _, lasso in candidates]) & ~differing(whole.state, before)
    return [bool(found >> lane & 1) and bool(lasso.loop) for lane, (_, lasso) in enumerate(candidates)]


class _Following:
    """Runs side by side, a lane for each."""

    def __init__(self, machine: SimulatedCircuit, owners: Sequence[int]) -> None:
        self.machine = machine
        self.everywhere = (1 << len(owners)) - 1
        self.mine: dict[int, LaneWord] = {}
        for lane, index in enumerate(owners):
            self.mine[index] = self.mine.get(index, 0) | 1 << lane
        self.state = initial(machine.latches, self.everywhere)

    def follow(self, runs: Sequence[Inputs]) -> LaneWord:
        """Follow runs; return where every step stays and all signals have been seen."""
        machine, cone, everywhere = self.machine, self.machine.cone, self.everywhere
        good = everywhere
        seen = dict.fromkeys((literal for index in self.mine for literal in machine.staying[index].signals), 0)
        for number in range(max(map(len, runs))):
            there, words = side_by_side(runs, number)
            values = cone.values(self.state, words)
            for index, mine in self.mine.items():
                here = mine & there
                if here:
                    good &= ~here | cone.read(values, machine.staying[index].step, everywhere)
            for signal in seen:
                seen[signal] |= cone.read(values, signal, everywhere) & there
            self.state = cone.after(values, there)
        for index, mine in self.mine.items():
            for signal in machine.staying[index].signals:
                good &= ~mine | seen[signal]
        return good


def shorter(machine: SimulatedCircuit, found: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
    """Return lassos made of steps of the given ones, from which no single step can be dropped.

    Blocks of steps are dropped, of half a lasso first (Zeller, Hildebrandt 2002), those of all lassos side by side, and
    of those that can be dropped as many as can together.
    """
    lassos = {index: InputLasso(machine.lively(lasso.stem), lasso.loop) for index, lasso in found.items()}
    sizes = {index: _length(lasso) // 2 for index, lasso in lassos.items()}
    while any(sizes.values()):
        good: dict[int, list[Blocks]] = {
            index: [(at,) for at in _places(lassos[index], size)] for index, size in sizes.items() if size
        }
        better: dict[int, InputLasso] = {}
        while good := _kept(machine, lassos, sizes, good):
            better |= {
                index: _without(lassos[index], max(blocks, key=len), sizes[index]) for index, blocks in good.items()
            }
            good = {index: _joined(blocks, sizes[index]) for index, blocks in good.items()}
        for index, size in sizes.items():
            if index in better:
                lassos[index] = better[index]
                sizes[index] = min(size, _length(better[index]) // 2 or 1)
            elif size:
                sizes[index] = size // 2
    return lassos


def _length(lasso: InputLasso) -> int:
    return len(lasso.stem) + len(lasso.loop)


Blocks = tuple[int, ...]
"""Where blocks of steps begin, in order; they do not overlap."""


def _places(lasso: InputLasso, size: int) -> range:
    """Return where blocks of so many steps begin that are half a block apart."""
    return range(0, _length(lasso) - size + 1, (size + 1) // 2)


def _kept(
    machine: SimulatedCircuit,
    lassos: Mapping[int, InputLasso],
    sizes: Mapping[int, int],
    blocks: Mapping[int, Sequence[Blocks]],
) -> dict[int, list[Blocks]]:
    """Return which blocks can be dropped: what is left is a lasso."""
    tried = [
        (index, each, _without(lassos[index], each, sizes[index])) for index, many in blocks.items() for each in many
    ]
    tried = [(index, each, lasso) for index, each, lasso in tried if lasso.loop]
    found: dict[int, list[Blocks]] = {}
    for (index, each, _), good in zip(tried, closed(machine, [(i, lasso) for i, _, lasso in tried]), strict=True):
        if good:
            found.setdefault(index, []).append(each)
    return found


def _joined(blocks: Sequence[Blocks], size: int) -> list[Blocks]:
    """Return more blocks at once: of single ones that can be dropped the first two, four, …, and all; else nothing."""
    if len(blocks[0]) > 1:
        return []
    apart: list[int] = []
    for (place,) in blocks:
        if not apart or place >= apart[-1] + size:
            apart.append(place)
    counts = [1 << k for k in range(1, len(apart).bit_length()) if 1 << k < len(apart)]
    return [tuple(apart[:count]) for count in (*counts, len(apart)) if count > 1]


def _without(lasso: InputLasso, places: Blocks, size: int) -> InputLasso:
    """Return the lasso without blocks of so many steps."""
    dropped = {number for place in places for number in range(place, place + size)}
    steps, turn = (*lasso.stem, *lasso.loop), len(lasso.stem)
    kept = [
        [step for n, step in enumerate(steps) if n not in dropped and (n < turn) == early] for early in (True, False)
    ]
    return InputLasso(tuple(kept[0]), tuple(kept[1]))


def shown(concretizer: Concretizer, lasso: InputLasso) -> Trace | None:
    """Return the lasso as a run of the reference interpreter; `None` if that does not come back to where it was."""
    for turns in (1, 2, TURNS):
        trace, states = concretizer.walk(lasso.stem + lasso.loop * turns)
        length = len(trace.moments)
        for border in range(length - turns * len(lasso.loop), length, len(lasso.loop)):
            end = border + len(lasso.loop)
            if border >= 0 and states[border].key() == states[end].key():
                return Trace(trace.moments[:end], border)
    return None
