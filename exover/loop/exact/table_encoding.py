"""Entries of the state vector as terms over exact states, and diagrams of the decoded tables as conditions."""

from collections.abc import Iterator, Sequence, Set
from dataclasses import field
from fractions import Fraction

from exover.dataclass import dataclass
from exover.loop.diagram_walk import agreed, follow
from exover.loop.exact.layout import Layout, level_name
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.term import Term
from exover.model.index import ModelIndex
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, FeatureRow, Node, Tables

MOST_CASES = 4000
"""The number of pairs (flag, remaining bound) up to which a bound on a sum of flags is expanded to if-then-elses."""


@dataclass(frozen=True, slots=True)
class RequestArguments:
    """The request whose arguments are tested, with these arguments, and results if there are any."""

    request: int
    values: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class LinearForm:
    """`constant + sum(factor * number) + sum(weight where flag)`."""

    constant: int = 0
    numbers: tuple[tuple[int, Term], ...] = ()
    flags: tuple[tuple[int, Term], ...] = ()


@dataclass(frozen=True, slots=True)
class Ranked:
    """The rank of a real among constants (`exover.ocrd.vector.rank`)."""

    value: Term
    cuts: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Ordered:
    """How two reals compare (`exover.ocrd.vector.Order`)."""

    left: Term
    right: Term


