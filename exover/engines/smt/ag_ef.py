"""AG (since -> E [allowed U goal]), by concrete ways to the goal and their weakest preconditions.

A way is found from one moment, as concrete events. The moments from which the same events lead to the goal are a
formula (the weakest precondition), and the next way is searched from a moment outside all formulas so far
(counterexample-guided, after Clarke, Grumberg, Jha, Lu, Veith 2000). If there is no such moment, the claim is proved.

Only home states, in which nothing is active, need be covered if reports lead to one from every moment
(`HomeStateProof`).
"""

from collections.abc import Sequence
from dataclasses import field
from functools import cached_property
from typing import Any

from exover.dataclass import dataclass
from exover.engines.smt.home_states import HomeStateProof
from exover.engines.smt.lasso import LASSOS, Lassos, TermSemantics
from exover.engines.smt.reachability import INDUCTION, Reachability, ReachingRun, UnreachableMoment
from exover.engines.smt.relation import Move
from exover.engines.smt.solver import Clock, Inconclusive
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken, Unrolled
from exover.loop.exact.layout import level_name
from exover.loop.exact.term import Term, variables
from exover.loop.formula_classes import Stuck
from exover.model.property import TRUE, Formula, Next, Until

FARTHEST = 6
"""The greatest number of steps of a way."""
DEEPEST = 6
"""The depth from the start up to which a moment without a way is searched."""
MOST = 80
"""The greatest number of ways that are searched."""
BY_WAYS = "ways from everywhere"
BY_HOME_STATES = "reports, then ways"


