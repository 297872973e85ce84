"""Property-directed reachability for all bad literals of a circuit at once.

Frame `k` is a set of clauses that hold in every state that at most `k` steps reach; a clause is kept at the highest
frame that it is known for, and holds in all lower ones (Bradley 2011; Eén, Mishchenko, Brayton 2011). Questions are
answered in turn over the same frames, so that what is learnt for one serves all. A cube that leads to a bad literal and
holds a state that was reached in simulation is an answer. Clauses may exclude such states: of what few steps reach they
can say more with fewer literals, and those that are no part of an invariant fall behind as the frames grow.
"""

from collections.abc import Iterable
from dataclasses import replace
from heapq import heappop, heappush
from itertools import count

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import (
    Answer,
    Clause,
    Inputs,
    Open,
    Reachable,
    SayAnswer,
    StopRequested,
    Unreachable,
    never,
)
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.solver import Exhausted
from exover.engines.aig.induction.frames import Frames, Stopped
from exover.engines.aig.induction.unreachable_cubes import unreachable_cubes
from exover.engines.aig.simulation.reached import Cube, reached
from exover.engines.aig.simulation.runs import Runs, Simulator, like, random_words, simulator


@dataclass(frozen=True, slots=True)
class Obligation:
    """A proof obligation: by its inputs every state of the cube comes to the cube of `then`.

    If that is None, the bad literal is true in that step.
    """

    cube: Cube
    inputs: frozenset[int]
    then: "Obligation | None"

    def rest(self) -> Inputs:
        """Return the inputs from a state of the cube to where the bad literal is true."""
        return (self.inputs, *(self.then.rest() if self.then else ()))


class Search:
    """Looks for runs to bad literals, and for clauses that exclude them."""

    def __init__(self, frames: Frames) -> None:
        self.frames = frames
        self._order = count()

    def blocked(self, bad: Literal, top: int) -> Inputs | None:
        """Exclude the bad literal from the frames up to `top`, or return a run that makes it true."""
        frames = self.frames
        goal = frames.solver.literal(bad)
        while frames.ask([*frames.frame(top), goal]):
            state, inputs = frames.step()
            cube = frames.lifted(state, inputs, [goal])
            found = self._block(Obligation(cube, inputs, None), top)
            if found is not None:
                return found
            frames.tidy()
            goal = frames.solver.literal(bad)
        return None

    def _block(self, first: Obligation, top: int) -> Inputs | None:
        """Block the obligation and those that arise, of the lowest frame first, or return a run to the bad literal."""
        frames = self.frames
        waiting = [(top, next(self._order), first)]
        while waiting:
            level, number, obligation = heappop(waiting)
            cube = obligation.cube
            states = frames.reached.where(cube)
            if states:
                return (*frames.reached.path(states), *obligation.rest())
            if frames.excluded(cube, level):
                if level < top:
                    heappush(waiting, (level + 1, number, obligation))
                continue
            part = frames.inductive(level - 1, cube)
            if part is None:
                state, inputs = frames.step()
                before = frames.lifted(state, inputs, [frames.after(literal) for literal in cube])
                heappush(waiting, (level, number, obligation))
                heappush(waiting, (level - 1, next(self._order), Obligation(before, inputs, obligation)))
            else:
                level = self._learn(level - 1, part, top)
                if level < top:
                    heappush(waiting, (level + 1, number, obligation))
            frames.tidy()
        return None

    def _learn(self, level: int, cube: Cube, top: int) -> int:
        """Exclude a cube that is inductive relative to a frame, and more; return up to which frame it is excluded."""
        part = self._general(level, cube)
        level += 1
        while level < top and self.frames.inductive(level, part) is not None:
            level += 1
        self.frames.learn(part, level)
        return level

    def _general(self, level: int, cube: Cube) -> Cube:
        """Return a part of the cube that is inductive relative to the frame, too; literals are dropped one by one."""
        frames = self.frames
        for literal in reversed(frames.often_first(cube)):
            smaller = tuple(other for other in cube if other != literal)
            if literal in cube and frames.leaves_start(smaller):
                cube = frames.inductive(level, smaller) or cube
        return cube

    def push(self, top: int) -> bool:
        """Push clauses to the highest frame they hold in; return True iff some hold forever that did not."""
        frames = self.frames
        level = 1
        while level < len(frames.levels):
            cubes, kept = frames.levels[level], []
            for cube in cubes:
                if frames.enters(level, cube):
                    kept.append(cube)
                else:
                    frames.raise_to(cube, level + 1)
            frames.levels[level] = kept
            if not kept and any(frames.levels[level + 1 :]):
                frames.settle(level)
                return True
            if level >= top and not frames.levels[level + 1 :]:
                break
            level += 1
        return False


