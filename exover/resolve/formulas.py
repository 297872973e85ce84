"""Resolves conditions of a properties file, which may have predicates on steps, and raw formulas of CTL and LTL."""

from collections.abc import Callable, Sequence
from dataclasses import field
from typing import Literal

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.expression import And, Not, Or
from exover.model.property import (
    Atom,
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    SomeAlways,
    SomeNext,
    SomeUntil,
    Until,
    all_always,
    all_finally,
    all_next,
    all_until,
    always,
    finally_,
    some_finally,
)
from exover.resolve.conditions import MAX_ATOMS, MAX_DEPTH, meaning
from exover.resolve.mistakes import Mistakes
from exover.resolve.names import find_request, requests
from exover.resolve.scope import PROPERTY, NameScope
from exover.source import Span
from exover.syntax import tree


@dataclass(frozen=True, slots=True)
class Sized:
    """A formula, the number of its atoms and its depth; a shared part counts as often as it occurs."""

    formula: Formula
    size: int = 1
    depth: int = 1


def negated(part: Sized | None) -> Sized | None:
    """Return the negation, inside the atom if it is one; None for None."""
    if part is None:
        return None
    formula = Atom(Not(part.formula.condition)) if isinstance(part.formula, Atom) else Negation(part.formula)
    return Sized(formula, part.size, part.depth + 1)


def joined(connective: Literal["and", "or"], parts: Sequence[Sized | None]) -> Sized | None:
    """Return the conjunction or disjunction, as one atom if all parts are atoms; None if a part is None."""
    found = [part for part in parts if part is not None]
    if len(found) < len(parts):
        return None
    formulas = tuple(part.formula for part in found)
    conditions = tuple(formula.condition for formula in formulas if isinstance(formula, Atom))
    formula: Formula
    if len(conditions) == len(formulas):
        formula = Atom(And(conditions) if connective == "and" else Or(conditions))
    else:
        formula = Conjunction(formulas) if connective == "and" else Disjunction(formulas)
    return Sized(formula, sum(part.size for part in found), 1 + max((part.depth for part in found), default=0))


def implication(left: Sized | None, right: Sized | None) -> Sized | None:
    """Return `left -> right`."""
    return joined("or", [negated(left), right])


@dataclass(frozen=True, slots=True)
class Binary:
    """How to make a formula of two, in which they stand `left` and `right` times."""

    make: Callable[[Formula, Formula], Formula]
    left: int = 1
    right: int = 1

    def of(self, one: Sized | None, other: Sized | None) -> Sized | None:
        """Return the formula of these two."""
        if one is None or other is None:
            return None
        size = self.left * one.size + self.right * other.size
        return Sized(self.make(one.formula, other.formula), size, max(one.depth, other.depth) + _LEVELS)


_LEVELS = 5
"""Levels that one temporal operator of the text adds at most."""

_UNARY: dict[tree.UnaryOperator, Callable[[Formula], Formula]] = {
    "X": Next,
    "F": finally_,
    "G": always,
    "EX": SomeNext,
    "EF": some_finally,
    "EG": SomeAlways,
    "AX": all_next,
    "AF": all_finally,
    "AG": all_always,
}


def _neither(left: Formula, right: Formula) -> Formula:
    return Conjunction((Negation(left), Negation(right)))


# f R g = !(!f U !g), f W g = !(!g U (!f & !g)), and with a quantifier the dual of the other one.
_BINARY: dict[tree.BinaryOperator, Binary] = {
    "U": Binary(Until),
    "R": Binary(lambda f, g: Negation(Until(Negation(f), Negation(g)))),
    "W": Binary(lambda f, g: Negation(Until(Negation(g), _neither(f, g))), right=2),
}
_QUANTIFIED: dict[tuple[tree.Quantifier, tree.BinaryOperator], Binary] = {
    ("E", "U"): Binary(SomeUntil),
    ("A", "U"): Binary(all_until, right=3),
    ("E", "R"): Binary(lambda f, g: Negation(all_until(Negation(f), Negation(g))), right=3),
    ("A", "R"): Binary(lambda f, g: Negation(SomeUntil(Negation(f), Negation(g)))),
    ("E", "W"): Binary(lambda f, g: Disjunction((SomeUntil(f, g), SomeAlways(f))), left=2),
    ("A", "W"): Binary(lambda f, g: Negation(SomeUntil(Negation(g), _neither(f, g))), right=2),
}


