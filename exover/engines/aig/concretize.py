"""From runs of the graph to concrete ones: events with real arguments, followed on the reference interpreter."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite

from exover.engines.aig.answer import Inputs
from exover.engines.aig.encoder import Encoding, Event
from exover.engines.aig.graph import Literal
from exover.engines.aig.state import Given
from exover.engines.aig.words import Grid, Word, as_word
from exover.loop.events import event_of, value_of
from exover.loop.layout import level_name
from exover.loop.term import Term
from exover.model.event import Event as Concrete
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Disagreement
from exover.model.types import Bool, Real, Value, ordinal
from exover.ocrd.vector import OUTCOMES

Values = Sequence[bool]
"""By node whether it is true."""


class Spurious(Exception):
    """A run of the graph has no doubles in it."""


@dataclass(frozen=True)
class Concretizer:
    """Makes concrete runs of an encoding's runs."""

    encoding: Encoding

    @cached_property
    def reference(self) -> Reference:
        """The interpreter on which runs are followed."""
        return Reference(self.encoding.compiled.model)

    def events(self, inputs: Inputs) -> tuple[Concrete, ...]:
        """Return the events of a run, steps in which nothing happens left out.

        Raises `Spurious`, and `Disagreement` unless every state is the one that the reference interpreter comes to.
        """
        state, found = self.reference.start(), []
        latches = dict(self.encoding.graph.latches)
        for step in inputs:
            values = self.evaluated(latches, step)
            latches = {node: value(values, self.encoding.following[2 * node]) for node in latches}
            if not value(values, self.encoding.legal):
                continue
            (event,) = (e for e in self.encoding.events if value(values, as_word(e.chosen).bits[0]))
            concrete = event_of(event.kind, self._arguments(event, values, state))
            state, _ = self.reference.step(state, concrete)
            found.append(concrete)
            self._compare(latches, state, concrete)
        return tuple(found)

    def evaluated(self, latches: dict[int, bool], inputs: frozenset[int]) -> Values:
        """Return the value of every node for a state and the inputs that are true."""
        values = [False] * len(self.encoding.graph.fanins)
        for node, pair in enumerate(self.encoding.graph.fanins):
            if pair is None:
                values[node] = node in inputs or latches.get(node, False)
            else:
                left, right = pair
                values[node] = values[left >> 1] != (left & 1) and values[right >> 1] != (right & 1)
        return values

    # ---- values ----

    def _arguments(self, event: Event, values: Values, state: State) -> tuple[Value, ...]:
        found: list[Value] = []
        fresh: list[tuple[Grid, int, float]] = []
        for given in event.given:
            position = number(values, given.term)
            grid = given.span.grid
            if grid is None:
                found.append(value_of(given.parameter.type, position))
                continue
            fixed = list(self._anchors(values, state, grid)) + [(p, v) for g, p, v in fresh if g == grid]
            real = self._real(given, grid, position, fixed)
            fresh.append((grid, position, real))
            found.append(real)
        return tuple(found)

    def _real(self, given: Given, grid: Grid, position: int, fixed: list[tuple[int, float]]) -> float:
        """Return a double that lies to constants, and to the reals that are held, as its position does to theirs."""
        cell = position >> grid.places
        if cell & 1:
            return float(grid.constants[cell // 2])
        low = [float(grid.constants[cell // 2 - 1])] + [v for p, v in fixed if p < position]
        high = [float(grid.constants[cell // 2])] + [v for p, v in fixed if p > position]
        if grid.places:
            same = [v for p, v in fixed if p == position]
            if same:
                return same[0]
        else:
            low, high = low[:1], high[:1]
        return between(max(low), min(high))

    def _anchors(self, values: Values, state: State, grid: Grid) -> Iterator[tuple[int, float]]:
        moved, spans = self.encoding.reembedded, self.encoding.latches.spans
        for name, held in holders(self.encoding, state):
            if grid.places and spans[name].grid == grid:
                assert isinstance(held, float)
                yield number(values, moved[name]), held

    def _compare(self, latches: dict[int, bool], state: State, event: Concrete) -> None:
        for name, held in holders(self.encoding, state):
            span = self.encoding.latches.spans[name]
            mine = span.low + sum(latches[bit >> 1] << k for k, bit in enumerate(self.encoding.latches.literals[name]))
            its = _number(self.encoding, name, held)
            if span.grid is not None:
                mine >>= span.grid.places
            if mine != its:
                raise Disagreement(
                    f"after {event} `{name}` is {held}, and the graph has number {mine} for it, not {its}"
                )


def holders(encoding: Encoding, state: State) -> Iterator[tuple[str, Value]]:
    """Yield the variables that count in a concrete state, with their values."""
    layout = encoding.latches
    yield from state.readings.items()
    yield from ((level_name(name), level) for name, level in state.levels.items())
    for request in layout.model.requests:
        for k, content in enumerate(state.slots[request.name]):
            slot = layout.slots[request.name, k]
            yield slot.active, content is not None
            if content is not None:
                yield slot.stopping, content.phase == "stopping"
                yield from zip(slot.args, content.args, strict=True)
        place, standing = layout.places[request.name], state.places[request.name]
        yield place.taken, standing is not None
        if standing is not None:
            yield place.clearing, standing.clearing
            yield from zip(place.args, standing.args, strict=True)
        memory, past = layout.memories[request.name], state.past[request.name]
        yield memory.known, past is not None
        if past is not None:
            yield from zip(memory.values, past, strict=True)
        yield memory.last, state.last[request.name]


def _number(encoding: Encoding, name: str, held: Value) -> int:
    """Return the number of a value, of a real that of its cell."""
    kind, span = encoding.latches.types[name], encoding.latches.spans[name]
    if isinstance(kind, Bool):
        return int(held)
    if span.grid is None:
        return OUTCOMES.index(held) if name.endswith(" last") and held in OUTCOMES else ordinal(kind, held)
    assert isinstance(kind, Real) and not isinstance(held, str)
    from fractions import Fraction

    return span.grid.position(Fraction(float(held))) >> span.grid.places


def value(values: Values, literal: Literal) -> bool:
    """Return whether a literal is true."""
    return values[literal >> 1] != (literal & 1)


def number(values: Values, term: Term) -> int:
    """Return the number, or position, that a word is."""
    word: Word = as_word(term)
    return word.low + sum(value(values, bit) << k for k, bit in enumerate(word.bits))


def between(low: float, high: float) -> float:
    """Return a double strictly between two, one with few digits where there is one; raises `Spurious`."""
    middle = low / 2 + high / 2
    if isfinite(middle):
        for digits in range(-3, 12):
            short = round(middle, digits)
            if low < short < high:
                return short
    if not low < middle < high:
        raise Spurious("there are not enough doubles between two values of a run")
    return middle
