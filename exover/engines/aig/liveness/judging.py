"""Whether infinite runs satisfy formulas of LTL: proofs that none does, and lassos that do.

k-liveness: if no run comes to the end of its k-th round, no infinite run satisfies the formula (Claessen, Sörensson
2012). From a run that does, random runs that stay and repeat themselves look for a lasso. If one round of all signals
decides nothing, liveness to safety: does a run come back to a state that was stored (Biere, Artho, Schuppan 2002)?
"""

from collections.abc import Callable, Container, Mapping, Sequence
from typing import Protocol

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Inputs, Open, Reachable, SayAnswer, Unreachable
from exover.engines.aig.circuit.graph import FALSE, Circuit, Literal
from exover.engines.aig.encoding.concretize import Concretizer, Spurious
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import LassoQuestion
from exover.engines.aig.liveness.k_liveness import KLiveness, Staying
from exover.engines.aig.liveness.lasso_seeds import LassoSeeds
from exover.engines.aig.liveness.lassos import nearer, shorter, shown
from exover.engines.aig.liveness.liveness_to_safety import LivenessToSafety, looked_at, return_to
from exover.engines.aig.liveness.random_lassos import InputLasso, RandomLassos, SimulatedCircuit
from exover.engines.aig.liveness.tableau import staying
from exover.engines.aig.simulation.coverage import CoverageGoals
from exover.engines.aig.simulation.exploration import LANES, Exploration, Seed
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.model.trace import Trace


@dataclass(frozen=True, slots=True)
class NoLasso:
    """No run satisfies the formula: the invariant excludes the bad literal of a monitor; `method`: of which."""

    method: str
    bad: Literal
    invariant: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class ShownLasso:
    """This run, a lasso of the reference interpreter, satisfies the formula."""

    trace: Trace


WORDS, EXPLORED = 6, 20
"""How many random words are tried from the seeds of a search; after how many rounds of random runs that show no end of
a round of k-liveness a model checker is asked."""
MOST_ROUNDS = 8
"""The greatest k for which k-liveness is asked."""
WORK, BRIEF = 50_000_000, 8
"""The budget of a question for model checkers; the fraction (1 / `BRIEF`) of it for one about a single state."""
ROUNDS, RETURN = "k-liveness k={}", "liveness to safety"
LassoAnswer = NoLasso | ShownLasso | Open
SayLasso = Callable[[int, LassoAnswer], None]
"""Takes the index of a question, and the answer."""


class BudgetedDecide(Protocol):
    """Answers the bad literals of a circuit, each by its index."""

    def __call__(self, circuit: Circuit, say: SayAnswer, *, budget: int) -> None:
        """Say the answer to each; `budget`: the work granted, as a part of `WORK`."""
        ...