class PdrRun:
    """The questions that are left, and what was spent on each, in propagations."""

    FIRST = 2_000_000
    """What a question may cost at each frame in the first round; in each round after it four times as much."""

    EXPLORED, FOLLOWED, LONGEST, LANES, STEPS, STATES = 200, 8, 30, 512, 15, 1 << 18
    """How often runs like a known one are simulated, how often of these before the search, how long the known one may
    be, in how many lanes, for how many steps beyond its end, and up to how many known states."""

    def __init__(self, frames: Frames, simulator: Simulator, say: SayAnswer) -> None:
        self.frames, self.simulator, self.say = frames, simulator, say
        self.search = Search(frames)
        self.spent = dict.fromkeys(simulator.asked, 0)
        self.seen: dict[frozenset[int], None] = {}
        self.explored = 0

    def run(self, asked: Iterable[int], budget: int) -> None:
        """Answer the questions, those that are costly in later rounds; one is left open once it cost its budget."""
        left = self._unproved(asked)
        granted = self.FIRST
        while left:
            left = self._round(left, granted, budget)
            for index in [index for index in left if self.spent[index] >= budget]:
                left.remove(index)
                self.say(index, Open(f"no answer after {budget} propagations"))
            granted *= 4

    def _round(self, left: list[int], granted: int, budget: int) -> list[int]:
        """Go through the frames until each question is answered or cost too much; return which are left."""
        late: list[int] = []
        for top in count():
            for index in list(left):
                if index not in left:
                    continue
                limit = min(granted, budget - self.spent[index])
                try:
                    run = self._blocked(index, top, limit)
                except Exhausted:
                    left.remove(index)
                    late.append(index)
                    continue
                if run is not None:
                    left.remove(index)
                    self.say(index, Reachable(run))
                    self._explore(run, left, late)
            if not left:
                return late
            self.frames.granted = None
            before = self.frames.work
            settled = self.search.push(top)
            share = (self.frames.work - before) // len(left)
            for index in left:
                self.spent[index] += share
            if settled:
                left, late = self._unproved(left), self._unproved(late)
        return late

    def follow(self, left: list[int], runs: Runs) -> None:
        """Answer the questions that runs reach, and simulate runs like the shortest of these."""
        found = runs.answers()
        for index in [index for index in left if index in found]:
            left.remove(index)
            self.say(index, found[index])
        for answer in sorted(found.values(), key=lambda answer: len(answer.inputs))[: self.FOLLOWED]:
            self._explore(answer.inputs, left)

    def _explore(self, run: Inputs, *waiting: list[int]) -> None:
        """Simulate runs like one that was found, and answer the waiting questions that they reach."""
        self.seen |= dict.fromkeys(run)
        asked = tuple(index for indices in waiting for index in indices)
        if not asked or self.explored >= self.EXPLORED or len(run) > self.LONGEST:
            return
        self.explored += 1
        stimulus = like(tuple(self.seen), run, self.LANES, self.explored)
        runs = replace(self.simulator, asked=asked).runs(stimulus, len(run) + self.STEPS, self.LANES)
        if self.frames.reached.size < self.STATES:
            self.frames.reached.add(runs)
        for index, answer in runs.answers().items():
            for indices in waiting:
                if index in indices:
                    indices.remove(index)
            self.seen |= dict.fromkeys(answer.inputs)
            self.say(index, answer)

    def _blocked(self, index: int, top: int, limit: int) -> Inputs | None:
        """Exclude a bad literal from the frames up to `top`, or return a run that makes it true.

        Raises `Exhausted` after `limit` propagations.
        """
        before = self.frames.work
        self.frames.granted = before + limit
        try:
            return self.search.blocked(self.frames.circuit.bad[index], top)
        finally:
            self.spent[index] += self.frames.work - before

    def _unproved(self, asked: Iterable[int]) -> list[int]:
        """Answer what is excluded by clauses that hold forever; return the others."""
        frames = self.frames
        frames.granted = None
        others = []
        for index in asked:
            if frames.ask([frames.solver.literal(frames.circuit.bad[index])]):
                others.append(index)
            else:
                self.say(index, Unreachable(frames.invariant()))
        return others


def decide(
    circuit: Circuit,
    say: SayAnswer,
    *,
    asked: Iterable[int] | None = None,
    runs: Runs | None = None,
    known: Iterable[Clause] = (),
    budget: int = 50_000_000,
    stop: StopRequested = never,
) -> tuple[Clause, ...]:
    """Say the answer to each bad literal that is asked about (by index; all if `None`), as soon as it is found.

    Returns an invariant: the known clauses, and what was found besides, whatever was answered.

    `known`: clauses over latches that together are an invariant. `runs`: of this circuit, if it was simulated already.
    `budget`: how many propagations each question may cost; equal arguments give equal answers. `stop` is polled
    between two calls of the solver: when it is true, what is left is open.
    """
    asked = tuple(range(len(circuit.bad)) if asked is None else asked)
    simulation = simulator(circuit, asked)
    runs = runs or simulation.runs(random_words(circuit, 512), 20, 512)
    left = list(asked)

    def answered(index: int, answer: Answer) -> None:
        if index in left:
            left.remove(index)
        say(index, answer)

    frames = Frames(circuit, known, reached(simulation.latches, runs), stop)
    decision = PdrRun(frames, simulation, answered)
    try:
        decision.follow(left, runs)
        if left:
            if not frames.forever:  # else guesses are known to be true or were found wrong
                frames.assume(unreachable_cubes(circuit, simulation.latches, frames.reached, granted=budget))
            decision.run(tuple(left), budget)
    except Stopped:
        for index in left:
            say(index, Open("stopped"))
    return frames.invariant()
