"""Events that come to two versions of a spec at once, as inputs that both get."""

from collections.abc import Iterator
from dataclasses import field, replace

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Literal
from exover.engines.aig.circuit.words import Word, Words, as_word
from exover.engines.aig.encoding.state import AllocatedRange, Given, Latches, number
from exover.loop.exact.events import Kind, kinds, parameters
from exover.loop.exact.term import Term
from exover.model.model import Parameter
from exover.model.types import Bool, Enum, Type, Value
from exover.model.versions import Versions, meet
from exover.ocrd.compile import Compiled

OLD, NEW = 0, 1
REQUEST_VERBS = ("ask", "report", "abort", "abort waiting")


@dataclass(frozen=True, slots=True)
class CommonEvent:
    """What comes to both versions at once: a kind of event of each; None: that version has no such thing.

    `broken`: of a reading that is out of range, the value that each version takes instead; None: it is no such reading.
    """

    kinds: tuple[Kind | None, Kind | None]
    broken: tuple[Value | None, Value | None] | None = None

    @property
    def kind(self) -> Kind:
        """The kind, as NEW calls it if it has it."""
        found = self.kinds[NEW] or self.kinds[OLD]
        assert found is not None
        return found


def common_events(versions: Versions, compiled: tuple[Compiled, Compiled]) -> Iterator[CommonEvent]:
    """Yield what can come to the two versions: what NEW knows, then what OLD alone knows."""
    mine, its = (dict.fromkeys(kinds(each.model, each.tables.may_wait())) for each in compiled)
    for kind in its:
        name = versions.was_called.get(kind.name, "") if kind.verb in REQUEST_VERBS else kind.name
        same = replace(kind, name=name)
        yield CommonEvent((same if same in mine else None, kind))
        mine.pop(same, None)
    yield from (CommonEvent((kind, None)) for kind in mine)
    for old, new in versions.variables:
        if old.fallback != new.fallback:
            read = Kind("observe", new.name)
            taken = (old.fallback, new.fallback)
            yield CommonEvent(tuple(None if value is None else read for value in taken), taken)  # type: ignore[arg-type]


@dataclass
class Stimuli:
    """The inputs that both versions get."""

    versions: Versions
    terms: Words
    events: tuple[CommonEvent, ...]
    given: dict[int, tuple[Given, ...]] = field(default_factory=dict)
    """By number of an event the values that come with it, of the types that both take."""
    _pool: list[Literal] = field(default_factory=list)

    def __post_init__(self) -> None:
        graph = self.terms.graph
        bits = [graph.input() for _ in range((len(self.events) - 1).bit_length())]
        self.code = tuple(bit >> 1 for bit in bits)
        self.here = graph.decoded(bits, len(self.events))

    def values(self, event: int, side: int, latches: Latches) -> tuple[Given, ...]:
        """Return the values that come with an event, as a version takes them."""
        kind = self.events[event].kinds[side]
        assert kind is not None
        mine = parameters(latches.model, kind)
        taken = self.events[event].broken
        if taken is not None:
            value = taken[side]
            assert value is not None
            return (_constant(latches, kind, mine[0], value),)
        if event not in self.given:
            common = self._parameters(event, kind, latches)
            self.given[event] = tuple(latches.values_given(kind, common, self._pool))
        found = {each.parameter.name: each for each in self.given[event]}
        return tuple(replace(found[p.name], term=self._converted(found[p.name], p.type), parameter=p) for p in mine)

    def _parameters(self, event: int, kind: Kind, latches: Latches) -> Iterator[Parameter]:
        """Yield the values that come with an event, with the types that both versions take."""
        new = self.events[event].kinds[NEW]
        others = {p.name: p.type for p in (parameters(self.versions.new, new) if new else ())}
        for parameter in parameters(latches.model, kind):
            common = meet(parameter.type, others[parameter.name]) if others else parameter.type
            assert common is not None, "versions whose types clash are not compared"
            yield replace(parameter, type=common)

    def _converted(self, given: Given, kind: Type) -> Word:
        """Return a value as one of a version's type; the ordinal of an enum is converted if the enums differ."""
        return converted(self.terms, given.term, given.parameter.type, kind)


def converted(terms: Words, term: Word, kind: Type, into: Type) -> Word:
    """Return a value of an enum as that of another enum, by its name, or as its first one; any other value as it is."""
    if not isinstance(kind, Enum) or not isinstance(into, Enum) or kind.values == into.values:
        return term
    cases: list[tuple[Term, Term]] = [
        (terms.equal(term, terms.constant(at, "Int")), terms.constant(into.values.index(value), "Int"))
        for at, value in enumerate(kind.values)
        if value in into.values
    ]
    return as_word(terms.selected(cases, terms.constant(0, "Int")))


def _constant(latches: Latches, kind: Kind, parameter: Parameter, value: Value) -> Given:
    span = latches.span_given(kind, parameter)
    at = number(parameter.type, span, value)
    terms = latches.terms
    term = terms.truth(bool(value)) if isinstance(parameter.type, Bool) else terms.word((), at, at, span.grid)
    return Given(parameter, (), AllocatedRange(at, at, span.grid), as_word(term))
