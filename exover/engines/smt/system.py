"""The transition system of a claim: the closed loop, reduced to the cone of influence of its formula.

Besides the variables of the state it has *observers*, one for each predicate on the last step. Variables on which
neither the formula nor the assumptions depend are left out, and so are moves that change none of the others.
"""

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import inf, nextafter

from exover.dataclass import dataclass
from exover.engines.smt.relation import Move, Relation
from exover.engines.smt.steps import SymbolicStep, SymbolicSteps
from exover.loop.exact.events import Kind
from exover.loop.exact.layout import Layout
from exover.loop.exact.predicates import Predicates
from exover.loop.exact.step_predicates import moment
from exover.loop.exact.term import Term, Terms, below, variables
from exover.model.property import (
    Formula,
    Happened,
    Passed,
    Properties,
    atoms,
)


@dataclass
class System:
    """Moments (values of the kept variables), the initial one, and the moves between them.

    `everywhere`: keep all variables and moves, for formulas that count steps; `fair`: keep all slots.
    """

    steps: SymbolicSteps
    properties: Properties
    formula: Formula
    everywhere: bool = False
    fair: bool = False
    vars: dict[str, Term] = field(init=False)
    moves: tuple[Move, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.layout: Layout = self.steps.layout
        self.terms: Terms = self.layout.terms
        self._now, self._once_stopped = Predicates(self.layout), Predicates(self.layout, once_stopped=True)
        assumed = [each.formula for each in self.properties.assumptions]
        found = [atom for formula in (self.formula, *assumed) for atom in atoms(formula)]
        self.asked = tuple(dict.fromkeys(atom for atom in found if isinstance(atom, Happened | Passed)))
        self.observers = {f"happened {n}": self.terms.var(f"happened {n}", "Bool") for n in range(len(self.asked))}
        self.assumption = self.terms.both(self.truth(formula) for formula in assumed)
        self._asked = (self.assumption, *(self.truth(atom) for atom in found))
        self._keep()
        if self._gaps:
            self.moves = tuple(self._careful(move) for move in self.moves)

    # ---- moments ----

    def truth(self, formula: Formula) -> Term:
        """Return where a formula without temporal operators is true."""
        return moment(self._now, self._once_stopped, self._happened, formula)

    def _happened(self, atom: Happened | Passed) -> Term:
        return self.observers[f"happened {self.asked.index(atom)}"]

    @cached_property
    def initial(self) -> dict[Term, Term]:
        """The values of the variables at the start."""
        values = {**self.layout.initial, **dict.fromkeys(self.observers, self.terms.false)}
        return {var: values[name] for name, var in self.vars.items()}

    @cached_property
    def assumed(self) -> Term:
        """A condition on every moment: the assumptions, or true if they are not true at the start."""
        holds = self.terms.replaced(self.assumption, self.initial) is self.terms.true
        return self.assumption if holds else self.terms.true

    @cached_property
    def lemmas(self) -> tuple[Term, ...]:
        """Invariants of the states between steps that mention kept variables.

        Other variables in them are free, that is, existentially quantified.
        """
        kept = set(self.vars.values())
        near = tuple(lemma for lemma in self.steps.lemmas if variables([lemma]) & kept)
        near += tuple(each for each in self.steps.invariants if variables([each]) <= kept)
        return near + tuple(self._between(var) for var in self.vars.values() if var.sort == "Real" and self._gaps)

    @cached_property
    def constants(self) -> list[Fraction]:
        """The real constants in the formulas, initial values, domains and moves, increasing; all are doubles."""
        terms = [*self._asked, *self.initial.values(), *self.layout.domains.values()]
        for move in self.moves:
            terms += [move.allowed, *move.after.values()]
        found = (term.number for term in below(terms) if term.kind == "constant" and term.sort == "Real")
        return sorted({Fraction(number) for number in found})

    @cached_property
    def _gaps(self) -> list[tuple[Fraction, Fraction]]:
        """The pairs of constants with no double between them: the solver would find reals there."""
        pairs = pairwise(self.constants)
        return [(low, high) for low, high in pairs if nextafter(float(low), inf) == float(high)]

    def _between(self, var: Term) -> Term:
        """Return the condition that a real is in no gap."""
        of, terms = self.terms.constant, self.terms
        return terms.both(
            terms.either((terms.at_most(var, of(low, "Real")), terms.at_most(of(high, "Real"), var)))
            for low, high in self._gaps
        )

    # ---- cone of influence ----

    def _observed(self, step: SymbolicStep) -> dict[str, Term]:
        """Return the values of the observers after a step."""
        found = {}
        for name, atom in zip(self.observers, self.asked, strict=True):
            if isinstance(atom, Passed):
                found[name] = step.marks.get(atom.label, self.terms.false)
            else:
                found[name] = self._now.happened(step.notes, atom)
        return found

    def _keep(self) -> None:
        """Find the cone of influence: the variables on which what is asked depends, and the moves that change one."""
        observed = {step.kind: self._observed(step) for step in self.steps.all}
        wanted = {var.name for var in variables(self._asked)}
        if self.everywhere:
            wanted |= {*self.layout.vars, *self.observers}
        if self.fair:
            wanted |= {slot.active for slot in self.layout.slots.values()}
        wanted |= {self.layout.owners[name] for name in wanted if name in self.layout.owners}
        relevant: dict[Kind, SymbolicStep] = {}
        grown = True
        while grown:
            grown = False
            for step in self.steps.all:
                seen = any(term is not self.terms.false for term in observed[step.kind].values())
                if step.kind in relevant or not (self.everywhere or seen or step.after.keys() & wanted):
                    continue
                relevant[step.kind], grown = step, True
            for kind, step in relevant.items():
                read = [step.enabled, *(step.after[name] for name in step.after.keys() & wanted)]
                names = {var.name for var in variables((*read, *observed[kind].values()))}
                names = {name for name in names if name in self.layout.vars}
                names |= {self.layout.owners[name] for name in names if name in self.layout.owners}
                grown, wanted = grown or not names <= wanted, wanted | names
        self.vars = {name: var for name, var in (self.layout.vars | self.observers).items() if name in wanted}
        idle = (s for s in self.steps.all if s.kind not in relevant and s.kind.verb in ("ask", "observe"))
        steps = [*relevant.values(), *([still] if (still := next(idle, None)) else [])]
        self.moves = self._distinct(self._move(step, observed[step.kind]) for step in steps)

    def _move(self, step: SymbolicStep, observed: Mapping[str, Term]) -> Move:
        after = {name: term for name, term in step.after.items() if name in self.vars} | dict(observed)
        values = {self.vars[name]: term for name, term in after.items() if name in self.vars}
        allowed = self.terms.both((step.enabled, self.terms.replaced(self.assumption, values)))
        after = {name: term for name, term in after.items() if name in self.vars}
        read = variables((allowed, *after.values()))
        return Move(step.kind, tuple(each for each in step.inputs if each.var in read), allowed, after)

    def _distinct(self, moves: Iterable[Move]) -> tuple[Move, ...]:
        """Return the moves without duplicates, and without those that are never allowed."""
        found: dict[tuple[object, ...], Move] = {}
        for move in moves:
            if move.allowed is not self.terms.false:
                found.setdefault((move.allowed, *move.after.items()), move)
        return tuple(found.values())

    def _careful(self, move: Move) -> Move:
        """Return the move with the condition that no real input is in a gap between doubles."""
        reals = [self._between(each.var) for each in move.inputs if each.var.sort == "Real"]
        return replace(move, allowed=self.terms.both((move.allowed, *reals)))

    def into(self, condition: Term) -> "System":
        """Return the system of the moves into moments in which a condition is true."""
        other, both = copy(self), self.terms.both
        moves = (replace(m, allowed=both((m.allowed, self.before(condition, m)))) for m in self.moves)
        other.moves = tuple(move for move in moves if move.allowed is not self.terms.false)
        other.__dict__.pop("relation", None)
        return other

    # ---- moves ----

    @cached_property
    def relation(self) -> Relation:
        """The moves as one relation between two moments."""
        return Relation(self.terms, self.vars, self.moves)

    def before(self, term: Term, move: Move, memory: dict[Term, Term] | None = None) -> Term:
        """Return the weakest precondition of a term under the move, over the moment before and the event's values."""
        return self.terms.replaced(term, {self.vars[name]: value for name, value in move.after.items()}, memory)