@dataclass
class TableEncoding:
    """The tests and diagrams of decoded tables as terms."""

    layout: Layout
    tables: Tables
    _predicates: dict[tuple[object, ...], Term] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.terms = self.layout.terms
        index = ModelIndex(self.layout.model)
        self.names, self.stocks = index.readings, index.stocks
        self.variable = self._by_entry((row.value, row.rank) for row in self.tables.variables)
        self.level = self._by_entry((row.entry,) for row in self.tables.stocks)
        self.last = self._by_entry((row.last,) for row in self.tables.requests)
        self.param = self._by_entry((row.value, row.rank) for row in self.tables.params)
        self.order = self._by_entry((row.entry,) for row in self.tables.orders)
        self.past = self._by_entry((row.entry,) for row in self.tables.pasts)
        self.features: dict[int, list[tuple[int, int]]] = {}
        for request, row in enumerate(self.tables.requests):
            for number in range(row.features, row.features_end):
                feature = self.tables.features[number]
                for entry in {feature.running, feature.stopping, feature.waiting, feature.clearing} - {NONE}:
                    self.features.setdefault(entry, []).append((request, number))
        self.parts = self.tables.parts()
        self.raw = tuple(self.names[number] for number, row in enumerate(self.tables.variables) if row.raw != NONE)

    def _by_entry(self, rows: Iterator[tuple[int, ...]]) -> dict[int, int]:
        return {entry: number for number, entries in enumerate(rows) for entry in entries if entry != NONE}

    # ---- entries ----

    def test(self, frame: SymbolicState, looked: RequestArguments | None, entry: int, bound: int) -> Term:
        """Return the condition `v[entry] <= bound`."""
        return self.at_most(self.entry(frame, looked, entry), bound)

    def at_most(self, quantity: LinearForm | Ranked | Ordered, bound: int) -> Term:
        """Return the condition that a quantity, a rank or an order is at most `bound`."""
        terms = self.terms
        match quantity:
            case Ranked(value, cuts):
                below, equal = divmod(bound, 2)
                if bound < 0 or below >= len(cuts):
                    return terms.truth(bound >= 0)
                cut = terms.constant(Fraction(cuts[below]), "Real")
                return terms.at_most(value, cut) if equal else terms.less(value, cut)
            case Ordered(left, right):
                if not 0 <= bound < 2:
                    return terms.truth(bound >= 2)
                return terms.at_most(left, right) if bound else terms.less(left, right)
            case LinearForm(constant, (), flags) if len(flags) * (sum(abs(w) for w, _ in flags) + 1) < MOST_CASES:
                return self._bounded([(w, flag) for w, flag in flags if w], bound - constant)
            case LinearForm():
                return terms.at_most(self.total(quantity), terms.constant(bound, "Int"))

    def total(self, quantity: LinearForm) -> Term:
        """Return the value of a quantity as a term of sort Int."""
        one, none = self.terms.constant(1, "Int"), self.terms.constant(0, "Int")
        counted = [(weight, self.terms.choose(flag, one, none)) for weight, flag in quantity.flags]
        return self.terms.sum(quantity.constant, (*quantity.numbers, *counted))

    def _bounded(self, flags: Sequence[tuple[int, Term]], bound: int) -> Term:
        """Return the condition that the weights of the true flags sum to at most `bound`, as a decision diagram."""
        flags = sorted(flags, key=lambda each: -abs(each[0]))  # fewer different rests are left
        lows, highs = [0], [0]
        for weight, _ in reversed(flags):
            lows.append(lows[-1] + min(weight, 0))
            highs.append(highs[-1] + max(weight, 0))
        rests = {bound}
        levels = []
        for number, (weight, _) in enumerate(flags):
            low, high = lows[len(flags) - number], highs[len(flags) - number]
            levels.append({rest for rest in rests if low <= rest < high})
            rests = levels[-1] | {rest - weight for rest in levels[-1]}
        known: dict[int, Term] = {}

        def decided(number: int, rest: int, below: dict[int, Term]) -> Term:
            low, high = lows[len(flags) - number], highs[len(flags) - number]
            if low <= rest < high:
                return below[rest]
            return self.terms.truth(rest >= high)

        def chosen(weight: int, flag: Term, then: Term, otherwise: Term) -> Term:
            """Return `ite flag then otherwise`, without the if-then-else: one branch implies the other."""
            terms = self.terms
            if weight > 0:
                return terms.both((otherwise, terms.implies(flag, then)))
            return terms.either((otherwise, terms.both((flag, then))))

        for number in reversed(range(len(flags))):
            weight, flag = flags[number]
            known = {
                rest: chosen(weight, flag, decided(number + 1, rest - weight, known), decided(number + 1, rest, known))
                for rest in levels[number]
            }
        return decided(0, bound, known)

    def entry(self, frame: SymbolicState, looked: RequestArguments | None, entry: int) -> LinearForm | Ranked | Ordered:
        """Return the value of an entry; one that no record changes has its initial value."""
        if entry in self.parts:
            return self._sum(frame, looked, entry)
        if entry in self.variable:
            number = self.variable[entry]
            return self._of(self.tables.variables[number], frame[self.names[number]])
        if entry in self.param:
            return self._argument(looked, self.param[entry])
        if entry in self.order:
            row = self.tables.orders[self.order[entry]]
            return Ordered(self._side(frame, looked, row.left), self._side(frame, looked, row.right))
        if entry in self.level:
            return number_of(frame[level_name(self.stocks[self.level[entry]])])
        if entry in self.last:
            name = self.layout.model.requests[self.last[entry]].name
            return number_of(frame[self.layout.memories[name].last])
        if entry in self.past:
            return number_of(self._remembered(frame, self.past[entry]))
        return self._counted(frame, {entry})

    def _sum(self, frame: SymbolicState, looked: RequestArguments | None, entry: int) -> LinearForm:
        """Return the value of a sum: its parts, plus the constant by which its initial value differs from theirs."""
        constant = self.tables.entries[entry].initial
        numbers: list[tuple[int, Term]] = []
        flags: list[tuple[int, Term]] = []
        for factor, parts in self._alike(entry):
            is_counted = parts <= self.features.keys()
            quantity = self._counted(frame, parts) if is_counted else self.entry(frame, looked, *parts)
            assert isinstance(quantity, LinearForm), "ranks are not summed"
            constant += factor * (quantity.constant - sum(self.tables.entries[part].initial for part in parts))
            numbers += [(factor * inner, term) for inner, term in quantity.numbers]
            flags += [(factor * weight, flag) for weight, flag in quantity.flags]
        return LinearForm(constant, tuple(numbers), tuple(flags))

    def _alike(self, entry: int) -> Iterator[tuple[int, frozenset[int]]]:
        """Yield factors with parts of a sum: parts that count slots and places grouped by factor, others alone."""
        counted: dict[int, set[int]] = {}
        for part, factor in self.parts[entry]:
            together = counted.setdefault(factor, set())
            if part in self.features and part not in together:
                together.add(part)
            else:
                yield factor, frozenset({part})
        yield from ((factor, frozenset(parts)) for factor, parts in counted.items() if parts)

    def _argument(self, looked: RequestArguments | None, number: int) -> LinearForm | Ranked:
        assert looked is not None, "arguments are tested of what is looked at"
        return self._of(self.tables.params[number], looked.values[number - self.tables.requests[looked.request].params])

    def _of(self, row: t.VariableRow | t.ParamRow, value: Term) -> LinearForm | Ranked:
        """Return a value as the entry counts it: the rank of a real, else the number."""
        return Ranked(value, self.tables.reals[row.cuts : row.cuts_end]) if row.type == t.REAL else number_of(value)

    def _side(self, frame: SymbolicState, looked: RequestArguments | None, side: int) -> Term:
        if side < 0:
            return frame[self.names[-1 - side]]
        assert looked is not None, "arguments are compared of what is looked at"
        return looked.values[side]

    def _remembered(self, frame: SymbolicState, number: int) -> Term:
        """Return the condition that there is a past which satisfies the predicate of this record."""
        (request,) = (k for k, row in enumerate(self.tables.requests) if row.pasts <= number < row.pasts_end)
        memory = self.layout.memories[self.layout.model.requests[request].name]
        agrees = self.agrees(
            frame, self.tables.pasts[number].predicate, RequestArguments(request, frame.all(memory.values))
        )
        return self.terms.both((frame[memory.known], agrees))

    def _counted(self, frame: SymbolicState, entries: Set[int]) -> LinearForm:
        """Return the sum of the initial values of entries plus what slots and waiting places add to them."""
        numbers: list[tuple[int, Term]] = []
        flags: list[tuple[int, Term]] = []
        for request, place in sorted({row for entry in entries for row in self.features.get(entry, ())}):
            feature = self.tables.features[place]
            for guard, values in self._holders(frame, request, feature, entries):
                counts = self.terms.both(
                    (guard, self.agrees(frame, feature.predicate, RequestArguments(request, values)))
                )
                if feature.weight == NONE:
                    flags.append((1, counts))
                    continue
                weight = number_of(values[feature.weight])
                flags += [(inner, self.terms.both((counts, flag))) for inner, flag in weight.flags]
                none = self.terms.constant(0, "Int")
                numbers += [(inner, self.terms.choose(counts, term, none)) for inner, term in weight.numbers]
                if weight.constant:
                    flags.append((weight.constant, counts))
        initial = sum(self.tables.entries[entry].initial for entry in entries)
        return LinearForm(initial, tuple(numbers), tuple(flags))

    def _holders(
        self, frame: SymbolicState, request: int, feature: FeatureRow, entries: Set[int]
    ) -> Iterator[tuple[Term, tuple[Term, ...]]]:
        """Yield for each slot and place that the feature counts in these entries its condition and its arguments.

        A slot that counts both while running and while stopping is yielded once, with the condition that it is active.
        """
        each = self.layout.model.requests[request]
        for number in range(each.instances):
            if feature.slot in (NONE, number):
                slot = self.layout.slots[each.name, number]
                phases = []
                if feature.running in entries:
                    phases.append(self.layout.running(slot, frame.values))
                if feature.stopping in entries:
                    phases.append(frame[slot.stopping])
                for guard in phases if len(phases) < 2 else [frame[slot.active]]:
                    yield guard, frame.all(slot.args)
        place = self.layout.places[each.name]
        if feature.waiting in entries:
            yield self.layout.waiting(place, frame.values), frame.all(place.args)
        if feature.clearing in entries:
            yield frame[place.clearing], frame.all(place.args)

    # ---- diagrams ----

    def agrees(self, frame: SymbolicState, root: int, looked: RequestArguments | None) -> Term:
        """Return the condition under which a diagram leads to an action: that of the predicate it represents."""
        if looked is None:
            return self._truth(frame, root, looked)
        key = (root, looked, frame.all(self.raw))
        if key not in self._predicates:
            self._predicates[key] = self._truth(frame, root, looked)
        return self._predicates[key]

    def _truth(self, frame: SymbolicState, root: int, looked: RequestArguments | None) -> Term:
        def chosen(node: Node, low: Term, high: Term) -> Term:
            return self.terms.choose(self.test(frame, looked, node.code, node.bound), low, high)

        return agreed(self.tables, root, self.terms.false, self.terms.true, chosen)

    def walk(
        self, frame: SymbolicState, guard: Term, root: int, looked: RequestArguments | None
    ) -> list[tuple[Node, Term]]:
        """Return the actions of a diagram in the order of their nodes, each with the condition that it is reached."""
        return [(node, here) for node, here in self.arrivals(frame, guard, root, looked) if node.code < 0]

    def arrivals(
        self, frame: SymbolicState, guard: Term, root: int, looked: RequestArguments | None
    ) -> list[tuple[Node, Term]]:
        """Return the nodes that a walk of a diagram may reach, in order, each with the condition that it does."""
        terms = self.terms
        found: list[tuple[Node, Term]] = []

        def joined(_: int, conditions: list[Term]) -> Term | None:
            here = terms.either(conditions)
            return None if here is terms.false else here

        def branched(_: int, node: Node, here: Term) -> tuple[Term, Term]:
            found.append((node, here))
            test = self.test(frame, looked, node.code, node.bound)
            return terms.both((here, test)), terms.both((here, terms.negation(test)))

        follow(self.tables, root, guard, joined, branched, lambda _, node, here: found.append((node, here)))
        return found


def number_of(value: Term) -> LinearForm:
    """Return a term as a linear form; true counts as 1, false as 0."""
    return LinearForm(0, (), ((1, value),)) if value.sort == "Bool" else LinearForm(0, ((1, value),))
