"""What a check claims, as SMT-LIB over the state and the facts that the checker of certificates knows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal, assert_never

from exover.model.expression import (
    And,
    Compare,
    Cond,
    Const,
    Count,
    Last,
    Level,
    Not,
    Or,
    Own,
    Param,
    Past,
    Reading,
    Status,
    Sum,
    Term,
    Used,
)
from exover.model.model import Model
from exover.model.property import (
    FALSE,
    TRUE,
    Atom,
    Broken,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Passed,
    SomeNext,
    SomeUntil,
)
from exover.model.types import Bool, Int, Real, Type, Value, ordinal
from exover.ocrd.reasons import reasons
from exover.ocrd.vector import OUTCOMES
from exover.verify.claim import Claim

Json = dict[str, Any]
Names = Mapping[str, tuple[str, Type]]
"""What stands for each parameter, with its type."""
FACTS = {"asked": "asked", "launched": "launch", "rejected": "reject", "killed": "kill", "ended": "ended"}


class Unsaid(Exception):
    """The claim cannot be said of the state and the facts; the text says why."""


@dataclass(frozen=True)
class Statement:
    """Says claims about one model."""

    model: Model

    @cached_property
    def request(self) -> dict[str, int]:
        """The numbers of the requests."""
        return {request.name: number for number, request in enumerate(self.model.requests)}

    @cached_property
    def first_slot(self) -> dict[str, int]:
        """The number of the first slot of each request among all."""
        found, slot = {}, 0
        for request in self.model.requests:
            found[request.name] = slot
            slot += request.instances
        return found

    @cached_property
    def readings(self) -> dict[str, tuple[str, Type]]:
        """What stands for each poster, state and latch."""
        kinds = [(v.name, v.type) for v in self.model.variables] + [
            (latch.name, Bool()) for latch in self.model.latches
        ]
        return {name: (f"reading.{number}", kind) for number, (name, kind) in enumerate(kinds)}

    @cached_property
    def levels(self) -> dict[str, str]:
        """What stands for the level of each consumable."""
        stocks = [resource.name for resource in self.model.resources if resource.consumable]
        return {name: f"level.{number}" for number, name in enumerate(stocks)}

    def slots(self, request: str) -> range:
        """Return the numbers of a request's slots."""
        return range(self.first_slot[request], self.first_slot[request] + self.model.request[request].instances)

    def params(self, request: str, prefix: str, results: bool = False) -> Names:
        """Return what stands for the parameters of what a slot, a waiting place or the past holds."""
        declared = self.model.request[request]
        fields = (*declared.params, *(declared.results if results else ()))
        return {field.name: (f"{prefix}.{k}", field.type) for k, field in enumerate(fields)}

    # ---- claims ----

    def claim(self, shape: "Shape") -> Json:
        """Return a claim in one of the forms of docs/certificates.md."""
        match shape:
            case Always(part, "first"):
                return {"always": disjunction(["(not start)", self.moment(part)])}
            case Always(part, "later"):
                return {"always": disjunction(["start", self.moment(part)])}
            case Always(part):
                return {"always": self.moment(part)}
            case Possible(now, later):
                after = conjunction(["(not start)", self.moment(later)])
                return {"possible": self.moment(now) if later == FALSE else disjunction([self.moment(now), after])}
            case Recoverable(since, allowed, goal):
                parts = {"since": since, "allowed": allowed, "goal": goal}
                return {"recoverable": {name: self.moment(part) for name, part in parts.items()}}
            case _:
                assert_never(shape)

    def moment(self, formula: Formula) -> str:
        """Return a formula of one moment."""
        match formula:
            case Atom(condition):
                return self.condition(condition)
            case Happened(occurrence, request, None):
                return f"{FACTS[occurrence]}.{self.request[request]}"
            case Happened():
                raise Unsaid("the checker does not know with which arguments something happened")
            case Passed(("launch", request)):
                return f"launch.{self.request[request]}"
            case Passed(("rule", name)):
                known = enumerate(reasons(self.model))
                return disjunction([f"named.{number}" for number, reason in known if reason.rule == name])
            case Passed(("abort",)):
                return "abort"
            case Passed():
                raise Unsaid("the checker does not know which demand has decided")
            case Broken(rule, calm):
                if rule.slot_of is None:
                    return self.condition(rule.condition, calm)
                found = []
                for slot in self.slots(rule.slot_of):
                    held = self.condition(rule.condition, calm, self.params(rule.slot_of, f"arg.{slot}"))
                    found.append(conjunction([phase(slot, "running" if calm else "active"), held]))
                return disjunction(found)
            case Negation(part):
                return f"(not {self.moment(part)})"
            case Conjunction(parts):
                return conjunction([self.moment(part) for part in parts])
            case Disjunction(parts):
                return disjunction([self.moment(part) for part in parts])
            case _:
                raise Unsaid("the claim is none of the forms that have proofs")

    # ---- conditions ----

    def condition(self, cond: Cond, calm: bool = False, params: Names | None = None, own: Names | None = None) -> str:
        """Return a condition; `calm` takes the stopping slots as idle, `params` and `own` are as in `Scope`."""
        match cond:
            case Compare():
                return self._compare(cond, calm, params or {}, own or {})
            case Status("waiting", request, where):
                number = self.request[request]
                there = f"(not (= place.{number} 0))"
                return conjunction([there, *self._where(request, f"held.{number}", where, params)])
            case Status(kind, request, where):
                found = []
                for slot in self.slots(request):
                    held = self._where(request, f"arg.{slot}", where, params)
                    there = "running" if calm and kind == "active" else kind
                    found.append("false" if calm and kind == "stopping" else conjunction([phase(slot, there), *held]))
                return disjunction(found)
            case Past(request, where):
                number = self.request[request]
                inner = self.params(request, f"past.{number}", results=True)
                held = [] if where is None else [self.condition(where, False, inner, params)]
                return conjunction([f"past.{number}", *held])
            case Last(request, outcome):
                return f"(= last.{self.request[request]} {OUTCOMES.index(outcome)})"
            case Not(part):
                return f"(not {self.condition(part, calm, params, own)})"
            case And(parts):
                return conjunction([self.condition(part, calm, params, own) for part in parts])
            case Or(parts):
                return disjunction([self.condition(part, calm, params, own) for part in parts])
            case _:
                assert_never(cond)

    def _where(self, request: str, prefix: str, where: Cond | None, params: Names | None) -> list[str]:
        return [] if where is None else [self.condition(where, False, self.params(request, prefix), params)]

    def _compare(self, cond: Compare, calm: bool, params: Names, own: Names) -> str:
        sides = (cond.left, cond.right)
        kind = next((k for side in sides if (k := self._type(side, params, own)) is not None), Int(0, 0))
        left, right = (self._term(side, kind, calm, params, own) for side in sides)
        if cond.operator == "!=":
            return f"(not (= {left} {right}))"
        return f"({'=' if cond.operator == '==' else cond.operator} {left} {right})"

    def _type(self, term: Term, params: Names, own: Names) -> Type | None:
        """Return the type of a term; None of a constant, which has that of the other side."""
        match term:
            case Param(name):
                return params[name][1]
            case Own(name):
                return own[name][1]
            case Reading(name):
                return self.readings[name][1]
            case Const(value):
                return Real() if isinstance(value, float) else None
            case _:
                return Int(0, 0)

    def _term(self, term: Term, kind: Type, calm: bool, params: Names, own: Names) -> str:
        match term:
            case Const(value):
                return constant(kind, value)
            case Param(name):
                return params[name][0]
            case Own(name):
                return own[name][0]
            case Reading(name):
                return self.readings[name][0]
            case Level(resource):
                return self.levels[resource]
            case Count(requests):
                there = [phase(s, "running" if calm else "active") for r in requests for s in self.slots(r)]
                return total([f"(ite {each} 1 0)" for each in there])
            case Used(resource):
                return total(self._shares(resource, calm))
            case Sum(first, parts):
                terms = [f"(* {constant(kind, f)} {self._term(part, kind, calm, params, own)})" for f, part in parts]
                return total([constant(kind, first), *terms])
            case _:
                assert_never(term)

    def _shares(self, resource: str, calm: bool) -> Iterable[str]:
        for request in self.model.requests:
            for share in request.shares:
                for slot in self.slots(request.name) if share.resource == resource else ():
                    held = self._where(request.name, f"arg.{slot}", None, None)
                    if share.when is not None:
                        held = [self.condition(share.when, False, self.params(request.name, f"arg.{slot}"))]
                    there = conjunction([phase(slot, "running" if calm else "active"), *held])
                    yield f"(ite {there} {share.amount} 0)"


