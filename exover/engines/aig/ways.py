"""Is there a way from everywhere? By ways that were found, and the states from which they lead to the goal.

A *word* is a concrete sequence of events. The states from which it leads to a goal, steps that cannot be taken being
left out, are a literal over the state: its weakest precondition (Dijkstra 1975), built by setting the inputs of copies
of the step to constants. A solver is asked for a reachable state that no word helps; a word is looked for from there,
and so on (counterexample-guided, after Clarke, Grumberg, Jha, Lu, Veith 2000). If a word is found from none, that there
is none is proved of the state. It is enough to look at home states where reports lead there from everywhere (`Home`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from exover.engines.aig.aims import Aims
from exover.engines.aig.answer import Answer, Clause, Inputs, Open, Reachable, Unreachable
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.exploration import Exploration, Seed, watched
from exover.engines.aig.graph import FALSE, TRUE, Circuit, Literal
from exover.engines.aig.home import Home
from exover.engines.aig.questions import CutOff
from exover.engines.aig.shorten import shorten
from exover.engines.aig.simulation import Evaluator, Word, at_lane, evaluator, side_by_side
from exover.engines.aig.solver import Solver
from exover.engines.aig.stimulus import Drawing
from exover.engines.aig.unfolding import Symbolic, Unfolding, copied
from exover.engines.aig.words import lit
from exover.model.property import Formula


@dataclass(frozen=True, slots=True)
class Excluded:
    """From every moment there is a way: where the invariant holds one of the words leads to the goal, after home."""

    words: tuple[Inputs, ...]
    invariant: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class Shown:
    """This run comes to a moment from which there is none."""

    inputs: Inputs


Verdict = Excluded | Shown | Open
Say = Callable[[int, Verdict], None]
"""Takes the index of a question, and the answer."""
Decide = Callable[[Circuit, Callable[[int, Answer], None], Callable[[], bool]], None]
"""A solver: says the answer to each bad literal of a circuit, by its index, until it is to stop."""


LANES = 512
"""So many runs look for words side by side."""


@dataclass(frozen=True, slots=True)
class Budget:
    """How much is tried.

    `readings`: states whose readings home states may have; `samples`: states that are looked at then, `tries`: those
    from which words are looked for, in `rounds` of runs each. `proofs`: how often the solver is asked for all;
    `counterexamples`: states of its answers that are looked into each time. `stop` ends it all.
    """

    readings: int = 12
    samples: int = 64
    tries: int = 10
    rounds: int = 4
    proofs: int = 5
    counterexamples: int = 3
    stop: Callable[[], bool] = lambda: False


@dataclass
class Ways:
    """Answers questions about one encoding."""

    encoding: Encoding
    questions: Sequence[CutOff]
    runs: Sequence[Inputs]
    decide: Decide
    say: Say
    budget: Budget

    def __post_init__(self) -> None:
        self.home = Home(self.encoding)
        _ = self.encoding.owed, self.encoding.domain  # they are to be in the graph before it is copied
        aims = Aims(self.encoding)
        self._reports = self.encoding.graph.any(
            self.encoding.graph.conjunction(self.encoding.legal, lit(event.chosen))
            for event in self.encoding.events
            if event.kind.verb == "report" or event.kind.verb.startswith("observe")
        )
        self.aims = [aims.of(question, self._calm) for question in self.questions]
        self.fresh = aims.fresh
        self.hits = tuple(aim.hit for aim in self.aims)
        self.circuit = self.encoding.circuit(self.hits)
        self.graph = copied(self.encoding.graph)
        self.cone = evaluator(self.circuit, [*self.hits, *(latch.next for latch in self.circuit.latches)])
        self.words: dict[Inputs, None] = {}
        self._chosen: dict[int, list[Inputs]] = {}
        self.left = dict.fromkeys(range(len(self.questions)))
        self.start = frozenset(latch.node for latch in self.circuit.latches if latch.initial)

    def _calm(self, allowed: Formula) -> bool:
        """Return whether a formula is true after every report and observation."""
        graph = self.encoding.graph
        wrong = graph.conjunction(self._reports, self.encoding.truth(allowed) ^ 1)
        if wrong == FALSE:
            return True
        solver = Solver(graph.circuit([FALSE] * len(graph.latches), ()))
        try:
            return not solver.satisfiable([solver.literal(wrong)])
        finally:
            solver.close()

    def judge(self) -> None:
        """Answer all questions."""
        kept = self._led([Seed(self.start, ())] * len(self.runs), self.runs) if self.runs else []
        homely = self._homely(kept)
        self.here = self.home.fixed
        self.begins = self._begins(homely)
        self._unfolding(homely)
        self._rehearse(self._samples(kept, homely)[: self.budget.samples])
        for _ in range(self.budget.proofs):
            if not self.left or self.budget.stop() or not self._reach(list(self.left)):
                break
        for index in list(self.left):
            self._answer(index, Open("bound reached: neither ways from everywhere nor a moment without one are known"))

    def _begins(self, homely: bool) -> list[Literal]:
        """Return, by question, in which states it is enough to have a way."""
        home = self.graph.all(2 * node + (not value) for node, value in self.here.items())
        return [home if homely and aim.homely else aim.since for aim in self.aims]

    def _answer(self, index: int, verdict: Verdict) -> None:
        del self.left[index]
        self.say(index, verdict)

    # ---- where ways begin ----

    def _homely(self, kept: Sequence[Seed]) -> bool:
        """Return whether reports lead from every reachable state to a home state, for readings that some state has."""
        best: tuple[Home, list[Literal]] | None = None
        for readings in (None, *(each.true for each in kept[1 :: max(1, len(kept) // self.budget.readings)])):
            home = Home(self.encoding, readings)
            failures = home.failures(self.graph, TRUE, most=len(best[1]) - 1 if best else 4)
            if failures is not None:
                self.home, best = home, (home, failures)
            if failures == []:
                return True
        if best is None:
            return False
        answers: list[Answer] = []
        following = [self.encoding.following[2 * node] for node, _ in self.graph.latches]
        self.decide(self.graph.circuit(following, best[1]), lambda _, a: answers.append(a), self.budget.stop)
        return all(isinstance(answer, Unreachable) for answer in answers)

    def _unfolding(self, homely: bool) -> None:
        """Return, by question, runs from all states in which its ways begin."""
        free: dict[int, Literal] = {latch.node: 2 * latch.node for latch in self.circuit.latches}
        free |= dict.fromkeys(self.fresh, TRUE)
        idle: Symbolic = free | {node: int(value) for node, value in self.home.fixed.items()}
        groups = []
        for homelike in (True, False):
            mine = [k for k, aim in enumerate(self.aims) if (homely and aim.homely) == homelike]
            first = idle if homelike else free
            groups.append((mine, Unfolding(self.graph, self.circuit, tuple(self.hits[k] for k in mine), first)))
        found: list[tuple[Unfolding, int]] = [(groups[0][1], 0)] * len(self.aims)
        for mine, unfolding in groups:
            for place, k in enumerate(mine):
                found[k] = unfolding, place
        self._places = [place for _, place in found]
        self._unfoldings = [unfolding for unfolding, _ in found]

    def _samples(self, kept: Sequence[Seed], homely: bool) -> list[Seed]:
        """Return reachable states in which ways are needed, each once."""
        found, seen = [], set()
        for each in self._led(kept, [self.home.run] * len(kept)) if homely else kept:
            if each.true not in seen:
                seen.add(each.true)
                found.append(each)
        return found

    def _led(self, seeds: Sequence[Seed], runs: Sequence[Inputs]) -> list[Seed]:
        """Return the states to which runs lead, one from each seed."""
        state = self._packed(seeds)
        for step in range(max(map(len, runs))):
            going, inputs = side_by_side(runs, step)
            values = self.cone.values({**state, **inputs})
            after = {n.node: self.cone.read(values, n.next, (1 << len(runs)) - 1) for n in self.circuit.latches}
            state = {node: word ^ ((word ^ after[node]) & going) for node, word in state.items()}
        pairs = enumerate(zip(seeds, runs, strict=True))
        return [Seed(at_lane(state, lane), (*seed.run, *run)) for lane, (seed, run) in pairs]

    def _packed(self, seeds: Sequence[Seed]) -> dict[int, Word]:
        words = {latch.node: 0 for latch in self.circuit.latches}
        for lane, seed in enumerate(seeds):
            for node in seed.true:
                words[node] |= 1 << lane
        return words

    # ---- words ----

    def _rehearse(self, samples: Sequence[Seed]) -> None:
        """Look for words from reachable states, those first from which most questions have none."""
        samples = [replace(each, true=each.true | self.fresh) for each in samples]
        tired: set[int] = set()
        for _ in range(self.budget.tries):
            unhelped = self._unhelped(samples)
            counts = {n: len(unhelped[n]) for n in range(len(samples)) if n not in tired and unhelped[n]}
            if not counts or self.budget.stop():
                break
            hardest = max(counts, key=lambda n: (counts[n], -n))
            tired.add(hardest)
            self._search(samples[hardest], unhelped[hardest])

    def _search(self, sample: Seed, wanted: Sequence[int]) -> list[int]:
        """Look for words from a state for questions, and return those for which none was found."""
        goals = [self.hits[k] for k in wanted]
        circuit = self._from(sample.true, goals)
        stimulus = Drawing(self.encoding, LANES).stimulus()
        exploration = Exploration(circuit, range(len(goals)), stimulus, watched(self.encoding), LANES, self.cone)
        self._learn(circuit, {goal: found.inputs for goal, found in exploration.run(self.budget.rounds).items()})
        return [wanted[goal] for goal in sorted(exploration.left)]

    def _settle(self, sample: Seed, wanted: Sequence[int]) -> None:
        """Ask the solver for words from a state, and where there are none take it as an answer."""
        circuit = self._from(sample.true, [self.hits[k] for k in wanted])
        answers: dict[int, Answer] = {}
        self.decide(circuit, answers.__setitem__, self.budget.stop)
        self._learn(circuit, {k: answer.inputs for k, answer in answers.items() if isinstance(answer, Reachable)})
        conditions, values = self._conditions, self._conditions.values(self._packed([sample]))
        for place, answer in sorted(answers.items()):
            index = wanted[place]
            if isinstance(answer, Unreachable) and conditions.read(values, self.aims[index].since, 1):
                self._answer(index, Shown(sample.run))

    def _from(self, true: frozenset[int], goals: Sequence[Literal]) -> Circuit:
        """Return the circuit that begins in a state."""
        latches = tuple(replace(latch, initial=latch.node in true) for latch in self.circuit.latches)
        return replace(self.circuit, latches=latches, bad=tuple(goals))

    def _learn(self, circuit: Circuit, runs: dict[int, Inputs]) -> None:
        """Keep words, without the events that they do not need."""
        if runs:
            for word in shorten(circuit, runs, self.cone).values():
                self.words.setdefault(word)

    def _unhelped(self, samples: Sequence[Seed]) -> list[list[int]]:
        """Return, by sample, the open questions whose ways begin there, and to whose goal no word leads from there.

        All words run from all samples side by side.
        """
        words, width = list(self.words), len(samples)
        packed, block = self._packed(samples), (1 << width) - 1
        values = self._conditions.values(packed)
        beginning = {k: self._conditions.read(values, self.begins[k], block) for k in self.left}
        wanted = [[k for k, word in beginning.items() if word >> number & 1] for number in range(width)]
        if not words:
            return wanted
        every = sum(block << width * place for place in range(len(words)))
        state = {node: sum(word << width * place for place in range(len(words))) for node, word in packed.items()}
        helped = dict.fromkeys(self.left, 0)
        for step in range(max(map(len, words))):
            true: dict[int, Word] = {}
            for place, word in enumerate(words):
                for node in word[step] if step < len(word) else ():
                    true[node] = true.get(node, 0) | block << width * place
            running = sum(block << width * place for place, word in enumerate(words) if step < len(word))
            values = self.cone.values({**state, **true})
            for k in helped:
                helped[k] |= self.cone.read(values, self.hits[k], every) & running
            state = {n.node: self.cone.read(values, n.next, every) for n in self.circuit.latches}
        for k, found in helped.items():
            for number in range(width):
                if k in wanted[number]:
                    leading = [word for place, word in enumerate(words) if found >> width * place + number & 1]
                    if leading:
                        wanted[number].remove(k)
                        self._choose(k, leading)
        return wanted

    @cached_property
    def _conditions(self) -> Evaluator:
        """Evaluates where ways begin."""
        literals = [*self.begins, *(aim.since for aim in self.aims)]
        return evaluator(self.graph.circuit([FALSE] * len(self.graph.latches), ()), literals)

    # ---- proofs ----

    def _choose(self, index: int, leading: Sequence[Inputs]) -> None:
        """Take the shortest of the words that lead from a state to the goal of a question, unless one is taken."""
        chosen = self._chosen.setdefault(index, [])
        if not any(word in chosen for word in leading):
            chosen.append(min(leading, key=lambda word: (len(word), *map(sorted, word))))

    def _unhelpful(self, index: int) -> Literal:
        """Return where a way must begin, and no word is one."""
        unfolding, place = self._unfoldings[index], self._places[index]
        helped = self.graph.any(unfolding.seen(word)[place] for word in self._chosen.get(index, ()))
        lost = self.graph.conjunction(self.begins[index], self.aims[index].lost)
        return self.graph.any((self.graph.conjunction(self.begins[index], helped ^ 1), lost))

    def _reach(self, asked: Sequence[int]) -> bool:
        """Ask the solver for reachable states that no word helps; return whether anything new was learnt."""
        before = len(self.left), len(self.words)
        following = [self.encoding.following[2 * node] for node, _ in self.graph.latches]
        circuit = self.graph.circuit(following, [self._unhelpful(index) for index in asked])
        answers: dict[int, Answer] = {}
        self.decide(circuit, answers.__setitem__, self.budget.stop)
        ends: dict[frozenset[int], Seed] = {}
        for place, answer in sorted(answers.items()):
            match answer:
                case Unreachable(invariant):
                    self._answer(asked[place], Excluded(tuple(self._chosen.get(asked[place], ())), invariant))
                case Reachable(inputs):
                    (end,) = self._led([Seed(self.start, ())], [inputs[:-1]])
                    ends.setdefault(end.true, replace(end, true=end.true | self.fresh))
                case Open():
                    pass
        for sample in list(ends.values())[: self.budget.counterexamples]:
            wanted = self._unhelped([sample])[0]
            rest = self._search(sample, wanted) if wanted else []
            if rest and not self.budget.stop():
                self._settle(sample, rest)
        if ends:
            self._unhelped([replace(each, true=each.true | self.fresh) for each in ends.values()])
        return (len(self.left), len(self.words)) != before


def judge_ways(
    encoding: Encoding,
    questions: Sequence[CutOff],
    runs: Sequence[Inputs],
    decide: Decide,
    say: Say,
    budget: Budget | None = None,
) -> None:
    """Say the answer to each question, as soon as it is found: `Excluded` iff it is answered with no.

    `runs`: some that come to states of many kinds. Where there are assumptions, answers are about runs that can go on
    for ever only if all can (`coherence.goes_on`).
    """
    Ways(encoding, questions, runs, decide, say, budget or Budget()).judge()
