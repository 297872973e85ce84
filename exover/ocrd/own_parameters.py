"""`self.p` in conditions on arguments: the parameters of the request whose clause it is, and values chosen for them."""

import math
from collections.abc import Iterator
from itertools import product

from exover.dataclass import dataclass
from exover.model.expression import And, Cond, Const, Or, Own, operands
from exover.model.types import Type, from_ordinal
from exover.ocrd.substitution import substitute
from exover.ocrd.vector import Vocabulary, ordinal_range
from exover.ocrd.view import ParameterOwner


def own_names(where: Cond) -> list[str]:
    """Return the names p of all `self.p` in a condition, sorted."""
    return sorted({term.name for term in operands(where) if isinstance(term, Own)})


@dataclass(frozen=True, slots=True)
class OwnParameters:
    """The parameters that `self.p` stands for in the conditions of a clause; None: of a clause of no request."""

    vocabulary: Vocabulary
    subject: ParameterOwner | None

    def _types(self, where: Cond) -> dict[str, Type]:
        """Return by name the type of each `self.p` in a condition, in the order of `own_names`."""
        names = own_names(where)
        if not names:
            return {}
        assert self.subject is not None
        return {name: self.vocabulary.parameter_types[self.subject.request, name] for name in names}

    def number(self, where: Cond) -> int:
        """Return how many choices of values there are."""
        return math.prod(high - low + 1 for low, high in map(ordinal_range, self._types(where).values()))

    def in_order(self, kind: type[And] | type[Or], parts: tuple[Cond, ...]) -> tuple[Cond, ...]:
        """Return the parts: those with `self.p`, the one with most choices first, then those without it, joined.

        Whatever is tested before the part with most choices would have to be remembered below all of them.
        """
        plain = tuple(part for part in parts if not own_names(part))
        owning = sorted(filter(own_names, parts), key=lambda part: -self.number(part))
        return (*owning, *((kind(plain),) if len(plain) > 1 else plain))

    def chosen(self, where: Cond) -> Iterator[tuple[dict[str, int], Cond]]:
        """Yield each choice of values of every `self.p`, as ordinals by name, and the condition with them."""
        types = self._types(where)
        ranges = [range(low, high + 1) for low, high in map(ordinal_range, types.values())]
        for numbers in product(*ranges):
            choice = dict(zip(types, numbers, strict=True))
            values = {name: Const(from_ordinal(types[name], number)) for name, number in choice.items()}
            yield choice, substitute(where, values)
