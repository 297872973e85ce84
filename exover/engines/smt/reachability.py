"""Can a moment be reached? Shown by a run, or refuted by induction, k-induction or Spacer, whichever comes first."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from exover.engines.smt.solver import Clock, Inconclusive, Prover, Translation
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken, Unrolled
from exover.loop.exact.term import Term, variables

INDUCTION = "induction"
FIRST = 6
"""So many steps a run is looked for before anything costly is tried."""
WIDEST = 3
"""So many steps k-induction looks back."""
LONGEST = 40
"""So many steps a run is looked for at last."""


@dataclass(frozen=True, slots=True)
class ReachingRun:
    """A run into such a moment."""

    steps: list[Taken]


@dataclass(frozen=True, slots=True)
class UnreachableMoment:
    """No run comes to such a moment, and how that was shown."""

    method: str


@dataclass
class Reachability:
    """Questions about the moments that a system can come to."""

    system: System
    clock: Clock
    known: tuple[Term, ...] = ()
    """What was found to be true of every moment, beside the lemmas."""
    _lemmas: tuple[Term, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.terms = self.system.terms
        self._lemmas = (*self.system.lemmas, *self.known)

    @cached_property
    def prover(self) -> Prover:
        """Answers questions about one step."""
        return Prover(self.clock)

    @cached_property
    def _forward(self) -> Unrolled:
        return Unrolled(self.system, self.clock)

    @cached_property
    def _backward(self) -> Unrolled:
        return Unrolled(self.system, self.clock, from_start=False)

    def reach(self, bad: Term, least: int = 0) -> ReachingRun | UnreachableMoment:
        """Return a run of `least` steps or more into a moment in which `bad` is true, or how it is known that none is.

        Raises `Inconclusive`.
        """
        if least == 0 and self.terms.replaced(bad, self.system.initial) is self.terms.true:
            return ReachingRun([])
        if self._inductive(bad):
            return UnreachableMoment(INDUCTION)
        return self._long(bad, least)

    def nowhere(self, bad: Term) -> bool:
        """Return whether it is seen at once that `bad` is true of no moment."""
        return self.terms.replaced(bad, self.system.initial) is self.terms.false and self._inductive(bad)

    def _long(self, bad: Term, least: int) -> ReachingRun | UnreachableMoment:
        for depth in range(1, FIRST + 1):
            found = self._run(bad, depth)
            if found:
                return found
        for width in range(2, WIDEST + 1):
            if self._k_inductive(bad, width):
                return UnreachableMoment(f"k-induction k={width}")
        if not self.system.steps.looked:
            raise Inconclusive("no facts of the loop were looked for")
        if self._refuted(bad, least):
            return UnreachableMoment("pdr")
        for depth in range(FIRST + 1, LONGEST + 1):
            found = self._run(bad, depth)
            if found:
                return found
        raise Inconclusive(
            f"bound reached: no run of {LONGEST} steps shows it, and no invariant was found that excludes one"
        )

    # ---- runs ----

    def _run(self, bad: Term, depth: int) -> ReachingRun | None:
        self._forward.grow_to(depth)
        model = self._forward.check([self._forward.at(depth, bad)])
        return None if model is None else ReachingRun(self._forward.taken(model, depth))

    # ---- induction ----

    def _inductive(self, bad: Term) -> bool:
        """Return whether no move leads into `bad`: from anywhere, or from elsewhere if runs do not begin there."""
        good = self.terms.negation(bad)
        outside = self.terms.replaced(bad, self.system.initial) is self.terms.false
        since = good if outside else self.terms.true
        return not any(self.prover.satisfiable((since, way), self._lemmas) for way in self._ways(bad))

    def _ways(self, bad: Term) -> Iterator[Term]:
        """Yield by move where it is allowed and leads into `bad`."""
        for move in self.system.moves:
            yield self.terms.both((move.allowed, self.system.before(bad, move)))

    def _k_inductive(self, bad: Term, width: int) -> bool:
        """Return whether no `width` moments without `bad` are followed by one with it; runs have no shorter way."""
        unrolled = self._backward
        unrolled.grow_to(width)
        before = [unrolled.at(moment, self.terms.negation(bad)) for moment in range(width)]
        known = [unrolled.at(moment, term) for moment in range(width + 1) for term in self.known]
        try:
            return unrolled.check([*before, *known, unrolled.at(width, bad)], most=10.0) is None
        except Inconclusive:
            self.clock.left()
            return False

    # ---- Spacer ----

    def _refuted(self, bad: Term, least: int) -> bool:
        """Return whether Spacer (Komuravelli, Gurfinkel, Chaki 2016) finds an invariant that excludes `bad`."""
        import z3

        engine, place = self._horn()
        names = list(self.system.vars.values())
        plain = Translation()
        here = place(*(plain(var) for var in names))
        goal = z3.Function("goal", z3.BoolSort())
        engine.register_relation(goal)
        if least == 0:
            engine.rule(goal(), [here, plain(bad)])
        for way in self._ways(bad) if least else ():
            engine.rule(goal(), [here, plain(way)])
        engine.set("timeout", self.clock.left(max(1.0, self.clock.left() / 2000)))
        try:
            return bool(engine.query(goal()) == z3.unsat)
        except z3.Z3Exception:
            return False

    def _horn(self) -> tuple[Any, Any]:
        """Return the moves as rules for one relation: the moments that are reached."""
        import z3

        plain = Translation()
        names = list(self.system.vars.values())
        engine = z3.Fixedpoint()
        engine.set(engine="spacer")
        place = z3.Function("reached", *(plain(var).sort() for var in names), z3.BoolSort())
        engine.register_relation(place)
        bound = {each.var for move in self.system.moves for each in move.inputs}
        bound |= variables(self._lemmas) - set(names)
        engine.declare_var(*(plain(var) for var in [*names, *sorted(bound, key=lambda var: var.name)]))
        engine.rule(place(*(plain(self.system.initial[var]) for var in names)))
        known = [plain(lemma) for lemma in self._lemmas]
        for move in self.system.moves:
            after = [plain(move.after.get(var.name, var)) for var in names]
            engine.rule(place(*after), [place(*(plain(var) for var in names)), plain(move.allowed), *known])
        return engine, place
