"""The closed loop and what is asked of it as SMT-LIB 2 (Barrett, Fontaine, Tinelli 2017), for any solver.

A state is a record, an event a record of its kind; `start`, `step` and `lemma` say what is true of them. Every question
stands between `push` and `pop` with the answer that decides it.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.smt.engine import Smt
from exover.engines.smt.questions import questions
from exover.engines.smt.smtlib_queries import Asker, inputs_of, literal, quoted, searches
from exover.engines.smt.solver import Clock
from exover.engines.smt.system import System
from exover.loop.claim import Claim
from exover.loop.exact.term import Term, below, numeral, variables
from exover.model.property import Conjunction, Formula, Happened, Passed, Properties
from exover.ocrd.compile import Compiled


def text(compiled: Compiled, properties: Properties, claims: Sequence[Claim], clock: Clock) -> str:
    """Return the file; raises `Inconclusive` when the time of the clock is over."""
    steps = Smt(compiled, properties, clock=clock).steps
    formulas = [claim.formula for claim in claims if claim.formula is not None]
    system = System(steps, properties, Conjunction(tuple(formulas)), everywhere=True)
    return "\n".join(_Writer(system).lines(claims)) + "\n"


def _field(name: str) -> str:
    """Return the symbol of a variable; one that is a single word could be a word of ours."""
    return quoted(name if re.search(r"\W", name) else f"reading {name}")


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
            return literal(term)
        case "var":
            return quoted(term.name)
        case "sum":
            assert isinstance(term.value, tuple)
            constant, *factors = term.value
            pairs = zip(factors, parts, strict=True)
            products = [part if f == 1 else f"(* {numeral(f, term.sort)} {part})" for f, part in pairs]
            products += [numeral(constant, term.sort)] if constant else []
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
        self.inputs = inputs_of(self.system)
        self.known |= {var: f"({_field(name)} s)" for name, var in self.system.vars.items()}
        self.known |= {var: f"({quoted(var.name)} e)" for var in self.inputs}
        roots = [*self.system.lemmas]
        for move in self.system.moves:
            roots += [move.allowed, *move.after.values()]
        self.uses: dict[Term, int] = {}
        for term in (*roots, *(part for each in below(roots) for part in each.parts)):
            self.uses[term] = self.uses.get(term, 0) + 1

    def lines(self, claims: Sequence[Claim]) -> Iterator[str]:
        """Yield the file."""
        yield f"; The closed loop of the spec {self.system.layout.model.name}: its checker, decided by packed tables,"
        yield "; together with whatever the robot's modules, the level above and the sensors may do."
        yield "; Enum values are numbers in the order of their list; endings are 0 none, 1 ok, 2 failed, 3 broken off."
        yield "(set-logic ALL)"
        yield from self._records()
        yield from self._definitions()
        if self.system.properties.assumptions:
            yield from self._assumptions()
        asked = [questions(claim) for claim in claims]
        asker = Asker(self.system, self.system.steps.prover, self.predicate, searches(asked))
        for claim, found in zip(claims, asked, strict=True):
            yield from asker.questions(claim, found)

    def _records(self) -> Iterator[str]:
        yield "\n; A state, and what the last step did (`happened`)."
        for number_, atom in enumerate(self.system.asked):
            yield f";   happened {number_}: {_words(atom)}"
        yield "(declare-datatype State ((state"
        yield from (f"    ({_field(name)} {var.sort})" for name, var in self.system.vars.items())
        yield ")))"
        yield "\n; An event: its kind, and the values that events of its kind bring; the others do not count."
        yield "(declare-datatype Kind ("
        yield from (f"    ({quoted(kind)})" for kind in [str(move.kind) for move in self.system.moves] or ["nothing"])
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
        yield "\n(define-fun after ((s State) (e Event)) State (state"
        yield from (f"    ({quoted(f'next {name}')} s e)" for name in system.vars)
        yield "))"
        yield "(define-fun step ((s State) (e Event) (t State)) Bool (and (allowed s e) (= t (after s e))))"
        yield "\n; Whether nothing that counts differs: what is idle, empty or not known holds nothing."
        yield "(define-fun same ((s State) (t State)) Bool (and true"
        yield from (f"    {self._same(name)}" for name in system.vars if name not in system.observers)
        yield "))"

    def _same(self, name: str) -> str:
        equal = f"(= ({_field(name)} s) ({_field(name)} t))"
        owner = self.system.layout.owners.get(name)
        return equal if owner is None else f"(=> ({quoted(owner)} s) {equal})"

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

    def predicate(self, name: str, formula: Formula) -> Iterator[str]:
        """Yield the definition of a predicate on states."""
        term = self.system.truth(formula)
        yield from self._shared([term])
        yield f"(define-fun {quoted(name)} ((s State)) Bool {_flat(term, self.known)})"

    def _assumptions(self) -> Iterator[str]:
        """Yield what has to be known of assumptions before anything else counts."""
        yield "\n; The assumptions forbid events: a run that is found below counts if it can go on for ever. It can"
        yield "; if this is unsat. Whether it can go on fairly, where that is assumed, is not asked."
        yield "(push 1)"
        yield '(echo "assumptions: is there a state without a step? unsat: there is none")'
        yield "(declare-const s State)\n(assert (and (lemma s) (forall ((e Event)) (not (allowed s e)))))"
        yield "(check-sat)\n(pop 1)"


def _words(atom: Happened | Passed) -> str:
    match atom:
        case Passed(label):
            return " ".join(label)
        case Happened(occurrence, request, where):
            return f"{occurrence} {request}" + (" with some arguments" if where else "")
