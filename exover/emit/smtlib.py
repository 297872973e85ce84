"""The closed loop and what the checks ask of it as SMT-LIB 2: `z3 rover.smt2`."""

from collections.abc import Sequence
from math import inf

from exover.emit.artefact import Artefact
from exover.loop.claim import Claim
from exover.model.property import Properties
from exover.ocrd.compile import Compiled


def emit(
    compiled: Compiled, properties: Properties, claims: Sequence[Claim], deadline: float = inf
) -> tuple[Artefact, ...]:
    """Return `NAME.smt2`; the state of the solver is reset first, so that the bytes are always the same.

    Raises `Inconclusive` of `exover.engines.smt.solver` after `deadline`, a time of `monotonic`.
    """
    from exover.engines.smt.solver import StepClock, forget
    from exover.engines.smt.text import text

    forget()
    found = text(compiled, properties, claims, StepClock(deadline))
    return (Artefact(f"{compiled.model.name}.smt2", found.encode()),)
