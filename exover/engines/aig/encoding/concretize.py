"""From runs of the graph to concrete ones: events with real arguments, followed on the reference interpreter."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Inputs
from exover.engines.aig.circuit.graph import Circuit, Literal
from exover.engines.aig.circuit.words import Grid, as_word
from exover.engines.aig.encoding.encoder import EncodedEvent, Encoding
from exover.engines.aig.encoding.range_allocation import Family
from exover.engines.aig.encoding.state import Given, family_of, number
from exover.engines.aig.simulation.evaluation import ConeValues, Evaluator, whole_evaluator
from exover.engines.aig.simulation.lanes import initial
from exover.engines.aig.simulation.replay import replay
from exover.loop.exact.events import Kind, event_of, value_of
from exover.loop.exact.term import Term
from exover.model.event import Event
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.trace import Disagreement, Moment, Trace
from exover.model.types import Value, plain

Anchor = tuple[int, float]
"""The position of a real, and its concrete value."""


class Spurious(Exception):
    """A run of the graph is none of the loop: no doubles fit it, or the passes do not settle one of its steps."""


@dataclass(frozen=True, slots=True)
class LaneValues:
    """The values of the nodes of a cone in one of several runs."""

    cone: Evaluator
    values: ConeValues
    lane: int

    def true(self, literal: Literal) -> bool:
        """Return whether a literal is true."""
        return bool(self.cone.read(self.values, literal, -1) >> self.lane & 1)

    def number(self, term: Term) -> int:
        """Return the value of a word: a number, or a position."""
        word = as_word(term)
        return word.low + sum(self.true(bit) << k for k, bit in enumerate(word.bits))


@dataclass(frozen=True)
class Concretizer:
    """Makes concrete runs of an encoding's runs."""

    encoding: Encoding

    @cached_property
    def reference(self) -> Reference:
        """The interpreter on which runs are followed."""
        return Reference(self.encoding.compiled.model)

    @cached_property
    def _circuit(self) -> Circuit:
        values = [given.term for event in self.encoding.events for given in event.given]
        bits = [bit for value in (*values, *self.encoding.reembedded.values()) for bit in as_word(value).bits]
        return self.encoding.circuit([self.encoding.legal, self.encoding.unsettled, *bits])

    @cached_property
    def _cone(self) -> Evaluator:
        return whole_evaluator(self._circuit)

    def traces(self, runs: Sequence[Inputs]) -> list[Trace | Spurious]:
        """Return for each run its trace, without steps in which nothing happens, or why it has none.

        Raises `Disagreement` if the reference interpreter comes to another state at the end than the graph.
        """
        return [run.spurious or Trace(tuple(run.moments)) for run in self._followed(runs)]

    def walk(self, inputs: Inputs) -> tuple[Trace, tuple[State, ...]]:
        """Return the concrete run and its states, that before each moment, and the last; raises `Spurious`."""
        (found,) = self._followed([inputs])
        if found.spurious is not None:
            raise found.spurious
        return Trace(tuple(found.moments)), tuple(found.states)

    def events(self, inputs: Inputs) -> tuple[Event, ...]:
        """Return the events of one run; raises `Spurious`."""
        return self.walk(inputs)[0].events

    def _followed(self, runs: Sequence[Inputs]) -> "list[_Run]":
        """Return runs that were followed to their ends. Raises `Disagreement`."""
        words = initial(self._circuit.latches, (1 << len(runs)) - 1)
        following = [_Run([self.reference.start()]) for _ in runs]
        for step, (_, values, after) in enumerate(replay(self._cone, words, runs)):
            for lane, run in enumerate(runs):
                if step < len(run):
                    self._follow(following[lane], run[step], LaneValues(self._cone, values, lane))
            words = after
        for lane, followed in enumerate(following):
            if followed.spurious is None:
                self._compare(words, lane, followed)
        return following

    def _follow(self, run: "_Run", inputs: frozenset[int], lane: LaneValues) -> None:
        """Take the step of one run on the reference interpreter, unless nothing happens in it."""
        legal, unsettled = self._circuit.bad[:2]
        if run.spurious is not None or not lane.true(legal):
            return
        if lane.true(unsettled):
            run.spurious = Spurious(f"a step of it may take more than {self.encoding.passes} passes")
            return
        event = self.encoding.chosen(inputs)
        try:
            concrete = event_of(event.kind, self._arguments(event, lane, run.states[-1]))
        except Spurious as reason:
            run.spurious = reason
            return
        state, actions = self.reference.step(run.states[-1], concrete)
        run.states.append(state)
        run.moments.append(Moment(concrete, actions))

    # ---- values ----

    def _arguments(self, event: EncodedEvent, lane: LaneValues, state: State) -> tuple[Value, ...]:
        def compared(given: Given) -> Family:
            return self.encoding.latches.grids.first(family_of(event.kind, given.parameter))

        def held(given: Given) -> Iterator[Anchor]:
            return anchors(self.encoding, state, lane, event.kind, given)

        return values_given(event.given, lane, compared, held)

    def _compare(self, words: Mapping[int, int], lane: int, run: "_Run") -> None:
        latches = self.encoding.latches
        for name, held in latches.counted(run.states[-1]):
            span, bits = latches.spans[name], latches.literals[name]
            mine = span.low + sum((words[bit >> 1] >> lane & 1) << k for k, bit in enumerate(bits))
            its = number(latches.types[name], span, held)
            if span.grid is not None:  # reals are compared by their cells
                mine, its = mine >> span.grid.places, its >> span.grid.places
            if mine != its:
                event = run.moments[-1].event if run.moments else "the start"
                raise Disagreement(f"after {event} `{name}` is {held}; the graph has {mine} for it, not {its}")


