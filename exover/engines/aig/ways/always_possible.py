"""Is there a way from everywhere? Answered by words that were found, and their weakest preconditions.

A *word* is a concrete sequence of events. The states from which it leads to a goal, steps that cannot be taken being
left out, are a literal over the state: its weakest precondition (Dijkstra 1975), built by setting the inputs of copies
of the step to constants. A solver is asked for a reachable state that no word helps; a word is looked for from there,
and so on (counterexample-guided, after Clarke, Grumberg, Jha, Lu, Veith 2000). Random runs that go on from such a state
often come to others, and cost less. If no word is found from one, that there is none is proved of it. It is enough to
look at home states where reports lead there from everywhere.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cached_property, partial

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Inputs, Open, Reachable, Unreachable
from exover.engines.aig.circuit.graph import FALSE, TRUE, Circuit
from exover.engines.aig.circuit.solver import Solver
from exover.engines.aig.circuit.words import lit
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import CutOff
from exover.engines.aig.induction.implicants import Decide, Implicants, StatesOfKind
from exover.engines.aig.induction.inductive import Induction
from exover.engines.aig.induction.reached_bmc import runs_from_start
from exover.engines.aig.simulation.evaluation import whole_evaluator
from exover.engines.aig.simulation.exploration import Seed
from exover.engines.aig.simulation.shorten import shorten
from exover.engines.aig.ways.beginnings import Beginnings
from exover.engines.aig.ways.home_ranking import home_space
from exover.engines.aig.ways.home_states import HomeSpace
from exover.engines.aig.ways.preconditions import Preconditions
from exover.engines.aig.ways.way_literals import WayEncoder
from exover.engines.aig.ways.word_search import WaysBudget, WordSearch, beginning_in
from exover.model.property import Formula

Unroll = Callable[[Circuit], dict[int, Inputs]]
"""Returns short runs that make bad literals true, by index, those that it finds soon."""
GROWTH = 1.0
"""Questions are asked together until the graph has grown by so many times the size of the circuit."""
TURNS = 3
"""How many times they are asked in a row, before others are, while that makes progress."""


@dataclass(frozen=True, slots=True)
class NeverCutOff:
    """There is a way from everywhere: in every state of the invariant that needs one, some word leads to the goal.

    If home states are reached from everywhere, only they need one, for most questions.
    """

    words: tuple[Inputs, ...]
    invariant: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class ShownCutOff:
    """This run comes to a moment from which there is no way."""

    inputs: Inputs


WayAnswer = NeverCutOff | ShownCutOff | Open
SayWay = Callable[[int, WayAnswer], None]
"""Takes the index of a question, and the answer."""


@dataclass
class Ways:
    """Answers questions about ways in one encoding."""

    encoding: Encoding
    questions: Sequence[CutOff]
    runs: Sequence[Inputs]
    decide: Decide
    say: SayWay
    budget: WaysBudget
    unroll: Unroll

    def __post_init__(self) -> None:
        _ = self.encoding.moments.owed, self.encoding.moments.domain  # makes them part of the graph before it is copied
        aims = WayEncoder(self.encoding)
        self._reports = self.encoding.graph.any(
            self.encoding.graph.conjunction(self.encoding.legal, lit(event.chosen))
            for event in self.encoding.events
            if event.kind.verb == "report" or event.kind.verb.startswith("observe")
        )
        with closing(Solver(self.encoding.graph.within_step())) as solver:
            allows = partial(self._allows_steps_home, solver)
            self.aims = [aims.of(question, allows) for question in self.questions]
        self.fresh = aims.fresh
        self.circuit = self.encoding.circuit([aim.hit for aim in self.aims])
        self.graph = self.encoding.graph.copy()
        self.cone = whole_evaluator(self.circuit)
        self.left = dict.fromkeys(range(len(self.questions)))
        self.induction = Induction(self.circuit)

    def close(self) -> None:
        """Free the solver."""
        self.induction.close()

    def _allows_steps_home(self, solver: Solver, allowed: Formula) -> bool:
        """Return whether a formula is true after every report and observation."""
        graph = self.encoding.graph
        wrong = graph.conjunction(self._reports, self.encoding.moments.truth(allowed) ^ 1)
        if wrong == FALSE:
            return True
        solver.grow(graph.within_step())
        return not solver.possible([wrong])

    @cached_property
    def words(self) -> WordSearch:
        """The search for words, from home states if these are reached from everywhere."""
        beginnings = Beginnings(self.encoding, self.circuit, self.cone, self.fresh)
        ends = beginnings.ends(self.runs)
        readings = (None, *(each.true for each in ends[1 :: max(1, len(ends) // self.budget.readings)]))
        found = home_space(self.encoding, self.graph, readings, self.decide, self.budget.stop)
        home = found or HomeSpace(self.encoding)
        return WordSearch(
            self.encoding,
            self.circuit,
            self.cone,
            self.left.keys(),
            replace(beginnings, home=home.run) if found else beginnings,
            Preconditions(self.graph, self.circuit, self.aims, self.fresh, home.fixed, found is not None),
            () if found else home.run,
            self.budget,
        )

    def judge(self) -> None:
        """Answer all questions."""
        beginnings, most = self.words.beginnings, self.budget.samples // 2
        known = beginnings.passed(self.runs, most) + beginnings.of_new_modes(self.runs, most)
        self.words.take(beginnings.of(known))
        self.words.rehearse()
        for _ in range(self.budget.proofs):
            more = [self._ask(part) for part in self._parts()]
            if not (self._settle_hard() or any(more)):
                break
        for index in list(self.left):
            self._answer(index, Open("bound reached: neither ways from everywhere nor a moment without one are known"))

    def _answer(self, index: int, verdict: WayAnswer) -> None:
        del self.left[index]
        self.words.rehearsal.drop(index)
        self.say(index, verdict)

    # ---- words ----

    def _settle_hard(self) -> bool:
        """Look for words by model checkers where random runs show none; return whether anything changed."""
        before = self.words.tried()
        self.words.settle_hard(self._settle)
        return self.words.tried() != before

    def _settle(self, sample: Seed, wanted: Sequence[int]) -> dict[int, Inputs]:
        """Return words that model checkers find from a state; if they prove that there is none, answer the question.

        The invariant of the proof is reduced to the clauses that it needs, so that it covers more states.
        """
        answers = self._answers(self.words.circuit_from(sample, wanted))
        invariants = {
            wanted[place]: self.induction.enough(each.invariant, self.circuit.bad[wanted[place]])
            for place, each in answers.items()
            if isinstance(each, Unreachable)
        }
        start, early = self.words.open_at_start(invariants)
        if early and start.true != sample.true:
            self._settle(start, early)  # if no way leads from the start, the run to it is the shortest
            invariants = {index: each for index, each in invariants.items() if index in self.left}
        if invariants:
            self._without_way(sample, invariants)
        return {place: each.inputs for place, each in answers.items() if isinstance(each, Reachable)}

    def _answers(self, circuit: Circuit) -> dict[int, Answer]:
        """Return the answers to the bad literals of a circuit, by index."""
        found: dict[int, Answer] = {index: Reachable(run) for index, run in self.unroll(circuit).items()}
        left = [index for index in range(len(circuit.bad)) if index not in found]
        if left:
            rest = replace(circuit, bad=tuple(circuit.bad[index] for index in left))
            self.decide(rest, lambda place, answer: found.__setitem__(left[place], answer), self.budget.stop)
        return dict(sorted(found.items()))

    def _without_way(self, sample: Seed, invariants: Mapping[int, Sequence[Clause]]) -> None:
        """Answer questions that have no way from a sample, if a run goes on from there to where they need one.

        `invariants`: by question one that holds in the sample; from no state of it is there a way. A shorter run than
        that by the sample often leads to a state of it. If no run is found, a question is asked of all states, not of
        home states alone.
        """
        graph = self.encoding.graph
        begun = {2 * node + sign: TRUE ^ sign for node in self.fresh for sign in (0, 1)}
        bad = []
        for index, clauses in invariants.items():
            inside = graph.all(graph.any(begun.get(literal, literal) for literal in clause) for clause in clauses)
            bad.append(graph.conjunction(self.aims[index].since, inside))
        circuit = self.encoding.circuit(bad)
        answers = self._answers(beginning_in(circuit, sample))
        runs = {place: (*sample.run, *each.inputs) for place, each in answers.items() if isinstance(each, Reachable)}
        for place, run in shorten(circuit, runs).items():
            self._answer([*invariants][place], ShownCutOff(run[:-1]))
        for index in self.left.keys() & invariants.keys():
            self.words.begin_anywhere(index, self.runs)

    # ---- proofs ----

    @cached_property
    def _implicants(self) -> Implicants:
        following = [self.encoding.following[2 * node] for node, _ in self.graph.latches]
        return Implicants(self.graph, following, self.encoding.moments.domain, self.decide, self.budget.stop)

    def _parts(self) -> Iterator[dict[int, StatesOfKind]]:
        """Yield the questions that have a word from every known state, those with the fewest steps first.

        Each comes with where no word helps it. What they need of the graph is built as they are taken: answers do not
        wait for what those with more steps need.
        """
        steps = {index: sum(map(len, self.words.rehearsal.chosen(index))) for index in self.left}
        part: dict[int, StatesOfKind] = {}
        size = len(self.graph.fanins)
        for index in sorted(self.left, key=steps.__getitem__):
            if index in self.left and self.words.rehearsal.helps(index) and not self.budget.stop():
                part[index] = self.words.unhelped(index)
            if part and len(self.graph.fanins) > size + GROWTH * len(self.circuit.fanins):
                yield part
                part, size = {}, len(self.graph.fanins)
        if part:
            yield part

    def _ask(self, part: Mapping[int, StatesOfKind]) -> bool:
        """Look for reachable states that no word helps, a few times while that makes progress; return whether it did.

        A question that is asked again soon costs little, one that is asked again and again keeps the others waiting.
        """
        for turn in range(TURNS):
            if not part or not self._reach(part):
                return turn > 0
            part = {k: self.words.unhelped(k) for k in part if k in self.left and self.words.rehearsal.helps(k)}
        return True

    def _reach(self, part: Mapping[int, StatesOfKind]) -> bool:
        """Look for reachable states that no word helps; return whether that made progress."""
        before = self.words.tried(), len(self._implicants.excluded)
        excluded, found = self._implicants.exclude(part)
        for index in excluded:
            self._answer(index, NeverCutOff(tuple(self.words.rehearsal.chosen(index)), tuple(self._implicants.clauses)))
        ends = self.words.beginnings.reached([run[:-1] for run in found])
        if ends:
            self.words.take(ends)
            self.words.rehearse()
            self.words.wander(ends)
        return (self.words.tried(), len(self._implicants.excluded)) != before


def judge_ways(
    encoding: Encoding,
    questions: Sequence[CutOff],
    runs: Sequence[Inputs],
    decide: Decide,
    say: SayWay,
    budget: WaysBudget | None = None,
    unroll: Unroll = runs_from_start,
) -> None:
    """Say the answer to each question, as soon as it is found: `NeverCutOff` iff it is answered with no.

    `runs`: some that come to states of many kinds. Where there are assumptions, answers are about runs that can go on
    for ever only if all can (`machine_closure`).
    """
    with closing(Ways(encoding, questions, runs, decide, say, budget or WaysBudget(), unroll)) as ways:
        ways.judge()
