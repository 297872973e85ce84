"""Questions put to model checkers in turn: ABC where it is there, then our own what it leaves open."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from exover.engines.aig import abc
from exover.engines.aig.answer import Answer, Open, Unreachable
from exover.engines.aig.graph import Circuit
from exover.engines.aig.pdr import decide
from exover.engines.aig.strengthening import Lemmas, strengthened

LONG, SHORT = 120.0, 20.0
"""Seconds of a processor that ABC may take for all questions about moments, and for each round of those about ways and
lassos."""


def put(
    circuit: Circuit,
    asked: Sequence[int],
    said: Callable[[int, Answer], None],
    program: str,
    seconds: float,
    budget: int,
    lemmas: Lemmas,
) -> None:
    """Have model checkers answer questions, by index. `program`: the path of ABC, empty if it is not to help.

    `seconds`: what ABC may take of a processor. What our own may cost for a question is a tenth of its budget after
    ABC. `lemmas`: what is known of the graph; what proofs find out is added.
    """
    if not asked:
        return
    part = replace(circuit, bad=tuple(circuit.bad[index] for index in asked))
    part = replace(part, latches=part.support(part.bad))
    known = lemmas.of(part)
    rest = list(range(len(asked)))

    def confirmed(place: int, answer: Answer) -> None:
        if isinstance(answer, Unreachable):
            lemmas.add(answer.invariant)
        rest.remove(place)
        said(asked[place], answer)

    if program:
        strong = strengthened(part, known)

        def claimed(place: int, answer: Answer) -> None:
            if not isinstance(answer, Open):
                confirmed(place, strong.answer(answer))

        abc.decide(strong.circuit, claimed, seconds, None, program)
    if rest:
        decide(part, confirmed, asked=tuple(rest), known=known, budget=budget // (10 if program else 1))
