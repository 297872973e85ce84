"""Bad states while they are looked into: what runs show first, what is proved soon, what is left.

Runs are looked for side by side, guided by coverage, and gone on with by a solver. What none of them shows is put to
model checkers, all of it together. That the passes of the graph are enough is a question like the others.
"""

from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import closing
from copy import copy
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.answer import Answer, Inductive, Inputs, Open, Reachable, Settled, Unreachable
from exover.engines.aig.concretize import Concretizer
from exover.engines.aig.coverage import CoverageGoals, coverage_goals
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.evidence import INDUCTION, PROVED, Answered, Found, shown
from exover.engines.aig.exploration import LANES, ROUNDS, Exploration, Seed
from exover.engines.aig.graph import Circuit, Literal
from exover.engines.aig.portfolio import LONG, Portfolio
from exover.engines.aig.questions import Reach
from exover.engines.aig.reached_bmc import RunSearch, runs_from
from exover.engines.aig.shorten import shorten
from exover.engines.aig.stimulus import RandomStimulus
from exover.engines.beside import SideTask, step_back_if_apart

OPENING = 1, 2, 4, 8, ROUNDS
"""Rounds of random runs, after each of which is said what they show: what is easy to see is said at once."""
EARLY = 2
"""After so many of them others may look for errors."""
FURTHER = 10
"""Rounds of random runs from where a solver has found a way to."""
RUNS = 256
"""So many of the runs that showed something new are taken to be about all kinds of states."""


class _MorePasses(Exception):
    """Some run needs more passes than the graph has."""


