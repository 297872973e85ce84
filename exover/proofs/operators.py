"""Proofs of the temporal operators of a formula: sets that steps cannot enter, layers, rankings (docs/certificates.md).

Each proof gives a bound on the moments from which a step leads to the target of its operator: an under-approximation if
the operator must be true of some moments (*needed*), an over-approximation if it must be false of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import cached_property
from math import inf
from time import process_time

from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.backward_reachability import BackwardReachability, TooWide
from exover.engines.bdd.fair_steps import LoopSteps, fair_reports
from exover.engines.bdd.fixpoints import Fixpoints
from exover.engines.bdd.ltl import Product
from exover.engines.bdd.manager import Set
from exover.engines.bdd.ranking import ranking
from exover.engines.bdd.steps import WIDE
from exover.loop.finite.step_predicates import connected, moments
from exover.model.property import (
    Conjunction,
    Disjunction,
    Formula,
    Negation,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    momentary,
    parts_of,
)
from exover.model.wire import Json
from exover.proofs.runs import RunWriter
from exover.proofs.sets import Sets
from exover.proofs.statement import Unsaid, distinct, temporal

OperatorProof = Json | None
"""The proof of one operator; the proofs of a formula are in the order in which its operators are written."""
INVARIANT: Json = {"kind": "invariant"}
MOST_NODES = 3000
"""A set with more nodes is not written down."""
TOO_LARGE = "the set of states that the proof needs is too large to be written down"
UNREACHED = "it holds of the states that are reached, and what they are is not written down"
CHOSEN = "where an event leads depends on how reals compare, and no one value leads on from all states"
ONE_MOMENT = "that a run goes on for ever is proved of one moment alone, by that run"
LATE = "the proof takes too long"


@dataclass(frozen=True)
class LimitedSteps(LoopSteps):
    """Backward steps that raise `TooWide` when a set is too large, and `Unsaid` after `deadline`."""

    deadline: float = inf

    def pre(self, states: Set, number: int) -> Set:
        """Return the states from which a step by this event leads into `states`."""
        if process_time() > self.deadline:
            raise Unsaid(LATE)
        found = super().pre(states, number)
        if len(found) > WIDE:
            raise TooWide
        return found


@dataclass
class Operators:
    """Proves formulas about one loop; `never`: tells whether a formula of one moment is known to be never true.

    `fair`: of the infinite runs, only those with fair reports count.
    """

    analysis: Analysis
    sets: Sets
    runs: RunWriter
    never: Callable[[Formula], bool]
    fair: bool
    deadline: float = inf
    _known: dict[Formula, Set] = field(default_factory=dict)

    @cached_property
    def steps(self) -> LimitedSteps:
        """The steps that the assumptions leave."""
        stepper = self.analysis.stepper
        return LimitedSteps(BackwardReachability(stepper, stepper.universe, None), deadline=self.deadline)

    @cached_property
    def fixpoints(self) -> Fixpoints:
        """Fixpoints over these steps, of fair runs if `fair`."""
        return Fixpoints(self.steps, fair_reports(self.analysis.stepper) if self.fair else ())

    @cached_property
    def moments(self) -> Set:
        """The start, and all states in which steps may end: an over-approximation of the moments."""
        return (self.steps.universe & self.analysis.stepper.allowed) | self.analysis.space.initial

    def nowhere(self, states: Set) -> bool:
        """Return True only if no moment is one of these states."""
        space = self.analysis.space
        if states & space.initial != space.none:
            return False
        return self.analysis.excluded(states & self.analysis.stepper.allowed)

    def true(self, formula: Formula) -> Set:
        """Return the states in which a formula is true, over infinite runs, and if `fair` over fair ones."""
        if formula not in self._known:
            self._known[formula] = self._true(formula)
        return self._known[formula]

    def _true(self, formula: Formula) -> Set:
        match formula:
            case Negation() | Conjunction() | Disjunction():
                return connected(self.analysis.space, formula, self.true)
            case SomeNext(part):
                return self.fixpoints.before(self.true(part))
            case SomeUntil(left, right):
                return self.fixpoints.until(self.true(left), self.true(right))
            case SomeAlways(part):
                return self.fixpoints.always(self.true(part))
            case _:
                return moments(self.analysis.meaning, formula)

    def text(self, states: Set, care: Set, names: dict[str, str] | None = None) -> str:
        """Return a formula that, within `care`, is true exactly of these states; `names`: of the bits of promises."""
        simple = self.analysis.space.simplified(self.analysis.stepper.forgotten(states), care)
        if len(simple) > MOST_NODES:
            raise Unsaid(TOO_LARGE)
        return self.sets.text(simple, names or {})

    # ---- formulas ----

    def prove(self, formula: Formula, positive: bool, needed: Set) -> list[OperatorProof]:
        """Return proofs that a formula is true of these moments, or if not `positive` false.

        Raises `Unsaid` if there are none, `TooWide` if they need too large sets.
        """
        if self.nowhere(needed):
            return trivial(formula, positive)
        match formula:
            case Negation(part):
                return self.prove(part, not positive, needed)
            case Conjunction(parts) if positive:
                return [each for part in parts for each in self.prove(part, True, needed)]
            case Disjunction(parts) if not positive:
                return [each for part in parts for each in self.prove(part, False, needed)]
            case Conjunction(parts) | Disjunction(parts) if parts:
                return self._one_of(parts, positive, needed)
            case SomeNext(SomeUntil() as until):
                return [None, *self._until(until, positive, needed)]
            case SomeNext(part):
                return self._next(part, positive, needed)
            case SomeUntil():
                return self._from_here(formula, positive, needed)
            case SomeAlways(part) if not positive:
                return [self._ranked(part, needed), *self.prove(part, False, self.moments & ~self.true(part))]
            case SomeAlways():
                raise Unsaid(ONE_MOMENT)
            case _:
                self._ensure(needed & self._being(formula, not positive))
                return []

    def _one_of(self, parts: Sequence[Formula], positive: bool, needed: Set) -> list[OperatorProof]:
        """Return proofs that of each moment some part is true, or if not `positive` false; momentary parts first."""
        last = max((number for number, part in enumerate(parts) if not momentary(part)), default=0)
        for part in parts:
            if momentary(part) and part is not parts[last]:
                needed &= ~self._being(part, positive)
        found: list[OperatorProof] = []
        for number, part in enumerate(parts):
            if number == last:
                found += self.prove(part, positive, needed)
            elif not momentary(part):
                mine = needed & self._being(part, positive)
                found += self.prove(part, positive, mine)
                needed &= ~mine
        return found

    def _being(self, formula: Formula, positive: bool) -> Set:
        return self.true(formula) if positive else ~self.true(formula)

    def _ensure(self, missing: Set) -> None:
        """Raise `Unsaid` unless it is known that no moment is one of these states."""
        if not self.nowhere(missing):
            raise Unsaid(UNREACHED)

    def _never(self, formula: Formula) -> list[OperatorProof] | None:
        """Return proofs that a formula is false of all moments; None if that is not known."""
        if momentary(formula):
            return [] if self.never(formula) else None
        try:
            return self.prove(formula, False, self.moments)
        except Unsaid:
            return None

    # ---- one step, and any number of steps ----

    def _next(self, part: Formula, positive: bool, needed: Set) -> list[OperatorProof]:
        """Return proofs that from each of the moments a step leads to where a formula is true, or from none of them."""
        if positive:
            there = self.true(part)
            layers, _ = self._layers(needed, self.analysis.space.none, there)
            return [{"kind": "layers", "layers": layers}, *self.prove(part, True, there)]
        never = self._never(part)
        if never is not None:
            return [INVARIANT, *never]
        there = self.true(part)
        closed = self._closed(self.fixpoints.before(there), needed)
        return [closed, *self.prove(part, False, self.moments & ~there)]

    def _from_here(self, until: SomeUntil, positive: bool, needed: Set) -> list[OperatorProof]:
        """Return proofs that an `until` is true, or false, of these moments."""
        if positive:
            missing = needed & ~self.true(until.right)
            self._ensure(missing & ~self.true(until.left))
            return self._until(until, True, missing)
        found = self._until(until, False, needed & self.true(until.left))
        if found[0] != INVARIANT:
            self._ensure(needed & self.true(until))
        return found

    def _until(self, until: SomeUntil, positive: bool, needed: Set) -> list[OperatorProof]:
        """Return proofs that from each of the moments a step leads to where an `until` is true, or from none of them.

        With proofs that its operands are true of the moments on the way, or false of those that would lead there.
        """
        left, right = until.left, until.right
        if positive:
            there, through = self.true(right), self.true(left)
            layers, found = self._layers(needed, through, there)
            inner = self.prove(left, True, through & (found | needed) & ~there)
            return [{"kind": "layers", "layers": layers}, *inner, *self.prove(right, True, there)]
        never = self._never(right)
        if never is not None:
            return [INVARIANT, *trivial(left, False), *never]
        found = self.true(until)
        into = self.fixpoints.before(found)
        closed = self._closed(into, needed)
        inner = self.prove(left, False, self.moments & into & ~found)
        return [closed, *inner, *self.prove(right, False, self.moments & ~found)]

    def _closed(self, into: Set, needed: Set) -> OperatorProof:
        """Return the proof by `into`, which has all moments with a step to the target, and none of those needed."""
        self._ensure(into & needed)
        return {"kind": "closed", "states": self.text(into, self.moments)}

    def _layers(self, needed: Set, through: Set, goal: Set) -> tuple[list[Json], Set]:
        """Return layers that cover the moments needed, and their union.

        The event of a layer leads from it to the goal, or to an earlier layer within `through`. Events take turns
        (chaining); those that change a variable on which the target depends are tried first.
        """
        events, found, layers = self.analysis.loop.events, self.analysis.space.none, list[Json]()
        every, turn = range(len(events)), None
        while not self.nowhere(needed & ~found):
            before = found
            for number in self.steps.touching(goal | through & found) if turn is None else turn:
                ways = self._led(goal | through & found, number)
                if self.nowhere(ways & ~found):
                    continue
                states = self.text(ways & ~found, self.moments & ~(ways & found))
                layers.append({"event": self.runs.event(events[number].event), "states": states})
                found |= ways
                if self.nowhere(needed & ~found):
                    break
            if found == before and turn is not None:
                raise Unsaid(CHOSEN if self.analysis.loop.approximate else UNREACHED)
            turn = every if found == before else None
        return layers, found

    def _led(self, states: Set, number: int) -> Set:
        """Return the states from which an event leads into these, whatever its inputs are."""
        found = self.steps.pre(states, number)
        inputs = self.analysis.stepper.step(number).function.inputs
        return found & ~self.steps.pre(~states, number) if inputs else found

    # ---- runs without end ----

    def _ranked(self, part: Formula, needed: Set) -> OperatorProof:
        """Return the ranking that proves: no fair run from a moment needed stays for ever where a formula is true."""
        return self._ranking(self.fixpoints, self.true(part), needed, self._reports, {})

    @property
    def _reports(self) -> list[str]:
        return [f"reported.{slot}" for slot in range(len(self.fixpoints.constraints))]

    def _ranking(
        self, fixpoints: Fixpoints, part: Set, needed: Set, constraints: Sequence[str], names: dict[str, str]
    ) -> OperatorProof:
        """Return the layers of the ranking of `part`, the lowest first, until they cover what is needed."""
        layers = list[Json]()
        for layer in () if self.nowhere(part & needed) else ranking(fixpoints, part):
            never = None if layer.never is None else constraints[layer.never]
            layers.append({"never": never, "states": self.text(layer.states, self.moments & part, names)})
            part &= ~layer.states
            if self.nowhere(part & needed):
                break
        self._ensure(part & needed)
        return {"kind": "ranking", "layers": layers}

    def linear(self, formula: Formula) -> list[OperatorProof]:
        """Return the proof that a formula of LTL is true of all fair runs."""
        said = distinct(formula)
        product = Product(self.steps, self.analysis.meaning, said)
        number = {each: f"promise.{n}" for n, each in enumerate(temporal(said))}
        names = {bit: number[promise] for bit, promise in zip(product.bits, product.promises, strict=True)}
        promises = [number[each] for each in product.promises if isinstance(each, Until)]
        fixpoints = Fixpoints(product, [*self.fixpoints.constraints, *product.constraints()])
        needed = self.analysis.space.initial & ~product.true(said)
        return [self._ranking(fixpoints, self.steps.universe, needed, [*self._reports, *promises], names)]


def trivial(formula: Formula, positive: bool) -> list[OperatorProof]:
    """Return trivial proofs for the operators of a formula whose truth is needed of no moment."""
    match formula:
        case Negation(part):
            return trivial(part, not positive)
        case SomeNext(SomeUntil()):
            head: list[OperatorProof] = [None]
        case SomeNext() | SomeUntil() if positive:
            head = [{"kind": "layers", "layers": []}]
        case SomeNext() | SomeUntil():
            head = [{"kind": "closed", "states": "true"}]
        case SomeAlways():
            head = [None if positive else {"kind": "ranking", "layers": []}]
        case _:
            head = []
    return [*head, *(each for part in parts_of(formula) for each in trivial(part, positive))]
