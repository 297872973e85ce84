"""Do the decoded tables decide as the rules say, in every state and for all arguments, whatever their numbers are?

The comparison of `exover.equivalence.state_equivalence`, over exact states and asked of Z3. First every entry of the
state vector: the records of the tables must count in it what the compiler says it is. Then the diagrams of the tables
are followed beside those of the rules, both over the same elements, and Z3 looks for a state in which the two do
different things.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field
from fractions import Fraction
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.concretize import as_doubles
from exover.engines.smt.solver import Inconclusive, Prover
from exover.equivalence.diagram_equivalence import alike, different_diagrams, differing, same_action
from exover.equivalence.record_equivalence import Records, different_for_all, different_records
from exover.loop.diagram_walk import agreed
from exover.loop.exact.layout import Layout, sort_of
from exover.loop.exact.quantity_terms import QuantityTerms
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import LinearForm, RequestArguments, TableEncoding
from exover.loop.exact.term import Term, Terms, below
from exover.model.expression import Cond
from exover.model.model import Parameter
from exover.ocrd.compile import DecodedTables
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.diagram import Act, Manager, deep
from exover.ocrd.entries import initial
from exover.ocrd.roots import decided
from exover.ocrd.tables import NONE, Node
from exover.ocrd.vector import Arg, ArgRank, Element, Order, Vocabulary

METHOD = "all states"


@dataclass
class TermComparison:
    """The tables of one model beside its rules."""

    compiled: DecodedTables
    prover: Prover
    _decisions: dict[str, bool] = field(default_factory=dict)
    _predicates: dict[tuple[int, int, Cond | None, bool], bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.model, self.tables, self.terms = self.compiled.model, self.compiled.tables, Terms()
        self.layout = Layout(self.model, self.terms)
        self.vector = TableEncoding(self.layout, self.tables)
        self.frame = SymbolicState(self.terms, self.layout.vars)
        self.looked = {r.name: self._arguments(r.name, (*r.params, *r.results)) for r in self.model.requests}
        self.questions = DecisionContext(Vocabulary(self.model))
        self.quantities = QuantityTerms(self.layout, self.looked, self.questions.vocabulary)
        self.entry_of = {element: entry for entry, element in enumerate(self.compiled.entries)}

    def _arguments(self, request: str, params: tuple[Parameter, ...]) -> tuple[Term, ...]:
        return tuple(self.terms.var(f"{request}: {each.name}", sort_of(each.type)) for each in params)

    def different(self, kind: str, name: str) -> Iterator[str]:
        """Yield in what the tables do otherwise than the rules say, for a kind of event and in every step.

        Raises `Inconclusive`.
        """
        yield from different_records(self.records, kind, name)
        if kind == "ask" and not self._decides(name):
            yield f"the decision on `{name}`"
        yield from self._steps

    @cached_property
    def records(self) -> Records:
        """The records of the tables, to be compared with the model."""
        return Records(self.model, self.tables, self.compiled.entries, self._same_predicate)

    @cached_property
    def _steps(self) -> tuple[str, ...]:
        """What every step needs and the tables have otherwise: counters, rules, launches, latches."""
        diagrams = different_diagrams(self.questions, self.tables, self.records.reasons, self._same)
        return (*different_for_all(self.records), *self._different_entries(), *diagrams)

    # ---- states ----

    @cached_property
    def _known(self) -> tuple[Term, ...]:
        """What is true of every state and of all arguments, in the midst of a step as well."""
        found = [*self.layout.domains.values(), *self.layout.sound.values()]
        for request in self.model.requests:
            pairs = zip((*request.params, *request.results), self.looked[request.name], strict=True)
            found += [self.layout.domain(parameter.type, term) for parameter, term in pairs]
        return tuple(each for each in found if each is not self.terms.true)

    def _possible(self, where: Term) -> bool:
        """Return whether a condition is true of some state and arguments; raises `Inconclusive`."""
        if where is self.terms.false:
            return False
        found = self.prover.model((where,), self._known)
        if found is None:
            return False
        if found.model is None:
            raise Inconclusive("the solver gave up")
        parts = list(below((where, *self._known)))
        reals = [term for term in parts if term.sort == "Real"]
        constants = sorted({Fraction(term.number) for term in reals if term.kind == "constant"})
        values = [Fraction(found.value(term)) for term in reals if term.kind == "var"]
        as_doubles(values, constants)  # comparisons are all that is asked of reals: doubles will do if there are any
        return True

    def passes(self, path: Iterable[tuple[Element, tuple[int, int]]]) -> bool:
        """Return whether in some state and for some arguments each element lies in its range; raises `Inconclusive`."""
        within = [self._between(element, low - 1, high) for element, (low, high) in path]
        return self._possible(self.terms.both(within))

    def at_most(self, element: Element, bound: int) -> Term:
        """Return where an element is at most `bound`, as the model has it."""
        return self.vector.at_most(self.quantities.element(element), bound)

    def _between(self, element: Element, above: int, most: int) -> Term:
        low, high = self.at_most(element, above), self.at_most(element, most)
        return self.terms.both((self.terms.negation(low), high))

    # ---- entries ----

    def _different_entries(self) -> Iterator[str]:
        """Yield the entries of the vector in which the tables count something else than what they are."""
        misread = tuple(self._misread())
        if misread:
            yield from misread
            return
        start, owners = self.layout.start, self._owners
        if any(entry >= len(self.compiled.entries) or entry < NONE for entry in owners):
            yield "records of entries that there are not"
        for entry, element in enumerate(self.compiled.entries):
            if owners[entry] > 1 or not self._same_entry(entry, element):
                yield f"entry {entry} of the state vector"
            first = sum(factor * initial(self.questions.vocabulary, part, start) for factor, part in element)
            if first != self.tables.entries[entry].initial:
                yield f"the initial value of entry {entry}"

    @cached_property
    def _owners(self) -> Counter[int]:
        """By entry how many records, or kinds of records that are summed, say what it is."""
        vector = self.vector
        rows = [entry for row in self.tables.variables for entry in (row.value, row.rank)]
        rows += [entry for row in self.tables.params for entry in (row.value, row.rank)]
        rows += [row.entry for row in self.tables.stocks] + [row.entry for row in self.tables.pasts]
        rows += [row.entry for row in set(self.tables.orders)] + [row.last for row in self.tables.requests]
        return Counter([*rows, *vector.parts, *vector.features])

    def _same_entry(self, entry: int, element: Element) -> bool:
        """Return whether an entry is this element by the records of the tables."""
        if entry in self.vector.parts:
            said = [(f * g, q) for part, f in self.vector.parts[entry] for g, q in self.compiled.entries[part]]
            return Counter(said) == Counter(element)
        requests = {q.request for _, q in element if isinstance(q, Arg | ArgRank | Order) and q.request is not None}
        if len(requests) > 1 or not self._is_of(entry, *requests):
            return False
        looked = [RequestArguments(self.records.index.request[name], self.looked[name]) for name in requests]
        its = self.vector.entry(self.frame, looked[0] if looked else None, entry)
        mine = self.quantities.element(element)
        if its == mine:
            return True
        if not (isinstance(its, LinearForm) and isinstance(mine, LinearForm)):
            return False
        same = self.terms.equal(self.vector.total(its), self.vector.total(mine))
        return not self._possible(self.terms.negation(same))

    def _is_of(self, entry: int, request: str | None = None) -> bool:
        """Return whether no record of another request's arguments says what an entry is."""
        params, orders = self.vector.param.get(entry), self.vector.order.get(entry)
        if request is None:
            return params is None and (orders is None or self._among_posters(orders))
        row = self.tables.requests[self.records.index.request[request]]
        return (params is None or row.params <= params < row.params_end) and (
            orders is None or row.orders <= orders < row.orders_end
        )

    def _among_posters(self, order: int) -> bool:
        return self.tables.orders[order].left < 0 and self.tables.orders[order].right < 0

    # ---- diagrams ----

    def _same_predicate(self, number: int, predicate: int, where: Cond | None, results: bool) -> bool:
        """Return whether a predicate of the tables is true of the arguments of which a condition is."""
        key = (number, predicate, where, results)
        if key not in self._predicates:
            name = self.model.requests[number].name
            same = self.terms.equal(self._agreed(predicate), self.quantities.concerned(name, where))
            self._predicates[key] = not self._possible(self.terms.negation(same))
        return self._predicates[key]

    def _agreed(self, root: int) -> Term:
        """Return where a diagram comes to an action."""

        def chosen(node: Node, low: Term, high: Term) -> Term:
            return self.terms.choose(self.tested(node.code, node.bound), low, high)

        return agreed(self.tables, root, self.terms.false, self.terms.true, chosen)

    def tested(self, entry: int, bound: int) -> Term:
        """Return where what an entry is, is at most `bound`."""
        return self.at_most(self.compiled.entries[entry], bound)

    def _misread(self) -> Iterator[str]:
        """Yield the requests whose arguments are told apart by something else than they are, and posters."""
        for request, row in zip(self.model.requests, self.tables.requests, strict=True):
            roots = [each.predicate for each in self.tables.features[row.features : row.features_end]]
            roots += [each.predicate for each in self.tables.pasts[row.pasts : row.pasts_end]]
            roots += [each.predicate for each in self.tables.amounts[row.consumes : row.produces_end]]
            tested = {entry for root in roots if root >= 0 for entry in self.records.tables.tested(root)}
            read = [part for entry in tested for _, part in self.compiled.entries[entry]]
            if not all(isinstance(part, Arg | ArgRank | Order) and part.request == request.name for part in read):
                yield f"what is told of the arguments of `{request.name}`"

    def _decides(self, name: str) -> bool:
        """Return whether in every state, for all arguments, the tables decide on a newcomer as the rules do."""
        if name not in self._decisions:
            with deep():
                manager, root = decided(self.questions, name)
            its = self.tables.requests[self.records.index.request[name]].decide
            self._decisions[name] = self._same(manager, root, its)
        return self._decisions[name]

    def _same(self, manager: Manager, diagram: int, root: int) -> bool:
        """Return whether a diagram of the tables does, in every state, what that of the rules does."""
        split = _Split(self)
        if alike(manager, diagram, self.tables.nodes, root, split.entry, split.same):
            return True
        return not self._possible(differing(manager, diagram, self.tables.nodes, root, self.terms.true, split))


