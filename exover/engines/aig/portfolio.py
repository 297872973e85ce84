"""Questions put to model checkers in turn: ABC where it is there, then our own what it leaves open."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from exover.engines.aig import abc
from exover.engines.aig.answer import Answer, Open
from exover.engines.aig.graph import Circuit
from exover.engines.aig.pdr import decide

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
) -> None:
    """Have model checkers answer questions, by index. `program`: the path of ABC, empty if it is not to help.

    `seconds`: what ABC may take of a processor. What our own may cost for a question is a tenth of its budget after
    ABC.
    """
    rest = list(asked)
    if program and rest:
        part = replace(circuit, bad=tuple(circuit.bad[index] for index in asked))

        def confirmed(place: int, answer: Answer) -> None:
            if not isinstance(answer, Open):
                rest.remove(asked[place])
                said(asked[place], answer)

        abc.decide(part, confirmed, seconds, None, program)
    if rest:
        decide(circuit, said, asked=rest, budget=budget // (10 if program else 1))
