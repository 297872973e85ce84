"""Whether infinite runs satisfy formulas of LTL: proofs that none does, and lassos that do.

k-liveness: if no run comes to the end of its k-th round, no infinite run satisfies the formula (Claessen, Sörensson
2012). From a run that does, random runs that stay and repeat themselves look for a lasso. It is asked of a round of few
signals, then of all; then liveness to safety: does a run come back to a state that was stored (Biere, Artho, Schuppan
2002)? What that leaves open, more rounds may decide.
"""

from collections.abc import Callable, Container, Mapping, Sequence
from typing import Protocol

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Inputs, Open, Reachable, SayAnswer, Unreachable
from exover.engines.aig.circuit.graph import FALSE, Circuit, Literal
from exover.engines.aig.encoding.concretize import Concretizer, Spurious
from exover.engines.aig.encoding.coverage_goals import coverage_goals
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


WORDS = 6
"""How many random words are tried from the seeds of a search."""
TOGETHER, ALONE = 4, 12
"""How many rounds of random runs may end no round of k-liveness, of all questions together, and of one alone."""
FURTHER_ROUNDS = 2, 4, 8
"""For which k k-liveness is asked after a return."""
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
        """By question those of its signals that some run was seen to miss; a first round waits for these alone."""
        places = {question: place for place, question in enumerate(made)}
        self.askers: dict[int, list[int]] = {}
        for index, question in enumerate(questions):
            self.askers.setdefault(places[question], []).append(index)
        self.left = list(range(len(made)))
        self.machine = SimulatedCircuit.of(encoding, self.staying)
        self.concretizer = Concretizer(encoding)
        self.ends: dict[int, Inputs] = {}
        """By question the latest run found that ends a round of all signals."""
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
        self._ask_few_signals()
        self._ask_all_signals()
        for place in list(self.left):
            nothing = f"neither a lasso nor a proof by {FURTHER_ROUNDS[-1]} rounds"
            self._answer(place, Open(self.why.get(place, nothing)))

    def _answer(self, place: int, answer: LassoAnswer) -> None:
        self.left.remove(place)
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

    def _ask_few_signals(self) -> None:
        """Ask whether runs end a round of the signals that some run misses; look for lassos from runs that do."""
        few = {place: self._of_few(place) for place in self.left if place not in self.ends}
        seen = [latch for each in few.values() for latch in (each.staying.begun, *each.seen)]
        pairs = (*dict.fromkeys(latch >> 1 for latch in seen), *coverage_goals(self.encoding.latches).pairs)
        explored = self._explored(few, CoverageGoals(pairs), TOGETHER)
        left = {place: monitor for place, monitor in few.items() if place not in explored}
        ended = explored | self._ended(left, 1)
        of_all = [place for place in ended if len(few[place].seen) == len(self.staying[place].signals)]
        self.ends |= {place: ended[place] for place in of_all}
        self._wander(self._seeds(ended), 2)

    def _of_few(self, place: int) -> KLiveness:
        whole = self.staying[place]
        signals = tuple(whole.signals[number] for number in sorted(self.needed[place]))
        return KLiveness(self.encoding, Staying(whole.begun, whole.step, signals))

    def _ask_all_signals(self) -> None:
        """Ask whether runs end a round of all signals, then whether they return, then about more and more rounds."""
        whole = {place: KLiveness(self.encoding, self.staying[place]) for place in self.left}
        known = {place: run for place, run in self.ends.items() if place in whole} | self._seen_ending(whole)
        left = {place: monitor for place, monitor in whole.items() if place not in known}
        self._look_from(known | self._ended(left, 1))
        for place in list(self.left):
            self._return(place)
        asked = [place for place in self.left if place in self.ends]
        for count in FURTHER_ROUNDS:
            ended = self._ended({place: whole[place] for place in asked}, count)
            self._look_from(ended)
            asked = [place for place in self.left if place in ended]

    def _seen_ending(self, whole: Mapping[int, KLiveness]) -> dict[int, Inputs]:
        """Return runs that end a round of all signals, of questions of which none is known, as random runs show them.

        As long as a run stays, it sees more and more signals. Sets of them that no run has seen are new, and random
        runs go on from those that have seen most.
        """
        found: dict[int, Inputs] = {}
        for place, monitor in whole.items():
            if place not in self.ends:
                seen = tuple(latch >> 1 for latch in monitor.seen)
                found |= self._explored({place: monitor}, CoverageGoals(mode=seen, progress=seen), ALONE)
        return found

    def _look_from(self, ended: Mapping[int, Inputs]) -> None:
        """Look for lassos from runs that end a round of all signals, with little effort."""
        self.ends |= ended
        self._wander(self._seeds(ended), 3)
        returning = {place: self._back_to(place, ended[place]) for place in sorted(ended) if place in self.left}
        self._found({place: lasso for place, lasso in returning.items() if lasso})

    def _seeds(self, ended: Mapping[int, Inputs]) -> dict[int, list[Seed]]:
        """Return the states of runs in which questions stay, of those that do."""
        found = {place: self.machine.seeds_of(place, run) for place, run in sorted(ended.items())}
        return {place: seeds for place, seeds in found.items() if seeds}

    def _ended(self, monitors: Mapping[int, KLiveness], count: int) -> dict[int, Inputs]:
        """Return runs, by question, that end the `count`-th round of monitors; answer questions of which none does."""
        bad = {place: monitor.bad(count) for place, monitor in monitors.items()}
        runs: dict[int, Inputs] = {}

        def heard(place: int, answer: Answer) -> None:
            match answer:
                case Unreachable(invariant):
                    self._answer(place, NoLasso(ROUNDS.format(count), bad[place], invariant))
                case Reachable(inputs):
                    runs[place] = inputs
                case Open(reason):
                    self.why.setdefault(place, reason)

        asked = list(bad)
        circuit = self.encoding.circuit(list(bad.values()))
        self.decide(circuit, lambda number, answer: heard(asked[number], answer), budget=WORK)
        return runs

    def _explored(self, monitors: Mapping[int, KLiveness], goals: CoverageGoals, rounds: int) -> dict[int, Inputs]:
        """Return runs, by question, that end the first round of monitors, as far as random runs show some."""
        asked = list(monitors)
        circuit = self.encoding.circuit([monitor.bad(1) for monitor in monitors.values()])
        stimulus = RandomStimulus(self.encoding, LANES).stimulus()
        exploration = Exploration(circuit, range(len(asked)), stimulus, goals)
        exploration.follow(self.runs)
        while exploration.run(rounds):
            pass
        return {asked[number]: found.inputs for number, found in exploration.found.items()}

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
