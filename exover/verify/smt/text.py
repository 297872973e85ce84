"""The closed loop and what is asked of it as SMT-LIB 2 (Barrett, Fontaine, Tinelli 2017), for any solver.

A state is a record, an event a record of its kind; `start`, `step` and `lemma` say what is true of them. Every question
stands between `push` and `pop` with the answer that decides it.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from exover.model.property import (
    Conjunction,
    Disjunction,
    Formula,
    Happened,
    Negation,
    Next,
    Passed,
    Properties,
    SomeNext,
    SomeUntil,
    Until,
)
from exover.ocrd.compile import Compiled
from exover.verify.claim import Claim
from exover.verify.smt.engine import Smt
from exover.verify.smt.shape import momentary
from exover.verify.smt.system import System
from exover.verify.smt.term import Term, below, variables

DEPTH = 4
"""So many steps the runs have that the text asks about."""


@dataclass(frozen=True, slots=True)
class Goal:
    """A moment that some run comes to (`wanted`), or none, after `least` steps or more; -1: that is the start."""

    formula: Formula
    least: int
    wanted: bool


def goals(formula: Formula, wanted: bool = True) -> tuple[Goal, ...] | None:
    """Return the moments that a formula, or its negation, is about; None if it is about more than that."""
    match formula:
        case _ if momentary(formula):
            return (Goal(formula, -1, wanted),)
        case Negation(part):
            return goals(part, not wanted)
        case SomeUntil(Conjunction(()), goal) | Until(Conjunction(()), goal) if momentary(goal):
            return (Goal(goal, 0, wanted),)
        case SomeNext(SomeUntil(Conjunction(()), goal)) | Next(Until(Conjunction(()), goal)) if momentary(goal):
            return (Goal(goal, 1, wanted),)
        case Conjunction(parts) | Disjunction(parts):
            found = [goals(part, wanted) for part in parts]
            return None if None in found else tuple(goal for part in found if part for goal in part)
        case _:
            return None


def text(compiled: Compiled, properties: Properties, claims: Sequence[Claim]) -> str:
    """Return the file."""
    steps = Smt(compiled, properties).steps
    asked = {claim: goals(claim.formula) for claim in claims if claim.formula is not None}
    formulas = [goal.formula for found in asked.values() for goal in found or ()]
    system = System(steps, properties, Conjunction(tuple(formulas)), everywhere=True)
    return "\n".join(_Writer(system).lines(claims, asked)) + "\n"


def quoted(name: str) -> str:
    """Return a symbol."""
    return f"|{name}|"


def number(value: int | Fraction, sort: str) -> str:
    """Return a number; a real is the fraction that its double is."""
    if value < 0:
        return f"(- {number(-value, sort)})"
    if sort == "Int":
        return str(value)
    fraction = Fraction(value)
    if fraction.denominator == 1:
        return f"{fraction.numerator}.0"
    return f"(/ {fraction.numerator}.0 {fraction.denominator}.0)"


def _in_order(term: Term) -> Iterator[Term]:
    """Yield what a term is made of, parts first, always in the same order."""
    done: set[Term] = set()
    stack = [(term, False)]
    while stack:
        here, finished = stack.pop()
        if finished:
            yield here
        elif here not in done:
            done.add(here)
            stack.append((here, True))
            stack += [(part, False) for part in reversed(here.parts)]


def _flat(term: Term, known: Mapping[Term, str]) -> str:
    if term in known:
        return known[term]
    parts = [_flat(part, known) for part in term.parts]
    match term.kind:
        case "constant":
            return str(term.constant).lower() if term.sort == "Bool" else number(term.number, term.sort)
        case "var":
            return quoted(term.name)
        case "sum":
            assert isinstance(term.value, tuple)
            constant, *factors = term.value
            pairs = zip(factors, parts, strict=True)
            products = [part if f == 1 else f"(* {number(f, term.sort)} {part})" for f, part in pairs]
            products += [number(constant, term.sort)] if constant else []
            return f"(+ {' '.join(products)})" if len(products) > 1 else products[0]
        case _:
            return f"({term.kind} {' '.join(parts)})"


@dataclass
class _Writer:
    """Writes the definitions and the questions of one system."""

    system: System
    known: dict[Term, str] = field(default_factory=dict)
    """How variables, and terms that have a name already, are written."""

    def __post_init__(self) -> None:
        self.terms = self.system.terms
        inputs = {each.var: None for move in self.system.moves for each in move.inputs}
        self.inputs = tuple(inputs)
        self.known |= {var: f"({quoted(name)} s)" for name, var in self.system.vars.items()}
        self.known |= {var: f"({quoted(var.name)} e)" for var in self.inputs}
        roots = [*self.system.lemmas]
        for move in self.system.moves:
            roots += [move.allowed, *move.after.values()]
        self.uses: dict[Term, int] = {}
        for term in (*roots, *(part for each in below(roots) for part in each.parts)):
            self.uses[term] = self.uses.get(term, 0) + 1

    def lines(self, claims: Sequence[Claim], asked: Mapping[Claim, tuple[Goal, ...] | None]) -> Iterator[str]:
        """Yield the file."""
        yield f"; The closed loop of the spec {self.system.layout.model.name}: its checker, decided by packed tables,"
        yield "; together with whatever the robot's modules, the level above and the sensors may do."
        yield "; Enum values are numbers in the order of their list; endings are 0 none, 1 ok, 2 failed, 3 broken off."
        yield "(set-logic ALL)"
        yield from self._records()
        yield from self._definitions()
        for claim in claims:
            yield from self._question(claim, asked.get(claim))

    def _records(self) -> Iterator[str]:
        yield "\n; A state, and what the last step did (`happened`)."
        for number_, atom in enumerate(self.system.asked):
            yield f";   happened {number_}: {_words(atom)}"
        yield "(declare-datatype State ((state"
        yield from (f"    ({quoted(name)} {var.sort})" for name, var in self.system.vars.items())
        yield ")))"
        yield "\n; An event: its kind, and the values that events of its kind bring; the others do not count."
        yield "(declare-datatype Kind ("
        yield from (f"    ({quoted(str(move.kind))})" for move in self.system.moves)
        yield "))"
        yield "(declare-datatype Event ((event (kind Kind)"
        yield from (f"    ({quoted(var.name)} {var.sort})" for var in self.inputs)
        yield ")))"

    def _shared(self, terms: Iterable[Term]) -> Iterator[str]:
        """Yield names for what stands in these terms more than once, and has none yet; `n7` is one."""
        for term in (part for each in terms for part in _in_order(each)):
            if term not in self.known and self.uses.get(term, 0) > 1 and term.kind not in ("constant", "not"):
                read = variables([term])
                event = " (e Event)" if read & set(self.inputs) else ""
                name = f"n{len(self.known)}"
                yield f"(define-fun {name} ((s State){event}) {term.sort} {_flat(term, self.known)})"
                self.known[term] = f"({name} s e)" if event else f"({name} s)"

    def _definitions(self) -> Iterator[str]:
        system = self.system
        yield "\n(define-fun start ((s State)) Bool (and"
        yield from (f"    (= {self.known[var]} {_flat(value, {})})" for var, value in system.initial.items())
        yield "))"
        yield "\n; True of every state between steps: values are in range, and the checker has nothing left to do."
        yield from self._shared(system.lemmas)
        yield "(define-fun lemma ((s State)) Bool (and true"
        yield from (f"    {_flat(lemma, self.known)}" for lemma in system.lemmas)
        yield "))"
        yield "\n; Whether an event can happen, its values are in range, and the assumptions allow what it leads to."
        yield from self._shared(move.allowed for move in system.moves)
        yield "(define-fun allowed ((s State) (e Event)) Bool (or false"
        for move in system.moves:
            yield f"    (and (= (kind e) {quoted(str(move.kind))}) {_flat(move.allowed, self.known)})"
        yield "))"
        for name, var in system.vars.items():
            yield from self._following(name, var)
        yield "\n(define-fun step ((s State) (e Event) (t State)) Bool (and (allowed s e)"
        yield from (f"    (= ({quoted(name)} t) ({quoted(f'next {name}')} s e))" for name in system.vars)
        yield "))"

    def _following(self, name: str, var: Term) -> Iterator[str]:
        """Yield what a variable is after an event."""
        changing = [move for move in self.system.moves if move.after.get(name, var) is not var]
        yield ""
        yield from self._shared(move.after[name] for move in changing)
        yield f"(define-fun {quoted(f'next {name}')} ((s State) (e Event)) {var.sort}"
        for move in changing:
            yield f"    (ite (= (kind e) {quoted(str(move.kind))}) {_flat(move.after[name], self.known)}"
        yield f"    {self.known[var]}" + ")" * (len(changing) + 1)

    # ---- questions ----

    def _question(self, claim: Claim, found: tuple[Goal, ...] | None) -> Iterator[str]:
        name = f"{claim.check} {claim.subject}"
        yield f"\n; ---- {name} ----"
        if found is None:
            yield "; It is not about moments alone, and is not asked here."
        for number_, goal in enumerate(found or ()):
            part = name if len(found or ()) == 1 else f"{name} ({number_ + 1})"
            term = self.system.truth(goal.formula)
            yield from self._shared([term])
            yield f"; It holds {'if some' if goal.wanted else 'only if no'} run comes to where this is true."
            yield f"(define-fun {quoted(part)} ((s State)) Bool {_flat(term, self.known)})"
            yield from self._initial(part) if goal.least < 0 else self._runs(part, goal)

    def _initial(self, name: str) -> Iterator[str]:
        yield from self._asked(f"{name}: sat iff this is true at the start", 0, [f"({quoted(name)} s0)"])

    def _runs(self, name: str, goal: Goal) -> Iterator[str]:
        reached = " ".join(f"({quoted(name)} s{moment})" for moment in range(goal.least, DEPTH + 1))
        yield from self._asked(f"{name}: sat if a run of at most {DEPTH} steps comes there", DEPTH, [f"(or {reached})"])
        yield "(push 1)"
        yield f'(echo "{name}: unsat if no step comes there, so that runs do only if they begin there")'
        yield "(declare-const s State)\n(declare-const e Event)\n(declare-const t State)"
        begins = self.terms.replaced(self.system.truth(goal.formula), self.system.initial) is not self.terms.false
        before = "" if begins else f" (not ({quoted(name)} s))"
        yield f"(assert (and (lemma s){before} (step s e t) ({quoted(name)} t)))"
        yield "(check-sat)\n(pop 1)"

    def _asked(self, what: str, depth: int, conditions: Iterable[str]) -> Iterator[str]:
        """Yield a question about the runs of so many steps; a shorter one goes on with steps that change nothing."""
        yield "(push 1)"
        yield f'(echo "{what}")'
        yield from (f"(declare-const s{moment} State)" for moment in range(depth + 1))
        yield from (f"(declare-const e{moment} Event)" for moment in range(depth))
        yield "(assert (start s0))"
        yield from (f"(assert (step s{moment} e{moment} s{moment + 1}))" for moment in range(depth))
        yield from (f"(assert {condition})" for condition in conditions)
        yield "(check-sat)\n(pop 1)"


def _words(atom: Happened | Passed) -> str:
    match atom:
        case Passed(label):
            return " ".join(label)
        case Happened(occurrence, request, where):
            return f"{occurrence} {request}" + (" with some arguments" if where else "")
