"""The bounded semantics of LTL (Biere, Cimatti, Clarke, Zhu 1999), for terms of Z3 and for text."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from exover.model.property import Conjunction, Disjunction, Formula, Negation, Next, Until, momentary

T = TypeVar("T")
"""A formula of a solver: a term of Z3, or its text."""


class BoundedSemantics(ABC, Generic[T]):
    """What is true of runs of `depth` steps; with `back`, after the last moment come those after moment `back`."""

    def __init__(self, depth: int, back: int | None) -> None:
        self.depth, self.back = depth, back
        self._known: dict[tuple[int, Formula, bool], T] = {}

    @abstractmethod
    def truth(self, value: bool) -> T:
        """Return `true` or `false`."""

    @abstractmethod
    def both(self, parts: Sequence[T]) -> T:
        """Return the conjunction."""

    @abstractmethod
    def either(self, parts: Sequence[T]) -> T:
        """Return the disjunction."""

    @abstractmethod
    def at(self, moment: int, formula: Formula, positive: bool) -> T:
        """Return where a formula without temporal operators, or its negation, is true of a moment."""

    def named(self, value: T) -> T:
        """Return what stands for a formula that may be needed more than once."""
        return value

    def true(self, moment: int, formula: Formula, positive: bool = True) -> T:
        """Return where the formula, or its negation, is true of the run from a moment on."""
        if momentary(formula):
            return self.at(moment, formula, positive)
        key = (moment, formula, positive)
        if key not in self._known:
            self._known[key] = self.named(self._true(moment, formula, positive))
        return self._known[key]

    def _true(self, moment: int, formula: Formula, positive: bool) -> T:
        match formula:
            case Negation(part):
                return self.true(moment, part, not positive)
            case Conjunction(parts) | Disjunction(parts):
                truths = [self.true(moment, part, positive) for part in parts]
                return self.both(truths) if isinstance(formula, Conjunction) == positive else self.either(truths)
            case Next(part):
                following = self._following(moment)
                return self.truth(False) if following is None else self.true(following, part, positive)
            case Until(left, right):
                return self._until(moment, left, right, positive)
            case _:
                raise TypeError("a path formula is of LTL")

    def _following(self, moment: int) -> int | None:
        if moment < self.depth:
            return moment + 1
        return None if self.back is None else self.back + 1

    def _until(self, moment: int, left: Formula, right: Formula, positive: bool) -> T:
        """Return where the until is true, or false: at the end of the moments neither is shown, but by repetition."""
        later = list(range(moment, self.depth + 1))
        if self.back is not None:
            later += range(self.back + 1, min(moment, self.depth + 1))
        found = self.truth(not positive and self.back is not None)
        for each in reversed(later):
            first, last = self.true(each, left, positive), self.true(each, right, positive)
            if positive:
                found = self.either((last, self.both((first, found))))
            else:
                found = self.both((last, self.either((first, found))))
        return found
