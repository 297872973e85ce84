"""Formulas of one moment as literals: of the moment after a step, before it, and at the start."""

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import TRUE, Literal
from exover.engines.aig.circuit.words import as_word, lit
from exover.engines.aig.encoding.state import Latches
from exover.loop.exact.predicates import Predicates
from exover.loop.exact.step_predicates import moment
from exover.loop.exact.symbolic_state import Note, SymbolicState
from exover.loop.exact.term import Term
from exover.model.property import Assumption, Atom, Disjunction, Formula, Happened, Label, Occurrence, Passed, atoms


@dataclass
class MomentFormulas:
    """Makes literals of formulas without temporal operators, in the graph of a step.

    `initial`, `after`: the variables at the start, and after the step; `step`: has its marks and notes.
    """

    latches: Latches
    initial: dict[str, Term]
    after: dict[str, Term]
    step: SymbolicState
    assumptions: tuple[Assumption, ...]

    def __post_init__(self) -> None:
        self.graph = self.latches.terms.graph

    def truth(self, formula: Formula) -> Literal:
        """Return where a formula is true of the moment after the step."""
        return self._truth(formula, self._next_predicates, after=True)

    @cached_property
    def _next_predicates(self) -> tuple[Predicates, Predicates]:
        return self._predicates_of(self.after)

    def now(self, formula: Formula) -> Literal:
        """Return where a formula is true of the moment before the step, of which nothing is known but the state."""
        return self._truth(formula, self._predicates_of(self.latches.vars), after=False)

    def at_start(self, formula: Formula) -> bool:
        """Return whether a formula is true of the start."""
        return self._truth(formula, self._predicates_of(self.initial), after=False) == TRUE

    def _predicates_of(self, values: dict[str, Term]) -> tuple[Predicates, Predicates]:
        layout = copy(self.latches)
        layout.vars = values
        return Predicates(layout), Predicates(layout, once_stopped=True)

    def _truth(self, formula: Formula, predicates: tuple[Predicates, Predicates], after: bool) -> Literal:
        def happened(atom: Happened | Passed) -> Term:
            if not after:
                return self.latches.terms.false
            if isinstance(atom, Passed):
                return self._passed(atom.label)
            return predicates[0].happened(self.step.notes, atom)

        return lit(moment(*predicates, happened, formula))

    def mark(self, label: Label) -> Literal:
        """Return where the step passes a mark."""
        return lit(self._passed(label))

    def _passed(self, label: Label) -> Term:
        return self.step.marks.get(label, self.latches.terms.false)

    def notes(self, occurrence: Occurrence, request: str) -> Sequence[Note]:
        """Return where, and with which arguments, the step does this with a request."""
        return self._notes.get((occurrence, request), ())

    @cached_property
    def _notes(self) -> dict[tuple[Occurrence, str], list[Note]]:
        found: dict[tuple[Occurrence, str], list[Note]] = {}
        for note in self.step.notes:
            found.setdefault((note.occurrence, note.request), []).append(note)
        return found

    # ---- what is known of states ----

    @cached_property
    def domain(self) -> Literal:
        """True in every reachable state: latches are values of their variables, and assumptions on states hold."""
        words = ((as_word(self.latches.vars[name]), span) for name, span in self.latches.spans.items())
        legal = [self.latches.legal(word, span) for word, span in words if word.sort != "Bool"]
        assumed = [each.formula for each in self.assumptions]
        lasting = [
            f for f in assumed if not any(isinstance(a, Happened | Passed) for a in atoms(f)) and self.at_start(f)
        ]
        return self.graph.all((*legal, *map(self.now, lasting)))

    @cached_property
    def owed(self) -> dict[str, tuple[Literal, Literal]]:
        """By request that some required launch is for: where that is due and the request is neither active nor waits,
        before the step and after it."""
        rules: dict[str, list[Formula]] = {}
        for launch in self.latches.model.launches:
            rules.setdefault(launch.request, []).append(Atom(launch.condition))
        found = {}
        for name, due in rules.items():
            flags = [slot.active for (owner, _), slot in self.latches.slots.items() if owner == name]
            flags.append(self.latches.places[name].taken)
            found[name] = (
                self._idle(flags, self.latches.vars, self.now(Disjunction(tuple(due)))),
                self._idle(flags, self.after, self.truth(Disjunction(tuple(due)))),
            )
        return found

    def _idle(self, flags: Sequence[str], values: Mapping[str, Term], due: Literal) -> Literal:
        return self.graph.all((due, *(lit(values[flag]) ^ 1 for flag in flags)))