@dataclass
class AlwaysPossible:
    """Searches a run to a moment without a way, or proves that there is none.

    `endless`: runs must be fair and infinite, and not every finite run is known to have a fair continuation.
    """

    system: System
    stuck: Stuck
    clock: Clock
    endless: bool
    _regions: list[Term] = field(default_factory=list)
    """The moments from which the found ways lead to the goal, one formula for each."""
    _found: list[Sequence[Taken]] = field(default_factory=list)
    """The ways that were found."""

    def __post_init__(self) -> None:
        self.terms = self.system.terms
        self.since = self.system.truth(self.stuck.since)
        self.allowed, self.goal = self.system.truth(self.stuck.way.allowed), self.system.truth(self.stuck.way.goal)
        self.reachability = Reachability(self.system, self.clock)

    def search(self) -> ReachingRun | UnreachableMoment:
        """Return a run to a moment of `since` without a way, or the method of the proof that there is none.

        Raises `Inconclusive`.
        """
        if self.reachability.nowhere(self.since):
            return UnreachableMoment(INDUCTION)
        if not self.endless and self._from_home():
            return UnreachableMoment(BY_HOME_STATES)
        if not self.endless and self._covered(self.since, self.stuck.way.strict):
            return UnreachableMoment(BY_WAYS)
        return self._lost()

    # ---- ways ----

    def ways(self) -> list[Sequence[Taken]] | None:
        """Return ways such that one of them leads to the goal from each state of `since` that satisfies the lemmas.

        None if they are not found. Raises `Inconclusive`.
        """
        return self._found if self._covered(self.since, self.stuck.way.strict) else None

    def _from_home(self) -> bool:
        """Return whether every moment in which nothing is active has a way, and reports lead there from all others."""
        home = HomeStateProof(self.system, self.reachability.prover, self.allowed)
        if not home.applies:
            return False
        return self._covered(self.terms.both((home.home, self.terms.negation(self.goal))), strict=True)

    def _covered(self, states: Term, strict: bool) -> bool:
        """Search ways until they cover all these states that satisfy the lemmas; return whether they do."""
        prover, names = self.reachability.prover, self.system.vars
        for _ in range(MOST):
            rest = self.terms.both((states, *(self.terms.negation(region) for region in self._regions)))
            model = prover.model((rest,), self.system.lemmas)
            if model is None:
                return True
            if model.model is None:
                return False
            values = {var: self.terms.literal(model.value(var), var.sort) for var in names.values()}
            steps = self._way(values, strict)
            if steps is None:
                return False
            self._regions.append(self._around(values, steps, strict))
        return False

    @cached_property
    def _ahead(self) -> Unrolled:
        return Unrolled(self.system, self.clock, from_start=False)

    def _way(self, values: dict[Term, Term], strict: bool) -> list[Taken] | None:
        """Return the steps of a shortest way from a state; None if it has none of at most `FARTHEST` steps."""
        way: Formula = Until(self.stuck.way.allowed, self.stuck.way.goal)
        for depth in range(FARTHEST + 1):
            self._ahead.grow_to(depth)
            here = [self._ahead.at(0, self.terms.equal(var, value)) for var, value in values.items()]
            shown = TermSemantics(self._ahead, depth, None).true(0, Next(way) if strict else way)
            found: Any = self._ahead.check([*here, shown], most=5.0)
            if found is not None:
                return self._ahead.taken(found, depth)
        return None

    def _around(self, values: dict[Term, Term], steps: Sequence[Taken], strict: bool) -> Term:
        """Return the states from which a way leads to the goal, immediately or after observations of the posters it
        depends on; add both variants to the found ways.
        """
        region = self._region(steps, strict)
        if self.terms.replaced(region, values) is not self.terms.true:
            raise AssertionError("a way does not lead from where it was found")
        read = variables([region])
        prefix = [
            Taken(move.kind, {move.inputs[0].var.name: values[var].constant})
            for move in self.system.moves
            if (var := self._observed(move)) in read
        ]
        ways = [list(steps), [*prefix, *steps]] if prefix else [list(steps)]
        self._found += ways
        return self.terms.either(self._region(way, strict) for way in ways)

    def _observed(self, move: Move) -> Term | None:
        """Return the variable that a move observes; None if the move is no observation."""
        match move.kind.verb:
            case "observe":
                return self.system.vars.get(move.kind.name)
            case "observe level":
                return self.system.vars.get(level_name(move.kind.name))
            case _:
                return None

    def _region(self, steps: Sequence[Taken], strict: bool) -> Term:
        """Return the weakest precondition: the states from which these steps are allowed and lead to the goal."""
        reached = self.goal
        for number, taken in reversed(list(enumerate(steps))):
            before = self._before(taken, reached)
            reached = (
                before
                if strict and number == 0
                else self.terms.either((self.goal, self.terms.both((self.allowed, before))))
            )
        return reached

    def _before(self, taken: Taken, states: Term) -> Term:
        """Return the states from which a step is allowed and leads into `states`."""
        (move,) = (move for move in self.system.moves if move.kind == taken.kind)
        inputs = {each.var: self.terms.literal(taken.values[each.var.name], each.var.sort) for each in move.inputs}
        there = self.terms.both((move.allowed, self.system.before(states, move)))
        return self.terms.replaced(there, inputs)

    # ---- moments without a way ----

    def _lost(self) -> ReachingRun | UnreachableMoment:
        """Return a run to a moment from which there is provably no way; raises `Inconclusive` if none is found."""
        forward = Unrolled(self.system, self.clock)
        tried = 0
        for depth in range(DEEPEST + 1):
            forward.grow_to(depth)
            while tried < MOST:
                tried += 1
                without = [self.terms.negation(region) for region in self._regions]
                found = forward.check([forward.at(depth, term) for term in (self.since, *without)])
                if found is None:
                    break
                values = forward.values(found, depth)
                steps = self._way(values, self.stuck.way.strict)
                if steps is None:
                    self._confirm(values)
                    return ReachingRun(forward.taken(found, depth))
                self._regions.append(self._around(values, steps, self.stuck.way.strict))
        raise Inconclusive(f"bound reached: no moment of {DEEPEST} steps is without a way, nor is it known for all")

    def _confirm(self, values: dict[Term, Term]) -> None:
        """Raise `Inconclusive` unless a state provably has no way and, if `endless`, has a fair run."""
        if not self._cut_off(values):
            raise Inconclusive("bound reached: a moment was found with no short way, and no proof that it has none")
        if self.endless and not self._goes_on(values):
            raise Inconclusive("bound reached: a moment was found with no way, and no fair run that goes on from there")

    def _goes_on(self, values: dict[Term, Term]) -> bool:
        """Return whether a fair run is found that goes on from a state."""
        onwards = self.system.into(self.terms.true)
        onwards.initial = values
        return Lassos(Unrolled(onwards, self.clock), fair=True, endless=True).find(TRUE, LASSOS) is not None

    def _cut_off(self, values: dict[Term, Term]) -> bool:
        """Return whether it is proved that no allowed steps lead from a state to the goal."""
        onwards = self.system.into(self.terms.either((self.allowed, self.goal)))
        strict = self.stuck.way.strict
        if not strict and self.terms.replaced(self.allowed, values) is self.terms.false:
            return self.terms.replaced(self.goal, values) is self.terms.false
        onwards.initial = values
        return isinstance(Reachability(onwards, self.clock).reach(self.goal, int(strict)), UnreachableMoment)
