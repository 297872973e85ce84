"""The temporal engine: whether properties are true of the loop, and runs that show it."""

from collections.abc import Callable
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.backward_reachability import BackwardReachability, Ring
from exover.engines.bdd.concretize import RunConcretizer, follow
from exover.engines.bdd.ctl import Ctl
from exover.engines.bdd.fair_steps import Constraint, LoopSteps, fair_reports
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.lasso import LoopRun, ProductRun, Run, advance, close_lasso, come
from exover.engines.bdd.ltl import Product
from exover.engines.bdd.manager import Set
from exover.engines.bdd.near_steps import NearSteps
from exover.engines.bdd.steps import Stepper
from exover.loop.finite.predicates import StatePredicates
from exover.model.property import (
    TRUE,
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    Property,
    SomeAlways,
    SomeNext,
    SomeUntil,
    momentary,
    parts_of,
)
from exover.model.semantics import Reference
from exover.model.trace import Trace


@dataclass(frozen=True, slots=True)
class PropertyAnswer:
    """Whether a property is true at the start, and a run that shows it, if a run can."""

    holds: bool
    trace: Trace | None = None


@dataclass
class TemporalEngine:
    """Questions about the runs within `universe`, a set of states with the initial one that no step leaves.

    `way`: the rings of the runs from the start into given states, or None; `fair`: only runs count on which every slot
    is infinitely often idle or reported.
    """

    stepper: Stepper
    meaning: StatePredicates[Set]
    reference: Reference
    universe: Set
    way: Callable[[Set], list[Ring] | None]
    fair: bool

    @cached_property
    def reports(self) -> list[Constraint]:
        """The justice constraints: every slot is infinitely often idle or reported."""
        return fair_reports(self.stepper)

    @cached_property
    def _backwards(self) -> BackwardReachability:
        return BackwardReachability(self.stepper, self.universe, None)

    @cached_property
    def ctl(self) -> Ctl:
        """Formulas of CTL."""
        steps = LoopSteps(self._backwards)
        return Ctl(self.meaning, Fixpoints(steps, self.reports if self.fair else ()), self.way)

    def _start(self) -> LoopRun:
        return LoopRun(RunConcretizer(self.stepper, self.reference))

    # ---- assumptions ----

    def stranded(self) -> Trace | None:
        """Return a run to a state that no step leaves, if there is one."""
        way = self.way(self.universe & ~self.ctl.fixpoints.before(self.universe))
        return None if way is None else follow(self._start().walker, way, self.stepper.space.all)

    def is_unfair(self) -> bool:
        """Return whether the start has no fair run (unless `fair`: no infinite run)."""
        space = self.stepper.space
        return bool(space.initial & self.ctl.fixpoints.fair == space.none)

    # ---- properties ----

    def possible(self, premise: Formula) -> bool:
        """Return whether a premise is true in some moment of some run."""
        return self.ctl.comes_to(premise)

    def answer(self, prop: Property) -> PropertyAnswer:
        """Return whether the property is true at the start, with a run that shows it."""
        if prop.form == "ltl":
            return self._linear(prop.formula)
        holds = self.ctl.starts_with(prop.formula)
        shown = prop.formula if holds else Negation(prop.formula)
        if not (_has_run(shown) or (not holds and momentary(shown))):
            return PropertyAnswer(holds)
        run = self._start()
        start = self._show(run, shown)
        return PropertyAnswer(holds, run.walker.trace(start))

    def _linear(self, formula: Formula) -> PropertyAnswer:
        """Return whether a formula of LTL is true of all fair runs, else a lasso of which it is false."""
        space = self.stepper.space
        product = Product(LoopSteps(self._backwards), self.meaning, formula)
        constraints = [*(self.reports if self.fair else ()), *product.constraints()]
        fixpoints = Fixpoints(product, constraints)
        begin = space.initial & ~product.true(formula) & fixpoints.fair
        if begin == space.none:
            return PropertyAnswer(True)
        run = ProductRun(RunConcretizer(self.stepper, self.reference), product, begin)
        start = close_lasso(run, fixpoints, fixpoints.fair)
        return PropertyAnswer(False, run.walker.trace(start))

    def _show(self, run: Run, formula: Formula) -> int | None:
        """Continue the run as a witness of a formula that is true in its state; return where its loop begins, if any.

        A universal formula has no single witness: there the run ends.
        """
        fixpoints = self.ctl.fixpoints
        match formula:
            case Negation(Negation(part)):
                return self._show(run, part)
            case Negation(Conjunction(parts)):
                return self._show(run, Disjunction(tuple(Negation(part) for part in parts)))
            case Negation(Disjunction(parts)):
                return self._show(run, Conjunction(tuple(Negation(part) for part in parts)))
            case Disjunction(parts):
                true = [part for part in parts if run.held & self.ctl.true(part) != fixpoints.none]
                return self._show(run, true[0])
            case Conjunction(parts):
                telling = [part for part in parts if _has_run(part)]
                return self._show(run, telling[0]) if telling else None
            case SomeNext(part):
                advance(run, fixpoints, self.ctl.true(part) & fixpoints.fair, fixpoints.steps.events)
                return self._show(run, part)
            case SomeUntil(left, right):
                goal = self.ctl.true(right) & fixpoints.fair
                way = self.way(goal) if left == TRUE and not run.walker.events else None
                if way is not None:
                    follow(run.walker, way, self.stepper.space.all)
                else:
                    come(run, fixpoints, self.ctl.true(left), goal)
                return self._show(run, right)
            case SomeAlways(part):
                return close_lasso(run, fixpoints, self.ctl.true(formula))
            case _:
                return None

    # ---- starvation ----

    def starving(self, request: str) -> Trace | None:
        """Return a run with fair reports on which one instance of the request waits for ever; None if there is none.

        First only steps near the variables that the settling of the request reads are searched. Then the reports of
        slots that it reads are tried alone as constraints, which may already exclude such a run.
        """
        looked_at, waits = self._looked_at(request), self.stepper.narrowed(self.meaning.waiting(request))
        reports = [each for each in self.reports if looked_at & self.stepper.space.support(each.states)]
        near, left = NearSteps(self.stepper, self._backwards, looked_at), ("left", request)
        close, lingering = Fixpoints(near), Fixpoints(near.avoiding(left), reports)
        waiting = lingering.always(near.among(waits))
        if self.stepper.space.initial & close.until(near.universe, waiting) != self.stepper.space.none:
            return self._lasso(close, lingering, waiting)
        steps = LoopSteps(self._backwards, left)
        if self.way(Fixpoints(steps, reports).always(waits)) is None:
            return None
        fixpoints = Fixpoints(steps, self.reports)
        waiting = fixpoints.always(waits)
        if self.way(waiting) is None:
            return None
        return self._lasso(self.ctl.fixpoints, fixpoints, waiting)

    def _lasso(self, way: Fixpoints, lingering: Fixpoints, lasting: Set) -> Trace:
        """Return a lasso that leads into `lasting` and stays there for ever."""
        run = self._start()
        come(run, way, self.stepper.space.all, lasting)
        start = close_lasso(run, lingering, lasting)
        return run.walker.trace(start)

    def _looked_at(self, request: str) -> frozenset[int]:
        """Return the variables that the component which settles the request reads."""
        loop = self.stepper.loop
        return loop.body[loop.settling(loop.request_number[request])].reads


def _has_run(formula: Formula, positive: bool = True) -> bool:
    """Return whether the formula (or, unless `positive`, its negation) has an existential part: a run to be shown."""
    match formula:
        case Negation(part):
            return _has_run(part, not positive)
        case SomeNext() | SomeUntil() | SomeAlways():
            return positive
        case _:
            return any(_has_run(part, positive) for part in parts_of(formula))
