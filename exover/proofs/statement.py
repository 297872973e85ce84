"""What a check claims, as SMT-LIB over the state and the facts that the checker of certificates knows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, assert_never

from exover.checks.demands import demands
from exover.loop.claim import Claim
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
from exover.model.index import ModelIndex
from exover.model.model import Model
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
    Properties,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    atoms,
    momentary,
    parts_of,
)
from exover.model.types import Int, Real, Type, Value, ordinal
from exover.ocrd.reasons import reasons
from exover.ocrd.vector import OUTCOMES

Json = dict[str, Any]
Said = str | list[Any]
"""A formula as a certificate has it: a text about one moment, or an operator and what it is applied to."""
OPERATORS = {SomeNext: "EX", SomeUntil: "EU", SomeAlways: "EG", Next: "X", Until: "U"}
Names = Mapping[str, tuple[str, Type]]
"""What stands for each parameter, with its type."""
FACTS = {"asked": "asked", "launched": "launch", "rejected": "reject", "killed": "kill", "ended": "ended"}


class Unsaid(Exception):
    """The claim cannot be said of the state and the facts; the text says why."""


@dataclass(frozen=True)
class Statement:
    """Says claims about one model; `facts`: what they ask of the arguments with which something happened."""

    model: Model
    facts: tuple[Happened, ...] = ()

    @cached_property
    def index(self) -> ModelIndex:
        """The numbers of what the model names."""
        return ModelIndex(self.model)

    @property
    def request(self) -> dict[str, int]:
        """The numbers of the requests."""
        return self.index.request

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
        return {name: (f"reading.{number}", kind) for number, (name, kind) in enumerate(self.index.typed_readings)}

    @cached_property
    def levels(self) -> dict[str, str]:
        """What stands for the level of each consumable."""
        return {name: f"level.{number}" for number, name in enumerate(self.index.stocks)}

    def slots(self, request: str) -> range:
        """Return the numbers of a request's slots."""
        return range(self.first_slot[request], self.first_slot[request] + self.model.request[request].instances)

    def params(self, request: str, prefix: str, results: bool = False) -> Names:
        """Return what stands for the parameters of what a slot, a waiting place or the past holds."""
        declared = self.model.request[request]
        fields = (*declared.params, *(declared.results if results else ()))
        return {field.name: (f"{prefix}.{k}", field.type) for k, field in enumerate(fields)}

    # ---- claims ----

    def claim(self, claim: Claim) -> Json:
        """Return a claim as docs/certificates.md has it; raises `Unsaid` if it cannot be said."""
        if claim.formula is None:
            raise Unsaid("the claim is not about the runs of one loop")
        return {"formula": self.formula(claim.formula), "fair": claim.fair, "linear": claim.linear}

    def formula(self, formula: Formula) -> Said:
        """Return a formula: what has no temporal operator is one text, the others are lists."""
        if momentary(formula):
            return self.moment(formula)
        match formula:
            case Negation(part):
                return ["not", self.formula(part)]
            case Conjunction(parts) | Disjunction(parts):
                now = [part for part in parts if momentary(part)]
                whole = type(formula)(tuple(now))
                return [
                    "and" if isinstance(formula, Conjunction) else "or",
                    *([self.moment(whole)] if now else []),
                    *(self.formula(part) for part in parts if not momentary(part)),
                ]
            case SomeNext() | SomeUntil() | SomeAlways() | Next() | Until():
                return [OPERATORS[type(formula)], *map(self.formula, parts_of(formula))]
            case _:
                raise TypeError(formula)

    def watched(self) -> list[list[Any]]:
        """Return what the checker has to watch: facts, their requests, and conditions on the arguments `value.K`."""
        return [[FACTS[each.occurrence], self.request[each.request], self._of(each)] for each in self.facts]

    def _of(self, fact: Happened) -> str:
        return self.condition(fact.where, params=self.params(fact.request, "value")) if fact.where else "true"

    def moment(self, formula: Formula) -> str:
        """Return a formula of one moment."""
        match formula:
            case Atom(condition):
                return self.condition(condition)
            case Happened(occurrence, request, None):
                return f"{FACTS[occurrence]}.{self.request[request]}"
            case Happened():
                return f"watched.{self.facts.index(formula)}"
            case Passed(("launch" | "left" as fact, request)):
                return f"{fact}.{self.request[request]}"
            case Passed(("rule", name)):
                return self._named(name)
            case Passed(("reject", name)) if self._only_rejects(name):
                return self._named(name)
            case Passed(("abort",)):
                return "abort"
            case Passed():
                raise Unsaid("the checker does not know which demand has decided")
            case Broken(rule, once_stopped):
                if rule.slot_of is None:
                    return self.condition(rule.condition, once_stopped)
                found = []
                for slot in self.slots(rule.slot_of):
                    held = self.condition(rule.condition, once_stopped, self.params(rule.slot_of, f"arg.{slot}"))
                    found.append(conjunction([phase(slot, "running" if once_stopped else "active"), held]))
                return disjunction(found)
            case Negation(part):
                return f"(not {self.moment(part)})"
            case Conjunction(parts):
                return conjunction([self.moment(part) for part in parts])
            case Disjunction(parts):
                return disjunction([self.moment(part) for part in parts])
            case _:
                raise TypeError("a formula of one moment has no temporal operator")

    def _named(self, rule: str) -> str:
        known = enumerate(reasons(self.model))
        tried = [f"tried.{number}" for number, launch in enumerate(self.model.launches) if launch.name == rule]
        return disjunction([*(f"named.{number}" for number, reason in known if reason.rule == rule), *tried])

    def _only_rejects(self, name: str) -> bool:
        """Return whether a rule or guard demands nothing but to reject, so that an answer that names it does so."""
        mine = {label for label, _ in demands(self.model).values() if label[1] == name}
        return mine == {("reject", name)} and all(launch.name != name for launch in self.model.launches)

    # ---- conditions ----

    def condition(
        self, cond: Cond, once_stopped: bool = False, params: Names | None = None, own: Names | None = None
    ) -> str:
        """Return a condition; `once_stopped`: with the stopping slots as idle; `params`, `own` as in `Scope`."""
        match cond:
            case Compare():
                return self._compare(cond, once_stopped, params or {}, own or {})
            case Status("waiting", request, where):
                number = self.request[request]
                there = f"(not (= place.{number} 0))"
                return conjunction([there, *self._where(request, f"held.{number}", where, params)])
            case Status(kind, request, where):
                found = []
                for slot in self.slots(request):
                    held = self._where(request, f"arg.{slot}", where, params)
                    there = "running" if once_stopped and kind == "active" else kind
                    found.append(
                        "false" if once_stopped and kind == "stopping" else conjunction([phase(slot, there), *held])
                    )
                return disjunction(found)
            case Past(request, where):
                number = self.request[request]
                inner = self.params(request, f"past.{number}", results=True)
                held = [] if where is None else [self.condition(where, False, inner, params)]
                return conjunction([f"past.{number}", *held])
            case Last(request, outcome):
                return f"(= last.{self.request[request]} {OUTCOMES.index(outcome)})"
            case Not(part):
                return f"(not {self.condition(part, once_stopped, params, own)})"
            case And(parts):
                return conjunction([self.condition(part, once_stopped, params, own) for part in parts])
            case Or(parts):
                return disjunction([self.condition(part, once_stopped, params, own) for part in parts])
            case _:
                assert_never(cond)

    def _where(self, request: str, prefix: str, where: Cond | None, params: Names | None) -> list[str]:
        return [] if where is None else [self.condition(where, False, self.params(request, prefix), params)]

    def _compare(self, cond: Compare, once_stopped: bool, params: Names, own: Names) -> str:
        sides = (cond.left, cond.right)
        kind = next((k for side in sides if (k := self._type(side, params, own)) is not None), Int(0, 0))
        left, right = (self._term(side, kind, once_stopped, params, own) for side in sides)
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

    def _term(self, term: Term, kind: Type, once_stopped: bool, params: Names, own: Names) -> str:
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
                there = [phase(s, "running" if once_stopped else "active") for r in requests for s in self.slots(r)]
                return total([f"(ite {each} 1 0)" for each in there])
            case Used(resource):
                return total(self._shares(resource, once_stopped))
            case Sum(first, parts):
                terms = [
                    f"(* {constant(kind, f)} {self._term(part, kind, once_stopped, params, own)})" for f, part in parts
                ]
                return total([constant(kind, first), *terms])
            case _:
                assert_never(term)

    def _shares(self, resource: str, once_stopped: bool) -> Iterable[str]:
        for request in self.model.requests:
            for share in request.shares:
                for slot in self.slots(request.name) if share.resource == resource else ():
                    held = self._where(request.name, f"arg.{slot}", None, None)
                    if share.when is not None:
                        held = [self.condition(share.when, False, self.params(request.name, f"arg.{slot}"))]
                    there = conjunction([phase(slot, "running" if once_stopped else "active"), *held])
                    yield f"(ite {there} {share.amount} 0)"


def facts(claims: Iterable[Claim], properties: Properties) -> tuple[Happened, ...]:
    """Return what claims and assumptions ask of the arguments with which something happened, each once."""
    said = [claim.formula for claim in claims if claim.formula is not None]
    asked = (atom for formula in (*said, *(each.formula for each in properties.assumptions)) for atom in atoms(formula))
    return tuple(dict.fromkeys(each for each in asked if isinstance(each, Happened) and each.where is not None))


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
