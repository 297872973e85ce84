"""Diagrams of comparisons of linear forms, and of terms given by cases, with constants."""

from itertools import product
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.expression import Operator
from exover.ocrd.diagram import NO, YES, Manager
from exover.ocrd.forms import Case, Factors, Numbers, add, plus
from exover.ocrd.vector import Quantity


@dataclass(frozen=True)
class Relations:
    """Builds, in one manager, diagrams of comparisons of linear forms over the quantities of one model."""

    numbers: Numbers
    manager: Manager

    def form(self, *quantities: Quantity) -> Factors:
        """Return the sum of these quantities."""
        return {self.numbers.quantity(quantity): 1 for quantity in quantities}

    def at_most(self, form: Factors, bound: int) -> int:
        """Return `form <= bound`."""
        if not any(form.values()):
            return YES if bound >= 0 else NO
        entry, factor = self.numbers.element(form)
        low, high = self.numbers.spans[entry]
        if factor > 0:
            return self.manager.at_most(entry, bound // factor, low, high)
        return self.manager.above(entry, -(bound // -factor) - 1, low, high)

    def at_least(self, form: Factors, bound: int) -> int:
        """Return `form >= bound`."""
        if not any(form.values()):
            return YES if bound <= 0 else NO
        entry, factor = self.numbers.element(form)
        low, high = self.numbers.spans[entry]
        if factor > 0:
            return self.manager.above(entry, (bound - 1) // factor, low, high)
        return self.manager.at_most(entry, -((bound - 1) // -factor) - 1, low, high)

    def equal(self, form: Factors, value: int) -> int:
        """Return `form == value`."""
        return self.manager.both(self.at_most(form, value), self.at_least(form, value))

    def compare_cases(self, op: Operator, cases: list[Case], bound: int) -> int:
        """Return the condition `term op bound` for a term given by cases."""
        found = NO
        for guard, form, constant in cases:
            found = self.manager.either(found, self.manager.both(guard, self.relate(op, form, bound - constant)))
        return found

    def relate(self, op: Operator, form: Factors, bound: int) -> int:
        """Return the condition `form op bound`."""
        match op:
            case "<=":
                return self.at_most(form, bound)
            case "<":
                return self.at_most(form, bound - 1)
            case ">":
                return self.at_least(form, bound + 1)
            case ">=":
                return self.at_least(form, bound)
            case "==":
                return self.equal(form, bound)
            case "!=":
                return self.manager.negate(self.equal(form, bound))
            case _:
                assert_never(op)

    def added(self, parts: list[list[Case]]) -> list[Case]:
        """Return the sum of terms given by cases, as cases; those whose condition is false are left out."""
        alike: dict[tuple[int, ...], list[Case]] = {}
        for part in parts:
            guards = tuple(guard for guard, _, _ in part)
            same = alike.get(guards) or [(guard, {}, 0) for guard in guards]
            pairs = zip(same, part, strict=True)
            alike[guards] = [(g, add(form, other), constant + more) for (g, form, constant), (_, other, more) in pairs]
        total: list[Case] = [(YES, {}, 0)]
        for group in alike.values():
            total = [
                (guard, *plus(case, other)[1:])
                for case, other in product(total, group)
                if (guard := self.manager.both(case[0], other[0])) != NO
            ]
        return total
