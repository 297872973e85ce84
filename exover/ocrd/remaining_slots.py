"""Which slots of a request remain where a decision takes some as idle, by conditions on their arguments.

What clears a slot is mostly a condition on its arguments. Then one counter with the opposite condition counts the slots
of a request that remain. To tell of each slot whether it remains doubles the cases of a sum with every slot.
"""

from collections.abc import Iterator, Sequence
from itertools import product

from exover.dataclass import dataclass
from exover.model.expression import And, Cond, Not, Or
from exover.ocrd.diagram import NO, YES, Manager
from exover.ocrd.forms import Numbers
from exover.ocrd.order import support
from exover.ocrd.vector import Slots
from exover.ocrd.view import Phases

MOST = 3
"""Conditions on the arguments of one slot that are told apart."""
Kind = tuple[int, Phases, Cond | None]
"""Slots in one phase whose arguments satisfy a condition (None: all), and the diagram of where they are idle."""


@dataclass(frozen=True, slots=True)
class RemainingSlots:
    """Tells apart the slots of a request that may remain, by the diagrams of where they are idle."""

    numbers: Numbers
    manager: Manager

    def kinds(self, request: str, idle: Sequence[int], phases: Phases) -> tuple[Kind, ...] | None:
        """Return disjoint kinds of the slots that may remain, if these are the same of every slot; else None.

        `idle`: by slot where it is idle. Also None for a single slot of which it depends on more than its arguments
        whether it remains: then two cases are smaller.
        """
        if len(idle) == 1:
            kinds = tuple(self._of_slot(request, None, idle[0], phases))
            return kinds if all(left == NO for left, _, _ in kinds) else None
        of_slots = (tuple(self._of_slot(request, slot, where, phases)) for slot, where in enumerate(idle))
        kinds = next(of_slots)
        return kinds if all(others == kinds for others in of_slots) else None

    def _of_slot(self, request: str, slot: int | None, idle: int, phases: Phases) -> Iterator[Kind]:
        """Yield disjoint kinds of one slot that may remain; `slot`: None for the only one of its request."""
        tests = self._tests(request, slot, idle)
        for phase in phases:
            told = tuple(dict.fromkeys(where for held, where in tests.values() if where and phase in held))
            if len(told) > MOST:
                yield idle, (phase,), None
                continue
            kinds: dict[int, list[Cond]] = {}
            for values in product((True, False), repeat=len(told)):
                true: dict[Cond | None, bool] = {None: True, **dict(zip(told, values, strict=True))}
                known = {element: int(phase in held and true[where]) for element, (held, where) in tests.items()}
                parts = [where if is_true else _opposite(where) for where, is_true in zip(told, values, strict=True)]
                left = self.manager.cofactor(idle, known)
                kinds.setdefault(left, []).append(_combined(And, parts))
            for left, conds in kinds.items():
                if left != YES:
                    yield left, (phase,), _combined(Or, conds) if len(conds) < 1 << len(told) else None

    def _tests(self, request: str, slot: int | None, idle: int) -> dict[int, tuple[Phases, Cond | None]]:
        """Return the elements in a diagram that are 1 iff this slot is in some phases with some arguments, else 0."""
        found: dict[int, tuple[Phases, Cond | None]] = {}
        for element in sorted(support(self.manager, [idle])):
            terms = self.numbers.elements[element]
            counted = [each for factor, each in terms if factor == 1 and isinstance(each, Slots)]
            told = {(each.request, each.slot, each.where) for each in counted}
            if len(counted) == len(terms) and told == {(request, slot, counted[0].where)}:
                found[element] = tuple(each.phase for each in counted), counted[0].where
        return found


def _combined(kind: type[And] | type[Or], parts: Sequence[Cond]) -> Cond:
    """Return the conjunction or disjunction of parts; a single part stays as it is."""
    return parts[0] if len(parts) == 1 else kind(tuple(parts))


def _opposite(cond: Cond) -> Cond:
    return cond.part if isinstance(cond, Not) else Not(cond)
