"""Claims as terms of SMT-LIB over the state and the facts that the checker of certificates knows."""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from exover.dataclass import dataclass
from exover.loop.claim import Claim
from exover.loop.exact.condition_formulas import ConditionFormulas, FormulaScope, TypedValues, bound
from exover.loop.exact.step_predicates import moment
from exover.loop.exact.term import numeral
from exover.model.expression import Cond, Operator, Phase
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.property import (
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
    subformulas,
)
from exover.model.types import Int, Real, Type, Value, ordinal
from exover.model.wire import Json
from exover.ocrd.reasons import reasons

Said = str | list[Any]
"""A formula as certificates write it: a term of SMT-LIB about one moment, or a list of an operator and its operands."""
OPERATORS = {SomeNext: "EX", SomeUntil: "EU", SomeAlways: "EG", Next: "X", Until: "U"}
FACTS = {"asked": "asked", "launched": "launch", "rejected": "reject", "killed": "kill", "ended": "ended"}


class Unsaid(Exception):
    """A claim cannot be expressed over the state and the facts, or no proof of it is found; the text says why."""


@dataclass(frozen=True)
class Statement:
    """Writes claims about one model; `facts`: their atoms with a condition on the arguments of what happened."""

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
        """The term and the type of each poster, state and latch."""
        return {name: (f"reading.{number}", kind) for number, (name, kind) in enumerate(self.index.typed_readings)}

    @cached_property
    def levels(self) -> dict[str, str]:
        """The term of the level of each consumable."""
        return {name: f"level.{number}" for number, name in enumerate(self.index.stocks)}

    def slots(self, request: str) -> range:
        """Return the numbers of a request's slots."""
        return range(self.first_slot[request], self.first_slot[request] + self.model.request[request].instances)

    def params(self, request: str, prefix: str, results: bool = False) -> TypedValues[str]:
        """Return the terms `PREFIX.K` of the arguments, or with results, in a slot, a waiting place or the past."""
        declared = self.model.request[request]
        fields = (*declared.params, *(declared.results if results else ()))
        return bound(fields, (f"{prefix}.{k}" for k in range(len(fields))))

    # ---- claims ----

    def claim(self, claim: Claim) -> Json:
        """Return a claim in the form of docs/certificates.md; raises `Unsaid` if it cannot be expressed."""
        if claim.formula is None:
            raise Unsaid("the claim is not about the runs of one loop")
        return {"formula": self.formula(claim.formula), "fair": claim.fair, "linear": claim.linear}

    def formula(self, formula: Formula) -> Said:
        """Return a formula as certificates write it: one term if it has no temporal operator, else a list."""
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
        """Return the entries of `watched`: [fact, number of the request, condition on the arguments `value.K`]."""
        return [[FACTS[each.occurrence], self.request[each.request], self._of(each)] for each in self.facts]

    def _of(self, fact: Happened) -> str:
        return self.condition(fact.where, params=self.params(fact.request, "value")) if fact.where else "true"

    def moment(self, formula: Formula) -> str:
        """Return a formula of one moment as a term; raises `Unsaid` if it cannot be expressed."""
        return moment(ConditionText(self, False), ConditionText(self, True), self._happened, formula)

    def _happened(self, atom: Happened | Passed) -> str:
        match atom:
            case Happened(occurrence, request, None):
                return f"{FACTS[occurrence]}.{self.request[request]}"
            case Happened():
                return f"watched.{self.facts.index(atom)}"
            case Passed(("launch" | "left" as fact, request)):
                return f"{fact}.{self.request[request]}"
            case Passed(("rule", name)):
                return self._named(name)
            case Passed(("reject", name)) if self._only_rejects(name):
                return self._named(name)
            case Passed(("abort",)):
                return "abort"
            case _:
                raise Unsaid("the checker does not know which demand has decided")

    def _named(self, rule: str) -> str:
        known = enumerate(reasons(self.model))
        tried = [f"tried.{number}" for number, launch in enumerate(self.model.launches) if launch.name == rule]
        return disjunction([*(f"named.{number}" for number, reason in known if reason.rule == rule), *tried])

    def _only_rejects(self, name: str) -> bool:
        """Return whether a rule or guard demands nothing but to reject, so that all answers that name it reject."""
        mine = {label for label, _ in self.model.demands.values() if label[1] == name}
        return mine == {("reject", name)} and all(launch.name != name for launch in self.model.launches)

    def condition(self, cond: Cond, once_stopped: bool = False, params: TypedValues[str] | None = None) -> str:
        """Return a condition as a term; `once_stopped`: stopping slots are read as idle; `params`: of its subject."""
        return ConditionText(self, once_stopped).truth(cond, FormulaScope(params or {}))


