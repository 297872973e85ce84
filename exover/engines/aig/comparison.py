"""Which answers two versions give otherwise: random runs first, then proofs, then the shortest run to each change."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Inputs, Open, Reachable, Unreachable
from exover.engines.aig.circuit.bounded import Shortest, shortest
from exover.engines.aig.circuit.graph import FALSE, Circuit, Literal
from exover.engines.aig.circuit.solver import Exhausted, Solver
from exover.engines.aig.differences import Differences
from exover.engines.aig.encoding.concretize import Spurious
from exover.engines.aig.encoding.encoder import PASSES
from exover.engines.aig.encoding.pair_concretize import Both, PairConcretizer
from exover.engines.aig.encoding.versions import ComparedLoops, VersionPair
from exover.engines.aig.engine import BUDGET, UNSETTLED
from exover.engines.aig.evidence import NOT_PROVED
from exover.engines.aig.portfolio import LONG, Portfolio, smaller
from exover.engines.aig.simulation.exploration import LANES, Exploration
from exover.engines.aig.simulation.shorten import shorten
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.limits import NO_LIMITS, Limits, TimeUp, interrupted
from exover.loop.claim import Progress
from exover.model.difference import AnswerChange, changes

EQUAL = 2_000_000
"""Propagations that it may cost to see that a variable stays equal in both."""
SHORTENING = 100_000_000
"""Propagations that shortest runs may cost, all together."""
ROUNDS = 24
"""Rounds of random runs."""
WITH_ABC = "with ABC more is answered: see `exover doctor`"


@dataclass(frozen=True, slots=True)
class CommonRun:
    """A run of both versions that they answer alike up to its last step, which shows a change.

    `shortest`: it is proved that no shorter run shows this change.
    """

    events: tuple[Both, ...]
    shortest: bool


ChangeAnswer = CommonRun | Open | None
"""A run that shows a change; None: no run does."""


class _MorePasses(Exception):
    """Some run needs more passes than the graph has."""


def compare(
    loops: ComparedLoops,
    abc: str = "",
    progress: Progress = lambda _: None,
    limits: Limits = NO_LIMITS,
) -> dict[AnswerChange, ChangeAnswer]:
    """Return by change a run that shows it, None where it is proved that none does, or why that is not known.

    When the time is over, what was found by then is returned; runs are not shortest ones then.
    """
    for passes in PASSES:
        try:
            with interrupted(limits):
                comparison = Comparison(_joined(loops, passes), abc, progress, limits)
        except TimeUp:
            return dict.fromkeys(changes(loops.versions), Open(limits.reason))
        try:
            return comparison.answers()
        except _MorePasses:
            continue
    return dict.fromkeys(changes(loops.versions), Open(UNSETTLED))


def _joined(loops: ComparedLoops, passes: int) -> Differences:
    """Return the differences of both versions in one graph that share what stays equal while both answer alike."""
    apart: frozenset[str] = frozenset()
    while True:
        differences = Differences(VersionPair(loops, passes, apart))
        unequal = dict(differences.pair.unequal(differences.agree))
        with closing(Solver(differences.pair.circuit(FALSE, ()))) as solver:
            found = {name for name, where in unequal.items() if where != FALSE and _may_be(solver, where)}
        if not found:
            return differences
        apart |= found


def _may_be(solver: Solver, where: Literal) -> bool:
    try:
        return solver.possible([where], EQUAL)
    except Exhausted:
        return True


def _unproved(runs: Mapping[int, Inputs]) -> dict[int, Shortest]:
    return {index: Shortest(run, False) for index, run in runs.items()}


@dataclass
class Comparison:
    """The search for runs of a pair that show changes; what was found and proved so far."""

    differences: Differences
    abc: str
    progress: Progress
    limits: Limits = NO_LIMITS
    proved: set[int] = field(default_factory=set)
    reasons: dict[int, str] = field(default_factory=dict)
    runs: dict[int, Inputs] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.pair: VersionPair = self.differences.pair
        self.changes = tuple(changes(self.pair.loops.versions))
        asked = [*self.differences.literals(self.changes), *self.pair.unsettled_parts]
        self.circuit: Circuit = self.pair.circuit(self.differences.agree, asked)

    @property
    def _about_passes(self) -> range:
        return range(len(self.changes), len(self.circuit.bad))

    def answers(self) -> dict[AnswerChange, ChangeAnswer]:
        """Return what is known of each change; raises `_MorePasses` if the graph has not enough of them."""
        late = False
        try:
            with interrupted(self.limits):
                self._explore()
                self._prove()
                shown = self._shown()
        except TimeUp:
            late, shown = True, self._shown(in_hurry=True)
        settled = self.proved.issuperset(self._about_passes)
        found: dict[AnswerChange, ChangeAnswer] = {}
        for number, change in enumerate(self.changes):
            if number in shown:
                found[change] = shown[number]
            elif number in self.proved and settled:
                found[change] = None
            else:
                found[change] = Open(self.limits.reason if late else self.reasons.get(number, NOT_PROVED))
        return found

    def _explore(self) -> None:
        self.progress("random runs of both")
        asked = [n for n, bad in enumerate(self.circuit.bad) if bad != FALSE]
        self.proved = {n for n, bad in enumerate(self.circuit.bad) if bad == FALSE}
        stimulus = RandomStimulus(self.pair, LANES).stimulus()
        seen = Exploration(self.circuit, asked, stimulus, self.pair.goals()).run(ROUNDS)
        self._reached({index: answer.inputs for index, answer in seen.items()})

    def _reached(self, runs: Mapping[int, Inputs]) -> None:
        if not runs.keys().isdisjoint(self._about_passes):
            raise _MorePasses
        self.runs |= runs

    def _prove(self) -> None:
        self.progress("proofs about both")
        if self._left:
            Portfolio(self.abc, self.pair).put(smaller(self.pair, self.circuit), self._left, self._said, LONG, BUDGET)

    @property
    def _left(self) -> list[int]:
        """The questions without an answer."""
        return [n for n in range(len(self.circuit.bad)) if n not in self.proved and n not in self.runs]

    def _said(self, index: int, answer: Answer) -> None:
        match answer:
            case Unreachable():
                self.proved.add(index)
            case Reachable(inputs):
                self._reached({index: inputs})
            case Open(reason):
                self.reasons[index] = reason if self.abc else f"{reason}; {WITH_ABC}"

    def _shown(self, in_hurry: bool = False) -> dict[int, CommonRun | Open]:
        """Return by change a shortest run that shows it; `Open` if that run is spurious.

        In a hurry the runs are only such that no step can be dropped.
        """
        if not self.runs:
            return {}
        self.progress("shortest runs")
        runs = PairConcretizer(self.pair, self.differences.agree)
        found: dict[int, CommonRun | Open] = {}
        short = shorten(self.circuit, self.runs)
        best_of = shortest(self.circuit, short, SHORTENING) if not in_hurry else _unproved(short)
        for index, best in best_of.items():
            try:
                found[index] = CommonRun(runs.events(best.run), best.proved)
            except Spurious as reason:
                found[index] = Open(str(reason))
        return found
