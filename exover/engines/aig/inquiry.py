"""Answers claims about one closed loop as questions to one graph.

Bad states come first (`BadStates`), then infinite runs, ways to goals, and the bad states that are left, side by side.
That the passes of the graph are enough is a question like the others: nothing is said to be proved before that is. Runs
are followed on the reference interpreter before they count.
"""

from collections.abc import Callable, Container, Iterable, Sequence
from copy import copy, deepcopy
from dataclasses import field, replace
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.aig.bad_states import BadStates
from exover.engines.aig.circuit.answer import Inputs, Open, Reachable, SayAnswer, Settled, StopRequested
from exover.engines.aig.circuit.graph import FALSE, Circuit
from exover.engines.aig.encoding.encoder import Encoding
from exover.engines.aig.encoding.questions import (
    CutOff,
    LassoQuestion,
    Leaf,
    Questions,
    Reach,
    RunQuestion,
    questions_in,
)
from exover.engines.aig.evidence import STRANDED, WAYS, WITNESS, Answered, Evidence, Found, shown
from exover.engines.aig.liveness import judging
from exover.engines.aig.liveness.machine_closure import can_go_on, stranded, unreported
from exover.engines.aig.portfolio import SHORT, Portfolio
from exover.engines.aig.redundancy import changes
from exover.engines.aig.ways import always_possible
from exover.engines.beside import Beside, Heard, SideTask, hear_all
from exover.loop.claim import Claim, SayOpinion
from exover.loop.formula_classes import Stuck, question_of
from exover.model.expression import Status
from exover.model.property import TRUE, Atom, Formula, Negation, finally_, some_finally
from exover.model.run_moments import is_true
from exover.model.semantics import Reference
from exover.model.trace import Trace, visited

FAIR = "fair reports end every wait"
URGENT = ("safety", "completeness", "obligation", "property")
"""Checks whose questions about bad states are asked before those of others."""


