"""Reachability of bad states: by random runs first, then by short proofs, at last by model checkers at length.

Runs are simulated side by side, guided by coverage, and continued by a solver. The questions that none of them answers
are put to model checkers together. That the passes of the graph are enough is a question like the others.
"""

from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import closing
from copy import copy
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Inductive, Inputs, Open, Reachable, Settled, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.encoding.concretize import Concretizer
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import Reach
from exover.engines.aig.evidence import INDUCTION, PROVED, Answered, Found, shown
from exover.engines.aig.induction.reached_bmc import RunSearch, runs_from
from exover.engines.aig.portfolio import LONG, Portfolio
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import LANES, ROUNDS, Exploration, Seed
from exover.engines.aig.simulation.shorten import shorten
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.engines.beside import SideTask, step_back_if_apart

OPENING = 1, 2, 4, 8, ROUNDS
"""Rounds of random runs, by batch; after each batch answers are said, so that what is easy to see is said at once."""
EARLY = 2
"""After this batch of `OPENING`, `early` is called, and from then on answers are said that are no errors."""
FURTHER = 10
"""Rounds of random runs from states to which a solver has found runs."""
RUNS = 256
"""How many runs that showed something new are kept, as runs to all kinds of states."""


class _MorePasses(Exception):
    """Some run needs more passes than the graph has."""


@dataclass
class BadStates:
    """The questions whether some run makes a bad literal true, with the runs and answers found so far.

    `bad`: the literals; `urgent`: those of them that errors depend on, which come first; `budget`: the propagations
    that a question may cost; `said`: takes answers, those that are found together at once.
    """

    encoding: Encoding
    bad: Sequence[Literal]
    urgent: Set[Literal]
    portfolio: Portfolio
    budget: int
    said: Callable[[Sequence[Answered]], None]
    runs: list[Inputs] = field(default_factory=list)
    """Runs to all kinds of states; if some run needs more passes, only such runs."""
    seeds: list[Seed] = field(default_factory=list)
    """States to which these runs lead, the start first."""
    _answered: set[Literal] = field(default_factory=set)
    _later: list[int] = field(default_factory=list)
    """Questions, by index, that are not proved soon; they are asked at last, lest others wait for a first answer."""
    _near: list[int] = field(default_factory=list)
    """The same; but first a solver looks for runs to them that continue known ones."""

    def __post_init__(self) -> None:
        self.concretizer = Concretizer(self.encoding)

    @cached_property
    def circuit(self) -> Circuit:
        """The circuit with all questions; the first of them ask whether the passes are too few."""
        return self.encoding.circuit([*self.encoding.unsettled_parts, *self.bad])

    @cached_property
    def _passes(self) -> range:
        """The indices of the questions about the passes."""
        return range(len(self.encoding.unsettled_parts))

    # ---- random runs ----

    def explore(self, known: "BadStates | None", cover: bool, early: Callable[[], None]) -> bool:
        """Look for runs, say what they show, and return whether none needs more passes.

        `known`: the same loop in another graph; its runs are followed and continued. `cover`: whether new states count
        as new, besides bad literals. If some run needs more passes, only such runs are kept: others are near them.
        `early` is called after a few rounds, before anything is said that is no error.
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
        """Take over what is known of the same loop in another graph, and say what its runs show.

        The latches of the loop are the same there; those that the questions have added to either graph are not.
        """
        latches = tuple(latch for latch in self.circuit.latches if latch.node in self.encoding.own)
        self.portfolio.lemmas.add(known.portfolio.lemmas.of(replace(self.circuit, latches=latches)))
        exploration = self._exploration(CoverageGoals())
        self._follow(exploration, known)
        self.seeds = exploration.seeds

    def _exploration(self, coverage: CoverageGoals, asked: Sequence[int] | None = None) -> Exploration:
        """Return an exploration that looks for runs to the bad literals asked, by index; None: to all of them."""
        stimulus = RandomStimulus(self.encoding, LANES).stimulus()
        return Exploration(self.circuit, range(len(self.circuit.bad)) if asked is None else asked, stimulus, coverage)

    def _follow(self, exploration: Exploration, known: "BadStates") -> None:
        """Take over the known runs, without guesses of monitors, and say what they show here."""
        inputs = dict(zip(known.encoding.given, self.encoding.given, strict=True))
        self.runs = [
            tuple(frozenset(inputs[node] for node in step if node in inputs) for step in run) for run in known.runs
        ]
        self._seen(exploration.follow(self.runs))

    def _seen(self, answers: Mapping[int, Reachable]) -> None:
        """Say what runs show, errors first."""
        for urgent in (True, False):
            self._reached(self._runs(answers, urgent))

    def _runs(self, answers: Mapping[int, Reachable], urgent: bool) -> dict[int, Inputs]:
        """Return the runs of answers, by index: of urgent questions, or of the others, but of none about passes."""
        return {
            index: answer.inputs
            for index, answer in answers.items()
            if index not in self._passes and self._is_urgent(index) == urgent
        }

    # ---- proofs ----

    def settle(self, insist: bool) -> bool | None:
        """Return whether it is proved that the passes are enough; None if some run needs more.

        Only runs that need more are kept then. Without `insist` only short proofs are tried, and None also says that
        they fail: mostly a run needs more then, and to find it takes longer than to prove one more pass to be enough.
        Urgent questions are asked besides: induction often proves the one only together with the other.
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
        """Answer the open questions that are soon proved; the rest is left for the end.

        Urgent ones were asked with the passes. `unroll`: whether a solver continues known runs, to urgent questions now
        and to others at the end, and whether lemmas are of use later.
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
        """Look for runs that continue known ones, say what they show, and return the indices of the questions left.

        In turns, bounded model checking looks for a few steps to bad literals, and random runs go on from their ends.
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
        """Whether some question is neither answered nor proved soon."""
        return bool(self._near or self._later)

    def at_length(self) -> SideTask[Sequence[Answered]]:
        """Return the side task that answers the questions not proved soon; nothing of it is said or kept here.

        Known runs are continued, then model checkers are asked at length.
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
        """Return the indices of the questions without an answer, but for those about passes."""
        return [index for index in range(len(self.circuit.bad)) if self._is_open(index)]

    def _is_open(self, index: int) -> bool:
        return index not in self._passes and self.circuit.bad[index] not in self._answered

    def _is_urgent(self, index: int) -> bool:
        """Return whether an error depends on a question."""
        return self.circuit.bad[index] in self.urgent

    def _reached(self, runs: Mapping[int, Inputs]) -> None:
        """Say what runs to bad literals show, made shorter and concrete; of spurious ones say that it is unknown."""
        short = shorten(self.circuit, runs) if runs else {}
        concrete = self.concretizer.traces(list(short.values()))
        self._say({index: shown(trace) for index, trace in zip(short, concrete, strict=True)})

    def _take(self, answers: Mapping[int, Answer | Settled]) -> None:
        """Say what the answers of model checkers show."""
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
