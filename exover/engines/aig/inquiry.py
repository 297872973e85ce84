"""Claims about one closed loop while they are looked into, as questions to one graph.

Runs are looked for first, side by side and guided by coverage; what none of them shows is put to a model checker, all
of it together. That the passes of the graph are enough is a question like the others: nothing is said to be proved
before that is. Runs are followed on the reference interpreter before they count.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from copy import copy, deepcopy
from dataclasses import field, replace
from functools import cached_property, partial
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.aig import liveness, ways
from exover.engines.aig.answer import Answer, Inductive, Inputs, Open, Reachable, SayAnswer, Settled, Unreachable
from exover.engines.aig.concretize import Concretizer
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.evidence import INDUCTION, PROVED, WAYS, WITNESS, Answered, Evidence, Found, shown
from exover.engines.aig.exploration import LANES, ROUNDS, Exploration, Seed, watched
from exover.engines.aig.graph import FALSE, Circuit
from exover.engines.aig.machine_closure import is_machine_closed
from exover.engines.aig.portfolio import LONG, SHORT, Portfolio
from exover.engines.aig.questions import (
    CutOff,
    LassoQuestion,
    Leaf,
    Questions,
    Reach,
    RunQuestion,
    questions_in,
)
from exover.engines.aig.reached_bmc import RunSearch, runs_from
from exover.engines.aig.redundancy import changes
from exover.engines.aig.shorten import shorten
from exover.engines.aig.stimulus import RandomStimulus
from exover.engines.beside import Beside, SideTask, step_back_if_apart
from exover.loop.claim import Claim, SayOpinion

OPENING = 1, 2, 4, 8, ROUNDS
"""Rounds of random runs, after each of which is said what they show: what is easy to see is said at once."""
EARLY = 2
"""After so many of them lassos are looked for that are errors."""
FURTHER = 10
"""Rounds of random runs from where a solver has found a way to."""
RUNS = 256
"""So many of the runs that showed something new are taken to be about all kinds of states."""
FAIR = "fair reports end every wait"
URGENT = ("safety", "completeness", "obligation", "property")
"""Checks whose questions about moments are asked before those of others."""


class _MorePasses(Exception):
    """Some run needs more passes than the graph has."""


@dataclass
class Inquiry:
    """Claims while they are looked into."""

    encoding: Encoding
    claims: Sequence[Claim]
    say: SayOpinion
    abc: str
    budget: int
    beside: list[Callable[[], object]] = field(default_factory=list)
    """Called between questions to model checkers: they take what is found meanwhile by others."""
    _said: set[int] = field(default_factory=set)
    _going_on: dict[bool, bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.evidence = Evidence(self._goes_on)
        asked = Questions(self.encoding)
        self.questions: list[RunQuestion] = [self._question(asked, claim) for claim in self.claims]
        self.leaves = dict.fromkeys(leaf for question in self.questions for leaf in questions_in(question))
        self.concretizer = Concretizer(self.encoding)
        self.portfolio = Portfolio(self.abc, self.encoding)
        self.runs: list[Inputs] = []
        self.seeds: list[Seed] = []
        """States to which these runs lead, the start first."""
        self._later: list[int] = []
        """What is not proved soon, which is looked into at last, lest it keep others from a first answer."""
        self._near: list[int] = []
        """What of it is first looked for near states that runs came to."""

    def _question(self, asked: Questions, claim: Claim) -> RunQuestion:
        if claim.check == "redundancy":
            return Reach(changes(self.encoding, claim.subject))
        return asked.of_claim(claim)

    @cached_property
    def circuit(self) -> Circuit:
        """The graph with all that is asked of runs to a moment; first, whether the passes are not enough."""
        literals = {leaf.bad for leaf in self.leaves if isinstance(leaf, Reach)}
        return self.encoding.circuit([*self.encoding.unsettled_parts, *sorted(literals - {FALSE})])

    @cached_property
    def _passes(self) -> range:
        """Which questions are about the passes."""
        return range(len(self.encoding.unsettled_parts))

    @cached_property
    def _urgent(self) -> frozenset[Leaf]:
        """What errors depend on."""
        asked = zip(self.questions, self.claims, strict=True)
        return frozenset(leaf for each, claim in asked if claim.check in URGENT for leaf in questions_in(each))

    # ---- the work ----

    def explore(self, known: "Inquiry | None" = None, cover: bool = True) -> bool:
        """Look for runs, say what they show, and return whether none needs more passes.

        Where a loop is `known` already, its runs are followed, and gone on with: while that shows anything new, or, to
        `cover`, new states. If some run needs more passes, such runs are all that is kept: others are near them.
        """
        self._tell()  # what is known of the start
        exploration = self._exploration(watched(self.encoding) if cover else ())
        if known is not None:
            self._follow(exploration, known)
        for rounds in OPENING:
            seen = exploration.run(rounds)
            self._seen(seen)
            self.runs = [seen[part].inputs for part in self._passes if part in seen]
            if self.runs:
                return False
            self._keep(exploration)
            if rounds == EARLY:
                self.wander(urgent=True)
        return True

    def _keep(self, exploration: Exploration) -> None:
        """Take runs to all kinds of states that were seen."""
        self.seeds = exploration.corpus(RUNS)
        self.runs = [seed.run for seed in self.seeds]

    def follow(self, known: "Inquiry") -> None:
        """Take what is known of the same loop, whose states have the same numbers, and say what its runs show."""
        self.evidence.settled = known.evidence.settled
        self.portfolio = replace(self.portfolio, lemmas=known.portfolio.lemmas)
        exploration = self._exploration(())
        self._follow(exploration, known)
        self.seeds = exploration.seeds

    def _exploration(self, coverage: Sequence[int], asked: Sequence[int] | None = None) -> Exploration:
        """Return what looks for runs to what is asked, by index; to all bad literals if that is not said."""
        stimulus = RandomStimulus(self.encoding, LANES).stimulus()
        return Exploration(self.circuit, range(len(self.circuit.bad)) if asked is None else asked, stimulus, coverage)

    def _follow(self, exploration: Exploration, known: "Inquiry") -> None:
        """Take the runs that are known, and what they show; what monitors guessed in them is of no use here."""
        inputs = dict(zip(known.encoding.given, self.encoding.given, strict=True))
        self.runs = [
            tuple(frozenset(inputs[node] for node in step if node in inputs) for step in run) for run in known.runs
        ]
        self._seen(exploration.follow(self.runs))

    @property
    def left(self) -> list[int]:
        """The claims, by place, of which nothing has been said yet."""
        return [number for number in range(len(self.claims)) if number not in self._said]

    def _seen(self, answers: Mapping[int, Reachable]) -> None:
        """Take what runs show, and say it, errors first."""
        runs = {index: answer.inputs for index, answer in answers.items() if index not in self._passes}
        errors = {index: run for index, run in runs.items() if self._is_urgent(index)}
        for part in (errors, {index: run for index, run in runs.items() if index not in errors}):
            if part:
                self._reached(part)
                self._tell()

    def settle(self, insist: bool = True) -> bool:
        """Ask whether the passes are enough, and return whether no run is known to need more.

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
                return False
            found = runs_from(self.circuit, left, self.seeds)
            if found:
                self.runs = list(found.values())
                return False
            self.portfolio.put(self.circuit, left, answered, LONG, self.budget)
        except _MorePasses:
            return False
        self.evidence.settled = all(isinstance(answers.get(n), Unreachable | Inductive) for n in self._passes)
        self._take_answers({n: answer for n, answer in answers.items() if n not in self._passes})
        self._tell()
        return True

    def prove(self, unroll: bool = True) -> None:
        """Ask what no run has shown and what can be proved soon; the rest is left for the end.

        What errors depend on was asked with the passes. `unroll`: whether known runs are gone on with, to errors
        now and to others at the end, and what proofs find out is of use later.
        """
        self._overhear()
        left = self._open()
        urgent = [n for n in left if self._is_urgent(n)]
        self._later += self._go_on(urgent) if unroll else urgent
        answers: dict[int, Settled] = {}
        others = [n for n in left if n not in urgent]
        others = self.portfolio.settle_soon(self.circuit, others, answers.__setitem__, self.budget, learn=unroll)
        self._take_answers(answers)
        self._tell()
        (self._near if unroll else self._later).extend(others)

    def _open(self) -> list[int]:
        """Return what is asked of moments, by index, and not answered yet."""
        return [number for number in range(len(self.circuit.bad)) if self._is_open(number)]

    def _is_open(self, number: int) -> bool:
        return number not in self._passes and Reach(self.circuit.bad[number]) not in self.evidence.found

    def _is_urgent(self, number: int) -> bool:
        """Return whether an error depends on what is asked."""
        return Reach(self.circuit.bad[number]) in self._urgent

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
                self._tell()
                runs = list(found.values())
                exploration = exploration or self._exploration(watched(self.encoding), left)
                exploration.follow(runs)
                self._seen(exploration.run(FURTHER))
                self.runs += runs
                further = exploration.corpus(RUNS)
                search.add(further)
                self.seeds += further
                left = [n for n in left if self._is_open(n)]
        return left

    def finish(self, spare: bool = False) -> None:
        """Put what is left to model checkers, and say what comes of it; with a `spare` processor, in other processes.

        Infinite runs, ways, and moments each begin with what is known now, so that the answers do not depend on that.
        """
        cut_off = [leaf for leaf in self.leaves if isinstance(leaf, CutOff)]
        apart = spare and bool(cut_off), spare and bool(self._near or self._later)
        with (
            Beside(self._look_for_ways(cut_off), apart[0]) as found,
            Beside(self._moments_at_length(), apart[1]) as at_length,
        ):
            others = found, at_length
            self.beside += [partial(each.overhear, self._heard) for each in others]
            self._look_for_lassos()
            for each in others:
                each.hear(self._heard)
        self._waits_end()
        self._tell(final=True)

    def _heard(self, answer: Answered) -> None:
        self.evidence.found[answer[0]] = answer[1]
        self._tell()

    def _overhear(self) -> None:
        """Take what those have found by now who work beside us."""
        for take in self.beside:
            take()

    def _moments_at_length(self) -> SideTask[Answered]:
        """Return what tells what comes of questions about moments that are not proved soon.

        Known runs are gone on with, then model checkers are asked at length.
        """
        rest = copy(self)
        rest.evidence = replace(self.evidence, found=dict(self.evidence.found))
        rest.portfolio = replace(self.portfolio, lemmas=self.portfolio.lemmas.copy())
        rest.runs, rest.seeds, rest.beside, rest._said = list(self.runs), list(self.seeds), [], set(self._said)

        def look(tell: Callable[[Answered], None]) -> None:
            step_back_if_apart()
            told = set(rest.evidence.found)

            def pass_on(*_: object) -> None:
                for leaf, found in rest.evidence.found.items():
                    if leaf not in told:
                        told.add(leaf)
                        tell((leaf, found))

            def answered(index: int, answer: Answer) -> None:
                rest._take_answers({index: answer})
                pass_on()

            rest.say = pass_on
            later = [*self._later, *rest._go_on(self._near)]
            pass_on()
            rest.portfolio.put(self.circuit, later, answered, LONG, self.budget)

        return look

    def _take_answers(self, answers: Mapping[int, Settled]) -> None:
        self._reached({n: answer.inputs for n, answer in answers.items() if isinstance(answer, Reachable)})
        for index, answer in answers.items():
            match answer:
                case Unreachable():
                    self.evidence.found[Reach(self.circuit.bad[index])] = Found(False, PROVED)
                case Inductive():
                    self.evidence.found[Reach(self.circuit.bad[index])] = Found(False, INDUCTION)
                case Open(reason):
                    self.evidence.found[Reach(self.circuit.bad[index])] = Found(None, reason=reason)
                case Reachable():
                    pass

    def _reached(self, runs: Mapping[int, Inputs]) -> None:
        """Take runs that make bad literals true; those with no doubles in them show nothing."""
        short = shorten(self.circuit, runs) if runs else {}
        concrete = self.concretizer.traces(list(short.values()))
        for index, trace in zip(short, concrete, strict=True):
            self.evidence.found[Reach(self.circuit.bad[index])] = shown(trace)

    def _waits_end(self) -> None:
        """Take from requests that never starve that there is a way out of every wait of theirs.

        Some run goes on fairly without an abort or a further ask of the request, and on it the wait ends. Where a
        required launch may take the place at once, a wait that ends need not leave the place empty.
        """
        model = self.encoding.compiled.model
        if self.encoding.properties.assumptions or len(model.requests) == 1:
            return
        required = {launch.request for launch in model.launches}
        ending = set[str]()
        for claim, question in zip(self.claims, self.questions, strict=True):
            if claim.check == "starvation" and self.evidence.answer(question, claim.fair).truth and not claim.coherent:
                ending.add(claim.subject)
        for claim, question in zip(self.claims, self.questions, strict=True):
            if claim.check == "deadlock" and claim.subject in ending - required:
                for leaf in questions_in(question):
                    if self.evidence.found.get(leaf, Found(None)).truth is None:
                        self.evidence.found[leaf] = Found(False, FAIR)

    def _look_for_ways(self, asked: Sequence[CutOff]) -> SideTask[Answered]:
        """Return what tells what comes of questions about ways."""
        # ways and lassos add what they look at to their graph, and learn of it
        encoding = deepcopy(self.encoding) if asked else self.encoding
        portfolio = Portfolio(self.abc, encoding, self.portfolio.lemmas.copy())
        runs = list(self.runs)

        def solve(circuit: Circuit, say: SayAnswer, _: Callable[[], bool]) -> None:
            portfolio.put(circuit, range(len(circuit.bad)), say, SHORT, self.budget)

        def look(tell: Callable[[Answered], None]) -> None:
            def said(index: int, answer: ways.WayAnswer) -> None:
                match answer:
                    case ways.NeverCutOff():
                        found = Found(False, WAYS)
                    case ways.ShownCutOff(inputs):
                        (trace,) = self.concretizer.traces([inputs])
                        found = shown(trace)
                    case Open(reason):
                        found = Found(None, reason=reason)
                    case _:
                        assert_never(answer)
                tell((asked[index], found))

            if asked:
                ways.judge_ways(encoding, asked, runs, solve, said, unroll=portfolio.unroll)

        return look

    @cached_property
    def _infinite(self) -> tuple[LassoQuestion, ...]:
        """The questions about infinite runs."""
        return tuple(leaf for leaf in self.leaves if isinstance(leaf, LassoQuestion))

    @cached_property
    def _lassos(self) -> liveness.Judging:
        """What answers them."""
        asked = self._infinite

        def said(index: int, answer: liveness.LassoAnswer) -> None:
            match answer:
                case liveness.NoLasso(method):
                    self.evidence.found[asked[index]] = Found(False, method)
                case liveness.ShownLasso(trace):
                    self.evidence.found[asked[index]] = Found(True, WITNESS, trace)
                case Open(reason):
                    self.evidence.found[asked[index]] = Found(None, reason=reason)
            self._tell()

        def solve(circuit: Circuit, say: SayAnswer, *, budget: int) -> None:
            self._overhear()
            part = budget / liveness.WORK
            self.portfolio.put(circuit, range(len(circuit.bad)), say, SHORT * part, int(self.budget * part))

        return liveness.Judging(self.encoding, asked, solve, said)

    def wander(self, urgent: bool = False) -> None:
        """Look for infinite runs at random, and say what they show, before anything is proved; `urgent`: for errors."""
        asked = [index for index, leaf in enumerate(self._infinite) if not urgent or leaf in self._urgent]
        if asked:
            self._lassos.wander(self.runs, asked)

    def _look_for_lassos(self) -> None:
        if self._infinite:
            self._lassos.run(self.runs)

    def _goes_on(self, fair: bool) -> bool:
        """Return whether it is proved that the assumptions let every run go on for ever, if `fair` fairly."""
        if not self.encoding.properties.assumptions:
            return True
        if not self.evidence.settled:
            return False
        if fair not in self._going_on:
            self._going_on[fair] = is_machine_closed(self.encoding, fair, self._excluded)
        return self._going_on[fair]

    def _excluded(self, circuit: Circuit) -> bool:
        answers: list[Answer] = []
        whole = range(len(circuit.bad))
        self.portfolio.put(circuit, whole, lambda _, answer: answers.append(answer), SHORT, self.budget)
        return all(isinstance(answer, Unreachable) for answer in answers)

    def _tell(self, final: bool = False) -> None:
        """Say of each claim what is known of it by now, and which are given up: all, if this is `final`."""
        for number, question in enumerate(self.questions):
            if number not in self._said:
                opinion = self.evidence.opinion(question, self.claims[number])
                if final or opinion.verdict != "unknown" or self.evidence.is_complete(question):
                    self._said.add(number)
                    self.say(number, opinion)