@dataclass
class _Run:
    """A run while it is followed."""

    states: list[State]
    """The state before each moment, and the last one."""
    moments: list[Moment] = field(default_factory=list)
    spurious: Spurious | None = None


def values_given(
    given: Sequence[Given],
    lane: LaneValues,
    compared: Callable[[Given], Family],
    held: Callable[[Given], Iterable[Anchor]],
) -> tuple[Value, ...]:
    """Return concrete values that come with an event; raises `Spurious`.

    `compared`: returns the first of the families that one is compared with; `held`: the reals of the state that it is
    compared with.
    """
    found: list[Value] = []
    fresh: dict[Family, list[Anchor]] = {}
    for each in given:
        position, grid = lane.number(each.term), each.span.grid
        if grid is None:
            found.append(value_of(each.parameter.type, position))
            continue
        together = fresh.setdefault(compared(each), [])
        real = real_at(grid, position, [*held(each), *together])
        together.append((position, real))
        found.append(real)
    return tuple(found)


def anchors(encoding: Encoding, state: State, lane: LaneValues, kind: Kind, given: Given) -> Iterator[Anchor]:
    """Yield the reals that are held and compared with one that comes with an event of a kind."""
    if given.span.grid is not None and given.span.grid.places:
        layout, moved = encoding.latches, encoding.reembedded
        group = layout.grids.first(family_of(kind, given.parameter))
        for name, held in layout.counted(state):
            if layout.spans[name].grid is not None and layout.grids.first(layout.family(name)) == group:
                assert isinstance(held, float)
                yield lane.number(moved[name]), held


def real_at(grid: Grid, position: int, fixed: Sequence[Anchor]) -> float:
    """Return a double that compares with constants and fixed reals as its position does; raises `Spurious`."""
    cell = position >> grid.places
    if cell & 1:
        return float(grid.constants[cell // 2])
    same = [v for p, v in fixed if p == position]
    if same:
        return same[0]
    low = [float(grid.constants[cell // 2 - 1]), *(v for p, v in fixed if p < position)]
    high = [float(grid.constants[cell // 2]), *(v for p, v in fixed if p > position)]
    return between(max(low), min(high))


def between(low: float, high: float) -> float:
    """Return a double strictly between two, one with few digits where there is one; raises `Spurious`."""
    found = plain(low, high)
    if found is None:
        raise Spurious("there are not enough doubles between two values of a run")
    return found
