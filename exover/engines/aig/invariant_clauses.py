"""Inductive invariants of an encoding, as clauses over its latches, for callers that need more than an answer."""

from collections.abc import Mapping, Sequence
from functools import partial

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Answer, Clause, Reachable, Unreachable
from exover.engines.aig.circuit.graph import FALSE, TRUE
from exover.engines.aig.encoding.encoder import PASSES, Encoding
from exover.engines.aig.induction.pdr import decide
from exover.model.property import Formula, Properties
from exover.ocrd.compile import Compiled

BUDGET = 5_000_000
"""Propagations of the solver that a question may cost."""


@dataclass(frozen=True, slots=True)
class InvariantClauses:
    """An inductive invariant of an encoding, as clauses over its latches; from its states every step settles.

    `never`: the indices of the formulas that are true after no step from a state of the invariant.
    """

    encoding: Encoding
    clauses: tuple[Clause, ...] = ()
    never: tuple[int, ...] = ()


def invariant_clauses(
    compiled: Compiled, properties: Properties, formulas: Sequence[Formula], budget: int = BUDGET
) -> InvariantClauses | None:
    """Return an invariant that excludes those of the formulas, each of one moment, that are proved never true.

    None if no number of passes is proved to be enough. `budget`: the propagations that each question may cost.
    """
    for passes in PASSES:
        encoding = Encoding(compiled, properties, passes)
        circuit = encoding.circuit([encoding.unsettled, *map(encoding.step_is, formulas)])
        answers: dict[int, Answer] = {n: Unreachable(()) for n, bad in enumerate(circuit.bad) if bad == FALSE}
        asked = [n for n, bad in enumerate(circuit.bad) if bad not in (FALSE, TRUE)]
        goes_on = partial(_reachable, answers)
        decide(circuit, answers.__setitem__, asked=asked, budget=budget, stop=goes_on)
        if goes_on():
            continue
        if not isinstance(answers[0], Unreachable):
            return None
        known = {n: answer for n, answer in answers.items() if isinstance(answer, Unreachable)}
        clauses = dict.fromkeys(clause for answer in known.values() for clause in answer.invariant)
        return InvariantClauses(encoding, tuple(clauses), tuple(n - 1 for n in sorted(known) if n))
    return None


def _reachable(answers: Mapping[int, Answer]) -> bool:
    """Return whether some run needs more passes than there are."""
    return isinstance(answers.get(0), Reachable)
