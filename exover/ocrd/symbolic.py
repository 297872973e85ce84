"""Conditions as diagrams over the state vector, for the present state or one that a decision supposes."""

from collections.abc import Collection, Iterator
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    ModelTerm,
    Not,
    Operator,
    Or,
    Own,
    Param,
    Past,
    Phase,
    Reading,
    Status,
    Sum,
    Used,
    atoms,
)
from exover.model.model import Forget, Request, SetState
from exover.model.types import Real, Type, ordinal
from exover.ocrd.diagram import NO, YES
from exover.ocrd.forms import Case, Factors, add, scale
from exover.ocrd.own_parameters import OwnParameters, own_names
from exover.ocrd.reals import RealComparisons
from exover.ocrd.remaining_slots import RemainingSlots
from exover.ocrd.vector import (
    OUTCOMES,
    Arg,
    HasPast,
    InPlace,
    LastOutcome,
    PlaceValue,
    Quantity,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
)
from exover.ocrd.view import PRESENT, ParameterOwner, Phases, View

MOST_SELECTED = 256
"""Combinations of values of `self.p` of which each selects a counter in a guard, as many as one may have values."""


@dataclass(frozen=True)
class ConditionDiagrams(RealComparisons):
    """Translates conditions and terms of one model to diagrams of one manager."""

    # ---- conditions ----

    def truth(self, cond: Cond, view: View = PRESENT, subject: ParameterOwner | None = None) -> int:
        """Return the diagram that is `YES` exactly where the condition holds in the supposed state."""
        if subject and subject.held and self.vocabulary.pure(cond):
            return self.at_least(self._holding(subject, cond), 1)
        match cond:
            case Compare(op, left, right):
                return self._compare(op, left, right, view, subject)
            case Status(phase, request, None):
                return self._status(phase, request, None, view)
            case Status(phase, request, where) if where and subject and self._by_holder(request, where, subject):
                return self._any(list(self._holders(phase, request, where, view, subject)))
            case Status(phase, request, where):
                parts = self._without_own(where, subject)
                return self._any([self.manager.both(g, self._status(phase, request, w, view)) for g, w in parts])
            case Past(request, where):
                return NO if self._forgotten(request, view) else self._past(request, where, subject)
            case Last(request, outcome):
                return self.equal(self.form(LastOutcome(request)), OUTCOMES.index(outcome))
            case Not(part):
                return self.manager.negate(self.truth(part, view, subject))
            case And(parts):
                return self._all([self.truth(part, view, subject) for part in self._grouped(cond, parts, subject)])
            case Or(parts):
                if view.newcomer and Status("active", view.newcomer.name) in parts:
                    return YES
                return self._any([self.truth(part, view, subject) for part in self._grouped(cond, parts, subject)])
            case _:
                assert_never(cond)

    def at_least_active(self, request: str, count: int, view: View = PRESENT) -> int:
        """Return where at least `count` slots of the request are active; the view must not touch the request."""
        return self.at_least(self._slots_form(request, None, None, view.phases), count)

    def slot_active(self, request: str, slot: int, view: View) -> int:
        """Return where this one slot is active in the supposed state."""
        return self._slot_in(view.phases, request, slot, view)

    def _slot_in(self, phases: Phases, request: str, slot: int, view: View) -> int:
        idle = view.idle.get(request, {})
        cases = self._unless(
            self.manager.either(idle.get(None, NO), idle.get(slot, NO)),
            self._slots_form(request, slot, None, phases),
        )
        return self.compare_cases(">=", cases, 1)

    def _by_holder(self, request: str, where: Cond, subject: ParameterOwner) -> bool:
        """Return whether `self.p` is compared with what each slot holds; else its value selects a counter.

        A guard selects once, by the values of the newcomer, if these are not too many in all their combinations. The
        copies of a rule would each select, and what is supposed of one slot depends on the others. Comparisons with few
        slots have fewer outcomes than there are values, and the slots of the rule's own request are told apart in any
        case, since each is killed alone.
        """
        if not own_names(where):
            return False
        slots = self.vocabulary.model.request[request].instances
        values = OwnParameters(self.vocabulary, subject).number(where)
        if subject.of_copy:
            return request == subject.request or 1 << slots <= values
        return values > MOST_SELECTED and slots < values

    def _holders(self, phase: Phase, request: str, where: Cond, view: View, subject: ParameterOwner) -> Iterator[int]:
        """Yield of each that can be in a phase (slots, the newcomer, the waiting place) where it is so in the supposed
        state, with arguments that satisfy `where`; its `self.p` are those of the subject.
        """
        if phase != "waiting":
            phases: Phases = view.phases if phase == "active" else (phase,)
            for slot in range(self.vocabulary.model.request[request].instances):
                there = self._slot_in(phases, request, slot, view)
                if there != NO:
                    owner = ParameterOwner(request, slot, clause=subject)
                    yield self.manager.both(there, self.truth(where, PRESENT, owner))
        if phase == "active" and view.newcomer and view.newcomer.name == request:
            yield self.truth(where, PRESENT, ParameterOwner(request, clause=subject))
        clearing = phase == "active" and request in view.clearing
        if phase == "waiting" or clearing:
            places = [InPlace(request, None, "clearing"), *([] if clearing else [InPlace(request, None, "waiting")])]
            there = self.at_least(self.form(*places), 1)
            owner = ParameterOwner(request, in_place=True, clause=subject)
            yield self.manager.both(there, self.truth(where, PRESENT, owner))

    def _any(self, parts: list[int]) -> int:
        found = NO
        for part in reversed(parts):  # the last part tests the lowest entries: diagrams grow from below
            found = self.manager.either(part, found)
        return found

    def _all(self, parts: list[int]) -> int:
        found = YES
        for part in reversed(parts):
            found = self.manager.both(part, found)
        return found

    def _grouped(self, cond: And | Or, parts: tuple[Cond, ...], subject: ParameterOwner | None) -> tuple[Cond, ...]:
        """Return the parts, with those that read only the arguments of a slot joined, so one counter serves all."""
        if not subject or not subject.held:
            return parts
        pure = tuple(part for part in parts if self.vocabulary.pure(part))
        if len(pure) < 2:
            return parts
        return (type(cond)(pure), *(part for part in parts if part not in pure))

    def _status(self, phase: Phase, request: str, where: Cond | None, view: View) -> int:
        match phase:
            case "waiting":
                places = (InPlace(request, where, "waiting"), InPlace(request, where, "clearing"))
                return self.at_least(self.form(*places), 1)
            case "active":
                if where is None and view.newcomer and view.newcomer.name == request:
                    return YES
                if not view.touches(request):
                    return self.at_least(self._slots_form(request, None, where, view.phases), 1)
                return self.compare_cases(">=", self._active(request, where, view), 1)
            case "running":
                return self.compare_cases(">=", self._slots(request, where, view, ("running",)), 1)
            case "stopping":
                return self.compare_cases(">=", self._slots(request, where, view, ("stopping",)), 1)
            case _:
                assert_never(phase)

    def _past(self, request: str, where: Cond | None, subject: ParameterOwner | None) -> int:
        """Return where the request has a past that satisfies `where`.

        There is at most one past, so connectives can be split. A part with one `self.p` then needs a flag for each
        value of p, not for each combination of values of all parameters.
        """
        if where is not None and own_names(where):
            own = OwnParameters(self.vocabulary, subject)
            match where:
                case Not(part):
                    known = self.at_least(self.form(HasPast(request, None)), 1)
                    return self.manager.both(known, self.manager.negate(self._past(request, part, subject)))
                case And(parts):
                    return self._all([self._past(request, part, subject) for part in own.in_order(And, parts)])
                case Or(parts):
                    return self._any([self._past(request, part, subject) for part in own.in_order(Or, parts)])
        flags = self._without_own(where, subject)
        return self._any([self.manager.both(g, self.at_least(self.form(HasPast(request, w)), 1)) for g, w in flags])

    def _forgotten(self, request: str, view: View) -> bool:
        effects = view.newcomer.on_launch if view.newcomer else ()
        return any(isinstance(effect, Forget) and request in effect.requests for effect in effects)

    def choices(self, cond: Cond, subject: ParameterOwner) -> Iterator[tuple[int, str]]:
        """Yield the element of each `self.p` inside a `where`, with the request of which it selects a counter."""
        for atom in atoms(cond):
            if not isinstance(atom, Status | Past) or atom.where is None:
                continue
            if isinstance(atom, Past) or not self._by_holder(atom.request, atom.where, subject):
                for name in own_names(atom.where):
                    yield self.numbers.element(self.form(self._argument(name, subject)))[0], atom.request

    def counting(self, requests: Collection[str]) -> set[int]:
        """Return the elements so far with a counter or flag of these requests that has a condition on arguments."""
        return {
            number
            for number, element in enumerate(self.numbers.elements)
            for _, quantity in element
            if isinstance(quantity, HasPast | Slots | InPlace) and quantity.where and quantity.request in requests
        }

    def _without_own(self, where: Cond | None, subject: ParameterOwner | None) -> Iterator[tuple[int, Cond | None]]:
        """Yield `(guard, where')` for each choice of values of every `self.p`: `guard` says that these are the values,
        and `where'` is `where` with them substituted, None if it is true. Choices that make it false are left out.
        """
        if where is None or where == TRUE:
            yield YES, None
            return
        if not own_names(where):
            yield YES, where
            return
        assert subject is not None
        for choice, chosen in OwnParameters(self.vocabulary, subject).chosen(where):
            guard = self._all(
                [self.equal(self.form(self._argument(name, subject)), number) for name, number in choice.items()]
            )
            if chosen != FALSE:
                yield guard, None if chosen == TRUE else chosen

    # ---- comparisons ----

    def _compare(
        self, op: Operator, left: ModelTerm, right: ModelTerm, view: View, subject: ParameterOwner | None
    ) -> int:
        kind = self._type(left, subject) or self._type(right, subject)
        if isinstance(kind, Real):
            return self.compare_reals(op, left, right, subject)
        minus = [(g, {q: -f for q, f in form.items()}, -c) for g, form, c in self._cases(right, kind, view, subject)]
        return self.compare_cases(op, self.added([self._cases(left, kind, view, subject), minus]), 0)

    def _type(self, term: ModelTerm, subject: ParameterOwner | None) -> Type | None:
        """Return the type of a parameter, reading or real constant; None for any other term."""
        match term:
            case Param(name):
                assert subject is not None
                return self.vocabulary.parameter_types[subject.request, name]
            case Own(name):
                assert subject is not None and subject.clause is not None
                return self.vocabulary.parameter_types[subject.clause.request, name]
            case Reading(name):
                return self.vocabulary.reading_type(name)
            case Const(float()):
                return Real()
            case _:
                return None

    # ---- terms ----

    def _cases(self, term: ModelTerm, kind: Type | None, view: View, subject: ParameterOwner | None) -> list[Case]:
        match term:
            case Const(value):
                return [(YES, {}, ordinal(kind, value) if kind else int(value))]
            case Param(name):
                assert subject is not None
                return [(YES, self.form(self._argument(name, subject)), 0)]
            case Own(name):
                assert subject is not None and subject.clause is not None
                return [(YES, self.form(self._argument(name, subject.clause)), 0)]
            case Reading(name):
                fixed = self._set_by_launch(name, view)
                if fixed is not None:
                    return [(YES, {}, ordinal(self.vocabulary.reading_type(name), fixed.value))]
                return [(YES, self.form(VariableValue(name)), 0)]
            case Level(resource):
                return self.added([[(YES, self.form(Stock(resource)), 0)], self.consumed(resource, view.newcomer, -1)])
            case Used() | Count():
                return self._total(term, view)
            case Sum(constant, terms):
                parts = [scale(self._cases(part, None, view, subject), factor) for factor, part in terms]
                return self.added([[(YES, {}, constant)], *parts])
            case _:
                assert_never(term)

    def _argument(self, name: str, subject: ParameterOwner) -> Quantity:
        if subject.in_place:
            return PlaceValue(subject.request, name)
        if subject.slot is not None:
            return SlotValue(subject.request, subject.slot, name)
        return Arg(subject.request, name)

    def _set_by_launch(self, name: str, view: View) -> SetState | None:
        effects = view.newcomer.on_launch if view.newcomer else ()
        found = [effect for effect in effects if isinstance(effect, SetState) and effect.state == name]
        return found[-1] if found else None

    def consumed(self, resource: str, newcomer: Request | None, sign: int = 1) -> list[Case]:
        """Return `sign` times the amount of a resource that the newcomer consumes, by cases of its arguments."""
        clauses = [c for c in newcomer.consumptions if c.resource == resource] if newcomer else []
        return self.added([self._if_argument(newcomer, c.when, sign * c.amount) for c in clauses if newcomer])

    def _if_argument(self, newcomer: Request, where: Cond | None, amount: int) -> list[Case]:
        guard = self.truth(where or TRUE, PRESENT, ParameterOwner(newcomer.name))
        cases: list[Case] = [(guard, {}, amount), (self.manager.negate(guard), {}, 0)]
        return [case for case in cases if case[0] != NO]

    def _total(self, term: Used | Count, view: View) -> list[Case]:
        """Return the value of the term in the supposed state, by cases."""
        counted = self.vocabulary.counted(term)
        parts: list[list[Case]] = [[(YES, self._plain_total(term, view), 0)]]
        for request in filter(view.touches, counted):
            for where, amount in counted[request]:
                present = self._slots_form(request, None, where, view.phases)
                parts.append(scale([(YES, present, 0)], -amount))
                parts.append(scale(self._active(request, where, view), amount))
        return self.added(parts)

    def _plain_total(self, term: Used | Count, view: View) -> Factors:
        """Return the value of the term in the present state; with `view.once_stopped`, over the running slots only."""
        key = (term, view.once_stopped)
        if key not in self.numbers.totals:
            total = self.numbers.totals[key] = {}
            for request, clauses in self.vocabulary.counted(term).items():
                for where, amount in clauses:
                    add(total, self._slots_form(request, None, where, view.phases), amount)
        return self.numbers.totals[key]

    def _active(self, request: str, where: Cond | None, view: View) -> list[Case]:
        """Return the number of active slots of a request whose arguments satisfy `where`, by cases."""
        parts = [self._slots(request, where, view, view.phases)]
        if view.newcomer and view.newcomer.name == request:
            parts.append(self._if_argument(view.newcomer, where, 1))
        if request in view.clearing:
            parts.append([(YES, self.form(InPlace(request, where, "clearing")), 0)])
        return self.added(parts) if len(parts) > 1 else parts[0]

    def _slots(self, request: str, where: Cond | None, view: View, phases: Phases) -> list[Case]:
        """Return the number of slots in these phases, without those that the view takes as idle, by cases."""
        idles = view.idle.get(request, {})
        whole = idles.get(None, NO)
        slots = range(self.vocabulary.model.request[request].instances)
        if not idles or (len(slots) > 1 and idles.keys() == {None}):
            return self._unless(whole, self._slots_form(request, None, where, phases))
        idle = [self.manager.either(whole, idles.get(slot, NO)) for slot in slots]
        kinds = RemainingSlots(self.numbers, self.manager).kinds(request, idle, phases)
        if kinds is None:
            parts = [self._unless(idle[slot], self._slots_form(request, slot, where, phases)) for slot in slots]
        else:
            parts = [
                self._unless(left, self._slots_form(request, None, _joined(where, kept), phase))
                for left, phase, kept in kinds
            ]
        return self.added(parts)

    def _unless(self, idle: int, form: Factors) -> list[Case]:
        """Return `form` as cases, 0 where `idle` holds; the constant 0 if `form` is 0 wherever `idle` does not hold."""
        if idle == NO:
            return [(YES, form, 0)]
        rest = self.manager.both(self.manager.negate(idle), self.at_least(form, 1))
        if rest == NO:
            return [(YES, {}, 0)]
        return [(idle, {}, 0), (self.manager.negate(idle), form, 0)]

    def _holding(self, owner: ParameterOwner, where: Cond) -> Factors:
        """Return 1 where a slot or waiting place holds arguments that satisfy `where`, else 0."""
        if owner.in_place:
            return self.form(*(InPlace(owner.request, where, phase) for phase in ("waiting", "clearing")))
        return self._slots_form(owner.request, owner.slot, where, ("running", "stopping"))

    def _slots_form(self, request: str, slot: int | None, where: Cond | None, phases: Phases) -> Factors:
        key = (request, slot, where, phases)
        if key not in self.numbers.counters:
            single = self.vocabulary.model.request[request].instances == 1
            kept = None if where == TRUE else where
            form = self.form(*(Slots(request, None if single else slot, kept, phase) for phase in phases))
            self.numbers.counters[key] = form
        return self.numbers.counters[key]


def _joined(where: Cond | None, other: Cond | None) -> Cond | None:
    """Return the conjunction of two conditions on arguments; None is true."""
    if where is None or where == TRUE:
        return other
    return And((where, other)) if other else where