@dataclass(frozen=True)
class ConditionText(ConditionFormulas[str]):
    """Writes conditions as terms of SMT-LIB over the names that the checker of certificates knows."""

    statement: Statement
    once_stopped: bool

    @property
    def model(self) -> Model:
        """The model."""
        return self.statement.model

    def both(self, parts: Iterable[str]) -> str:
        """Return the conjunction."""
        return conjunction(list(parts))

    def either(self, parts: Iterable[str]) -> str:
        """Return the disjunction."""
        return disjunction(list(parts))

    def negation(self, part: str) -> str:
        """Return the negation."""
        return f"(not {part})"

    def held(self, phase: Phase, request: str) -> Iterator[tuple[str, TypedValues[str]]]:
        """Yield for each slot, or for the waiting place, the condition that it is in this phase, and its arguments."""
        said = self.statement
        if phase == "waiting":
            number = said.request[request]
            yield f"(not (= place.{number} 0))", said.params(request, f"held.{number}")
            return
        there = "running" if self.once_stopped and phase == "active" else phase
        for slot in said.slots(request):
            idle = self.once_stopped and phase == "stopping"
            yield "false" if idle else in_phase(slot, there), said.params(request, f"arg.{slot}")

    def past(self, request: str) -> tuple[str, TypedValues[str]]:
        """Return the condition that a request has a past, and the arguments and results of that."""
        known = f"past.{self.statement.request[request]}"
        return known, self.statement.params(request, known, results=True)

    def ended(self, request: str, outcome: int) -> str:
        """Return the condition that the last instance of a request ended with this outcome, given by its number."""
        return f"(= last.{self.statement.request[request]} {outcome})"

    def compared(self, left: str, operator: Operator, right: str) -> str:
        """Return the comparison of two values."""
        if operator == "!=":
            return f"(not (= {left} {right}))"
        return f"({'=' if operator == '==' else operator} {left} {right})"

    def constant(self, kind: Type | None, value: Value) -> str:
        """Return the literal of a value of a type; None: an integer."""
        return constant(kind or Int(0, 0), value)

    def reading(self, name: str) -> tuple[Type, str]:
        """Return the type and the term of a poster, state or latch."""
        text, kind = self.statement.readings[name]
        return kind, text

    def level(self, resource: str) -> str:
        """Return the term of the level of a consumable."""
        return self.statement.levels[resource]

    def counted(self, amounts: Sequence[tuple[int, str]]) -> str:
        """Return the sum of the amounts whose conditions are true."""
        return total(f"(ite {guard} {amount} 0)" for amount, guard in amounts)

    def sum(self, first: int, parts: Sequence[tuple[int, str]]) -> str:
        """Return `first + sum(factor * value)`."""
        return total([numeral(first), *(f"(* {numeral(factor)} {value})" for factor, value in parts)])


def facts(claims: Iterable[Claim], properties: Properties) -> tuple[Happened, ...]:
    """Return the atoms of claims and assumptions with a condition on the arguments of what happened, each once."""
    said = [claim.formula for claim in claims if claim.formula is not None]
    asked = (atom for formula in (*said, *(each.formula for each in properties.assumptions)) for atom in atoms(formula))
    return tuple(dict.fromkeys(each for each in asked if isinstance(each, Happened) and each.where is not None))


def distinct(formula: Formula) -> Formula:
    """Return an equivalent formula of LTL in which no two temporal operators are the same subformula.

    So the product with its tableau has one promise for each operator, in whatever order they are numbered.
    """
    return _distinct(formula, set())


def _distinct(formula: Formula, seen: set[Formula]) -> Formula:
    found: Formula
    match formula:
        case Negation(part):
            return Negation(_distinct(part, seen))
        case Conjunction(parts):
            return Conjunction(tuple(_distinct(part, seen) for part in parts))
        case Disjunction(parts):
            return Disjunction(tuple(_distinct(part, seen) for part in parts))
        case Next(part):
            part = _distinct(part, seen)
            while (found := Next(part)) in seen:
                part = Conjunction((part,))
        case Until(left, right):
            left, right = _distinct(left, seen), _distinct(right, seen)
            while (found := Until(left, right)) in seen:
                right = Conjunction((right,))
        case _:
            return formula
    seen.add(found)
    return found


def temporal(formula: Formula) -> Iterator[Formula]:
    """Yield the temporal operators of a formula as they are numbered: each before those within it."""
    return (each for each in subformulas(formula) if type(each) in OPERATORS)


def in_phase(slot: int, kind: str) -> str:
    """Return the condition that a slot is active, running or stopping."""
    return f"(not (= phase.{slot} 0))" if kind == "active" else f"(= phase.{slot} {1 if kind == 'running' else 2})"


def conjunction(parts: list[str]) -> str:
    """Return the conjunction of the parts."""
    return "true" if not parts else parts[0] if len(parts) == 1 else f"(and {' '.join(parts)})"


def disjunction(parts: list[str]) -> str:
    """Return the disjunction of the parts."""
    return "false" if not parts else parts[0] if len(parts) == 1 else f"(or {' '.join(parts)})"


def total(parts: Iterable[str]) -> str:
    """Return the sum of the parts."""
    listed = list(parts)
    return "0" if not listed else listed[0] if len(listed) == 1 else f"(+ {' '.join(listed)})"


def constant(kind: Type, value: Value) -> str:
    """Return a value as a literal of SMT-LIB: a real as an exact fraction."""
    if isinstance(kind, Real):
        return numeral(Fraction(value), "Real")
    return numeral(int(value) if isinstance(value, int) else ordinal(kind, value))