@dataclass
class BadStates:
    """Whether some run comes to a bad state, one in which a bad literal is true, while that is looked into.

    `bad`: the literals; `urgent`: those of them that errors depend on, which come first; `budget`: the propagations
    that a question may cost; `said`: is told what is found of them, together what is found together.
    """

    encoding: Encoding
    bad: Sequence[Literal]
    urgent: Set[Literal]
    portfolio: Portfolio
    budget: int
    said: Callable[[Sequence[Answered]], None]
    runs: list[Inputs] = field(default_factory=list)
    """To all kinds of states, or such as need more passes, if some do."""
    seeds: list[Seed] = field(default_factory=list)
    """States to which these runs lead, the start first."""
    _answered: set[Literal] = field(default_factory=set)
    _later: list[int] = field(default_factory=list)
    """What is not proved soon, by index, which is looked into at last, lest it keep others from a first answer."""
    _near: list[int] = field(default_factory=list)
    """What of it is first looked for near states that runs came to."""

    def __post_init__(self) -> None:
        self.concretizer = Concretizer(self.encoding)

    @cached_property
    def circuit(self) -> Circuit:
        """The graph with all that is asked; first, whether the passes are not enough."""
        return self.encoding.circuit([*self.encoding.unsettled_parts, *self.bad])

    @cached_property
    def _passes(self) -> range:
        """Which questions are about the passes."""
        return range(len(self.encoding.unsettled_parts))

    # ---- random runs ----

    def explore(self, known: "BadStates | None", cover: bool, early: Callable[[], None]) -> bool:
        """Look for runs, say what they show, and return whether none needs more passes.

        Where a loop is `known` already, its runs are followed, and gone on with: while that shows anything new, or, to
        `cover`, new states. If some run needs more passes, such runs are all that is kept: others are near them.
        `early` is called when a little has been looked for, before anything is said that is no error.
        """
        exploration = self._exploration(coverage_goals(self.encoding.latches) if cover else CoverageGoals())
        if known is not None:
            self._follow(exploration, known)
        others: dict[int, Inputs] = {}
        for rounds in OPENING:
            seen = exploration.run(rounds)
            self._reached(self._runs(seen, urgent=True))
            others |= self._runs(seen, urgent=False)
            needing_more = [seen[part].inputs for part in self._passes if part in seen]
            if needing_more:
                self._reached(others)
                self.runs = needing_more
                return False
            self.seeds = exploration.corpus(RUNS)
            self.runs = [seed.run for seed in self.seeds]
            if rounds == EARLY:
                early()
            if rounds >= EARLY:
                self._reached(others)
                others = {}
        return True

    def follow(self, known: "BadStates") -> None:
        """Take what is known of the same loop, whose states have the same numbers, and say what its runs show."""
        self.portfolio = replace(self.portfolio, lemmas=known.portfolio.lemmas)
        exploration = self._exploration(CoverageGoals())
        self._follow(exploration, known)
        self.seeds = exploration.seeds

    def _exploration(self, coverage: CoverageGoals, asked: Sequence[int] | None = None) -> Exploration:
        """Return what looks for runs to what is asked, by index; to all bad literals if that is not said."""
        stimulus = RandomStimulus(self.encoding, LANES).stimulus()
        return Exploration(self.circuit, range(len(self.circuit.bad)) if asked is None else asked, stimulus, coverage)

    def _follow(self, exploration: Exploration, known: "BadStates") -> None:
        """Take the runs that are known, and what they show; what monitors guessed in them is of no use here."""
        inputs = dict(zip(known.encoding.given, self.encoding.given, strict=True))
        self.runs = [
            tuple(frozenset(inputs[node] for node in step if node in inputs) for step in run) for run in known.runs
        ]
        self._seen(exploration.follow(self.runs))

    def _seen(self, answers: Mapping[int, Reachable]) -> None:
        """Take what runs show, and say it, errors first."""
        for urgent in (True, False):
            self._reached(self._runs(answers, urgent))

    def _runs(self, answers: Mapping[int, Reachable], urgent: bool) -> dict[int, Inputs]:
        """Return the runs of answers, by index, to what errors depend on, or the others but for the passes."""
        return {
            index: answer.inputs
            for index, answer in answers.items()
            if index not in self._passes and self._is_urgent(index) == urgent
        }

    # ---- proofs ----

    def settle(self, insist: bool) -> bool | None:
        """Return whether it is proved that the passes are enough, and None if some run is known to need more.

        If one is, it is all that is kept of runs. Not to `insist` is to ask what is proved soon, and to take it that a
        run needs more if that is not: mostly one does, and to find it takes longer than to prove that of more passes.
        What errors depend on is asked besides: by induction the one is often proved only together with the other.
        """
        answers: dict[int, Settled] = {}

        def answered(index: int, answer: Settled) -> None:
            if isinstance(answer, Reachable) and index in self._passes:
                self.runs = [answer.inputs]
                raise _MorePasses
            answers[index] = answer

        try:
            asked = [*self._passes, *(n for n in self._open() if self._is_urgent(n))]
            left = self.portfolio.settle_soon(self.circuit, asked, answered, self.budget, learn=True)
            left = [n for n in left if n in self._passes]
            if left and not insist:
                return None
            found = runs_from(self.circuit, left, self.seeds)
            if found:
                self.runs = list(found.values())
                return None
            self.portfolio.put(self.circuit, left, answered, LONG, self.budget)
        except _MorePasses:
            return None
        self._take({n: answer for n, answer in answers.items() if n not in self._passes})
        return all(isinstance(answers.get(n), Unreachable | Inductive) for n in self._passes)

    def prove(self, unroll: bool) -> None:
        """Ask what no run has shown and what can be proved soon; the rest is left for the end.

        What errors depend on was asked with the passes. `unroll`: whether known runs are gone on with, to errors
        now and to others at the end, and what proofs find out is of use later.
        """
        left = self._open()
        urgent = [n for n in left if self._is_urgent(n)]
        self._later += self._go_on(urgent) if unroll else urgent
        answers: dict[int, Settled] = {}
        others = [n for n in left if n not in urgent]
        others = self.portfolio.settle_soon(self.circuit, others, answers.__setitem__, self.budget, learn=unroll)
        self._take(answers)
        (self._near if unroll else self._later).extend(others)

    def _go_on(self, asked: Sequence[int]) -> list[int]:
        """Say what runs show that go on from known ones, and return which questions are left.

        By turns a solver looks for a few steps to what is asked, and random runs go on from where those lead.
        """
        left = list(asked)
        if not left:
            return left
        exploration: Exploration | None = None
        with closing(RunSearch(self.circuit, left)) as search:
            search.add(self.seeds)
            while left and (found := search.runs(left)):
                self._reached(found)
                runs = list(found.values())
                exploration = exploration or self._exploration(coverage_goals(self.encoding.latches), left)
                exploration.follow(runs)
                self._seen(exploration.run(FURTHER))
                self.runs += runs
                further = exploration.corpus(RUNS)
                search.add(further)
                self.seeds += further
                left = [n for n in left if self._is_open(n)]
        return left

    @property
    def unproved(self) -> bool:
        """Whether something is not proved soon."""
        return bool(self._near or self._later)

    def at_length(self) -> SideTask[Sequence[Answered]]:
        """Return what tells what comes of that which is not proved soon; nothing of it is said or kept here.

        Known runs are gone on with, then model checkers are asked at length.
        """
        rest = copy(self)
        rest.portfolio = self.portfolio.copy()
        rest.runs, rest.seeds, rest._answered = list(self.runs), list(self.seeds), set(self._answered)

        def look(tell: Callable[[Sequence[Answered]], None]) -> None:
            step_back_if_apart()
            rest.said = tell
            later = [*rest._later, *rest._go_on(rest._near)]
            rest.portfolio.put(rest.circuit, later, lambda n, answer: rest._take({n: answer}), LONG, rest.budget)

        return look

    # ---- what is found ----

    def _open(self) -> list[int]:
        """Return what is asked of runs, by index, and not answered yet."""
        return [index for index in range(len(self.circuit.bad)) if self._is_open(index)]

    def _is_open(self, index: int) -> bool:
        return index not in self._passes and self.circuit.bad[index] not in self._answered

    def _is_urgent(self, index: int) -> bool:
        """Return whether an error depends on what is asked."""
        return self.circuit.bad[index] in self.urgent

    def _reached(self, runs: Mapping[int, Inputs]) -> None:
        """Take runs that make bad literals true; those with no doubles in them show nothing."""
        short = shorten(self.circuit, runs) if runs else {}
        concrete = self.concretizer.traces(list(short.values()))
        self._say({index: shown(trace) for index, trace in zip(short, concrete, strict=True)})

    def _take(self, answers: Mapping[int, Answer | Settled]) -> None:
        """Take what model checkers say."""
        self._reached({n: answer.inputs for n, answer in answers.items() if isinstance(answer, Reachable)})
        found: dict[int, Found] = {}
        for index, answer in answers.items():
            match answer:
                case Unreachable():
                    found[index] = Found(False, PROVED)
                case Inductive():
                    found[index] = Found(False, INDUCTION)
                case Open(reason):
                    found[index] = Found(None, reason=reason)
                case Reachable():
                    pass
        self._say(found)

    def _say(self, found: Mapping[int, Found]) -> None:
        if found:
            self._answered.update(self.circuit.bad[index] for index in found)
            self.said([(Reach(self.circuit.bad[index]), each) for index, each in found.items()])
