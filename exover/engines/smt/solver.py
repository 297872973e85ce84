"""Z3 on terms, within a time limit."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from fractions import Fraction
from time import monotonic
from typing import Any

from exover.dataclass import dataclass
from exover.loop.exact.term import Number, Term, folded

STEPS = 2_500_000
"""The steps that Z3 takes in about a second, as it counts them (`rlimit`)."""


class Inconclusive(Exception):
    """There is no answer: the solver gave up, or a limit was reached; the message says which."""


def forget() -> None:
    """Drop Z3's context with all expressions; those made before must not be used any more.

    Z3's results depend on how expressions are numbered, and so on all that it was asked before.
    """
    import z3

    z3.z3._main_ctx = None  # a new one is made when it is asked for


def new_solver() -> Any:
    """Return a solver of Z3 that leaves Ctrl-C to Python: Z3 would end its search without saying why."""
    import z3

    solver = z3.Solver()
    solver.set("ctrl_c", False)
    return solver


@dataclass
class Clock:
    """The time that a claim has: until `deadline` on the clock of `monotonic`."""

    deadline: float = float("inf")

    def left(self, most: float = float("inf")) -> int:
        """Return the milliseconds that a call of the solver may take; raises `Inconclusive` if none are left."""
        left = min(self.deadline - monotonic(), most)
        if left <= 0:
            raise Inconclusive("time limit")
        return int(min(left * 1000 + 1, 2**31))

    def limit(self, solver: Any, most: float = float("inf")) -> None:
        """Bound the next call of a solver: to the time that is left, and to so many seconds."""
        solver.set("timeout", self.left(most))


@dataclass
class StepClock(Clock):
    """A clock that bounds calls of the solver by its own steps, so that answers are the same on every machine.

    Seconds count as so many steps. `steps` are for all calls; each takes `least` of them, for what Python does for it.
    """

    steps: int = 10**18
    least: int = 0
    _counted: int | None = None

    def limit(self, solver: Any, most: float = float("inf")) -> None:
        """Bound the next call to the steps that are left; raises `Inconclusive` if there are none."""
        counted = solver.statistics().get_key_value("rlimit count")
        self.steps -= self.least + (0 if self._counted is None else counted - self._counted)
        self._counted = counted
        if self.steps <= 0:
            raise Inconclusive("bound reached: the steps of the solver are over")
        solver.set("rlimit", int(min(self.steps, most * STEPS, 2**32 - 1)))
        super().limit(solver)


@dataclass
class Translation:
    """Terms as expressions of Z3; `suffix` tells the variables of one moment from those of another."""

    suffix: str = ""
    memory: dict[Term, Any] = field(default_factory=dict)

    def __call__(self, term: Term) -> Any:
        """Return the expression of a term."""
        return folded(term, self._built, self.memory)

    def _built(self, term: Term, parts: tuple[Any, ...]) -> Any:
        import z3

        context = z3.main_ctx()
        match term.kind:
            case "constant":
                return z3.BoolVal(term.value) if term.sort == "Bool" else number(term.number, term.sort)
            case "var":
                sorts = {"Bool": z3.BoolSort, "Int": z3.IntSort, "Real": z3.RealSort}
                return z3.Const(term.name + self.suffix, sorts[term.sort]())
            # The functions below are those of the C interface: what And, Or and If of Python check is known here.
            case "not":
                return z3.BoolRef(z3.Z3_mk_not(context.ref(), parts[0].ast), context)
            case "and" | "or":
                array = (z3.Ast * len(parts))(*(part.ast for part in parts))
                make = z3.Z3_mk_and if term.kind == "and" else z3.Z3_mk_or
                return z3.BoolRef(make(context.ref(), len(parts), array), context)
            case "ite":
                made = z3.Z3_mk_ite(context.ref(), *(part.ast for part in parts))
                return (z3.BoolRef if term.sort == "Bool" else z3.ArithRef)(made, context)
            case "<=":
                return z3.BoolRef(z3.Z3_mk_le(context.ref(), parts[0].ast, parts[1].ast), context)
            case "=":
                return z3.BoolRef(z3.Z3_mk_eq(context.ref(), parts[0].ast, parts[1].ast), context)
            case "sum":
                assert isinstance(term.value, tuple)
                constant, *factors = term.value
                pairs = zip(factors, parts, strict=True)
                products = [part if factor == 1 else number(factor, term.sort) * part for factor, part in pairs]
                return z3.Sum([number(constant, term.sort), *products] if constant else products)


def number(value: Number, sort: str) -> Any:
    """Return a number as an expression."""
    import z3

    if sort == "Int":
        return z3.IntVal(int(value))
    fraction = Fraction(value)
    return z3.Q(fraction.numerator, fraction.denominator)


@dataclass
class Prover:
    """Satisfiability of terms over one state and one step, under lemmas that are true of all states."""

    clock: Clock
    most: float = 5.0
    """Seconds for one question."""
    _known: Sequence[Term] = ()
    _solver: Any = None
    _translation: Translation = field(default_factory=Translation)

    def begin_anew(self) -> None:
        """Drop all expressions, before a call of `forget`; the solver is built again when it is next needed."""
        self._solver, self._translation = None, Translation()

    def satisfiable(self, terms: Iterable[Term], known: Sequence[Term] = ()) -> bool:
        """Return whether the terms can be true together where `known` is; true if the solver does not know."""
        return self.model(terms, known) is not None

    def model(self, terms: Iterable[Term], known: Sequence[Term] = ()) -> "Valuation | None":
        """Return values with which the terms are true together; None if there are none."""
        import z3

        questions = [term for term in terms if not (term.kind == "constant" and term.value)]
        if any(term.kind == "constant" for term in questions):
            return None
        if self._solver is None or known is not self._known:
            self._solver, self._known = new_solver(), known
            self._solver.add([self._translation(term) for term in known])
        self.clock.limit(self._solver, self.most)
        self._solver.push()
        self._solver.add([self._translation(term) for term in questions])
        try:
            answer = self._solver.check()
            if answer == z3.unsat:
                return None
            return Valuation(self._solver.model() if answer == z3.sat else None, self._translation)
        finally:
            self._solver.pop()


@dataclass(frozen=True)
class Valuation:
    """Values of variables; `model` is None if the solver did not find them, though there may be some."""

    model: Any
    translation: Callable[[Term], Any]

    def value(self, term: Term) -> bool | Number:
        """Return the value of a term."""
        return plain(self.model.eval(self.translation(term), model_completion=True))

    def values(self, variables: Mapping[str, Term]) -> dict[str, bool | Number]:
        """Return the values of variables by name."""
        return {name: self.value(term) for name, term in variables.items()}


def plain(value: Any) -> bool | Number:
    """Return a value of Z3 as one of Python."""
    import z3

    if z3.is_bool(value):
        return bool(z3.is_true(value))
    if z3.is_int_value(value):
        return int(value.as_long())
    assert z3.is_rational_value(value), "comparisons alone leave rational values"
    return Fraction(value.numerator_as_long(), value.denominator_as_long())
