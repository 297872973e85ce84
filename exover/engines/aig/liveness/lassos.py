"""Lassos of a circuit: whether one is closed and fair, shorter ones, and the runs of the reference interpreter."""

from collections.abc import Mapping, Sequence
from functools import reduce
from itertools import chain, islice
from operator import or_

from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.liveness.nearby_lassos import nearby
from exover.engines.aig.liveness.random_lassos import InputLasso, SimulatedCircuit
from exover.engines.aig.simulation.lanes import LaneWord, initial, side_by_side
from exover.engines.aig.simulation.shorten import at_once, doublings
from exover.engines.aig.ways.home_states import LEVELS, POSTERS, HomeSpace, rereadings
from exover.model.lasso import StepNumbers, endings, rearranged, related
from exover.model.state import State
from exover.model.trace import Trace

Candidate = tuple[int, InputLasso]
"""The index of a question, and what may be a lasso of it."""
TURNS = 8
"""How often a loop is followed at most until all variables, not only those of a question, return to their values."""
PAIRED = 32
"""Up to this length, lassos are tried without any two steps, and with any step in the place of another."""
OBSERVED = 2
"""How many observations of posters or levels are tried as a loop that changes nothing."""


def closed(machine: SimulatedCircuit, candidates: Sequence[Candidate]) -> list[InputLasso | None]:
    """Return the lassos without their impossible steps, `None` for those that are no lassos of their questions then.

    A lasso comes back to where its loop begins, stays all the way and sees all signals. The loop is followed twice: a
    monitor may begin within the first turn, after which the run is the same.
    """
    return [lasso for part in at_once(candidates) for lasso in _closed(machine, part)]


def _closed(machine: SimulatedCircuit, candidates: Sequence[Candidate]) -> list[InputLasso | None]:
    """Return the same for candidates that are followed at once."""
    whole, found = _Following(machine, [index for index, _ in candidates]), -1
    _, stem = whole.follow([lasso.stem for _, lasso in candidates])
    for _ in range(2):
        before = whole.state
        stays, loop = whole.follow([lasso.loop for _, lasso in candidates])
        for index, mine in whole.mine.items():
            nodes = machine.looked_at[index] - {machine.staying[index].begun >> 1}
            found &= ~mine | ~reduce(or_, (before[node] ^ whole.state[node] for node in nodes), 0)
    found &= stays & reduce(or_, loop, 0)
    return [
        InputLasso(_at(lane, lasso.stem, stem), _at(lane, lasso.loop, loop)) if found >> lane & 1 else None
        for lane, (_, lasso) in enumerate(candidates)
    ]


def _at(lane: int, steps: Inputs, taken: Sequence[LaneWord]) -> Inputs:
    """Return the steps that are taken in a lane."""
    return tuple(step for step, where in zip(steps, taken, strict=False) if where >> lane & 1)


class _Following:
    """Runs side by side, a lane for each."""

    def __init__(self, machine: SimulatedCircuit, owners: Sequence[int]) -> None:
        self.machine = machine
        self.everywhere = (1 << len(owners)) - 1
        self.mine: dict[int, LaneWord] = {}
        for lane, index in enumerate(owners):
            self.mine[index] = self.mine.get(index, 0) | 1 << lane
        self.state = initial(machine.latches, self.everywhere)

    def follow(self, runs: Sequence[Inputs]) -> tuple[LaneWord, list[LaneWord]]:
        """Follow runs without their impossible steps.

        Return the lanes in which every step stays and all signals are seen, and by step those in which it is possible.
        """
        machine, cone, everywhere = self.machine, self.machine.cone, self.everywhere
        good, taken = everywhere, list[LaneWord]()
        seen = dict.fromkeys((literal for index in self.mine for literal in machine.staying[index].signals), 0)
        for number in range(max(map(len, runs))):
            there, words = side_by_side(runs, number)
            values = cone.values(self.state, words)
            there &= cone.read(values, machine.encoding.legal, everywhere)
            for index, mine in self.mine.items():
                here = mine & there
                if here:
                    good &= ~here | cone.read(values, machine.staying[index].step, everywhere)
            for signal in seen:
                seen[signal] |= cone.read(values, signal, everywhere) & there
            self.state = cone.after(values, there)
            taken.append(there)
        for index, mine in self.mine.items():
            for signal in machine.staying[index].signals:
                good &= ~mine | seen[signal]
        return good, taken


