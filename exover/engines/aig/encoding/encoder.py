"""The closed loop as one transition system: any event, then passes of steps 3 to 5, in one step of a graph.

What an event does is executed symbolically for every kind of event from the same state, and one of the results is
chosen. Then the parts of a pass run, once for all events, for a number of passes; that one more pass would change
nothing is a question of its own (`Encoding.unsettled`), on which all other answers rest. Inputs that encode no event
that can happen change nothing, and no question is asked of them.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import field, replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, Circuit, Literal, cone
from exover.engines.aig.circuit.words import Word, Words, as_word, lit
from exover.engines.aig.encoding.moment_formulas import MomentFormulas
from exover.engines.aig.encoding.range_allocation import allocate_ranges
from exover.engines.aig.encoding.state import Given, Latches, Reembedding
from exover.loop.exact.actions import Observer, TableActions, fallen, tried
from exover.loop.exact.events import Kind, Part, enabling, kinds, parameters, parts, update
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import TableEncoding
from exover.loop.exact.term import Term
from exover.model.property import Conjunction, Formula, Properties
from exover.model.state import SlotId
from exover.ocrd.compile import Compiled

PASSES = range(2, 13)
"""Numbers of passes that are tried, until one is seen to be enough."""


@dataclass(frozen=True, slots=True)
class EncodedEvent:
    """A kind of event. `chosen`: where the inputs encode one that can happen; `given`: its values."""

    kind: Kind
    chosen: Term
    given: tuple[Given, ...]


@dataclass
class Encoding:
    """The transition system of a compiled model, with `passes` passes after each event."""

    compiled: Compiled
    properties: Properties
    passes: int = 2
    observer: Observer | None = None
    """Sees what is decided in a step; its marks are marks of the step."""
    events: list[EncodedEvent] = field(default_factory=list)
    following: dict[Literal, Literal] = field(default_factory=dict)
    """By latch its next-state literal."""
    code: tuple[int, ...] = ()
    """The nodes of the inputs that are the number of the event, the least significant first."""
    given: tuple[int, ...] = ()
    """The nodes of all inputs of a step; what monitors guess comes later."""
    own: frozenset[int] = frozenset()
    """The nodes of the latches of the loop; questions and monitors add others, in each graph of theirs."""

    def __post_init__(self) -> None:
        model = self.compiled.model
        self._declare()
        self.graph = self.terms.graph
        self.actions = TableActions(TableEncoding(self.latches, self.compiled.tables), self.observer)
        self._memory = [tried(k) for k in range(len(model.launches))]
        self._memory += [fallen(request.name) for request in model.requests]
        self._outside = FALSE
        self._between: list[Literal] = []
        """The literals of variables between the parts of a step; they are among the roots of `whole`."""
        self._frame = self._after_event()
        self._settle()
        self._close()
        self.given = tuple(self.graph.inputs)
        self.own = frozenset(node for node, _ in self.graph.latches)

    def _declare(self) -> None:
        """Make the variables of a state, and the reembedding of their reals."""
        self.terms = Words()
        self.latches = Latches(self.compiled.model, self.terms, grids=allocate_ranges(self.compiled, self.properties))
        self._reembedding = Reembedding(self.latches)

    # ---- a step ----

    @cached_property
    def _present(self) -> dict[str, Term]:
        forgotten = dict.fromkeys(self._memory, self.terms.false)
        return self.latches.vars | self._reembedding.moved | forgotten

    def _after_event(self) -> SymbolicState:
        """Return the state after the update of any event, before the passes."""
        frame = SymbolicState(self.terms, dict(self._present))
        writes: dict[str, list[tuple[Term, Term]]] = {}
        for kind, here, given in self._choices():
            after = SymbolicState(self.terms, dict(self._present))
            possible = update(self.actions, after, kind, tuple(each.term for each in given))
            guard = self.graph.conjunction(here, lit(possible))
            event = EncodedEvent(kind, self.terms.bit(guard), given)
            self.events.append(event)
            for name in after.written(self._present):
                value = self._narrowed(name, after.values[name], event.chosen)
                writes.setdefault(name, []).append((event.chosen, value))
            for label, where in after.marks.items():
                frame.mark(self.terms.both((event.chosen, where)), *label)
            for note in after.notes:
                frame.note(self.terms.both((event.chosen, note.guard)), note.occurrence, note.request, note.args)
        for name, cases in writes.items():
            frame.values[name] = self.terms.selected(cases, self._present[name])
        return frame

    def _choices(self) -> Iterator[tuple[Kind, Literal, tuple[Given, ...]]]:
        """Yield the kinds of events, each with where the inputs are its number, and the values that come with it."""
        found = list(kinds(self.compiled.model, self.actions.may_wait))
        code = [self.graph.input() for _ in range((len(found) - 1).bit_length())]
        self.code = tuple(bit >> 1 for bit in code)
        pool: list[Literal] = []
        for kind, here in zip(found, self.graph.decoded(code, len(found)), strict=True):
            yield kind, here, tuple(self.latches.values_given(kind, parameters(self.compiled.model, kind), pool))

    def _narrowed(self, name: str, value: Term, guard: Term) -> Term:
        """Return a value within the range of a variable; add to `_outside` where it lies outside."""
        if name not in self.latches.spans or value.sort != "Int":
            return value
        span = self.latches.spans[name]
        word, outside = self.terms.narrowed(value, span.low, span.high)
        self._outside = self.graph.any((self._outside, self.graph.conjunction(lit(guard), outside)))
        return word

    def _settle(self) -> None:
        """Run the passes; in each only the parts that read a variable which was written since they last ran."""
        due = set(range(len(self._parts)))
        self._between += self._bits(self._frame.values)
        for _ in range(self.passes):
            for number, part in enumerate(self._parts):
                if number not in due:
                    continue
                due.discard(number)
                before = dict(self._frame.values)
                part.run(self._frame)
                written = self._frame.written(before)
                for name in written:
                    value = self._narrowed(name, self._frame.values[name], self.terms.true)
                    self._frame.values[name] = value
                self._between += self._bits(written)
                due |= {other for other, reads in enumerate(self._reads) if not reads.isdisjoint(written)}
        changing = (self._changes(self._parts[number]) for number in sorted(due))
        self._unsettled = tuple(literal for literal in dict.fromkeys(changing) if literal != FALSE)

    def _bits(self, names: Collection[str]) -> list[Literal]:
        """Return the present literals of variables of the frame."""
        values = [self._frame.values[name] for name in sorted(names)]
        return [bit for value in values if isinstance(value, Word) for bit in value.bits]

    def _changes(self, part: Part) -> Literal:
        """Return where a part would still change the state; its marks and notes count for the step in any case."""
        frame = self._frame
        after = SymbolicState(self.terms, dict(frame.values), frame.marks, frame.notes)
        part.run(after)
        changed = after.changed(self._frame)
        return self.graph.any(lit(where) for name, where in changed.items() if name in self.latches.vars)

    @cached_property
    def _parts(self) -> tuple[Part, ...]:
        return tuple(parts(self.actions))

    @cached_property
    def _reads(self) -> list[frozenset[str]]:
        """By part the variables that it reads."""
        memory = {name: self.graph.latch(False) for name in self._memory}
        self.following |= dict.fromkeys(memory.values(), FALSE)
        present: dict[str, Term] = dict(self.latches.vars)
        present |= {name: self.terms.bit(literal) for name, literal in memory.items()}
        names = {bit >> 1: name for name, bits in self.latches.literals.items() for bit in bits}
        names |= {literal >> 1: name for name, literal in memory.items()}
        found = []
        for part in self._parts:
            frame = SymbolicState(self.terms, dict(present))
            part.run(frame)
            literals = [bit for name in frame.written(present) for bit in as_word(frame.values[name]).bits]
            literals += [lit(where) for where in frame.marks.values()] + [lit(note.guard) for note in frame.notes]
            found.append(frozenset(names[node] for node in cone(self.graph.fanins, literals) if node in names))
        return found

    def chosen(self, inputs: Collection[int]) -> EncodedEvent:
        """Return the event whose number the true inputs, by their nodes, encode; it happens if the step is legal."""
        return self.events[self.number_of(inputs)]

    def number_of(self, inputs: Collection[int]) -> int:
        """Return the number of that event."""
        number = sum(1 << place for place, node in enumerate(self.code) if node in inputs)
        return min(number, len(self.events) - 1)

    def enabling(self, number: int) -> Literal | None:
        """Return the latch that is true where the event of a number can happen, None if it always can."""
        flag = enabling(self.latches, self.events[number].kind)
        return None if flag is None else self.latches.literals[flag][0]

    @cached_property
    def reports(self) -> dict[SlotId, list[int]]:
        """By slot the numbers of the events that report it."""
        found: dict[SlotId, list[int]] = {slot: [] for slot in self.latches.slots}
        for number, event in enumerate(self.events):
            if event.kind.reported:
                found[event.kind.reported].append(number)
        return found

    # ---- the next state ----

    def _close(self) -> None:
        """Define the next state of each latch: a held variable whose owner is false gets its initial value."""
        values = self._frame.values
        after = {name: values[name] for name in self.latches.vars}
        for name, owner in self.latches.owners.items():
            if name in self.latches.held:
                after[name] = self.terms.choose(values[owner], after[name], self._initial[name])
        self.after: dict[str, Term] = after
        happens = [lit(event.chosen) for event in self.events]
        self.possible = self.graph.all((self.graph.any(happens), self._reembedding.legal))
        self.moments = self._moments()
        assumed = Conjunction(tuple(each.formula for each in self.properties.assumptions))
        self.legal = self.graph.conjunction(self.possible, self.moments.truth(assumed))
        for name, bits in self.latches.literals.items():
            for bit, literal in zip(bits, self.state_bits(name, after[name]), strict=True):
                self.follow(bit, literal)

    def _moments(self) -> MomentFormulas:
        return MomentFormulas(self.latches, self._initial, self.after, self._frame, self.properties.assumptions)

    @cached_property
    def _initial(self) -> dict[str, Term]:
        """The values at the start, reals on their grids."""
        found = dict(self.latches.initial)
        for name, span in self.latches.spans.items():
            if span.grid is not None:
                start = span.grid.position(found[name].number)  # type: ignore[arg-type]
                found[name] = self.terms.word((), start, start, span.grid)
        return found

    def state_bits(self, name: str, value: Term) -> list[Literal]:
        """Return the literals of a variable's latches where it has a value."""
        word, wide = as_word(value), len(self.latches.literals[name])
        literals: Sequence[Literal] = word.bits
        if word.sort != "Bool":
            span = self.latches.spans[name]
            word = self.terms.narrowed(word, span.low, span.high)[0] if word.sort == "Int" else word
            literals = self.terms.offset_bits(word, span.low)
        return [*literals, *[FALSE] * wide][:wide]

    def follow(self, latch: Literal, after: Literal) -> None:
        """Define the next state of a latch: `after` if the step is legal, else the latch itself."""
        self.following[latch] = self.graph.choose(self.legal, after, latch)

    def whole(self) -> Circuit:
        """Return the circuit whose bad literals are all literals that describe the step, for `rewrite`."""
        marks, notes, moved = self._frame.marks, self._frame.notes, self._reembedding.moved
        terms = [*self.after.values(), *marks.values(), *moved.values()]
        terms += [term for note in notes for term in (note.guard, *note.args)]
        terms += [term for event in self.events for term in (event.chosen, *(given.term for given in event.given))]
        found = [bit for term in terms if isinstance(term, Word) for bit in term.bits]
        found += [self.possible, self.legal, *self._unsettled, self._outside, *self._between, *self.terms.sums]
        return self.circuit(found)

    def rewrite(self, circuit: Circuit) -> None:
        """Describe the step by literals of a smaller circuit; literals that were returned before are invalid then.

        `circuit` equals `whole` and has fewer nodes, inputs and latches being the same.
        """
        marks, notes, moved = self._frame.marks, self._frame.notes, self._reembedding.moved
        now = dict(zip(self.whole().bad, circuit.bad, strict=True))
        self.terms.replace(circuit)
        self.following = {2 * latch.node: latch.next for latch in circuit.latches}
        self.possible, self.legal, self._outside = now[self.possible], now[self.legal], now[self._outside]
        self._unsettled = tuple(now[literal] for literal in self._unsettled)

        def moved_to(term: Term) -> Term:
            """Return the term; one that is no word is a constant."""
            return self.terms.alike(term, [now[bit] for bit in term.bits]) if isinstance(term, Word) else term

        self.after = {name: moved_to(term) for name, term in self.after.items()}
        self._reembedding.moved = {name: as_word(moved_to(term)) for name, term in moved.items()}
        self._frame = SymbolicState(self.terms, {}, {label: moved_to(where) for label, where in marks.items()})
        self._frame.notes = [
            replace(note, guard=moved_to(note.guard), args=tuple(map(moved_to, note.args))) for note in notes
        ]
        self.events = [
            EncodedEvent(
                e.kind, moved_to(e.chosen), tuple(replace(each, term=as_word(moved_to(each.term))) for each in e.given)
            )
            for e in self.events
        ]
        self.moments = self._moments()

    # ---- what is asked ----

    def step_is(self, formula: Formula) -> Literal:
        """Return where a legal step leads to a moment of which a formula is true."""
        return self.graph.conjunction(self.legal, self.moments.truth(formula))

    @property
    def reembedded(self) -> dict[str, Term]:
        """By variable with a place between two constants the position that it has when the event comes."""
        return dict(self._reembedding.moved)

    @property
    def shifts(self) -> tuple[int, ...]:
        """The nodes of the inputs that give reals other positions; where all are false they keep theirs."""
        return tuple(self._reembedding.inputs)

    @property
    def unsettled(self) -> Literal:
        """Where a step would need one more pass, or a number leaves its range: nothing else is answered then."""
        return self.graph.any(self.unsettled_parts)

    @property
    def unsettled_parts(self) -> tuple[Literal, ...]:
        """Where a step is unsettled, by the part of a pass that would still change the state; last, by numbers.

        Each is proved by few clauses, where all together take many. Assumptions do not restrict these steps: whether a
        step satisfies them is known only once it is settled.
        """
        return tuple(self.graph.conjunction(self.possible, part) for part in (*self._unsettled, self._outside))

    def circuit(self, bad: Sequence[Literal]) -> Circuit:
        """Return the transition system with these bad literals."""
        following = [self.following[2 * node] for node, _ in self.graph.latches]
        return self.graph.circuit(following, bad)