class Judging:
    """Judges questions about infinite runs of one encoding, by index, and says each answer as soon as it is found.

    Monitors are added to the graph. All answers but lassos hold only if the passes are enough.
    """

    def __init__(
        self,
        encoding: Encoding,
        questions: Sequence[LassoQuestion],
        decide: BudgetedDecide,
        say: SayLasso,
    ) -> None:
        """Take questions."""
        self.encoding, self.decide, self.say = encoding, decide, say
        self.runs: Sequence[Inputs] = ()
        made = {each: staying(encoding, each.path, each.fair) for each in dict.fromkeys(questions)}
        self.staying = tuple(made.values())
        self.needed: list[set[int]] = [set() for _ in made]
        """By question which of its signals a round waits for: those that some run was seen to miss."""
        self.counts = dict.fromkeys(range(len(made)), 1)
        """By question the k of k-liveness that is asked about next."""
        self.rounds: dict[tuple[int, frozenset[int]], KLiveness] = {}
        places = {question: place for place, question in enumerate(made)}
        self.askers: dict[int, list[int]] = {}
        for index, question in enumerate(questions):
            self.askers.setdefault(places[question], []).append(index)
        self.left = list(range(len(made)))
        self.machine = SimulatedCircuit.of(encoding, self.staying)
        self.concretizer = Concretizer(encoding)
        self.ends: dict[int, Inputs] = {}
        """By question the latest run found that ends a round, of all signals or of the needed ones."""
        self.why: dict[int, str] = {}
        """By question why it is left open, if that is known."""
        latches = encoding.latches
        values = (*latches.readings, *latches.held)
        self._values = [frozenset(bit >> 1 for bit in latches.literals[name]) for name in values]

    def wander(self, runs: Sequence[Inputs], asked: Container[int] | None = None) -> None:
        """Look for random lassos from states of known runs in which questions stay; `asked`: of these indices alone."""
        places = [place for place in self.left if asked is None or any(index in asked for index in self.askers[place])]
        if places:
            begun = LassoSeeds(self.machine, runs, 0).seeds()
            self._wander({place: begun[place] for place in places if place in begun}, 1)

    def run(self, runs: Sequence[Inputs]) -> None:
        """Answer all questions; `runs`: known runs, to states of many kinds."""
        self.runs = runs
        self.wander(runs)
        for place in list(self.left):
            if self.staying[place].step == FALSE:
                self._answer(place, NoLasso(ROUNDS.format(1), FALSE, ()))
        shown = sorted(self.ends.keys() & self.counts.keys())  # known runs end a round of these
        for place in shown:
            self.needed[place] = self._signals(place)
        self._look_on(shown)
        turn = 1
        while self.counts:
            self._count(turn)
            turn += 1
        for place in list(self.left):
            nothing = f"neither a lasso nor a proof by {MOST_ROUNDS} rounds"
            self._answer(place, Open(self.why.get(place, nothing)))

    def _answer(self, place: int, answer: LassoAnswer) -> None:
        self.left.remove(place)
        self.counts.pop(place, None)
        for index in self.askers[place]:
            self.say(index, answer)

    def _found(self, found: Mapping[int, InputLasso]) -> None:
        """Answer questions by lassos that the reference interpreter follows; of others note why it does not."""
        short = shorter(self.machine, found)
        near = nearer(self.machine, short)
        for place, lasso in sorted(short.items()):
            trace = self._shown(near.get(place, lasso)) or self._shown(lasso)
            if trace is None:
                self.why[place] = "an abstract run through compared reals has no concrete one"
            else:
                self._answer(place, ShownLasso(trace))

    def _wander(self, begun: dict[int, list[Seed]], seed: int) -> None:
        """Look for random lassos from seeds in which questions stay."""
        if not begun:
            return
        wandering = RandomLassos(self.machine, begun, seed)
        found = dict(wandering.lassos(WORDS))
        for place, missed in wandering.missed.items():
            self.needed[place] |= missed
        self.ends |= wandering.rounds()
        self._found(found)

    def _shown(self, lasso: InputLasso) -> Trace | None:
        try:
            return shown(self.concretizer, lasso)
        except Spurious:
            return None

    def _monitor(self, place: int) -> KLiveness:
        """Return the monitor that counts the rounds of a question; a round waits for the needed signals alone."""
        needed = frozenset(self.needed[place])
        if (place, needed) not in self.rounds:
            whole = self.staying[place]
            signals = tuple(whole.signals[number] for number in sorted(needed))
            self.rounds[place, needed] = KLiveness(self.encoding, Staying(whole.begun, whole.step, signals))
        return self.rounds[place, needed]

    def _count(self, turn: int) -> None:
        """Ask of each question whether a run ends its k-th round; look for lassos, and go on, from runs that do."""
        asked = list(self.counts)
        bad = [self._monitor(place).bad(self.counts[place]) for place in asked]
        runs: dict[int, list[Seed]] = {}
        given_up: list[int] = []

        def heard(number: int, answer: Answer) -> None:
            place = asked[number]
            match answer:
                case Unreachable(invariant):
                    self._answer(place, NoLasso(ROUNDS.format(self.counts[place]), bad[number], invariant))
                case Reachable(inputs):
                    runs[place] = self.machine.seeds_of(place, inputs)
                    self.ends[place] = inputs
                case Open(reason):
                    del self.counts[place]
                    self.why.setdefault(place, reason)
                    given_up.append(place)

        for number, place in enumerate(asked):
            if found := self._explored(self._monitor(place), bad[number]):
                heard(number, found)
        left = [number for number, place in enumerate(asked) if place not in runs]
        circuit = self.encoding.circuit([bad[number] for number in left])
        self.decide(circuit, lambda number, answer: heard(left[number], answer), budget=WORK)
        self._wander({place: found for place, found in runs.items() if found}, turn + 1)
        self._look_on([place for place in sorted(runs) if place in self.counts])
        for place in sorted(given_up):
            self._return(place)

    def _explored(self, monitor: KLiveness, bad: Literal) -> Reachable | None:
        """Return a run to a bad literal of a monitor, if random runs show one; they go on where most signals were seen.

        What is new are sets of signals that were seen: as long as a run stays, they only grow.
        """
        seen = tuple(latch >> 1 for latch in monitor.seen)
        stimulus = RandomStimulus(self.encoding, LANES).stimulus()
        circuit = self.encoding.circuit([bad])
        exploration = Exploration(circuit, [0], stimulus, CoverageGoals(mode=seen, progress=seen))
        exploration.follow(self.runs)
        exploration.run(EXPLORED)
        return exploration.found.get(0)

    def _signals(self, place: int) -> set[int]:
        """Return the indices of all signals of a question."""
        return set(range(len(self.staying[place].signals)))

    def _look_on(self, places: Sequence[int]) -> None:
        """Let rounds wait for all signals; if such a round has ended, ask for a return, then about more rounds."""
        ended = [place for place in places if self.needed[place] == self._signals(place)]
        first = [place for place in ended if self.counts[place] == 1]
        returning = {place: self._back_to(place, self.ends[place]) for place in first}
        self._found({place: lasso for place, lasso in returning.items() if lasso})
        for place in places:
            if place not in ended:
                self.needed[place] = self._signals(place)
            elif place in self.counts:
                self._look_further(place)

    def _look_further(self, place: int) -> None:
        if self.counts[place] == 1:
            self._return(place)
        if place in self.counts:
            self.counts[place] *= 2
            if self.counts[place] > MOST_ROUNDS:
                del self.counts[place]

    def _back_to(self, place: int, run: Inputs) -> InputLasso | None:
        """Return a lasso whose loop begins at the end of `run`, if one is found with little effort; else None."""
        *_, state = self.machine.states(run)
        circuit = return_to(self.encoding, self.staying[place], {node: bool(word) for node, word in state.items()})
        answers: list[Answer] = []
        self.decide(circuit, lambda _, each: answers.append(each), budget=WORK // BRIEF)
        return InputLasso(run, answers[0].inputs[:-1]) if isinstance(answers[0], Reachable) else None

    def _return(self, place: int) -> None:
        """Ask whether a run comes back to where it was, having seen all signals.

        Counterexample-guided refinement (Clarke, Grumberg, Jha, Lu, Veith 2003): at first readings, levels, arguments
        and results need not be as they were; those that differ on a run that is found have to be from then on.
        """
        free: Sequence[frozenset[int]] | None = self._values
        while free is not None:
            free = self._come_back(place, free)

    def _come_back(self, place: int, free: Sequence[frozenset[int]]) -> list[frozenset[int]] | None:
        """Ask for a return to a state that is equal but for the `free` variables, each a set of latches.

        Return the variables that stay free if it is to be asked again, else `None`.
        """
        whole = looked_at(self.encoding, self.staying[place])
        copied = set(whole).difference(*free)
        monitor = LivenessToSafety(self.encoding, self.staying[place], [node for node in whole if node in copied])
        answers: list[Answer] = []
        self.decide(self.encoding.circuit([monitor.bad]), lambda _, each: answers.append(each), budget=WORK)
        match answers:
            case [Unreachable(invariant)]:
                self._answer(place, NoLasso(RETURN, monitor.bad, invariant))
            case [Reachable(inputs)]:
                lasso = self.machine.returned(place, inputs, monitor.keep)
                moved = self.machine.moved(lasso).intersection(whole)
                if moved:
                    again = self._back_to(place, lasso.stem)
                    if again is None:
                        rest = [each for each in free if each.isdisjoint(moved)]
                        assert len(rest) < len(free), "what is compared differs"
                        return rest
                    lasso = again
                self._found({place: lasso})
            case _:
                pass
        return None
