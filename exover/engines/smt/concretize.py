"""Concretization of runs that the solver finds: doubles for its fractions, events, and their replay.

The solver's reals are mathematical reals, the language's are doubles. A run depends only on comparisons, so fractions
may be moved as long as their order among each other and to the constants of the system is kept: those between two
neighbouring constants are replaced by as many doubles. If there are not enough doubles, the run does not exist.
"""

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.steps import Input, SymbolicSteps
from exover.engines.smt.system import System
from exover.engines.smt.unrolling import Taken, reals
from exover.loop.exact.events import event_of, value_of
from exover.loop.exact.layout import Layout
from exover.loop.exact.term import Term
from exover.model.event import Args, Ask, Event, Observe, Report
from exover.model.trace import Disagreement, Trace, run
from exover.ocrd.tables import Tables
from exover.ocrd.trace_replay import TraceReplay

ROUNDS = 8
"""How often the part of a run that is repeated is gone through until all that it does not look at is the same again."""


class SpuriousModel(Exception):
    """A real of the solver's run cannot be replaced by a double."""


@dataclass(frozen=True)
class ModelConcretizer:
    """Makes concrete runs of one closed loop, and confirms them."""

    steps: SymbolicSteps
    tables: Tables

    def events(self, system: System, taken: Sequence[Taken]) -> tuple[Event, ...]:
        """Return the events of a run; raises `SpuriousModel`."""
        doubles = as_doubles(reals(taken), system.constants)
        found = []
        for each in taken:
            values = []
            for one in self.steps.inputs(each.kind):
                number = each.values.get(one.var.name)
                values.append(doubles[number] if isinstance(number, Fraction) else value_of(one.parameter.type, number))
            found.append(event_of(each.kind, tuple(values)))
        return tuple(found)

    def trace(self, events: tuple[Event, ...]) -> Trace:
        """Return the run that these events have on the reference interpreter, which the tables' walker confirms."""
        trace = run(self._replay.reference, events)
        self._replay.confirm(trace)
        return trace

    def lasso(self, events: tuple[Event, ...], loop_start: int) -> Trace:
        """Return the run that repeats the events from `loop_start` on for ever.

        The solver's states are the same before and after; of what it does not look at, arguments move from places to
        slots to pasts, so after some rounds that is the same as well.
        """
        reference, stem, repeated = self._replay.reference, events[:loop_start], events[loop_start:]
        states = [reference.start()]
        for event in stem + repeated * ROUNDS:
            states.append(reference.step(states[-1], event)[0])
        for first in range(len(stem), len(states) - 1, len(repeated)):
            if states[first].key() == states[first + len(repeated)].key():
                trace = run(reference, (stem + repeated * ROUNDS)[: first + len(repeated)], first)
                self._replay.confirm(trace)
                return trace
        raise AssertionError("a run that should repeat itself does not")

    def followed(self, system: System, taken: Sequence[Taken], events: Sequence[Event]) -> dict[Term, Term]:
        """Return the moment that the moves of a system come to by these events.

        Raises `Disagreement` unless they are allowed and lead where the reference interpreter says.
        """
        terms, layout = system.terms, system.layout
        values, reference = system.initial, self._replay.reference
        state = reference.start()
        for each, event in zip(taken, events, strict=True):
            move = next(move for move in system.moves if move.kind == each.kind)
            now = {**values, **inputs_of(layout, self.steps.inputs(each.kind), event)}
            memory: dict[Term, Term] = {}
            after = {system.vars[name]: terms.replaced(term, now, memory) for name, term in move.after.items()}
            values, (state, _) = {**values, **after}, reference.step(state, event)
            wanted = layout.of_state(state)
            counting = (n for n in system.vars if n in wanted and layout.counts(n, wanted))
            if terms.replaced(move.allowed, now) is not terms.true or any(
                values[system.vars[name]] is not wanted[name] for name in counting
            ):
                raise Disagreement(f"a step of the formulas, {each.kind}, is not that of the reference")
        return values

    @cached_property
    def _replay(self) -> TraceReplay:
        return TraceReplay(self.steps.model, self.tables)


def as_doubles(values: Iterable[Fraction], fixed: Sequence[Fraction]) -> dict[Fraction, float]:
    """Return a double for each fraction so that they compare with each other and with `fixed` as before."""
    found = {each: float(each) for each in fixed}
    gaps: dict[int, list[Fraction]] = {}
    for value in sorted(set(values) - set(fixed)):
        gaps.setdefault(bisect_left(fixed, value), []).append(value)
    for number, inside in gaps.items():
        low = float(fixed[number - 1]) if number else -math.inf
        high = float(fixed[number]) if number < len(fixed) else math.inf
        found |= zip(inside, between(low, high, inside), strict=True)
    return found


def between(low: float, high: float, wanted: Sequence[Fraction]) -> list[float]:
    """Return increasing doubles strictly between two, each near the one that is wanted; raises `SpuriousModel`."""
    found: list[float] = []
    for value in wanted:
        least = math.nextafter(found[-1] if found else low, math.inf)
        found.append(max(float(value), least))
    greatest = high
    for number in reversed(range(len(found))):
        greatest = math.nextafter(greatest, -math.inf)
        found[number] = min(found[number], greatest)
        greatest = found[number]
    if any(not one < other for one, other in zip((low, *found), (*found, high), strict=True)):
        raise SpuriousModel("there are not enough doubles between two constants")
    return found


def inputs_of(layout: Layout, inputs: tuple[Input, ...], event: Event) -> dict[Term, Term]:
    """Return the values that an event brings."""
    match event:
        case Ask(_, args):
            values: Args = args
        case Report(_, _, _, results):
            values = results
        case Observe(_, value):
            values = (value,)
        case _:
            values = ()
    parameters = tuple(each.parameter for each in inputs)
    return dict(zip((each.var for each in inputs), layout.values(parameters, values), strict=True))
