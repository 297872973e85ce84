"""From runs of the graph of two versions to concrete events, followed on the reference interpreter of each."""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.words import Grid, as_word
from exover.engines.aig.encoding.common_events import CommonEvent
from exover.engines.aig.encoding.concretize import LaneValues, anchors, family_of, real_at
from exover.engines.aig.encoding.state import Given
from exover.engines.aig.encoding.versions import VersionPair
from exover.engines.aig.simulation.evaluation import Evaluator, whole_evaluator
from exover.engines.aig.simulation.lanes import initial
from exover.loop.exact.events import event_of, parameters, value_of
from exover.model.event import Event, Observe
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Value

Both = tuple[Event | None, Event | None]
"""What comes to OLD and to NEW in a step; None: nothing."""


@dataclass(frozen=True)
class PairConcretizer:
    """Makes concrete events of the runs of a pair; `agree`: literal of the steps that both answer alike."""

    pair: VersionPair
    agree: Literal

    @cached_property
    def _references(self) -> tuple[Reference, Reference]:
        old, new = (Reference(side.compiled.model) for side in self.pair.sides)
        return old, new

    @cached_property
    def _circuit(self) -> Circuit:
        pair = self.pair
        terms = [given.term for found in pair.stimuli.given.values() for given in found]
        terms += [as_word(term) for side in pair.sides for term in side.reembedded.values()]
        bits = [bit for term in terms for bit in term.bits]
        return pair.circuit(self.agree, [pair.legal, *pair.stimuli.here, *bits])

    @cached_property
    def _cone(self) -> Evaluator:
        return whole_evaluator(self._circuit)

    def events(self, run: Inputs) -> tuple[Both, ...]:
        """Return the events of a run by step, without steps in which nothing happens; raises `Spurious`."""
        cone = self._cone
        words = initial(self._circuit.latches, 1)
        states = [reference.start() for reference in self._references]
        found: list[Both] = []
        for inputs in run:
            values = cone.values(words, dict.fromkeys(inputs, 1))
            lane = LaneValues(cone, values, 0)
            if lane.true(self.pair.legal):
                both = self._event(lane, (states[0], states[1]))
                found.append(both)
                for side, event in enumerate(both):
                    if event is not None:
                        states[side], _ = self._references[side].step(states[side], event)
            words = cone.after(values, 1)
        return tuple(found)

    def _event(self, lane: LaneValues, states: tuple[State, State]) -> Both:
        stimuli = self.pair.stimuli
        number = next(n for n, here in enumerate(stimuli.here) if lane.true(here))
        event = stimuli.events[number]
        values = self._values(event, stimuli.given.get(number, ()), lane, states)
        old, new = (self._of_version(side, event, values) for side in (0, 1))
        return old, new

    def _of_version(self, side: int, event: CommonEvent, values: dict[str, Value]) -> Event | None:
        kind = event.kinds[side]
        if kind is None:
            return None
        if event.broken is not None:
            taken = event.broken[side]
            assert taken is not None
            return Observe(kind.name, taken, broken=True)
        return event_of(kind, tuple(values[p.name] for p in parameters(self.pair.sides[side].compiled.model, kind)))

    def _values(
        self, event: CommonEvent, given: tuple[Given, ...], lane: LaneValues, states: tuple[State, State]
    ) -> dict[str, Value]:
        found: dict[str, Value] = {}
        fresh: list[tuple[int, float]] = []
        for each in given:
            position, grid = lane.number(each.term), each.span.grid
            if grid is None:
                found[each.parameter.name] = value_of(each.parameter.type, position)
                continue
            fixed = [*self._anchors(event, each, lane, states, grid), *fresh]
            found[each.parameter.name] = real = real_at(grid, position, fixed)
            fresh += [(position, real)] if grid.places else []
        return found

    def _anchors(
        self, event: CommonEvent, given: Given, lane: LaneValues, states: tuple[State, State], grid: Grid
    ) -> Iterator[tuple[int, float]]:
        """Yield positions and values of the reals that either version holds and compares with a value of an event."""
        for side, state, kind in zip(self.pair.sides, states, event.kinds, strict=True):
            if kind is not None:
                yield from anchors(side, state, lane, grid, side.latches.grids.first(family_of(kind, given)))
