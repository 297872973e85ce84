"""LTL by the product of the loop with the tableau of a formula (Clarke, Grumberg, Hamaguchi 1994).

A moment of the product is a moment of the loop and, for each subformula `X f` or `f U g`, a promise: the guess whether
`X f`, or X (f U g), is true there. The next moment must keep every promise, true or false; justice constraints make
each until that is true come to its right side.
"""

from collections.abc import Iterable, Sequence
from dataclasses import field
from typing import assert_never

from exover.dataclass import dataclass
from exover.engines.bdd.fair_steps import Constraint, TransitionSystem
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.loop.finite.predicates import StatePredicates
from exover.loop.finite.step_predicates import connected, moments
from exover.model.property import (
    Atom,
    Broken,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    parts_of,
)


@dataclass
class Product:
    """The product as a transition system; `promises`: the subformulas, `bits`, `then`: their bits now and next."""

    base: TransitionSystem
    meaning: StatePredicates[Set]
    formula: Formula
    promises: list[Formula] = field(default_factory=list)
    _known: dict[Formula, Set] = field(default_factory=dict)
    _last: tuple[Set, Set] | None = None

    def __post_init__(self) -> None:
        self.promises = list(dict.fromkeys(_promising(self.formula)))
        self.bits = [self.space.passenger(f"promise{k}") for k in range(len(self.promises))]
        self.then = [self.space.passenger(f"kept{k}") for k in range(len(self.promises))]

    @property
    def space(self) -> Space:
        """The space of the loop."""
        return self.base.space

    @property
    def universe(self) -> Set:
        """The universe of the loop, whatever is promised."""
        return self.base.universe

    @property
    def events(self) -> Sequence[int]:
        """The events of the loop."""
        return self.base.events

    def touching(self, states: Set) -> Sequence[int]:
        """Return all events, since each may change the promises."""
        return self.events

    def pre(self, states: Set, number: int) -> Set:
        """Return the states from which a step by this event leads into `states` and keeps all promises."""
        return self.base.pre(self.promised(states), number)

    def promised(self, states: Set) -> Set:
        """Return the states of the loop with promises made one moment before, such that some of `states` keeps them."""
        if self._last is None or self._last[0] != states:
            bdd = self.space.bdd
            found = self._later(states)
            for bit, promise in zip(self.bits, self.promises, strict=True):
                found &= ~bdd.apply("^", bdd.var(bit), self._later(self.kept(promise)))
            self._last = (states, bdd.exist(self.then, found) if self.then else found)
        return self._last[1]

    def _later(self, states: Set) -> Set:
        names = dict(zip(self.bits, self.then, strict=True))
        return self.space.bdd.let(names, states) if names else states

    def kept(self, promise: Formula) -> Set:
        """Return the moments that keep a promise made one moment before."""
        return self.true(promise.part if isinstance(promise, Next) else promise)

    def constraints(self) -> list[Constraint]:
        """Return one justice constraint for each until: infinitely often it is false, or its right side is true."""
        untils = [each for each in self.promises if isinstance(each, Until)]
        return [Constraint(~self.true(each) | self.true(each.right)) for each in untils]

    def true(self, formula: Formula) -> Set:
        """Return the moments of the product in which a formula is true if the promises are kept."""
        if formula not in self._known:
            self._known[formula] = self._true(formula)
        return self._known[formula]

    def _true(self, formula: Formula) -> Set:
        match formula:
            case Atom() | Happened() | Passed() | Broken():
                return moments(self.meaning, formula)
            case Negation() | Conjunction() | Disjunction():
                return connected(self.space, formula, self.true)
            case Next():
                return self._promise(formula)
            case Until(left, right):
                return self.true(right) | (self.true(left) & self._promise(formula))
            case SomeNext() | SomeUntil() | SomeAlways():
                raise TypeError("a formula of LTL has no path quantifier")
            case _:
                assert_never(formula)

    def _promise(self, formula: Formula) -> Set:
        return self.space.bdd.var(self.bits[self.promises.index(formula)])


def _promising(formula: Formula) -> Iterable[Formula]:
    """Yield the subformulas of the form `X f` or `f U g`, inner ones first."""
    for part in parts_of(formula):
        yield from _promising(part)
    if isinstance(formula, Next | Until):
        yield formula