@dataclass(frozen=True)
class _Split:
    """Conditions on states and arguments, told apart by what elements are."""

    rules: TermComparison

    @property
    def none(self) -> Term:
        """No state."""
        return self.rules.terms.false

    def either(self, one: Term, other: Term) -> Term:
        """Return the states of both."""
        return self.rules.terms.either((one, other))

    def tested(self, states: Term, entry: int, bound: int) -> tuple[Term, Term]:
        """Return those in which the entry of the tables is at most `bound`, and the others."""
        terms, low = self.rules.terms, self.rules.tested(entry, bound)
        return terms.both((states, low)), terms.both((states, terms.negation(low)))

    def between(self, states: Term, element: int, above: int | None, most: int | None) -> Term:
        """Return those in which the element of this number is more than `above`, and `most` at most."""
        terms, of = self.rules.terms, self.rules.questions.numbers.elements[element]
        low = terms.true if above is None else terms.negation(self.rules.at_most(of, above))
        high = terms.true if most is None else self.rules.at_most(of, most)
        return terms.both((states, low, high))

    def entry(self, element: int) -> int | None:
        """Return the entry of the tables that is the element of this number; None if there is none."""
        return self.rules.entry_of.get(self.rules.questions.numbers.elements[element])

    def same(self, mine: Act, its: Node) -> bool:
        """Return whether two actions are the same."""
        rules = self.rules
        return same_action(mine, its, rules.tables, rules.records.index.request, rules.records.reasons)
