"""Runs of an encoding and of the reference interpreter side by side, compared after every step.

Some lanes of a simulation are given the events of a random stream, made into inputs; the others random inputs, made
into events. What the step of the graph did, and where it led, must be what the reference interpreter says.
"""

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from random import Random

from exover.engines.aig.circuit.words import as_word, lit
from exover.engines.aig.encoding.concretize import Concretizer, LaneValues, Spurious
from exover.engines.aig.encoding.encoder import EncodedEvent, Encoding
from exover.engines.aig.encoding.state import Given, family_of, number
from exover.engines.aig.simulation.evaluation import evaluator
from exover.engines.aig.simulation.stimulus import RandomStimulus
from exover.loop.exact.events import event_of
from exover.loop.exact.layout import resting_value
from exover.model.evaluate import holds
from exover.model.event import Abort, AbortWaiting, Args, Ask, Event, Invalid, Observe, Report
from exover.model.property import Atom, Broken, Conjunction, Disjunction, Formula, Happened, Negation
from exover.model.state import State
from exover.model.types import Bool, Value, ordinal
from exover.model.wire_reading import read_event
from tests.support.events import Stream
from tests.support.moments import happening
from tests.support.oracle import _broken as broken
from tests.support.recording import done

Place = tuple[object, int, float]
"""A group of reals that are compared with each other, a cell of their grid, and a value in it."""


class NoRoom(Exception):
    """There are more reals between two constants than places for them."""


@dataclass
class Inverse:
    """Makes inputs that are a concrete event in a concrete state."""

    encoding: Encoding
    numbers: dict[tuple[str, str, int, str], int] = field(default_factory=dict)
    groups: dict[object, list[str]] = field(default_factory=dict)
    """By the first of the families that are compared with each other the variables of these."""

    def __post_init__(self) -> None:
        for which, event in enumerate(self.encoding.events):
            self.numbers[event.kind.verb, event.kind.name, event.kind.slot, event.kind.outcome] = which
        layout = self.encoding.latches
        for name, span in layout.spans.items():
            if span.grid is not None and span.grid.places:
                self.groups.setdefault(layout.grids.first(layout.family(name)), []).append(name)

    def kind_of(self, event: Event, state: State) -> tuple[int, Args]:
        """Return the number of the kind of an event, and its values."""
        match event:
            case Ask(name, args):
                return self.numbers["ask", name, 0, "ok"], args
            case Report(name, slot, outcome, results):
                return self.numbers["report", name, slot, outcome], results if outcome == "ok" else ()
            case Abort(name, slot):
                return self.numbers["abort", name, slot, "ok"], ()
            case AbortWaiting(name):
                return self.numbers["abort waiting", name, 0, "ok"], ()
            case Observe(name, value):
                verb = "observe level" if name in state.levels else "observe"
                return self.numbers[verb, name, 0, "ok"], (value,)

    def inputs(self, event: Event, state: State, words: Mapping[int, int], lane: int) -> frozenset[int]:
        """Return the inputs that are true; the state is that of a lane; raises `NoRoom`."""
        number, values = self.kind_of(event, state)
        chosen = self.encoding.events[number]
        true = {node for k, node in enumerate(self.encoding.code) if number >> k & 1}
        held = self._held(state)
        fresh = [
            (self.group(chosen, given), float(value))
            for given, value in zip(chosen.given, values, strict=True)
            if given.span.grid is not None
        ]
        places = self._dealt([*held.values(), *fresh])
        for given, value in zip(chosen.given, values, strict=True):
            true |= self._bits(chosen, given, value, places)
        shifts = iter(self.encoding.shifts)
        for name, (group, value) in held.items():
            span = self.encoding.latches.spans[name]
            assert span.grid is not None
            place = places.get((group, self._cell(group, value), value), 0)
            for k, bit in enumerate(self.encoding.latches.literals[name][: span.grid.places]):
                if (place >> k & 1) != (words[bit >> 1] >> lane & 1):
                    true.add(next(shifts))
                else:
                    next(shifts)
            for _ in range(span.grid.places - len(self.encoding.latches.literals[name])):
                next(shifts)
        return frozenset(true)

    def _held(self, state: State) -> dict[str, tuple[object, float]]:
        """Return by variable, in the order in which they are moved, its group and value."""
        layout, here = self.encoding.latches, dict(self.encoding.latches.counted(state))
        return {
            name: (group, float(here.get(name, resting_value(layout.types[name]))))
            for group, names in self.groups.items()
            for name in names
        }

    def group(self, chosen: EncodedEvent, given: Given) -> object:
        """Return the first of the families that a value of an event is compared with."""
        return self.encoding.latches.grids.first(family_of(chosen.kind, given.parameter))

    def _cell(self, group: object, value: float) -> int:
        names = self.groups.get(group)
        if not names:
            return 1
        grid = self.encoding.latches.spans[names[0]].grid
        assert grid is not None
        return grid.position(Fraction(value)) >> grid.places

    def _dealt(self, reals: Iterable[tuple[object, float]]) -> dict[Place, int]:
        """Return the place of each real between two constants: those of one cell in their order."""
        cells: dict[tuple[object, int], set[float]] = {}
        for group, value in reals:
            cell = self._cell(group, value)
            if not cell & 1:
                cells.setdefault((group, cell), set()).add(value)
        found: dict[Place, int] = {}
        for (group, cell), values in cells.items():
            grid = self.encoding.latches.spans[self.groups[group][0]].grid
            assert grid is not None
            if len(values) > 1 << grid.places:
                raise NoRoom(f"{sorted(values)} in {1 << grid.places} places of {group}")
            found |= {(group, cell, value): place for place, value in enumerate(sorted(values))}
        return found

    def _bits(self, chosen: EncodedEvent, given: Given, value: Value, places: Mapping[Place, int]) -> set[int]:
        span, kind = given.span, given.parameter.type
        if isinstance(kind, Bool):
            return {given.bits[0] >> 1} if value else set()
        if span.grid is None:
            above = ordinal(kind, value) - span.low
        else:
            real, group = float(value), self.group(chosen, given)
            cell = (span.grid.position(Fraction(real)) - span.low) >> span.grid.places
            above = (cell << span.grid.places) + places.get((group, self._cell(group, real), real), 0)
        return {bit >> 1 for k, bit in enumerate(given.bits) if above >> k & 1}