@dataclass
class Inquiry:
    """The claims about one encoding, their questions, and the evidence so far."""

    encoding: Encoding
    claims: Sequence[Claim]
    say: SayOpinion
    abc: str
    budget: int
    _said: set[int] = field(default_factory=set)
    _fair_run: bool | None = None
    """Whether a fair run is known; None before one was looked for."""
    _stops: list[Inputs] = field(default_factory=list)
    """Runs to states from which the assumptions may allow no step."""

    def __post_init__(self) -> None:
        self.evidence = Evidence(self._goes_on, self._some_run_is_fair)
        self._asked = Questions(self.encoding)
        self.questions: list[RunQuestion] = [self._question(self._asked, claim) for claim in self.claims]
        self.leaves: dict[Leaf, list[int]] = {}
        """The elementary questions, each with the claims that it is a part of, by place."""
        for number, question in enumerate(self.questions):
            for leaf in questions_in(question):
                self.leaves.setdefault(leaf, []).append(number)
        bad = {leaf.bad for leaf in self.leaves if isinstance(leaf, Reach)} - {FALSE}
        self.bad_states = BadStates(
            self.encoding,
            sorted(bad),
            bad & {leaf.bad for leaf in self._urgent if isinstance(leaf, Reach)},
            Portfolio(self.abc, self.encoding),
            self.budget,
            self._heard,
        )

    def _question(self, asked: Questions, claim: Claim) -> RunQuestion:
        if claim.check == "redundancy":
            return Reach(changes(self.encoding, claim.subject))
        return asked.of_claim(claim)

    @cached_property
    def _urgent(self) -> frozenset[Leaf]:
        """The elementary questions on which errors depend."""
        asked = zip(self.questions, self.claims, strict=True)
        return frozenset(leaf for each, claim in asked if claim.check in URGENT for leaf in questions_in(each))

    # ---- the work ----

    def explore(self, known: "Inquiry | None" = None, cover: bool = True) -> bool:
        """Look for runs, say what they show, and return whether none needs more passes.

        `known`: the same loop in another graph, whose runs are continued; `cover`: whether new states count as new.
        """
        self._tell()  # what is known of the start
        before = None if known is None else known.bad_states
        return self.bad_states.explore(before, cover, lambda: self.wander(urgent=True))

    def follow(self, known: "Inquiry") -> None:
        """Take over what is known of the same loop in a graph with the same latches, and say what its runs show."""
        self.evidence.settled = known.evidence.settled
        self.bad_states.follow(known.bad_states)
        self._tell()

    def settle(self, insist: bool = True) -> bool:
        """Ask whether the passes are enough; return False if a run needs more, else True.

        Without `insist`, False also if it is not soon proved that none does.
        """
        settled = self.bad_states.settle(insist)
        if settled is None:
            return False
        self.evidence.settled = settled
        self._tell()
        return True

    def prove(self, unroll: bool = True) -> None:
        """Answer the questions left that are soon proved; `unroll`: a solver continues known runs first."""
        self.bad_states.prove(unroll)

    @property
    def left(self) -> list[int]:
        """The claims, by place, of which nothing has been said yet."""
        return [number for number in range(len(self.claims)) if number not in self._said]

    def finish(self, spare: bool = False, others: Sequence[Heard] = ()) -> None:
        """Answer what is left by model checkers, and say all opinions; with a `spare` processor, in other processes.

        The searches for lassos, ways and bad states each start from what is known now, so that answers are the same in
        any case. `others`: side tasks that run already, whose messages are heard meanwhile.
        """
        cut_off = self._about_ways()
        with (
            Beside(self._look_for_ways(cut_off), spare and bool(cut_off)) as found,
            Beside(self.bad_states.at_length(), spare and self.bad_states.unproved) as at_length,
            Beside(self._look_for_lassos(), spare and bool(self._infinite)) as lassos,
        ):
            # where one process does all: ways first, which take less time, and of each request an error depends on one
            hear_all([(each, self._heard) for each in (found, lassos, at_length)], others)
        self._waits_end()
        self._ask_of_fair_runs()
        self._tell(final=True)

    def _about_ways(self) -> list[CutOff]:
        """Return the questions about ways, with those on which it depends whether answers count for fair runs."""
        asked = [leaf for leaf in self.leaves if isinstance(leaf, CutOff)]
        fair = (self.questions[number] for number in self.left if self.claims[number].fair)
        of_fair = any(leaf in asked for question in fair for leaf in questions_in(question))
        if of_fair and self._goes_on(False) and not self._goes_on(True):
            asked += [ending for ending in self._endings if ending not in asked]
        return asked

    def _heard(self, answers: Sequence[Answered]) -> None:
        """Take answers to elementary questions, and say the opinions that follow.

        Of claims that these are no part of nothing new follows, unless the answers say whether runs can go on.
        """
        self.evidence.found.update(answers)
        changed = {leaf for leaf, _ in answers}
        if changed <= self.leaves.keys():
            self._tell(sorted({number for leaf in changed for number in self.leaves[leaf]}))
        else:
            self._tell()

    def _waits_end(self) -> None:
        """Conclude that a request which never starves has no deadlock: every wait of it has a way out.

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

    def _look_for_ways(self, asked: Sequence[CutOff]) -> SideTask[Sequence[Answered]]:
        """Return the side task that answers the questions about ways."""
        # ways and lassos add monitors to their graph, and lemmas about it
        encoding = deepcopy(self.encoding) if asked else self.encoding
        portfolio = self.bad_states.portfolio.copy(encoding)
        runs = list(self.bad_states.runs)

        def solve(circuit: Circuit, say: SayAnswer, stop: StopRequested) -> None:
            portfolio.put(circuit, range(len(circuit.bad)), say, SHORT, self.budget, stop)

        def look(tell: Callable[[Sequence[Answered]], None]) -> None:
            def said(index: int, answer: always_possible.WayAnswer) -> None:
                match answer:
                    case always_possible.NeverCutOff():
                        found = Found(False, WAYS)
                    case always_possible.ShownCutOff(inputs):
                        (trace,) = self.bad_states.concretizer.traces([inputs])
                        found = shown(trace)
                    case Open(reason):
                        found = Found(None, reason=reason)
                    case _:
                        assert_never(answer)
                tell([(asked[index], found)])

            if asked:
                always_possible.judge_ways(encoding, asked, runs, solve, said, unroll=portfolio.unroll)

        return look

    @cached_property
    def _infinite(self) -> tuple[LassoQuestion, ...]:
        """The questions about infinite runs."""
        return tuple(leaf for leaf in self.leaves if isinstance(leaf, LassoQuestion))

    @cached_property
    def _lassos(self) -> judging.Judging:
        """Judges them: by random runs at any time, by proofs at last."""
        return judging.Judging(
            self.encoding, self._infinite, self._asking_for_lassos(self.bad_states.portfolio), self._saying(self._heard)
        )

    def _asking_for_lassos(self, portfolio: Portfolio) -> judging.BudgetedDecide:
        def decide(circuit: Circuit, say: SayAnswer, *, budget: int) -> None:
            part = budget / judging.WORK
            portfolio.put(circuit, range(len(circuit.bad)), say, SHORT * part, int(self.budget * part))

        return decide

    def _saying(self, tell: Callable[[Sequence[Answered]], None]) -> judging.SayLasso:
        return lambda index, answer: tell([(self._infinite[index], _found(answer))])

    def wander(self, urgent: bool = False) -> None:
        """Look for random lassos, and say what they show, before anything is proved; `urgent`: for errors alone."""
        asked = [index for index, leaf in enumerate(self._infinite) if not urgent or leaf in self._urgent]
        if asked:
            self._lassos.wander(self.bad_states.runs, asked)

    def _look_for_lassos(self) -> SideTask[Sequence[Answered]]:
        """Return the side task that answers the questions about infinite runs."""
        runs, portfolio = list(self.bad_states.runs), self.bad_states.portfolio.copy()

        def look(tell: Callable[[Sequence[Answered]], None]) -> None:
            if self._infinite:
                lassos = copy(self._lassos)
                lassos.decide, lassos.say = self._asking_for_lassos(portfolio), self._saying(tell)
                lassos.run(runs)

        return look

    def _goes_on(self, fair: bool) -> bool:
        """Return whether it is proved that every run can go on for ever under the assumptions, if `fair` fairly."""
        if not self.encoding.properties.assumptions:
            return True
        if not (self.evidence.settled and self._can_go_on):
            return False
        known = self.evidence.found
        return not fair or all(ending in known and known[ending].truth is False for ending in self._endings)

    @cached_property
    def _can_go_on(self) -> bool:
        """Whether it is proved that every run can go on for ever."""
        proved = can_go_on(self.encoding, self._excluded)
        if not proved:
            self.evidence.stranded = self._stranded()
        return proved

    @cached_property
    def _endings(self) -> tuple[CutOff, ...]:
        """Of each request with a slot that may not always be reported: whether some run comes to where there is no way
        to none of it being active. If none does, slots can be reported, or left idle, in turn."""
        found = []
        for name in dict.fromkeys(name for name, _ in unreported(self.encoding, self._excluded)):
            stuck = question_of(some_finally(Negation(some_finally(Negation(Atom(Status("active", name)))))))
            assert isinstance(stuck, Stuck)
            found.append(CutOff(stuck))
        return tuple(found)

    def _some_run_is_fair(self) -> bool:
        """Return whether a fair run under the assumptions is found, near the runs that are known."""
        if self._fair_run is None:
            answers: list[judging.LassoAnswer] = []
            fair = self._judging_fair([finally_(TRUE)], lambda _, answer: answers.append(answer))
            fair.wander(self.bad_states.runs)
            self._fair_run = any(isinstance(answer, judging.ShownLasso) for answer in answers)
        return self._fair_run

    def _judging_fair(self, paths: Sequence[Formula], say: judging.SayLasso) -> judging.Judging:
        """Return what judges whether fair runs satisfy formulas; it adds monitors to a graph of its own."""
        asked = [LassoQuestion(path, True) for path in paths]
        decide = self._asking_for_lassos(self.bad_states.portfolio.copy())
        return judging.Judging(deepcopy(self.encoding), asked, decide, say)

    def _ask_of_fair_runs(self) -> None:
        """Ask whether fair runs come to the moments to which some run comes, where not every run can go on fairly."""
        of_fair = [self.questions[number] for number in self.left if self.claims[number].fair]
        asked = {leaf for question in of_fair for leaf in questions_in(question)}
        come_to = {leaf for leaf, found in self.evidence.found.items() if found.truth}
        leaves = [leaf for leaf in self._asked.shown if leaf in asked & come_to]
        if not leaves or not self.evidence.settled or self._goes_on(True):
            return
        ways = [self._asked.shown[leaf] for leaf in leaves]

        def said(index: int, answer: judging.LassoAnswer) -> None:
            found, way = _found(answer), ways[index]
            if found.trace is not None:
                found = replace(found, trace=self._up_to(way.goal, found.trace, int(way.strict)))
            if found.truth is False or found.trace is not None:
                self.evidence.fairly[leaves[index]] = found

        self._judging_fair([way.path for way in ways], said).run(self.bad_states.runs)

    def _up_to(self, goal: Formula, trace: Trace, first: int) -> Trace | None:
        """Return a run up to the first moment, from one on, of which a formula is true; None if answers hide it."""
        reference = Reference(self.encoding.compiled.model)
        events = (None, *trace.events)
        answers = ((), *(moment.actions for moment in trace.moments))
        states = visited(reference, trace.events)
        for number, moment in enumerate(zip(events, states, answers, strict=True)):
            truth = is_true(reference.model, *moment, goal) if number >= first else False
            if truth is not False:
                return Trace(trace.moments[:number]) if truth else None
        return None

    def _excluded(self, circuit: Circuit) -> Container[int]:
        """Return the bad literals of a circuit, by index, that no reachable state makes true."""
        shown, portfolio = set[int](), self.bad_states.portfolio

        def hear(number: int, answer: Settled) -> None:
            if isinstance(answer, Reachable):
                self._stops.append(answer.inputs[:-1])
            elif not isinstance(answer, Open):
                shown.add(number)

        left = portfolio.settle_soon(circuit, range(len(circuit.bad)), hear, self.budget, learn=False)
        portfolio.put(circuit, left, hear, SHORT, self.budget)
        return shown

    def _stranded(self) -> Trace | None:
        """Return a run to a state from which the assumptions allow no step, if some known run comes to one."""
        found = stranded(self.encoding, [*self.bad_states.runs, *self._stops])
        traces = self.bad_states.concretizer.traces([] if found is None else [found])
        return next((trace for trace in traces if isinstance(trace, Trace)), None)

    def _tell(self, about: Iterable[int] | None = None, final: bool = False) -> None:
        """Say the opinion on each claim that is decided or has all its questions answered; on all claims if `final`.

        Only the claims of these places are looked at; None: all.
        """
        for number in range(len(self.claims)) if about is None else about:
            if number not in self._said:
                question = self.questions[number]
                opinion = self.evidence.opinion(question, self.claims[number])
                known = opinion.verdict != "unknown" or self.evidence.is_complete(question)
                if final or (known and STRANDED not in opinion.message):
                    self._said.add(number)
                    self.say(number, opinion)


def _found(answer: judging.LassoAnswer) -> Found:
    """Return what an answer says of a question about infinite runs."""
    match answer:
        case judging.NoLasso(method):
            return Found(False, method)
        case judging.ShownLasso(trace):
            return Found(True, WITNESS, trace)
        case Open(reason):
            return Found(None, reason=reason)
        case _:
            assert_never(answer)
