"""The closed loop and what the checks ask of it as SMT-LIB 2: `z3 rover.smt2`."""

from collections.abc import Sequence

from exover.emit.artefact import Artefact
from exover.loop.claim import Claim
from exover.model.property import Properties
from exover.ocrd.compile import Compiled


def emit(compiled: Compiled, properties: Properties, claims: Sequence[Claim], name: str) -> tuple[Artefact, ...]:
    """Return `name.smt2`; the solver forgets all that it was asked before, so that the bytes are always the same."""
    from exover.engines.smt.solver import forget
    from exover.engines.smt.text import text

    forget()
    return (Artefact(f"{name}.smt2", text(compiled, properties, claims).encode()),)
