"""Is there a way from everywhere? Answered by words that were found, and their weakest preconditions.

A *word* is a concrete sequence of events. The states from which it leads to a goal, steps that cannot be taken being
left out, are a literal over the state: its weakest precondition (Dijkstra 1975), built by setting the inputs of copies
of the step to constants. A solver is asked for a reachable state that no word helps; a word is looked for from there,
and so on (counterexample-guided, after Clarke, Grumberg, Jha, Lu, Veith 2000). Random runs that go on from such a state
often come to others, and cost less. If no word is found from one, that there is none is proved of it. It is enough to
look at home states where reports lead there from everywhere.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cached_property, partial, reduce
from operator import or_

from exover.dataclass import dataclass
from exover.engines.aig.answer import Answer, Clause, Inputs, Open, Reachable, StopRequested, Unreachable, never
from exover.engines.aig.beginnings import Beginnings
from exover.engines.aig.coverage import coverage_goals
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.evaluation import whole_evaluator
from exover.engines.aig.exploration import Exploration, Seed, thinned
from exover.engines.aig.graph import FALSE, TRUE, Circuit, Literal
from exover.engines.aig.home_ranking import home_space
from exover.engines.aig.home_states import HomeSpace
from exover.engines.aig.implicants import Decide, Implicants, StatesOfKind
from exover.engines.aig.inductive import Induction
from exover.engines.aig.lanes import numbers
from exover.engines.aig.preconditions import Preconditions
from exover.engines.aig.questions import CutOff
from exover.engines.aig.reached_bmc import runs_from_start
from exover.engines.aig.shorten import shorten
from exover.engines.aig.simulation import Stimulus
from exover.engines.aig.solver import Solver
from exover.engines.aig.stimulus import RandomStimulus
from exover.engines.aig.way_literals import WayEncoder
from exover.engines.aig.word_simulation import WordSimulation
from exover.engines.aig.words import lit
from exover.model.property import Formula


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
Unroll = Callable[[Circuit], dict[int, Inputs]]
"""Returns short runs that make bad literals true, by index, those that it finds soon."""


Look = Callable[[Seed, Sequence[int]], dict[int, Inputs]]
"""Returns words from a state, by place of a question among those that need one."""
LANES = 512
"""How many random runs look for words side by side."""
GROWTH = 1.0
"""Questions are asked together until the graph has grown by so many times the size of the circuit."""
TURNS = 3
"""How many times they are asked in a row, before others are, while that makes progress."""
BEGUN = 64
"""From how many states random runs go on at once, at most."""
VAIN = 2
"""How many times in a row they may come to no state without a word."""


@dataclass(frozen=True, slots=True)
class WaysBudget:
    """How much is tried.

    `readings`: from how many states home states may take their readings; `samples`: from how many states words are
    simulated; `tries`: from how many words are looked for at once, in `rounds` of random runs each. `proofs`: how often
    all questions are asked of the solver. `stop` ends it all.
    """

    readings: int = 12
    samples: int = 4096
    tries: int = 32
    rounds: int = 12
    proofs: int = 12
    stop: StopRequested = never


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
        self.hits = tuple(aim.hit for aim in self.aims)
        self.circuit = self.encoding.circuit(self.hits)
        self.graph = self.encoding.graph.copy()
        self.cone = whole_evaluator(self.circuit)
        self.rehearsal = WordSimulation(self.circuit, self.cone)
        self.hard: set[int] = set()
        """Questions for which random runs from some sample found no word; model checkers are asked next."""
        self.tired: set[tuple[int, int]] = set()
        """Pairs of a sample, by number, and a question for which model checkers have looked for a word from there."""
        self.left = dict.fromkeys(range(len(self.questions)))
        self.beginnings = Beginnings(self.encoding, self.circuit, self.cone, self.fresh)
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
        return not solver.satisfiable([solver.literal(wrong)])

    def judge(self) -> None:
        """Answer all questions."""
        ends = self.beginnings.ends(self.runs)
        readings = (None, *(each.true for each in ends[1 :: max(1, len(ends) // self.budget.readings)]))
        home = home_space(self.encoding, self.graph, readings, self.decide, self.budget.stop)
        home_reachable, self.home = home is not None, home or HomeSpace(self.encoding)
        self.prefix = () if home_reachable else self.home.run
        self.beginnings.home = self.home.run if home_reachable else ()
        self.preconditions = Preconditions(
            self.graph, self.circuit, self.aims, self.fresh, self.home.fixed, home_reachable
        )
        known = self.beginnings.passed(self.runs, self.budget.samples // 2)
        known += self.beginnings.of_new_modes(self.runs, self.budget.samples // 2)
        self._take(self.beginnings.of(known))
        self._rehearse()
        for _ in range(self.budget.proofs):
            more = [self._ask(part) for part in self._parts()]
            if not (self._settle_hard() or any(more)):
                break
        for index in list(self.left):
            self._answer(index, Open("bound reached: neither ways from everywhere nor a moment without one are known"))

    def _answer(self, index: int, verdict: WayAnswer) -> None:
        del self.left[index]
        self.rehearsal.drop(index)
        self.say(index, verdict)

    # ---- words ----

    def _take(self, samples: Sequence[Seed]) -> list[Seed]:
        """Simulate known words from more samples; return those from which a question that is not hard has none."""
        if not samples:
            return []
        first = len(self.rehearsal.samples)
        self.rehearsal.add(samples, self.preconditions.needed(samples, self.left))
        unhelped = self.rehearsal.unhelped().items()
        missed = reduce(or_, (where for k, where in unhelped if k not in self.hard), 0) >> first
        return [sample for number, sample in enumerate(samples) if missed >> number & 1]

    def _wander(self, begun: Sequence[Seed]) -> None:
        """Look for states without a word where random runs lead from these states, and for words from there.

        It goes on, from what is found first, as long as something is and there are not too many samples.
        """
        around, vain, most = list(thinned(begun, BEGUN)), 0, self.budget.samples
        while vain < VAIN and self.left and len(self.rehearsal.samples) < most and not self.budget.stop():
            known = {sample.true for sample in self.rehearsal.samples}
            missed = self._take([each for each in self.beginnings.near(around) if each.true not in known])
            vain = 0 if missed else vain + 1
            around = [*missed, *around][:BEGUN]
            self._rehearse()

    def _rehearse(self) -> None:
        """Look for words from samples without one, by pairs of known words and random runs; else a question is hard."""
        for _ in range(self.budget.tries):
            number, wanted = self._hardest(lambda _, question: question not in self.hard)
            if not wanted or self.budget.stop():
                break
            self.hard.update(self._look(number, wanted, (self.rehearsal.composed, self._search)))

    def _settle_hard(self) -> bool:
        """Look for words by model checkers where random runs show none; return whether anything changed."""
        before = self._tried()
        for _ in range(self.budget.tries):
            number, wanted = self._hardest(lambda *pair: pair not in self.tired)
            if not wanted or self.budget.stop():
                break
            self._look(number, wanted, (self._settle,))
            self.tired.update((number, question) for question in wanted)
            self.hard.difference_update(wanted)
            self._rehearse()
        return self._tried() != before

    def _look(self, number: int, wanted: Sequence[int], looks: Sequence[Look]) -> list[int]:
        """Look for words from a sample, and return the questions of which none is found.

        Words that begin with the run home are tried first: they help in many more states.
        """
        left = list(wanted)
        for prefix in dict.fromkeys((self.prefix, ())):
            (there,) = self.beginnings.led([self.rehearsal.samples[number]], [prefix])
            sample = self.beginnings.fresh_at(there)
            for look in looks:
                if left and not self.budget.stop():
                    self._learn(prefix, sample, left, look(sample, left))
                    unhelped = self.rehearsal.unhelped()
                    left = [k for k in left if unhelped.get(k, 0) >> number & 1]
        return left

    def _hardest(self, counts: Callable[[int, int], bool]) -> tuple[int, list[int]]:
        """Return the sample, by number, at which most questions need a word, and these; of the pairs that count."""
        wanted: dict[int, list[int]] = {0: []}
        for question, where in self.rehearsal.unhelped().items():
            for number in numbers(where):
                if counts(number, question):
                    wanted.setdefault(number, []).append(question)
        hardest = max(wanted, key=lambda number: (len(wanted[number]), -number))
        return hardest, wanted[hardest]

    @cached_property
    def _events(self) -> Stimulus:
        """Random events, the same for each search."""
        return RandomStimulus(self.encoding, LANES).stimulus()

    def _search(self, sample: Seed, wanted: Sequence[int]) -> dict[int, Inputs]:
        """Return words that random runs from a state show."""
        circuit = self._from(sample, wanted)
        exploration = Exploration(
            circuit, range(len(wanted)), self._events, coverage_goals(self.encoding.latches), LANES, self.cone
        )
        return {place: found.inputs for place, found in exploration.run(self.budget.rounds).items()}

    def _settle(self, sample: Seed, wanted: Sequence[int]) -> dict[int, Inputs]:
        """Return words that model checkers find from a state; if they prove that there is none, answer the question.

        The invariant of the proof is reduced to the clauses that it needs, so that it covers more states.
        """
        answers = self._answers(self._from(sample, wanted))
        invariants = {
            wanted[place]: self.induction.enough(each.invariant, self.hits[wanted[place]])
            for place, each in answers.items()
            if isinstance(each, Unreachable)
        }
        start, early = self._open_at_start(invariants)
        if early and start.true != sample.true:
            self._settle(start, early)  # if no way leads from the start, the run to it is the shortest
            invariants = {index: each for index, each in invariants.items() if index in self.left}
        if invariants:
            self._without_way(sample, invariants)
        return {place: each.inputs for place, each in answers.items() if isinstance(each, Reachable)}

    def _open_at_start(self, questions: Iterable[int]) -> tuple[Seed, list[int]]:
        """Return the start, and the questions that need a way there and have no word."""
        start, unhelped = self.beginnings.fresh_at(self.beginnings.start), self.rehearsal.unhelped()
        there = sum(1 << n for n, sample in enumerate(self.rehearsal.samples) if sample.true == start.true)
        return start, [index for index in questions if unhelped.get(index, 0) & there]

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
        answers = self._answers(_begun(circuit, sample))
        runs = {place: (*sample.run, *each.inputs) for place, each in answers.items() if isinstance(each, Reachable)}
        for place, run in shorten(circuit, runs).items():
            self._answer([*invariants][place], ShownCutOff(run[:-1]))
        for index in self.left.keys() & invariants.keys():
            self._begin_anywhere(index)

    def _begin_anywhere(self, index: int) -> None:
        """Ask a question of every state of its `since`, not of home states alone, and take samples again."""
        self.preconditions.begin_anywhere(index)
        self.rehearsal.drop(index)
        passed = self.beginnings.passed(self.runs, self.budget.samples // 2)
        self._take([self.beginnings.fresh_at(seed) for seed in passed])

    def _from(self, sample: Seed, wanted: Sequence[int]) -> Circuit:
        """Return the circuit that begins in a state, asked for the goals of some questions."""
        return _begun(replace(self.circuit, bad=tuple(self.hits[k] for k in wanted)), sample)

    def _learn(self, prefix: Inputs, sample: Seed, wanted: Sequence[int], runs: dict[int, Inputs]) -> None:
        """Keep words after a prefix, without the events that they do not need."""
        if runs:
            words = shorten(self._from(sample, wanted), runs, self.cone).values()
            self.rehearsal.learn([(*prefix, *word) for word in words])

    # ---- proofs ----

    def _unhelpful(self, index: int) -> StatesOfKind:
        """Return two literals over the state: a question needs a way, and none of its chosen words is one."""
        return self.preconditions.unhelped(index, self.rehearsal.chosen(index))

    @cached_property
    def _implicants(self) -> Implicants:
        following = [self.encoding.following[2 * node] for node, _ in self.graph.latches]
        return Implicants(self.graph, following, self.encoding.moments.domain, self.decide, self.budget.stop)

    def _parts(self) -> Iterator[dict[int, StatesOfKind]]:
        """Yield the questions that have a word from every known state, those with the fewest steps first.

        Each comes with where no word helps it. What they need of the graph is built as they are taken: answers do not
        wait for what those with more steps need.
        """
        steps = {index: sum(map(len, self.rehearsal.chosen(index))) for index in self.left}
        part: dict[int, StatesOfKind] = {}
        size = len(self.graph.fanins)
        for index in sorted(self.left, key=steps.__getitem__):
            if index in self.left and self.rehearsal.helps(index) and not self.budget.stop():
                part[index] = self._unhelpful(index)
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
            part = {k: self._unhelpful(k) for k in part if k in self.left and self.rehearsal.helps(k)}
        return True

    def _reach(self, part: Mapping[int, StatesOfKind]) -> bool:
        """Look for reachable states that no word helps; return whether that made progress."""
        before = self._tried(), len(self._implicants.excluded)
        excluded, found = self._implicants.exclude(part)
        for index in excluded:
            self._answer(index, NeverCutOff(tuple(self.rehearsal.chosen(index)), tuple(self._implicants.clauses)))
        ends = self.beginnings.reached([run[:-1] for run in found])
        if ends:
            self._take(ends)
            self._rehearse()
            self._wander(ends)
        return (self._tried(), len(self._implicants.excluded)) != before

    def _tried(self) -> dict[int, tuple[Literal, list[Inputs]]]:
        """Return, by question, where its ways begin and which words are known."""
        return {index: (self.preconditions.begins[index], self.rehearsal.chosen(index)) for index in self.left}


def _begun(circuit: Circuit, sample: Seed) -> Circuit:
    """Return a circuit that begins in a state."""
    latches = tuple(replace(latch, initial=latch.node in sample.true) for latch in circuit.latches)
    return replace(circuit, latches=latches)


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
