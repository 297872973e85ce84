"""From rules to decisions: for each event a diagram of the actions (docs/language.md section 4).

The paragraphs of the page are followed one by one, as in `model/semantics.py`, but for all states at once: a condition
that the interpreter evaluates in one state is here a diagram, the set of states where it holds. "Where" means this set.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.conditions import fulfilled
from exover.model.decision import BUSY, Reason, kills_first, verdict_without_kill
from exover.model.expression import And, Compare, Cond, Const, Level, Not
from exover.model.model import Guard, Kill, KillRemedy, KillSlot, Launch, Reject, Remedy, Request, Rule, Wait
from exover.model.waiting import killed, killed_requests
from exover.ocrd.decision import (
    DecisionList,
    Do,
    DoAgree,
    DoDismiss,
    DoReject,
    DoSettle,
    DoViolation,
    DoWait,
    kills,
)
from exover.ocrd.decision_context import DecisionContext, SymbolicInstance
from exover.ocrd.diagram import NO, YES, Manager
from exover.ocrd.symbolic import ConditionDiagrams
from exover.ocrd.view import PRESENT, KillTarget, ParameterOwner, View

Hit = tuple[int, tuple[KillTarget, ...], Reason]
"""A condition, the slots that are cleared or killed where it holds, and the reason."""


@dataclass(frozen=True)
class Decider:
    """Builds the diagrams of one model in one manager."""

    questions: DecisionContext
    manager: Manager

    @cached_property
    def symbolic(self) -> ConditionDiagrams:
        """The translation of conditions to diagrams."""
        return ConditionDiagrams(self.questions.numbers, self.manager)

    # ---- roots ----

    def predicate(self, request: str, where: Cond) -> int:
        """Return `DoAgree` where the loaded arguments (and results) satisfy `where`."""
        return self._agree(self.symbolic.truth(where, PRESENT, ParameterOwner(request)))

    def condition(self, cond: Cond) -> int:
        """Return `DoAgree` where a condition without parameters holds."""
        return self._agree(self.symbolic.truth(cond))

    def required(self, launch: Launch) -> int:
        """Return `DoAgree` where the condition of the launch rule holds and its request is neither active nor waiting
        with the same arguments.
        """
        due = And((launch.condition, Not(fulfilled(self.questions.model, launch))))
        return self._agree(self.symbolic.truth(due))

    def _agree(self, where: int) -> int:
        return self.manager.ite(where, self.manager.act(DoAgree(), NO), NO)

    def recover(self, instance: SymbolicInstance) -> int:
        """Return, where F holds with the stopping slots taken as idle, the kills of the first remedy that helps, else
        a violation.
        """
        stopped = View(once_stopped=True)
        left = self._true(instance, stopped)
        result = self.manager.act(DoViolation(instance.reason), NO)
        chain: list[tuple[int, list[KillTarget]]] = []
        for remedy in instance.rule.remedies:
            targets = self._targets(remedy, instance)
            if targets:
                helps = self.manager.negate(self._true(instance, self._more_idle(stopped, targets, YES)))
                chain.append((self.manager.both(left, helps), targets))
        for helps, targets in reversed(chain):
            result = self.manager.ite(helps, kills(self.manager, targets, instance.reason, NO), result)
        return self.manager.ite(left, result, NO)

    def broken(self, instance: SymbolicInstance) -> int:
        """Return a violation where the F of a rule holds with the stopping slots as they are."""
        return self.manager.ite(self._true(instance, PRESENT), self.manager.act(DoViolation(instance.reason), NO), NO)

    def decide(self, request: Request, rules: Iterable[Rule] | None = None) -> DecisionList:
        """Return the decision on a newcomer of this request with the loaded arguments.

        `rules`, in their order, replace the rules in question.
        """
        view = View(newcomer=request)
        asked = self.questions.rules[request.name] if rules is None else rules
        instances = [i for rule in asked for i in self.questions.instances(rule, request)]
        for choice, _ in self._choices(request, instances):
            self.manager.level(choice)  # above what it selects from, which another may have selected from before
        busy: list[tuple[int, Do]] = []
        if not request.interrupts_self:
            busy = [(self.symbolic.at_least_active(request.name, request.instances), DoReject(BUSY))]
        view, hits = self._clear(view, [(i, list(kills_first(i.rule.remedies))) for i in instances])
        demands = (*busy, *self._demands(request, view, instances))
        return DecisionList(self.choices(request, instances), demands, tuple(hits))

    def restore(self, rules: Iterable[Rule]) -> list[Hit]:
        """Return, in order, where recovering from exactly these rules kills which slots, and why."""
        instances = [i for rule in rules for i in self.questions.instances(rule, None)]
        return self._clear(View(once_stopped=True), [(i, i.rule.kills) for i in instances])[1]

    def choices(self, request: Request, instances: Iterable[SymbolicInstance]) -> dict[int, set[int]]:
        """Return for each argument that selects a counter of a condition (`self.p` inside `with`) these counters.

        Both are elements. Only counters that have numbers by now are found: build the conditions first.
        """
        found: dict[int, set[str]] = {}
        for choice, of in self._choices(request, instances):
            found.setdefault(choice, set()).add(of)
        return {choice: self.symbolic.counting(requests) for choice, requests in found.items()}

    def _choices(self, request: Request, instances: Iterable[SymbolicInstance]) -> Iterator[tuple[int, str]]:
        """Yield each argument that selects a counter, an element, with the request that is counted."""
        for guard in request.guards:
            yield from self.symbolic.choices(guard.condition, ParameterOwner(request.name))
        for instance in instances:
            if owner := instance.owner:
                yield from self.symbolic.choices(instance.rule.condition, owner)

    # ---- clearing ----

    def _clear(self, view: View, instances: list[tuple[SymbolicInstance, list[KillRemedy]]]) -> tuple[View, list[Hit]]:
        """Return the view with C taken as idle, and, in order, where which targets are put into C, and why.

        `instances`: each with those of its remedies that are kills and may apply.
        """
        hits: list[Hit] = []
        for instance, killing in instances:
            left = self._true_either_way(instance, view) if killing else NO
            for remedy in killing:
                if left == NO:
                    break
                targets = self._targets(remedy, instance)
                still = self._true_either_way(instance, self._more_idle(view, targets, YES))
                hit = self.manager.both(left, self.manager.negate(still))
                left = self.manager.both(left, still)
                if hit != NO:
                    hits.append((hit, tuple(targets), instance.reason))
                    view = self._more_idle(view, targets, hit)
        return view, hits

    def _more_idle(self, view: View, targets: list[KillTarget], where: int) -> View:
        idle = dict(view.idle)
        for name, slot in targets:
            before = idle.get(name, {})
            idle[name] = before | {slot: self.manager.either(before.get(slot, NO), where)}
        return replace(view, idle=idle)

    # ---- demands ----

    def _demands(self, request: Request, view: View, instances: list[SymbolicInstance]) -> list[tuple[int, Do]]:
        """Return the demands, each with the condition under which it is made, in the order of the text."""
        found: list[tuple[int, int, Do]] = []
        present = View(idle=view.idle)
        for guard in request.guards:
            holds = self.symbolic.truth(guard.condition, present, ParameterOwner(request.name))
            found.append((guard.place, self.manager.negate(holds), _guard_demand(guard)))
        found += self._shortages(request)
        for instance in instances:
            rule, true = instance.rule, self._true_either_way(instance, view)
            found.append((rule.place, true, _verdict(rule.remedies, instance.reason)))
            if request.name in killed(rule):
                found += [(rule.place, where, do) for where, do in self._if_clearing(request, view, instance, true)]
        found.sort(key=lambda demand: demand[0])
        return [(where, do) for _, where, do in found if where != NO]

    def _shortages(self, request: Request) -> Iterator[tuple[int, int, Do]]:
        """Yield the demands of `consumes` clauses: each where it is the first of its resource to count and the level
        is too low.
        """
        subject = ParameterOwner(request.name)
        earlier: dict[str, int] = {}
        for clause in request.consumptions:
            resource = self.questions.model.resource[clause.resource]
            counts = YES if clause.when is None else self.symbolic.truth(clause.when, PRESENT, subject)
            first = self.manager.both(counts, self.manager.negate(earlier.get(resource.name, NO)))
            earlier[resource.name] = self.manager.either(earlier.get(resource.name, NO), counts)
            short = self.symbolic.truth(Compare("<", Level(resource.name), ZERO), View(newcomer=request))
            reason = Reason(resource.name, self.questions.model.text(clause))
            yield clause.place, self.manager.both(first, short), _verdict(resource.remedies, reason)

    def _if_clearing(
        self, request: Request, view: View, instance: SymbolicInstance, true: int
    ) -> Iterator[tuple[int, Do]]:
        """Yield the demands of a rule that may kill the newcomer, for F with the clearing requests running too; none
        where F holds without them (`true`).
        """
        rule = instance.rule
        clearing = self.questions.clearable - {request.name}
        running = replace(view, clearing=clearing)
        left = self.manager.both(self.manager.negate(true), self._true_either_way(instance, running))
        for remedy in rule.remedies:
            if left == NO:
                return
            if isinstance(remedy, Reject | Wait):
                yield left, _verdict((remedy,), instance.reason)
                return
            spared = [name for name in killed_requests(remedy, rule) if name != request.name]
            without = replace(running, clearing=clearing - set(spared))
            without = self._more_idle(without, self._targets(remedy, instance), YES)
            still = self._true_either_way(instance, without)
            helps = self.manager.both(left, self.manager.negate(still))
            left = self.manager.both(left, still)
            if helps != NO:
                yield from ((helps, DoDismiss(name, instance.reason)) for name in spared)
        yield left, DoReject(instance.reason)

    # ---- rules ----

    def _true(self, instance: SymbolicInstance, view: View) -> int:
        """Return where the F of a rule holds in a supposed state."""
        rule = instance.rule
        both = self.questions.pairs[id(rule)]
        if both and view.newcomer and view.newcomer.name in both:
            other = both[both[0] == view.newcomer.name]
            if not view.touches(other):  # all that is left to ask, most often
                return self.symbolic.at_least_active(other, 1, view)
        owner = instance.owner
        if owner is None or owner.slot is None:
            return self.symbolic.truth(rule.condition, view, owner)
        active = self.symbolic.slot_active(owner.request, owner.slot, view)
        return self.manager.both(active, self.symbolic.truth(rule.condition, view, owner))

    def _true_either_way(self, instance: SymbolicInstance, view: View) -> int:
        """Return where F holds with the stopping slots as they are, or with them taken as idle."""
        as_is = self._true(instance, view)
        if self.questions.growing[id(instance.rule)]:
            return as_is
        return self.manager.either(as_is, self._true(instance, replace(view, once_stopped=True)))

    def _targets(self, remedy: Remedy, instance: SymbolicInstance) -> list[KillTarget]:
        """Return the slots that a kill remedy names, in order, without the newcomer's; none for other remedies."""
        match remedy:
            case Kill(requests):
                return [(name, None) for name in requests]
            case KillSlot():
                rule = instance.rule
                return [(rule.slot_of, instance.slot)] if rule.slot_of and not instance.newcomer else []
            case Reject() | Wait():
                return []
            case _:
                assert_never(remedy)


def _guard_demand(guard: Guard) -> Do:
    reason = Reason(guard.name, guard.because)
    match guard.kind:
        case "check":
            return DoReject(reason)
        case "wait":
            return DoWait(reason)
        case "settle":
            return DoSettle(reason)
        case _:
            assert_never(guard.kind)


def _verdict(remedies: tuple[Remedy, ...], reason: Reason) -> Do:
    return DoReject(reason) if verdict_without_kill(remedies) == "reject" else DoWait(reason)


ZERO = Const(0)