@dataclass(frozen=True, slots=True)
class Always:
    """AG: the formula is true in every moment, in the first one, or in all later ones."""

    part: Formula
    when: Literal["always", "first", "later"] = "always"


@dataclass(frozen=True, slots=True)
class Possible:
    """EF: `now` is true in some moment, or `later` in one that is not the first."""

    now: Formula
    later: Formula = FALSE


@dataclass(frozen=True, slots=True)
class Recoverable:
    """AG (since -> EX E [allowed U (allowed and goal)])."""

    since: Formula
    allowed: Formula
    goal: Formula


Shape = Always | Possible | Recoverable


def shape(claim: Claim) -> Shape:
    """Return what a claim comes down to; raises `Unsaid` if it is none of the forms that have proofs."""
    if claim.formula is None:
        raise Unsaid("the claim is not about the runs of one loop")
    if claim.linear or (claim.fair and claim.check == "starvation"):
        raise Unsaid("the claim is about runs without end")
    match claim.formula:
        case Negation(SomeNext(SomeUntil(Conjunction(()), Negation(part)))) if momentary(part):
            return Always(part, "later")
        case Negation(SomeUntil(Conjunction(()), Negation(part))) if momentary(part):
            return Always(part)
        case Negation(SomeUntil(Conjunction(()), Negation(part))):
            return _recoverable(part)
        case SomeUntil(Conjunction(()), now) if momentary(now):
            return Possible(now)
        case Disjunction((SomeUntil(Conjunction(()), now), SomeNext(SomeUntil(Conjunction(()), later)))):
            return Possible(now, later)
        case part if momentary(part):
            return Always(part, "first")
        case _:
            raise Unsaid("the claim is about more than one moment of a run after another")


