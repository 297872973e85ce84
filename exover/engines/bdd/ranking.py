"""Rankings: proofs that no fair run stays among some states (Manna, Pnueli 1991).

The rank of a state is the number of its layer. No step within the states increases the rank, and within a layer one
constraint is never met. So a run that stays would finally stay in one layer, and would not be fair.
"""

from collections.abc import Generator, Iterator

from exover.dataclass import dataclass
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.manager import Set


@dataclass(frozen=True, slots=True)
class Layer:
    """States that do not meet constraint `never`; nor does a step from one of them to another.

    None: no step leads from one of them to another, only to lower layers or out.
    """

    never: int | None
    states: Set


def ranking(fixpoints: Fixpoints, part: Set) -> Iterator[Layer]:
    """Yield the layers of the states of `part` from which no fair run stays in it, the lowest first.

    They are the sets that the iteration of the greatest fixpoint `Fixpoints.always` removes, in order: a step within
    `part` from a layer leads into the same layer or a lower one.
    """
    found = part & fixpoints.steps.universe
    while True:
        before = found
        found = yield from _led_out(fixpoints, found)
        for number, constraint in enumerate(fixpoints.constraints):
            kept = fixpoints.meets(constraint, found)
            if kept != found:
                yield Layer(number, found & ~kept)
                found = yield from _led_out(fixpoints, kept)
        if found == before:
            return


def _led_out(fixpoints: Fixpoints, part: Set) -> Generator[Layer, None, Set]:
    """Yield, as layers, the states of `part` from which every run leaves it; return the others."""
    while True:
        kept = fixpoints.before(part, part)
        if kept == part:
            return part
        yield Layer(None, part & ~kept)
        part = kept
