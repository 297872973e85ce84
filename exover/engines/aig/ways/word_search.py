"""The search for words: from samples, the states in which ways begin, that no known word helps.

Known words are simulated from every sample; where none helps, random runs look for another, and pairs of known words.
Random runs that go on from a sample without a word often come to others.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import field, replace
from functools import cached_property, reduce
from operator import or_

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs, StopRequested, never
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.encoding.coverage_goals import coverage_goals
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.induction.implicants import StatesOfKind
from exover.engines.aig.simulation.evaluation import Evaluator
from exover.engines.aig.simulation.exploration import Exploration, Seed, thinned
from exover.engines.aig.simulation.lanes import numbers
from exover.engines.aig.simulation.runs import Stimulus
from exover.engines.aig.simulation.shorten import shorten
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.engines.aig.ways.beginnings import Beginnings
from exover.engines.aig.ways.preconditions import Preconditions
from exover.engines.aig.ways.word_simulation import WordSimulation

Look = Callable[[Seed, Sequence[int]], dict[int, Inputs]]
"""Returns words from a state, by place of a question among those that need one."""
LANES = 512
"""How many random runs look for words side by side."""
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
class WordSearch:
    """Looks for words that lead to the goals of questions, the bad literals of the circuit.

    `cone` evaluates these and the latches; `left`: the questions that are open; `prefix`: the run with which words
    begin that help in many more states.
    """

    encoding: Encoding
    circuit: Circuit
    cone: Evaluator
    left: Collection[int]
    beginnings: Beginnings
    preconditions: Preconditions
    prefix: Inputs
    budget: WaysBudget
    hard: set[int] = field(default_factory=set)
    """Questions for which random runs from some sample found no word; model checkers are asked next."""
    tired: set[tuple[int, int]] = field(default_factory=set)
    """Pairs of a sample, by number, and a question for which model checkers have looked for a word from there."""

    def __post_init__(self) -> None:
        self.rehearsal = WordSimulation(self.circuit, self.cone)

    def take(self, samples: Sequence[Seed]) -> list[Seed]:
        """Simulate known words from more samples; return those from which a question that is not hard has none."""
        if not samples:
            return []
        first = len(self.rehearsal.samples)
        self.rehearsal.add(samples, self.preconditions.needed(samples, self.left))
        unhelped = self.rehearsal.unhelped().items()
        missed = reduce(or_, (where for k, where in unhelped if k not in self.hard), 0) >> first
        return [sample for number, sample in enumerate(samples) if missed >> number & 1]

    def begin_anywhere(self, question: int, runs: Sequence[Inputs]) -> None:
        """Ask a question of every state of its `since`, not of home states alone, and take samples again."""
        self.preconditions.begin_anywhere(question)
        self.rehearsal.drop(question)
        passed = self.beginnings.passed(runs, self.budget.samples // 2)
        self.take([self.beginnings.fresh_at(seed) for seed in passed])

    def open_at_start(self, questions: Iterable[int]) -> tuple[Seed, list[int]]:
        """Return the start, and the questions that need a way there and have no word."""
        start, unhelped = self.beginnings.fresh_at(self.beginnings.start), self.rehearsal.unhelped()
        there = sum(1 << n for n, sample in enumerate(self.rehearsal.samples) if sample.true == start.true)
        return start, [question for question in questions if unhelped.get(question, 0) & there]

    def unhelped(self, question: int) -> StatesOfKind:
        """Return two literals over the state: a question needs a way, and none of its chosen words is one."""
        return self.preconditions.unhelped(question, self.rehearsal.chosen(question))

    def tried(self) -> dict[int, tuple[Literal, list[Inputs]]]:
        """Return, by question, where its ways begin and which words are known."""
        return {k: (self.preconditions.begins[k], self.rehearsal.chosen(k)) for k in self.left}

    def wander(self, begun: Sequence[Seed]) -> None:
        """Look for states without a word where random runs lead from these states, and for words from there.

        It goes on, from what is found first, as long as something is and there are not too many samples.
        """
        around, vain, most = list(thinned(begun, BEGUN)), 0, self.budget.samples
        while vain < VAIN and self.left and len(self.rehearsal.samples) < most and not self.budget.stop():
            known = {sample.true for sample in self.rehearsal.samples}
            missed = self.take([each for each in self.beginnings.near(around) if each.true not in known])
            vain = 0 if missed else vain + 1
            around = [*missed, *around][:BEGUN]
            self.rehearse()

    def rehearse(self) -> None:
        """Look for words from samples without one, by pairs of known words and random runs; else a question is hard."""
        for _ in range(self.budget.tries):
            number, wanted = self._hardest(lambda _, question: question not in self.hard)
            if not wanted or self.budget.stop():
                break
            self.hard.update(self._look(number, wanted, (self.rehearsal.composed, self._search)))

    def settle_hard(self, look: Look) -> None:
        """Look for words where random runs show none, once from each sample for each question."""
        for _ in range(self.budget.tries):
            number, wanted = self._hardest(lambda *pair: pair not in self.tired)
            if not wanted or self.budget.stop():
                break
            self._look(number, wanted, (look,))
            self.tired.update((number, question) for question in wanted)
            self.hard.difference_update(wanted)
            self.rehearse()

    def _look(self, number: int, wanted: Sequence[int], looks: Sequence[Look]) -> list[int]:
        """Look for words from a sample, and return the questions of which none is found.

        Words that begin with the prefix are tried first.
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
        circuit = self.circuit_from(sample, wanted)
        exploration = Exploration(
            circuit, range(len(wanted)), self._events, coverage_goals(self.encoding.latches), LANES, self.cone
        )
        return {place: found.inputs for place, found in exploration.run(self.budget.rounds).items()}

    def circuit_from(self, sample: Seed, wanted: Sequence[int]) -> Circuit:
        """Return the circuit that begins in a state, asked for the goals of some questions."""
        return beginning_in(replace(self.circuit, bad=tuple(self.circuit.bad[k] for k in wanted)), sample)

    def _learn(self, prefix: Inputs, sample: Seed, wanted: Sequence[int], runs: dict[int, Inputs]) -> None:
        """Keep words after a prefix, without the events that they do not need."""
        if runs:
            words = shorten(self.circuit_from(sample, wanted), runs, self.cone).values()
            self.rehearsal.learn([(*prefix, *word) for word in words])


def beginning_in(circuit: Circuit, sample: Seed) -> Circuit:
    """Return a circuit that begins in a state."""
    latches = tuple(replace(latch, initial=latch.node in sample.true) for latch in circuit.latches)
    return replace(circuit, latches=latches)
