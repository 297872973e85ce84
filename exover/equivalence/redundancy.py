"""Redundancy: the decisions of a model compared with those without a rule, reasons left aside.

Both are read from the rules, as diagrams of one manager: where they differ is a diagram again, mostly the one that is
nowhere true. Else the states of the loop in which the decision is taken tell whether the difference is ever met.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.image import PASS
from exover.engines.bdd.manager import Set
from exover.equivalence.state_equivalence import StateComparison
from exover.loop.finite.argument_classes import Cell
from exover.loop.finite.program import Walk
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.model import Request, Rule
from exover.ocrd.decision import DecisionEffect, DecisionList, DoDismiss, DoReject, DoSettle, DoWait
from exover.ocrd.demand import Decider, Hit
from exover.ocrd.diagram import NO, YES, Manager, deep
from exover.ocrd.memory import IDLE, RUNNING

_DecisionPoint = tuple[Cell, tuple[int, ...], Set, bool]
"""Arguments, how they compare with posters, states in which they are decided; whether as a newcomer."""


@dataclass(frozen=True)
class _Change:
    """Where the decision on a request is another without the rule: by effect, conditions of one manager.

    `superseding`: where a newcomer is not rejected, if without the rule it would be, the place being taken.
    """

    number: int
    manager: Manager
    effects: dict[DecisionEffect, int]
    superseding: int = NO


@dataclass(frozen=True)
class RuleContribution:
    """Asks of one closed loop what its rules change."""

    analysis: Analysis
    equivalence: StateComparison

    def changes(self, rules: Sequence[Rule]) -> bool:
        """Return whether without these rules something else is done at some moment of some reachable step.

        That is: another verdict on a newcomer, other slots killed for it, others dismissed; other slots killed to
        restore rules; a violation that is no longer raised.
        """
        analysis = self.analysis
        if analysis.reaches_into(analysis.broken(rules)):
            return True
        named = {request.name: request for rule in rules for request in self.equivalence.asking(rule)}
        changes = [self._change(request, rules) for request in named.values()]
        changes = [change for change in changes if change.effects or change.superseding != NO]
        for change in changes:
            for point in self._at_first(change.number):
                if any(analysis.reaches(states) for states in self._differing(change, *point)):
                    return True
        return self._restores(rules) or any(self._met_within(change) for change in changes)

    def _met_within(self, change: _Change) -> bool:
        """Return whether a decision within some step is another; where none can be, no step is looked at."""
        arguments, everywhere = self.analysis.loop.arguments[change.number], self.analysis.space.all
        kinds = [(cell, choice) for cell in arguments.cells for choice in arguments.choices()]
        if not any(True for kind in kinds for _ in self._differing(change, *kind, everywhere, True)):
            return False
        return any(True for point in self._within(change.number) for _ in self._differing(change, *point))

    # ---- decisions ----

    @cached_property
    def _deciders(self) -> dict[str, tuple[Decider, dict[DecisionEffect, int]]]:
        """By request what reads its decision, and the decision of the model."""
        return {}

    def _change(self, request: Request, rules: Sequence[Rule]) -> _Change:
        """Return where the decision on a request is another without the rules."""
        loop, questions = self.analysis.loop, self.equivalence.questions
        with deep():
            if request.name not in self._deciders:
                fresh = Decider(questions, Manager())
                self._deciders[request.name] = fresh, self._effects(fresh.manager, fresh.decide(request))
            decider, mine = self._deciders[request.name]
            names = {rule.name for rule in rules}
            left = [rule for rule in questions.rules[request.name] if rule.name not in names]
            alone = request.without_rules(names)
            its = self._effects(decider.manager, decider.decide(alone, left))
            effects = _different(decider.manager, mine, its)
            taken = decider.manager.negate(mine.get(("reject",), NO)) if alone is not request else NO
        return _Change(loop.request_number[request.name], decider.manager, effects, taken)

    def _effects(self, manager: Manager, decision: DecisionList) -> dict[DecisionEffect, int]:
        """Return where a decision has which effect."""
        first: dict[type, int] = {}
        for where, do in decision.demands:
            first[type(do)] = manager.either(first.get(type(do), NO), where)
        found: dict[DecisionEffect, int] = {}
        left = YES
        cleared = _any(manager, decision.hits)
        for verdict, where in (
            ("reject", first.get(DoReject, NO)),
            ("wait", first.get(DoWait, NO)),
            ("clear", cleared),
            ("settle", first.get(DoSettle, NO)),
        ):
            found[verdict,] = manager.both(left, where)
            left = manager.both(left, manager.negate(where))
        for effect, where in self._killed(manager, decision.hits).items():
            found[effect] = manager.both(found["clear",], where)
        for where, do in decision.demands:
            if isinstance(do, DoDismiss):
                effect = ("dismiss", do.request)
                found[effect] = manager.either(found.get(effect, NO), manager.both(left, where))
        return found

    def _killed(self, manager: Manager, hits: Sequence[Hit]) -> dict[DecisionEffect, int]:
        """Return by slot where it is among the targets."""
        found: dict[DecisionEffect, int] = {}
        for where, targets, _ in hits:
            for name, at in targets:
                for slot in range(self.analysis.loop.model.request[name].instances) if at is None else [at]:
                    found["kill", name, slot] = manager.either(found.get(("kill", name, slot), NO), where)
        return found

    def _differing(
        self, change: _Change, cell: Cell, choice: tuple[int, ...], states: Set, asked: bool
    ) -> Iterator[Set]:
        """Yield, effect by effect, those of some states in which the decision on a newcomer is another."""
        space, where = self.analysis.space, self.equivalence.where
        conditions = [(condition, states & self._met(effect)) for effect, condition in change.effects.items()]
        if asked and change.superseding != NO:
            empty = self._empty(change.number)
            conditions = [(condition, among & empty) for condition, among in conditions]
            conditions.insert(0, (change.superseding, states & ~empty))
        for condition, among in conditions:
            found = where(change.manager, condition, change.number, cell, choice, among)
            if found != space.none:
                yield found

    def _met(self, effect: DecisionEffect) -> Set:
        """Return the states in which an effect is one: a slot that runs is killed, a place that is taken emptied."""
        loop, space = self.analysis.loop, self.analysis.space
        match effect:
            case ("kill", str(name), int(slot)):
                first = loop.tables.requests[loop.request_number[name]].slots
                return space.is_value(loop.index["phase", first + slot], RUNNING)
            case ("dismiss", str(name)):
                return ~self._empty(loop.request_number[name])
            case _:
                return space.all

    def _empty(self, number: int) -> Set:
        """Return the states in which nothing stands in the waiting place of a request."""
        place = self.analysis.loop.index.get(("place", number))
        return self.analysis.space.all if place is None else self.analysis.space.is_value(place, IDLE)

    # ---- where decisions are taken ----

    def _at_first(self, number: int) -> Iterator[_DecisionPoint]:
        """Yield for all arguments the states in which an ask is decided, unless assumptions forbid some steps."""
        loop, space = self.analysis.loop, self.analysis.space
        if self.analysis.stepper.allowed != space.all:
            return
        arguments, states = loop.arguments[number], self.analysis.stepper.universe
        if not loop.model.requests[number].interrupts_self:
            states = states & self._empty(number)
        for cell in arguments.cells:
            for choice in arguments.choices():
                so = states
                for which, order in enumerate(arguments.poster_orders):
                    value, poster = float(cell.args[order.left]), -1 - order.right
                    cases = range(len(loop.samples[poster]))
                    fitting = [c for c in cases if choice[which] in loop.orders[number].feasible(which, value, c)]
                    so = so & space.among(loop.index["reading", poster], fitting)
                yield cell, choice, so, True

    def _within(self, number: int) -> Iterator[_DecisionPoint]:
        """Yield for all arguments the states within allowed steps in which a newcomer is decided, or one that waits.

        An ask that does the same as another is looked at where that one is.
        """
        for walk, newcomer in self.analysis.loop.decided:
            states = self._deciding.get(walk)
            if newcomer.request == number and states is not None:
                yield newcomer.cell, newcomer.choice, states, not newcomer.settling

    @cached_property
    def _deciding(self) -> dict[Walk, Set]:
        """By walk the states that come to it in allowed steps."""
        found: dict[Walk, Set] = {}
        for walk, _ in self.analysis.loop.decided:
            if id(walk) in self._met_states:
                found[walk] = found.get(walk, self.analysis.space.none) | self._met_states[id(walk)]
        return found

    @cached_property
    def _met_states(self) -> dict[int, Set]:
        """By identity of a walk the states that come to it in allowed steps; by `PASS` those that begin a pass."""
        stepper, space = self.analysis.stepper, self.analysis.space
        if stepper.universe == space.all:
            raise TooLarge("what is decided within the steps of so large a spec is not followed")
        states = self.analysis.reached
        found: dict[int, Set] = {PASS: space.none}
        stepper.image.noted = found
        for number in range(len(self.analysis.loop.events)):
            free = stepper.allowed == space.all
            stepper.post(states if free else states & stepper.pre(space.all, number), number)
        stepper.image.noted = None
        return found

    # ---- restoring ----

    def _restores(self, rules: Sequence[Rule]) -> bool:
        """Return whether without these rules other slots are killed when rules are restored."""
        analysis, questions = self.analysis, self.equivalence.questions
        restored = [rule for rule in analysis.loop.model.rules if questions.restored(rule)]
        left = [rule for rule in restored if all(rule is not other for other in rules)]
        if len(left) == len(restored):
            return False
        manager = Manager()
        decider = Decider(questions, manager)
        with deep():
            mine = self._killed(manager, decider.restore(restored))
            its = self._killed(manager, decider.restore(left))
            different = _different(manager, mine, its)
        begun = self._met_states[PASS]
        return any(
            self.equivalence.holding(manager, condition, begun & self._met(effect)) != analysis.space.none
            for effect, condition in different.items()
            if condition != NO
        )


def _any(manager: Manager, hits: Sequence[Hit]) -> int:
    found = NO
    for where, _, _ in hits:
        found = manager.either(found, where)
    return found


def _different(
    manager: Manager, mine: dict[DecisionEffect, int], its: dict[DecisionEffect, int]
) -> dict[DecisionEffect, int]:
    """Return by effect where one has it and the other has not, if that can be anywhere."""
    found = {}
    for effect in {**mine, **its}:
        left, right = mine.get(effect, NO), its.get(effect, NO)
        if left != right:
            found[effect] = manager.ite(left, manager.negate(right), right)
    return found