def nearer(machine: SimulatedCircuit, short: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
    """Return lassos that are shorter than some without needless steps, and found near them (see `nearby`).

    All variables return to their values, and again no step is needless.
    """
    found: dict[int, InputLasso] = {}
    left = dict(short)
    while near := {index: lasso for index, each in left.items() if (lasso := nearby(machine, index, each))}:
        tried = list(shorter(machine, near).items())
        whole = zip(tried, closed(machine.exact, tried), strict=True)
        left = {k: lasso for (k, _), lasso in whole if lasso and lasso.length < left[k].length}
        found |= left
    return found


def shorter(machine: SimulatedCircuit, found: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
    """Return lassos made of steps of the given ones, from which no single step can be dropped, nor two related ones.

    Nor is it shorter if a step takes the place of another, or the loop begins earlier.

    All variables return to their values, if they do after some turns. If the run may stutter from some step on it does.
    Blocks of steps are dropped, of half a lasso first (Zeller, Hildebrandt 2002), then related steps. Candidates of all
    lassos are tried side by side, and of the blocks that can be dropped as many as can together.
    """
    machine = machine.exact
    lassos = _turned(machine, found)
    lassos = {index: InputLasso(machine.lively(lasso.stem), lasso.loop) for index, lasso in lassos.items()}
    lassos |= _resting(machine, lassos)
    sizes = {index: lasso.length // 2 for index, lasso in lassos.items()}
    while any(sizes.values()):
        better = _better(machine, lassos, {k: _blocks(lassos[k], size) for k, size in sizes.items() if size})
        lassos |= better
        for index, size in sizes.items():
            sizes[index] = min(size, lassos[index].length // 2 or 1) if index in better else size // 2
    left = list(lassos)
    while left:
        better = _better(machine, lassos, {index: related(lassos[index], machine.subject, PAIRED) for index in left})
        short = {index: lassos[index] for index in left if index not in better and lassos[index].length <= PAIRED}
        better |= _shortest(
            machine, [(k, each) for k, lasso in short.items() for each in rearranged(lasso, machine.subject)]
        )
        lassos |= better
        left = list(better)
    rests = _resting(machine, lassos)
    return lassos | {index: lasso for index, lasso in rests.items() if lasso.length < lassos[index].length}


def _turned(machine: SimulatedCircuit, found: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
    """Return lassos with as many turns of the loop in the stem as it takes until all variables return, if they do."""
    tried = [
        (index, InputLasso(lasso.stem + lasso.loop * turns, lasso.loop))
        for index, lasso in found.items()
        for turns in range(TURNS)
    ]
    lassos = dict(found)
    for (index, _), good in reversed(list(zip(tried, closed(machine, tried), strict=True))):
        if good:
            lassos[index] = good
    return lassos


def _resting(machine: SimulatedCircuit, lassos: Mapping[int, InputLasso]) -> dict[int, InputLasso]:
    """Return the shortest lassos that follow the given ones up to a step from which they stutter (see `endings`).

    The loop observes a poster, or a level, to have the value that it has already.
    """
    reports = tuple(slot.events[0] for slot in HomeSpace(machine.encoding).slots())
    tried: list[Candidate] = []
    for index, lasso in lassos.items():
        states = chain([initial(machine.latches, 1)], machine.states(lasso.steps))
        for count, state in enumerate(states):
            observed = [event for _, event in islice(rereadings(machine.encoding, state, POSTERS, LEVELS), OBSERVED)]
            tried += [(index, each) for each in endings(lasso.steps[:count], reports, observed)]
    return _shortest(machine, tried)


def _shortest(machine: SimulatedCircuit, tried: Sequence[Candidate]) -> dict[int, InputLasso]:
    """Return by question the first of the shortest candidates that are lassos, if there is one."""
    found: dict[int, InputLasso] = {}
    for (index, _), lasso in zip(tried, closed(machine, tried), strict=True):
        if lasso and (index not in found or lasso.length < found[index].length):
            found[index] = lasso
    return found


def _blocks(lasso: InputLasso, size: int) -> list[StepNumbers]:
    """Return the blocks of so many steps that begin half a block apart."""
    return [frozenset(range(at, at + size)) for at in range(0, lasso.length - size + 1, (size + 1) // 2)]


def _better(
    machine: SimulatedCircuit, lassos: Mapping[int, InputLasso], drops: Mapping[int, Sequence[StepNumbers]]
) -> dict[int, InputLasso]:
    """Return the lassos from which some of these steps can be dropped, without as many as can be dropped together."""
    good = _droppable(machine, lassos, drops)
    more = _droppable(machine, lassos, {index: _joined([drop for drop, _ in each]) for index, each in good.items()})
    return {
        index: min((left for _, left in (*each, *more.get(index, ()))), key=lambda left: left.length)
        for index, each in good.items()
    }


def _droppable(
    machine: SimulatedCircuit, lassos: Mapping[int, InputLasso], drops: Mapping[int, Sequence[StepNumbers]]
) -> dict[int, list[tuple[StepNumbers, InputLasso]]]:
    """Return by lasso the sets of steps without which it is still a lasso, each with what is left."""
    tried = [(index, each, _left(machine, lassos[index], each)) for index, many in drops.items() for each in many]
    tried = [(index, each, lasso) for index, each, lasso in tried if lasso.loop]
    found: dict[int, list[tuple[StepNumbers, InputLasso]]] = {}
    for (index, each, _), left in zip(tried, closed(machine, [(k, lasso) for k, _, lasso in tried]), strict=True):
        if left:
            found.setdefault(index, []).append((each, left))
    return found


def _joined(drops: Sequence[StepNumbers]) -> list[StepNumbers]:
    """Return the unions of the first 2, 4, … and of all of the sets that do not overlap."""
    apart: list[StepNumbers] = []
    for drop in drops:
        if all(map(drop.isdisjoint, apart)):
            apart.append(drop)
    return [frozenset[int]().union(*apart[:count]) for count in doublings(len(apart))]


def _left(machine: SimulatedCircuit, lasso: InputLasso, dropped: StepNumbers) -> InputLasso:
    """Return the lasso without these steps; if its loop observes a poster, and they did, with what that reads now."""
    left, event_of = lasso.without(dropped), machine.encoding.chosen
    kind = event_of(left.loop[0]).kind if len(left.loop) == 1 else None
    if kind is None or kind.verb != "observe" or all(event_of(lasso.steps[number]).kind != kind for number in dropped):
        return left
    observed = [step for step in left.stem if event_of(step).kind == kind]
    if not observed:
        start = initial(machine.latches, 1)
        observed = [event for name, event in rereadings(machine.encoding, start, POSTERS) if name == kind.name]
    return InputLasso(left.stem, (observed[-1],))


def shown(concretizer: Concretizer, lasso: InputLasso) -> Trace | None:
    """Return the lasso as a run of the reference interpreter; `None` if that does not come back to where it was."""
    for turns in (1, 2, TURNS):
        trace, states = concretizer.walk(lasso.stem + lasso.loop * turns)
        length = len(trace.moments)
        for border in range(length - turns * len(lasso.loop), length, len(lasso.loop)):
            end = border + len(lasso.loop)
            if border >= 0 and states[border].key() == states[end].key():
                return _rolled(Trace(trace.moments[:end], border), states)
    return None


def _rolled(trace: Trace, states: Sequence[State]) -> Trace:
    """Return the same infinite run with the earliest loop: equal steps before the loop and at its end become one.

    `states`: those before each moment, and the last.
    """
    begin, end = trace.loop_start or 0, len(trace.moments)
    while begin and trace.moments[begin - 1].event == trace.moments[end - 1].event:
        if states[begin - 1].key() != states[end - 1].key():
            break
        begin, end = begin - 1, end - 1
    return Trace(trace.moments[:end], begin)
