"""The engine: all claims about one closed loop at once, as questions to one graph.

Runs are looked for first, side by side and guided by coverage; what none of them shows is put to a model checker, all
of it together. That the passes of the graph are enough is a question like the others: nothing is said to hold before
that is proved. Runs are followed on the reference interpreter before they count.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from exover.engines.aig import abc
from exover.engines.aig.answer import Answer, Open, Reachable, Unreachable
from exover.engines.aig.concretize import Concretizer, Spurious
from exover.engines.aig.encoder import Encoding
from exover.engines.aig.exploration import LANES, Exploration
from exover.engines.aig.graph import FALSE, TRUE, Circuit, Literal
from exover.engines.aig.pdr import decide
from exover.engines.aig.questions import (
    Beyond,
    CutOff,
    Either,
    Known,
    Lasso,
    Not,
    Question,
    Questions,
    Reach,
    questions_in,
)
from exover.engines.aig.shorten import shorten
from exover.engines.aig.stimulus import Drawing
from exover.loop.claim import NO_FORMULA, Claim, Opinion, Verdict
from exover.model.property import Negation, Properties
from exover.model.trace import Trace
from exover.ocrd.compile import Compiled

PASSES = range(2, 13)
"""Numbers of passes that are tried, until one is enough."""
BUDGET = 20_000_000
"""Propagations of the solver that a question may cost."""
UNSETTLED = f"a step may take more than {PASSES[-1]} passes"
WITNESS, PROVED = "witness", "pdr"
Leaf = Reach | Lasso | CutOff
Said = Callable[[int, Opinion], None]


@dataclass
class Aig:
    """Answers claims about one closed loop; `abc`: the program of Berkeley ABC, if it is to help."""

    compiled: Compiled
    properties: Properties
    abc: str = ""
    budget: int = BUDGET
    name: str = "aig"

    def judge_all(self, claims: Sequence[Claim], say: Said) -> None:
        """Say of each claim, by its index and as soon as it is known, whether it is true of every run."""
        for passes in PASSES:
            inquiry = Inquiry(Encoding(self.compiled, self.properties, passes), claims, say, self.abc, self.budget)
            if inquiry.explore():
                inquiry.prove()
                return
        for number in range(len(claims)):
            say(number, Opinion("unknown", "", UNSETTLED))


@dataclass
class Inquiry:
    """Claims while they are looked into."""

    encoding: Encoding
    claims: Sequence[Claim]
    say: Said
    abc: str
    budget: int
    answers: dict[Literal, Answer] = field(default_factory=dict)
    traces: dict[Literal, Trace] = field(default_factory=dict)
    _said: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        asked = Questions(self.encoding)
        self.questions: list[Question] = [self._question(asked, claim) for claim in self.claims]
        self.answers[FALSE] = Unreachable(())
        self.answers[TRUE] = Reachable((frozenset(),))

    def _question(self, asked: Questions, claim: Claim) -> Question:
        if claim.formula is None:
            return Beyond()
        if claim.linear:
            return Not(Lasso(Negation(claim.formula), claim.fair))
        return asked.of(claim.formula, claim.fair)

    @cached_property
    def circuit(self) -> Circuit:
        """The graph with everything that is asked of it; first, whether the passes are not enough."""
        literals = {
            leaf.bad for question in self.questions for leaf in questions_in(question) if isinstance(leaf, Reach)
        }
        return self.encoding.circuit([self.encoding.unsettled, *sorted(literals - {FALSE, TRUE})])

    # ---- the work ----

    def explore(self) -> bool:
        """Look for runs, and return whether no run needs more passes; if so, say what they show."""
        watched = [
            bit >> 1
            for name, bits in self.encoding.latches.literals.items()
            for bit in bits[:4]
            if name not in self.encoding.latches.held
        ]
        asked = range(len(self.circuit.bad))
        found = Exploration(self.circuit, asked, Drawing(self.encoding, LANES).stimulus(), watched).run()
        if 0 in found:
            return False
        self._reached({index: answer.inputs for index, answer in found.items()})
        return True

    def prove(self) -> None:
        """Put what is left to a model checker, and say what comes of it."""
        left = [index for index, bad in enumerate(self.circuit.bad) if bad not in self.answers]
        found: dict[int, Answer] = {}

        def answered(index: int, answer: Answer) -> None:
            found[index] = answer
            if isinstance(answer, Reachable) and index:
                self._reached({index: answer.inputs})

        self._decide(left, answered)
        settled = self.circuit.bad[0] == FALSE or isinstance(found.get(0), Unreachable)
        for index, answer in found.items():
            if not isinstance(answer, Reachable):
                self.answers[self.circuit.bad[index]] = answer if settled else Open(UNSETTLED)
        self._tell(final=True)

    def _decide(self, left: Sequence[int], answered: Callable[[int, Answer], None]) -> None:
        """Have the model checkers answer questions, by index: ABC where it is there, then our own what is left."""
        rest = list(left)
        if self.abc and rest:
            part = replace(self.circuit, bad=tuple(self.circuit.bad[index] for index in left))

            def confirmed(place: int, answer: Answer) -> None:
                if not isinstance(answer, Open):
                    rest.remove(left[place])
                    answered(left[place], answer)

            abc.decide(part, confirmed, None, None, self.abc)
        if rest:
            decide(self.circuit, answered, asked=rest, budget=self.budget)

    def _reached(self, runs: Mapping[int, tuple[frozenset[int], ...]]) -> None:
        """Take runs that make bad literals true; those with no doubles in them show nothing."""
        short = shorten(self.circuit, runs)
        concrete = Concretizer(self.encoding).traces(list(short.values()))
        for index, trace in zip(short, concrete, strict=True):
            bad = self.circuit.bad[index]
            if isinstance(trace, Spurious):
                self.answers[bad] = Open(str(trace))
            else:
                self.answers[bad], self.traces[bad] = Reachable(short[index]), trace
        self._tell()

    # ---- answers ----

    def _tell(self, final: bool = False) -> None:
        """Say of each claim what is known of it by now."""
        for number, question in enumerate(self.questions):
            if number not in self._said:
                opinion = self._opinion(question, self.claims[number])
                if final or opinion.verdict != "unknown":
                    self._said.add(number)
                    self.say(number, opinion)

    def _opinion(self, question: Question, claim: Claim) -> Opinion:
        truth = self._truth(question)
        if truth is None:
            reasons = dict.fromkeys(self._reasons(question))
            return Opinion("unknown", "", "; ".join(reasons) or NO_FORMULA)
        verdict: Verdict = "holds" if truth else "violated"
        shown = [leaf.bad for leaf in questions_in(question) if isinstance(leaf, Reach) and leaf.bad in self.traces]
        if not shown:
            return Opinion(verdict, PROVED)
        return Opinion(verdict, WITNESS, trace=self.traces[shown[0]])

    def _truth(self, question: Question) -> bool | None:
        """Return whether a question is answered with yes; None if that is not known."""
        match question:
            case Reach(bad):
                answer = self.answers.get(bad)
                known = isinstance(answer, Reachable | Unreachable)
                return isinstance(answer, Reachable) if known else None
            case Known(truth):
                return truth
            case Not(part):
                inner = self._truth(part)
                return None if inner is None else not inner
            case Either(parts):
                found = [self._truth(part) for part in parts]
                return True if True in found else None if None in found else False
            case _:
                return None

    def _reasons(self, question: Question) -> Iterator[str]:
        for leaf in questions_in(question):
            answer = self.answers.get(leaf.bad) if isinstance(leaf, Reach) else None
            if isinstance(answer, Open):
                yield answer.reason
