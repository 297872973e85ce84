"""Terms of SMT-LIB over Bool, Int and Real, each built once and simplified as it is built.

Equal terms of one `Terms` are one object, so that they compare by identity and a term is a graph without repetition.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field
from fractions import Fraction
from typing import Literal, TypeVar

from exover.dataclass import dataclass

Sort = Literal["Bool", "Int", "Real"]
TermOperator = Literal["constant", "var", "not", "and", "or", "ite", "<=", "=", "sum"]
Number = int | Fraction
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """A term; `value`: of a constant its value, of a variable its name, of a sum its constant and factors."""

    kind: TermOperator
    sort: Sort
    parts: tuple["Term", ...] = ()
    value: bool | Number | str | tuple[Number, ...] = False

    @property
    def name(self) -> str:
        """The name of a variable."""
        assert isinstance(self.value, str)
        return self.value

    @property
    def number(self) -> Number:
        """The value of a constant that is a number."""
        assert not isinstance(self.constant, bool)
        return self.constant

    @property
    def constant(self) -> bool | Number:
        """The value of a constant."""
        assert self.kind == "constant" and not isinstance(self.value, str | tuple)
        return self.value


def numeral(value: Number, sort: Sort = "Int") -> str:
    """Return a number in SMT-LIB; a real as an exact fraction."""
    if value < 0:
        return f"(- {numeral(-value, sort)})"
    if sort == "Int":
        return str(value)
    fraction = Fraction(value)
    if fraction.denominator == 1:
        return f"{fraction.numerator}.0"
    return f"(/ {fraction.numerator}.0 {fraction.denominator}.0)"


Values = Mapping[Term, Term]
"""A substitution: maps variables to terms."""


@dataclass
class Terms:
    """Makes terms, simplified and each once (hash consing)."""

    _known: dict[tuple[object, ...], Term] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.true = self._make("constant", "Bool", (), True)
        self.false = self._make("constant", "Bool", (), False)

    def _make(
        self,
        kind: TermOperator,
        sort: Sort,
        parts: tuple[Term, ...],
        value: bool | Number | str | tuple[Number, ...] = False,
    ) -> Term:
        key = (kind, sort, parts, value)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = Term(kind, sort, parts, value)
        return found

    # ---- leaves ----

    def var(self, name: str, sort: Sort) -> Term:
        """Return the variable of this name."""
        return self._make("var", sort, (), name)

    def truth(self, value: bool) -> Term:
        """Return `true` or `false`."""
        return self.true if value else self.false

    def constant(self, value: Number, sort: Sort) -> Term:
        """Return a number of sort Int or Real; a double is given as the fraction that it is."""
        return self._make("constant", sort, (), Fraction(value) if sort == "Real" else int(value))

    def literal(self, value: bool | Number, sort: Sort) -> Term:
        """Return a value as a constant of a sort."""
        return self.truth(bool(value)) if sort == "Bool" else self.constant(value, sort)

    # ---- connectives ----

    def negation(self, term: Term) -> Term:
        """Return `not term`."""
        if term.kind == "constant":
            return self.truth(not term.value)
        return term.parts[0] if term.kind == "not" else self._make("not", "Bool", (term,))

    def both(self, terms: Iterable[Term]) -> Term:
        """Return the conjunction."""
        return self._join("and", terms, self.true, self.false)

    def either(self, terms: Iterable[Term]) -> Term:
        """Return the disjunction."""
        return self._join("or", terms, self.false, self.true)

    def _join(self, kind: Literal["and", "or"], terms: Iterable[Term], neutral: Term, absorbing: Term) -> Term:
        found: dict[Term, None] = {}
        for term in terms:
            for part in term.parts if term.kind == kind else (term,):
                if part is absorbing or self.negation(part) in found:
                    return absorbing
                if part is not neutral:
                    found[part] = None
        if len(found) <= 1:
            return next(iter(found), neutral)
        return self._make(kind, "Bool", tuple(found))

    def implies(self, left: Term, right: Term) -> Term:
        """Return `left => right`."""
        return self.either((self.negation(left), right))

    def choose(self, condition: Term, then: Term, otherwise: Term) -> Term:
        """Return `ite condition then otherwise`."""
        if condition.kind == "constant":
            return then if condition.value else otherwise
        if condition.kind == "not":
            condition, then, otherwise = condition.parts[0], otherwise, then
        if then.kind == "ite" and then.parts[0] is condition:
            then = then.parts[1]
        if otherwise.kind == "ite" and otherwise.parts[0] is condition:
            otherwise = otherwise.parts[2]
        if then is otherwise:
            return then
        if then.sort == "Bool":
            if then.kind == "constant" or then is condition:
                first = self.true if then is condition or then.value else self.false
                return (
                    self.either((condition, otherwise))
                    if first is self.true
                    else self.both((self.negation(condition), otherwise))
                )
            if otherwise.kind == "constant" or otherwise is condition:
                last = self.false if otherwise is condition or not otherwise.value else self.true
                return (
                    self.both((condition, then))
                    if last is self.false
                    else self.either((self.negation(condition), then))
                )
        return self._make("ite", then.sort, (condition, then, otherwise))

    # ---- numbers ----

    def sum(self, constant: Number, parts: Iterable[tuple[Number, Term]], sort: Sort = "Int") -> Term:
        """Return `constant + sum(factor * term)`."""
        total: dict[Term, Number] = {}
        for factor, term in parts:
            if term.kind == "constant":
                constant += factor * term.number
            elif term.kind == "sum":
                assert isinstance(term.value, tuple)
                constant += factor * term.value[0]
                for inner, part in zip(term.value[1:], term.parts, strict=True):
                    total[part] = total.get(part, 0) + factor * inner
            else:
                total[term] = total.get(term, 0) + factor
        left = {term: factor for term, factor in total.items() if factor}
        if not left:
            return self.constant(constant, sort)
        if constant == 0 and list(left.values()) == [1]:
            return next(iter(left))
        return self._make("sum", sort, tuple(left), (constant, *left.values()))

    def at_most(self, left: Term, right: Term) -> Term:
        """Return `left <= right`."""
        return self._compare("<=", left, right)

    def less(self, left: Term, right: Term) -> Term:
        """Return `left < right`."""
        return self.negation(self.at_most(right, left))

    def equal(self, left: Term, right: Term) -> Term:
        """Return `left = right`."""
        if left.sort == "Bool":
            return self.choose(left, right, self.negation(right))
        return self._compare("=", left, right)

    def _compare(self, kind: Literal["<=", "="], left: Term, right: Term) -> Term:
        """Return the comparison of two numbers; a comparison of `ite` with a constant moves into the branches."""
        if left is right:
            return self.true
        if left.kind == "constant" and right.kind == "constant":
            return self.truth(left.number <= right.number if kind == "<=" else left.number == right.number)
        if kind == "=" and left.kind == "constant":
            left, right = right, left
        key = (kind, left, right)
        found = self._known.get(key)
        if found is None:
            if left.kind == "ite" and right.kind == "constant":
                condition, then, otherwise = left.parts
                found = self.choose(condition, self._compare(kind, then, right), self._compare(kind, otherwise, right))
            elif right.kind == "ite" and left.kind == "constant":
                condition, then, otherwise = right.parts
                found = self.choose(condition, self._compare(kind, left, then), self._compare(kind, left, otherwise))
            else:
                found = self._make(kind, "Bool", (left, right))
            self._known[key] = found
        return found

    # ---- graphs ----

    def rebuilt(self, term: Term, parts: tuple[Term, ...]) -> Term:
        """Return the term with other parts, simplified."""
        match term.kind:
            case "not":
                return self.negation(parts[0])
            case "and":
                return self.both(parts)
            case "or":
                return self.either(parts)
            case "ite":
                return self.choose(*parts)
            case "<=":
                return self.at_most(*parts)
            case "=":
                return self.equal(*parts)
            case "sum":
                assert isinstance(term.value, tuple)
                return self.sum(term.value[0], zip(term.value[1:], parts, strict=True), term.sort)
            case _:
                return term

    def replaced(self, term: Term, values: Values, memory: dict[Term, Term] | None = None) -> Term:
        """Return the term with variables replaced; `memory` caches results for the same values."""

        def build(each: Term, parts: tuple[Term, ...]) -> Term:
            return values.get(each, each) if each.kind == "var" else self.rebuilt(each, parts)

        return folded(term, build, {} if memory is None else memory)


def folded(term: Term, build: Callable[[Term, tuple[T, ...]], T], memory: dict[Term, T]) -> T:
    """Return the fold of a term: `build` is applied to each subterm once, with the results for its parts."""
    stack = [term]
    while stack:
        here = stack[-1]
        if here in memory:
            stack.pop()
            continue
        missing = [part for part in here.parts if part not in memory]
        if missing:
            stack += missing
        else:
            memory[here] = build(here, tuple(memory[part] for part in here.parts))
            stack.pop()
    return memory[term]


def below(terms: Iterable[Term]) -> Iterator[Term]:
    """Yield every subterm of these terms, themselves included, each once."""
    seen: set[Term] = set()
    stack = list(terms)
    while stack:
        term = stack.pop()
        if term not in seen:
            seen.add(term)
            yield term
            stack += term.parts


def variables(terms: Iterable[Term]) -> set[Term]:
    """Return the variables that terms depend on."""
    return {term for term in below(terms) if term.kind == "var"}
