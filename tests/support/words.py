"""Runs as words: what a formula of LTL says of one trace, moment by moment, by its definition."""

from dataclasses import dataclass
from typing import assert_never

from exover.model.evaluate import holds
from exover.model.event import Report
from exover.model.model import Model
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
    atoms,
)
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Trace
from tests.support.moments import happening


@dataclass
class Word:
    """The moments of a trace, the start first; after the last comes `back` again, or the last itself for ever.

    Which predicates on steps hold at a moment is asked of the interpreter; `back` is that of the step that returns.
    """

    model: Model
    states: list[State]
    happened: list[frozenset[Happened]]
    reported: list[frozenset[tuple[str, int]]]
    back: int | None

    def after(self, moment: int) -> int:
        """Return the moment after this one."""
        if moment + 1 < len(self.states):
            return moment + 1
        return len(self.states) - 1 if self.back is None else self.back

    def satisfies(self, formula: Formula) -> bool:
        """Return whether the word satisfies a formula of LTL."""
        return 0 in self.where(formula)

    def where(self, formula: Formula) -> set[int]:
        """Return the moments from which the word satisfies a formula of LTL."""
        everywhere = set(range(len(self.states)))
        match formula:
            case Atom(condition):
                return {k for k in everywhere if holds(self.model, self.states[k], condition)}
            case Happened():
                return {k for k in everywhere if formula in self.happened[k]}
            case Negation(part):
                return everywhere - self.where(part)
            case Conjunction(parts):
                return everywhere.intersection(*map(self.where, parts))
            case Disjunction(parts):
                return set().union(*map(self.where, parts))
            case Next(part):
                inner = self.where(part)
                return {k for k in everywhere if self.after(k) in inner}
            case Until(left, right):
                stay, found = self.where(left), self.where(right)
                for _ in everywhere:
                    found = found | {k for k in stay if self.after(k) in found}
                return found
            case SomeNext() | SomeUntil() | SomeAlways():
                raise AssertionError("a word knows no other")
            case _:
                assert_never(formula)

    def is_fair(self) -> bool:
        """Return whether every slot is idle or reported somewhere in what is repeated; there must be something."""
        assert self.back is not None
        repeated = range(self.back, len(self.states))
        return all(
            any(
                self.states[k].slots[request.name][slot] is None or (request.name, slot) in self.reported[k]
                for k in repeated
            )
            for request in self.model.requests
            for slot in range(request.instances)
        )


def word_of(model: Model, trace: Trace, formulas: list[Formula]) -> Word:
    """Return the word of a trace for these formulas; a lasso is followed round once more, so that its moments are those
    of steps that return.
    """
    reference = Reference(model)
    asked = [atom for formula in formulas for atom in atoms(formula) if isinstance(atom, Happened)]
    events = trace.events if trace.loop_start is None else (*trace.events, *trace.events[trace.loop_start :])
    word = Word(model, [reference.start()], [frozenset()], [frozenset()], None)
    for event in events:
        before = word.states[-1]
        word.happened.append(happening(model, before, event, asked))
        word.reported.append(frozenset((event.request, event.slot) for event in (event,) if isinstance(event, Report)))
        word.states.append(reference.step(before, event)[0])
    if trace.loop_start is not None:
        word.back = len(trace.events) + 1
        assert word.states[-1].key() == word.states[len(trace.events)].key()
    return word
