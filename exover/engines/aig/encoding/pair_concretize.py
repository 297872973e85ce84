"""From runs of the graph of two versions to concrete events, followed on the reference interpreter of each."""

from collections.abc import Iterator
from functools import cached_property
from itertools import chain

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.words import as_word
from exover.engines.aig.encoding.common_events import NEW, OLD, CommonEvent
from exover.engines.aig.encoding.concretize import Anchor, LaneValues, anchors, values_given
from exover.engines.aig.encoding.range_allocation import Family
from exover.engines.aig.encoding.state import Given, family_of
from exover.engines.aig.encoding.versions import VersionPair
from exover.engines.aig.simulation.evaluation import Evaluator, whole_evaluator
from exover.engines.aig.simulation.lanes import initial
from exover.engines.aig.simulation.replay import replay
from exover.loop.exact.events import event_of, parameters
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
        states = [reference.start() for reference in self._references]
        found: list[Both] = []
        for _, values, _ in replay(cone, initial(self._circuit.latches, 1), [run]):
            lane = LaneValues(cone, values, 0)
            if lane.true(self.pair.legal):
                both = self._event(lane, (states[0], states[1]))
                found.append(both)
                for side, event in enumerate(both):
                    if event is not None:
                        states[side], _ = self._references[side].step(states[side], event)
        return tuple(found)

    def _event(self, lane: LaneValues, states: tuple[State, State]) -> Both:
        stimuli = self.pair.stimuli
        number = next(n for n, here in enumerate(stimuli.here) if lane.true(here))
        event = stimuli.events[number]
        given = stimuli.given.get(number, ())
        values = self._values(event, given, lane, states)
        named = {each.parameter.name: value for each, value in zip(given, values, strict=True)}
        old, new = (self._of_version(side, event, named) for side in (OLD, NEW))
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
    ) -> tuple[Value, ...]:
        """Return the values that come with an event; reals compare with those that either version holds."""
        sides = zip(self.pair.sides, states, event.kinds, strict=True)
        knowing = [(side, state, kind) for side, state, kind in sides if kind is not None]

        def compared(each: Given) -> Family:  # both compare the same reals with each other
            side, _, kind = knowing[0]
            return side.latches.grids.first(family_of(kind, each.parameter))

        def held(each: Given) -> Iterator[Anchor]:
            return chain.from_iterable(anchors(side, state, lane, kind, each) for side, state, kind in knowing)

        return values_given(given, lane, compared, held)