@dataclass(frozen=True, slots=True)
class Reader:
    """Resolves the formulas of one file; `scope`: the names of the spec, `defines`: the file's own, resolved so far."""

    scope: NameScope
    defines: dict[str, Sized | None] = field(default_factory=dict)

    @property
    def mistakes(self) -> Mistakes:
        """The mistakes found so far."""
        return self.scope.mistakes

    def bounded(self, found: Sized | None, span: Span) -> Sized | None:
        """Return the formula if it is within MAX_ATOMS and MAX_DEPTH, else note a mistake and return None."""
        if found is None or (found.size <= MAX_ATOMS and found.depth <= MAX_DEPTH):
            return found
        deep = f"nested at most {MAX_DEPTH} deep, a temporal operator counted as {_LEVELS} levels"
        limits = f"at most {MAX_ATOMS} comparisons and predicates, {deep}"
        self.mistakes.add("E414", "the formula is too large with its defines expanded", span, hint=limits)
        return None

    # ---- conditions ----

    def condition(self, node: tree.Cond) -> Sized | None:
        """Return the formula of a condition, without temporal operators, or None with its mistakes noted."""
        match node:
            case tree.Not(part):
                return negated(self.condition(part))
            case tree.And(parts):
                return joined("and", [self.condition(part) for part in parts])
            case tree.Or(parts):
                return joined("or", [self.condition(part) for part in parts])
            case tree.Implies(left, right):
                return implication(self.condition(left), self.condition(right))
            case tree.Predicate("asked" | "launched" | "rejected" | "killed" | "ended" as kind):
                return self._happened(node, kind)
            case tree.NameUse(None, name) if name.text in self.scope.names.defines:
                return self.defines[name.text]
            case _:
                known = meaning(self._fresh(), node)
                return None if known is None else Sized(Atom(known.cond), known.size, known.depth + 1)

    def _fresh(self) -> NameScope:
        scope = self.scope
        return NameScope(scope.names, scope.meanings, scope.mistakes, PROPERTY)

    def _happened(self, node: tree.Predicate, kind: tree.StepKind) -> Sized | None:
        """Return the disjunction of `kind(…)` over the listed requests, or that of one request `with` a condition."""
        if node.condition is None:
            found = requests(self.scope.names, node.requests, self.mistakes)
            atoms = [Sized(Happened(kind, request)) for request in found]
            return atoms[0] if len(atoms) == 1 else joined("or", atoms)
        ref = node.requests[0]
        assert isinstance(ref, tree.Ref), "the grammar has one request before `with`"
        signature = find_request(self.scope.names, ref, self.mistakes)
        if signature is None:
            return None
        where = meaning(self._fresh().inside(signature, past=False), node.condition)
        return None if where is None else Sized(Happened(kind, signature.name, where.cond), where.size, where.depth + 1)

    # ---- raw formulas ----

    def formula(self, node: tree.Formula, logic: tree.Logic) -> Sized | None:
        """Return the meaning of a raw formula, or None with its mistakes noted."""
        match node:
            case tree.Connected("not", (part,)):
                return negated(self.formula(part, logic))
            case tree.Connected("and" | "or" as connective, parts):
                return joined(connective, [self.formula(part, logic) for part in parts])
            case tree.Connected("implies", (left, right)):
                return implication(self.formula(left, logic), self.formula(right, logic))
            case tree.Connected(_, (left, right)):
                one, other = self.formula(left, logic), self.formula(right, logic)
                return joined("and", [implication(one, other), implication(other, one)])
            case tree.Connected():
                raise AssertionError("the grammar gives each connective its parts")
            case tree.Temporal(operator, part):
                return self._temporal(operator, part, node.place, logic)
            case tree.TemporalBinary(left, operator, right):
                return self._path(left, operator, right, node.place, logic)
            case tree.Quantified():
                return self._quantified(node, logic)
            case _:
                return self.condition(node)

    def _temporal(
        self, operator: tree.UnaryOperator, node: tree.Formula, place: Span, logic: tree.Logic
    ) -> Sized | None:
        part = self.formula(node, logic)
        is_ltl = operator in ("X", "F", "G")
        if is_ltl != (logic == "ltl"):
            last = operator[-1]
            hint = f"write `{last}`: every run is meant" if logic == "ltl" else f"write `A{last}` or `E{last}`"
            self._foreign(operator, place, logic, hint)
            return None
        if part is None:
            return None
        found = _UNARY[operator](part.formula)
        return Sized(found, part.size, part.depth + _LEVELS)

    def _path(
        self, left: tree.Formula, operator: tree.BinaryOperator, right: tree.Formula, place: Span, logic: tree.Logic
    ) -> Sized | None:
        """Return `left operator right` of LTL."""
        one, other = self.formula(left, logic), self.formula(right, logic)
        if logic == "ctl":
            hint = f"write `A [ … {operator} … ]` or `E [ … {operator} … ]`"
            self.mistakes.add("E418", f"`{operator}` has no path quantifier, which `ctl` needs", place, hint=hint)
            return None
        return _BINARY[operator].of(one, other)

    def _quantified(self, node: tree.Quantified, logic: tree.Logic) -> Sized | None:
        """Return `A [ … ]` or `E [ … ]` of CTL."""
        if logic == "ltl":
            self._foreign(node.quantifier, node.place, logic, "leave it out: every run is meant")
            return None
        match node.part:
            case tree.TemporalBinary(left, operator, right):
                one, other = self.formula(left, logic), self.formula(right, logic)
                return _QUANTIFIED[node.quantifier, operator].of(one, other)
            case tree.Temporal(operator) if operator in ("X", "F", "G"):
                hint = f"write `{node.quantifier}{operator}`"
            case _:
                hint = f"it reads `{node.quantifier} [ … U … ]`"
        message = f"`{node.quantifier} [ ]` holds `U`, `R` or `W`"
        self.mistakes.add("E418", message, node.part.span, hint=hint)
        return None

    def _foreign(self, operator: str, place: Span, logic: tree.Logic, hint: str) -> None:
        other = "ctl" if logic == "ltl" else "ltl"
        message = f"{quote(operator)} is an operator of `{other}`, this formula is `{logic}`"
        self.mistakes.add("E418", message, place, hint=hint)