@dataclass
class Following:
    """Runs side by side; `atoms`: what is asked of the moment after each step."""

    encoding: Encoding
    atoms: Sequence[Formula] = ()
    lanes: int = 32
    seed: int = 0
    script: Sequence[Event] = ()
    """What the lanes of streams begin with."""
    counts: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        encoding, model = self.encoding, self.encoding.compiled.model
        self.model = model
        self.truths = {atom: encoding.moments.truth(atom) for atom in self.atoms}
        self.marks = {label: encoding.moments.mark(label) for label in sorted(encoding._frame.marks)}
        self.may_wait = {r.name: encoding.actions.may_wait[k] for k, r in enumerate(model.requests)}
        self.random = Random(self.seed)
        self.inverse = Inverse(encoding)
        self.concretizer = Concretizer(encoding)
        self.streams = [Stream(model, 1000 * self.seed + lane) for lane in range(self.lanes)]
        values = [given.term for event in encoding.events for given in event.given]
        bits = [bit for value in (*values, *encoding.reembedded.values()) for bit in as_word(value).bits]
        roots = [*self.truths.values(), *self.marks.values(), encoding.legal, encoding.unsettled]
        roots += [lit(event.chosen) for event in encoding.events] + bits
        self.circuit = encoding.circuit(roots)
        self.cone = evaluator(self.circuit, roots, self.circuit.latches)
        self.words = {latch.node: 0 for latch in self.circuit.latches}
        for lane in range(self.lanes):
            self._restart(lane)

    def _restart(self, lane: int) -> None:
        for latch in self.circuit.latches:
            kept = self.words[latch.node] & ~(1 << lane)
            self.words[latch.node] = kept | (latch.initial << lane)
        self.streams[lane].state = self.streams[lane].reference.start()

    def run(self, steps: int) -> None:
        """Follow the lanes for so many steps; raises `AssertionError` where they part."""
        drawn = RandomStimulus(self.encoding, self.lanes, self.seed).stimulus()
        for step in range(steps):
            inputs = dict(drawn(step, self.words))
            moving = sum(1 << lane for lane in range(3, self.lanes, 8))
            for node in self.encoding.shifts:
                few = self.random.getrandbits(self.lanes) & self.random.getrandbits(self.lanes)
                inputs[node] = moving & few & self.random.getrandbits(self.lanes)
            anything = sum(1 << lane for lane in range(1, self.lanes, 8))
            for node in self.encoding.code:
                inputs[node] = inputs[node] & ~anything | self.random.getrandbits(self.lanes) & anything
            events: list[Event | None] = [None] * self.lanes
            for lane in range(0, self.lanes, 2):
                events[lane] = self._drawn(lane, step)
                true = self.inverse.inputs(events[lane], self.streams[lane].state, self.words, lane)  # type: ignore[arg-type]
                for node in self.encoding.graph.inputs:
                    inputs[node] = inputs.get(node, 0) & ~(1 << lane) | (node in true) << lane
            values = self.cone.values(self.words, inputs)
            before = dict(self.words)
            for latch in self.circuit.latches:
                self.words[latch.node] = self.cone.read(values, latch.next, (1 << self.lanes) - 1)
            for lane in range(self.lanes):
                self._compare(LaneValues(self.cone, values, lane), events[lane], before)

    def _drawn(self, lane: int, step: int) -> Event:
        """Return the event of the script, or where it cannot happen another one."""
        stream = self.streams[lane]
        if step < len(self.script) and stream.reference.validate(stream.state, self.script[step]) is None:
            return self.script[step]
        while True:
            event = read_event(self.model, json.dumps(stream.line()))
            if not isinstance(event, Invalid) and stream.reference.validate(stream.state, event) is None:
                return event

    def _compare(self, lane: LaneValues, wanted: Event | None, before: Mapping[int, int]) -> None:
        encoding, stream, number = self.encoding, self.streams[lane.lane], lane.lane
        if not lane.true(encoding.legal):
            if wanted is not None:
                self._is_forbidden(wanted, stream.state)
            moved = [n for n, word in self.words.items() if (word ^ before[n]) >> number & 1]
            assert not moved, "what is no event changes something"
            assert not lane.true(encoding.unsettled)
            self.counts["stutter"] += 1
            return
        (event,) = [each for each in encoding.events if lane.true(lit(each.chosen))]
        try:
            concrete = event_of(event.kind, self.concretizer._arguments(event, lane, stream.state))
        except Spurious:
            self.counts["spurious"] += 1
            self._restart(number)
            return
        if wanted is not None:
            kind, args = self.inverse.kind_of(wanted, stream.state)
            assert encoding.events[kind] is event, f"{wanted} became {event.kind}"
            self._same_values(event, args, lane)
            self._alike(event, self.inverse.kind_of(concrete, stream.state)[1], args, stream.state)
            concrete = wanted
        told = f"{concrete} in {stream.state}"
        said = done(self.model, stream.state, concrete, self.may_wait)
        after, old = said.state, stream.state
        settled = said.passes <= encoding.passes
        assert lane.true(encoding.unsettled) != settled, f"{said.passes} passes: {told}"
        self.counts[f"{said.passes} passes"] += 1
        if not settled:
            self._restart(number)
            return
        marks = {label for label, literal in self.marks.items() if lane.true(literal)}
        assert marks == said.marks, f"{told}: graph only {marks - said.marks}, reference only {said.marks - marks}"
        self._same_state(number, after, told)
        for each in encoding.properties.assumptions:
            assert self._holds(each.formula, old, concrete, after), f"{each} is assumed, but not after {told}"
        happened = happening(self.model, old, concrete, [atom for atom in self.truths if isinstance(atom, Happened)])
        for atom, literal in self.truths.items():
            true = atom in happened or self._is_true(atom, after)
            assert lane.true(literal) == true, f"{atom} is {true} after {told}"
            self.counts[f"{type(atom).__name__} {true}"] += 1
        stream.state = after
        self.counts["event" if wanted is None else "given event"] += 1
        self.counts.update(f"mark {label[0]}" for label in marks)

    def _is_forbidden(self, event: Event, before: State) -> None:
        """Raise `AssertionError` unless assumptions forbid a step."""
        after = done(self.model, before, event, self.may_wait).state
        formulas = [each.formula for each in self.encoding.properties.assumptions]
        truths = [self._holds(formula, before, event, after) for formula in formulas]
        assert not all(truths), f"{event} is no event of the graph in {before}"
        self.counts["forbidden"] += 1

    def _holds(self, formula: Formula, before: State, event: Event, after: State) -> bool:
        match formula:
            case Negation(part):
                return not self._holds(part, before, event, after)
            case Conjunction(parts):
                return all(self._holds(part, before, event, after) for part in parts)
            case Disjunction(parts):
                return any(self._holds(part, before, event, after) for part in parts)
            case _:
                happened = happening(self.model, before, event, [formula] if isinstance(formula, Happened) else [])
                return formula in happened or self._is_true(formula, after)

    def _same_values(self, event: EncodedEvent, args: Args, lane: LaneValues) -> None:
        for given, value in zip(event.given, args, strict=True):
            mine = lane.number(given.term)
            grid = given.span.grid
            if grid is None:
                assert mine == (int(value) if isinstance(value, bool) else ordinal(given.parameter.type, value))
            else:
                assert mine >> grid.places == grid.position(Fraction(float(value))) >> grid.places

    def _alike(self, event: EncodedEvent, mine: Args, its: Args, state: State) -> None:
        """Compare how the reals of two events of a kind lie to those that are held and compared with them."""
        held = self.inverse._held(state).values()
        for given, one, other in zip(event.given, mine, its, strict=True):
            if given.span.grid is not None and given.span.grid.places:
                a, b, group = float(one), float(other), self.inverse.group(event, given)
                for value in (value for where, value in held if where == group):
                    assert (a < value, a > value) == (b < value, b > value), f"{a} and {b} beside {value}"

    def _same_state(self, lane: int, state: State, told: str) -> None:
        """Compare everything in a state, and how the reals that are compared with each other lie to each other."""
        layout = self.encoding.latches
        here = dict(self.encoding.latches.counted(state))
        numbers = {}
        for name, bits in layout.literals.items():
            span = layout.spans[name]
            numbers[name] = span.low + sum((self.words[bit >> 1] >> lane & 1) << k for k, bit in enumerate(bits))
            if name in here:
                places = span.grid.places if span.grid else 0
                mine, its = numbers[name] >> places, number(layout.types[name], span, here[name]) >> places
                assert mine == its, f"{name} is {here[name]}: {mine}, not {its}, after {told}"
            elif name in layout.owners:
                start = span.low + sum(self.initial[bit >> 1] << k for k, bit in enumerate(bits))
                assert numbers[name] == start, f"{name} does not count, but is {numbers[name]} after {told}"
        for names in self.inverse.groups.values():
            held = [(float(here[name]), numbers[name]) for name in names if name in here]
            for one, position in held:
                for other, place in held:
                    assert (one <= other) == (position <= place), f"{one} and {other} after {told}"

    @cached_property
    def initial(self) -> dict[int, int]:
        """By node of a latch its value at the start."""
        return {latch.node: int(latch.initial) for latch in self.circuit.latches}

    def _is_true(self, atom: Formula, after: State) -> bool:
        match atom:
            case Atom(condition):
                return holds(self.model, after, condition)
            case Happened():
                return False
            case Broken(rule, calm):
                return broken(self.model, after.once_stopped() if calm else after, rule)
            case _:
                raise TypeError(atom)