def _recoverable(part: Formula) -> Recoverable:
    match part:
        case Disjunction((Negation(since), SomeNext(SomeUntil(allowed, Conjunction((also, goal)))))) if also == allowed:
            if all(map(momentary, (since, allowed, goal))):
                return Recoverable(since, allowed, goal)
        case Disjunction((Negation(since), SomeUntil(Conjunction(()), goal))) if momentary(since) and momentary(goal):
            return Recoverable(Conjunction((since, Negation(goal))), TRUE, goal)
        case SomeUntil(Conjunction(()), goal) if momentary(goal):
            return Recoverable(Negation(goal), TRUE, goal)
        case _:
            pass
    raise Unsaid("the claim is about more than one moment of a run after another")


def momentary(formula: Formula) -> bool:
    """Return whether a formula has no temporal operator."""
    match formula:
        case Negation(part):
            return momentary(part)
        case Conjunction(parts) | Disjunction(parts):
            return all(momentary(part) for part in parts)
        case Atom() | Happened() | Passed() | Broken():
            return True
        case _:
            return False


def phase(slot: int, kind: str) -> str:
    """Return that a slot is active, running or stopping."""
    return f"(not (= phase.{slot} 0))" if kind == "active" else f"(= phase.{slot} {1 if kind == 'running' else 2})"


def conjunction(parts: list[str]) -> str:
    """Return all of the parts."""
    return "true" if not parts else parts[0] if len(parts) == 1 else f"(and {' '.join(parts)})"


def disjunction(parts: list[str]) -> str:
    """Return one of the parts."""
    return "false" if not parts else parts[0] if len(parts) == 1 else f"(or {' '.join(parts)})"


def total(parts: Iterable[str]) -> str:
    """Return the sum."""
    listed = list(parts)
    return "0" if not listed else listed[0] if len(listed) == 1 else f"(+ {' '.join(listed)})"


def constant(kind: Type, value: Value) -> str:
    """Return a value as SMT-LIB has it: reals are exact fractions."""
    if isinstance(kind, Real):
        exact = Fraction(value)
        text = (
            f"{abs(exact.numerator)}.0"
            if exact.denominator == 1
            else f"(/ {abs(exact.numerator)}.0 {exact.denominator}.0)"
        )
        return f"(- {text})" if exact < 0 else text
    return number(int(value) if isinstance(value, int) else ordinal(kind, value))


def number(value: int) -> str:
    """Return an integer as SMT-LIB has it."""
    return f"(- {-value})" if value < 0 else str(value)
