"""Model checkers for the questions of one graph: ABC if it is there, then embedded PDR for what it leaves open."""

from collections.abc import Sequence
from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.engines.aig.abc import prover
from exover.engines.aig.abc.prover import BOTH, FIRST
from exover.engines.aig.circuit.answer import (
    Answer,
    Inductive,
    Inputs,
    Open,
    SayAnswer,
    SaySettled,
    Settled,
    StopRequested,
    Unreachable,
    never,
)
from exover.engines.aig.circuit.graph import Circuit
from exover.engines.aig.induction.mutual_induction import mutually_inductive
from exover.engines.aig.induction.pdr import decide
from exover.engines.aig.induction.reached_bmc import runs_from_start
from exover.engines.aig.induction.strengthening import Lemmas, strengthened
from exover.engines.aig.simulation.reached import reached
from exover.engines.aig.simulation.reduction import reduced
from exover.engines.aig.simulation.runs import Runs, simulate
from exover.engines.aig.simulation.stimulus import Eventful, RandomStimulus, Stimulated

LONG, SHORT = 120.0, 30.0
"""Seconds of a processor that ABC may take for all questions about moments, and for each round of those about ways and
lassos."""
SOON = 5
"""Seconds of a processor that ABC may take for questions about moments that are not inductive, before runs are looked
for at length."""
BRIEFLY = 50
"""Embedded PDR gets this fraction of its budget (1 / `BRIEFLY`) for a question, instead of `SOON` or after ABC."""
STEPS, LANES = 20, 512
"""Steps and lanes of the random runs before embedded PDR, and before a circuit is made smaller."""


@dataclass(frozen=True)
class Portfolio:
    """The model checkers for one graph, and the lemmas that their proofs have found.

    `program`: the path of ABC, empty if it is not to be asked.
    """

    program: str
    system: Stimulated[Eventful]
    lemmas: Lemmas = field(default_factory=Lemmas)

    def copy(self, system: Stimulated[Eventful] | None = None) -> "Portfolio":
        """Return a portfolio with a copy of the lemmas, for a copy of the graph if one is given; it learns apart."""
        return replace(self, system=system or self.system, lemmas=self.lemmas.copy())

    def put(
        self,
        circuit: Circuit,
        asked: Sequence[int],
        said: SayAnswer,
        seconds: float,
        budget: int,
        stop: StopRequested = never,
    ) -> None:
        """Answer questions of a circuit of the graph, by index; the invariants of proofs become lemmas.

        `seconds`: the processor time of ABC. `budget`: propagations of embedded PDR for a question; after ABC it gets a
        part of them. `stop` is polled around the rounds of ABC: once it is true, nothing is said of the rest.
        """
        if self.program:
            left = self._by_abc(circuit, asked, said, seconds, stop=stop)
            if not stop():
                self._by_our_own(circuit, left, said, budget // BRIEFLY)
        else:
            self._by_our_own(circuit, asked, said, budget)

    def settle_soon(
        self, circuit: Circuit, asked: Sequence[int], said: SaySettled, budget: int, learn: bool
    ) -> list[int]:
        """Answer questions about moments that take little effort, and return the indices of the others.

        Mutual induction comes first: it needs no search. `learn`: whether model checkers are then asked the rest for a
        short time, since their lemmas are of use later.
        """
        left = dict.fromkeys(asked)

        def heard(index: int, answer: Settled) -> None:
            if not isinstance(answer, Open):
                del left[index]
                said(index, answer)

        part = _asking(circuit, asked)
        for place in mutually_inductive(part, self.lemmas.of(part)):
            heard(asked[place], Inductive())
        if learn and self.program:
            self._by_abc(circuit, list(left), heard, SOON, FIRST)
        elif learn:
            self._by_our_own(circuit, list(left), heard, budget // BRIEFLY)
        return list(left)

    def _by_abc(
        self,
        circuit: Circuit,
        asked: Sequence[int],
        said: SayAnswer,
        seconds: float,
        rounds: slice = BOTH,
        stop: StopRequested = never,
    ) -> list[int]:
        """Answer questions by ABC; return the indices of those that it leaves open, of which nothing is said."""
        if not asked:
            return []
        part = _asking(circuit, asked)
        strong = strengthened(part, self.lemmas.of(part))
        left = dict.fromkeys(asked)

        def claimed(place: int, answer: Answer) -> None:
            if not isinstance(answer, Open):
                del left[asked[place]]
                self._learn(strong.answer(answer), asked[place], said)

        prover.decide(strong.circuit, claimed, seconds, self.program, rounds, stop)
        return list(left)

    def _by_our_own(self, circuit: Circuit, asked: Sequence[int], said: SayAnswer, budget: int) -> None:
        """Answer questions by embedded PDR; `budget`: the propagations that each may cost."""
        if not asked:
            return
        part = _asking(circuit, asked)
        known, runs = self.lemmas.of(part), _random_runs(self.system, part, range(len(asked)))
        self.lemmas.add(
            decide(
                part,
                lambda place, answer: self._learn(answer, asked[place], said),
                runs=runs,
                known=known,
                budget=budget,
            )
        )

    def _learn(self, answer: Answer, index: int, said: SayAnswer) -> None:
        if isinstance(answer, Unreachable):
            self.lemmas.add(answer.invariant)
        said(index, answer)

    def unroll(self, circuit: Circuit) -> dict[int, Inputs]:
        """Return short runs that make bad literals true, by index, as far as bounded model checking soon finds them."""
        return prover.unrolled(circuit, self.program) if self.program else runs_from_start(circuit)


def _asking(circuit: Circuit, asked: Sequence[int]) -> Circuit:
    """Return a circuit with some of its bad literals alone, and the latches of their cone of influence."""
    bad = tuple(circuit.bad[index] for index in asked)
    return replace(circuit, bad=bad, latches=circuit.support(bad))


def smaller(system: Stimulated[Eventful], circuit: Circuit) -> Circuit:
    """Return a smaller circuit, equal in all states to one of the graph, with the same inputs and latches."""
    return reduced(circuit, reached(circuit.support(circuit.bad), _random_runs(system, circuit)))


def _random_runs(system: Stimulated[Eventful], circuit: Circuit, asked: Sequence[int] | None = None) -> Runs:
    return simulate(circuit, asked, RandomStimulus(system, LANES).stimulus(), STEPS, LANES)
