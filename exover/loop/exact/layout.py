"""The states of docs/language.md section 3 as variables of Bool, Int and Real, without abstraction.

A slot has the flags `active` and `stopping`, a waiting place `taken` and `clearing`, a past `known`. The contents of a
slot, place or past count only while its first flag is set; they keep their values when it is cleared.
"""

from collections.abc import Iterator, Mapping
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.loop.exact.term import Sort, Term, Terms
from exover.model.event import Args
from exover.model.model import Model, Parameter, Request
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.types import Bool, Enum, Int, Real, Type, Value, finite_ends, ordinal, resting_value
from exover.ocrd.vector import OUTCOMES

Holding = tuple[str, ...]
"""Names of the variables that hold arguments, in the order of their declaration."""


@dataclass(frozen=True, slots=True)
class SlotNames:
    """The names of a slot's variables."""

    active: str
    stopping: str
    args: Holding


@dataclass(frozen=True, slots=True)
class PlaceNames:
    """The names of a waiting place's variables."""

    taken: str
    clearing: str
    args: Holding


@dataclass(frozen=True, slots=True)
class PastNames:
    """The names of the variables of a past, arguments and results, and of how the last instance ended."""

    known: str
    values: Holding
    last: str


@dataclass
class Layout:
    """The variables of a state, with their initial values and domains."""

    model: Model
    terms: Terms
    vars: dict[str, Term] = field(default_factory=dict)
    initial: dict[str, Term] = field(default_factory=dict)
    domains: dict[str, Term] = field(default_factory=dict)
    """Maps a variable to the condition that it is in its domain; left out if every value of its sort is."""
    types: dict[str, Type] = field(default_factory=dict)
    """Maps a variable to the type of its values."""
    held: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Maps a variable that holds an argument or a result to its request, and to the name that it has there."""
    slots: dict[tuple[str, int], SlotNames] = field(default_factory=dict)
    places: dict[str, PlaceNames] = field(default_factory=dict)
    memories: dict[str, PastNames] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.start = Reference(self.model).start()
        for variable in self.model.variables:
            self._hold(variable.name, variable.type, self.start.readings[variable.name])
        for latch in self.model.latches:
            self._hold(latch.name, Bool(), self.start.readings[latch.name])
        for resource in self.model.resources:
            if resource.consumable:
                self._hold(level_name(resource.name), Int(0, resource.capacity), resource.initial)
        for request in self.model.requests:
            self._declare_request(request)

    def _declare_request(self, request: Request) -> None:
        name = request.name
        for slot in range(request.instances):
            owner = f"{name}[{slot}]"
            flags = self._flag(f"{owner} active"), self._flag(f"{owner} stopping")
            self.slots[name, slot] = SlotNames(*flags, self._held(owner, name, request.params))
        flags = self._flag(f"{name} waiting taken"), self._flag(f"{name} waiting clearing")
        self.places[name] = PlaceNames(*flags, self._held(f"{name} waiting", name, request.params))
        known = self._flag(f"{name} past known")
        values = self._held(f"{name} past", name, (*request.params, *request.results))
        last = f"{name} last"
        self._hold(last, Enum(OUTCOMES), OUTCOMES[0])
        self.memories[name] = PastNames(known, values, last)

    def _flag(self, name: str) -> str:
        self._hold(name, Bool(), False)
        return name

    def _held(self, owner: str, request: str, parameters: tuple[Parameter, ...]) -> Holding:
        names = {f"{owner}.{parameter.name}": parameter for parameter in parameters}
        for name, parameter in names.items():
            self.held[name] = request, parameter.name
            self._hold(name, parameter.type, resting_value(parameter.type))
        return tuple(names)

    def _hold(self, name: str, kind: Type, initial: Value) -> None:
        self.vars[name] = self.terms.var(name, sort_of(kind))
        self.initial[name] = self.value(kind, initial)
        self.types[name] = kind
        domain = self.domain(kind, self.vars[name])
        if domain is not self.terms.true:
            self.domains[name] = domain

    # ---- values ----

    def value(self, kind: Type, value: Value) -> Term:
        """Return the constant of a value of a type; of an enum its ordinal."""
        match kind:
            case Bool():
                return self.terms.truth(bool(value))
            case Int() | Enum():
                return self.terms.constant(ordinal(kind, value), "Int")
            case Real():
                return self.terms.constant(Fraction(float(value)), "Real")
            case _:
                assert_never(kind)

    def resting(self, kind: Type) -> Term:
        """Return the constant of a type's resting value, which stands for no value."""
        return self.value(kind, resting_value(kind))

    def values(self, parameters: tuple[Parameter, ...], args: Args) -> tuple[Term, ...]:
        """Return the constants of arguments or results."""
        return tuple(self.value(p.type, value) for p, value in zip(parameters, args, strict=True))

    def domain(self, kind: Type, term: Term) -> Term:
        """Return the condition that a term is a value of a type."""
        terms = self.terms
        match kind:
            case Bool():
                return terms.true
            case Int(low, high):
                bounds = terms.constant(low, "Int"), terms.constant(high, "Int")
            case Enum(values):
                bounds = terms.constant(0, "Int"), terms.constant(len(values) - 1, "Int")
            case Real():
                low_end, high_end = finite_ends(kind)
                bounds = terms.constant(Fraction(low_end), "Real"), terms.constant(Fraction(high_end), "Real")
            case _:
                assert_never(kind)
        return terms.both((terms.at_most(bounds[0], term), terms.at_most(term, bounds[1])))

    def running(self, slot: SlotNames, values: Mapping[str, Term]) -> Term:
        """Return the condition that a slot is running."""
        return self.terms.both((values[slot.active], self.terms.negation(values[slot.stopping])))

    def waiting(self, place: PlaceNames, values: Mapping[str, Term]) -> Term:
        """Return the condition that what stands in a place waits, and that the way is not being cleared for it."""
        return self.terms.both((values[place.taken], self.terms.negation(values[place.clearing])))

    @cached_property
    def sound(self) -> dict[str, Term]:
        """Maps a flag to an invariant: a stopping slot is active, a clearing place is taken."""
        found = {}
        for slot in self.slots.values():
            found[slot.stopping] = self.terms.implies(self.vars[slot.stopping], self.vars[slot.active])
        for place in self.places.values():
            found[place.clearing] = self.terms.implies(self.vars[place.clearing], self.vars[place.taken])
        return found

    def of_state(self, state: State) -> dict[str, Term]:
        """Return the values of the variables in a concrete state; those that do not count are as at the start."""
        return self.initial | {name: self.value(self.types[name], value) for name, value in self.counted(state)}

    def counted(self, state: State) -> Iterator[tuple[str, Value]]:
        """Yield the variables that count in a concrete state (their owner's flag is set), with their values."""
        yield from state.readings.items()
        yield from ((level_name(name), level) for name, level in state.levels.items())
        for request in self.model.requests:
            for number, content in enumerate(state.slots[request.name]):
                slot = self.slots[request.name, number]
                yield slot.active, content is not None
                if content is not None:
                    yield slot.stopping, content.phase == "stopping"
                    yield from zip(slot.args, content.args, strict=True)
            place, standing = self.places[request.name], state.places[request.name]
            yield place.taken, standing is not None
            if standing is not None:
                yield place.clearing, standing.clearing
                yield from zip(place.args, standing.args, strict=True)
            memory, past = self.memories[request.name], state.past[request.name]
            yield memory.known, past is not None
            if past is not None:
                yield from zip(memory.values, past, strict=True)
            yield memory.last, state.last[request.name]

    def counts(self, name: str, values: Mapping[str, Term]) -> bool:
        """Return whether a variable counts in a state with these values."""
        owner = self.owners.get(name)
        return owner is None or values[owner] is self.terms.true

    @property
    def readings(self) -> tuple[str, ...]:
        """The variables that belong to no request: of posters, states of modules, latches and levels."""
        return (*self.start.readings, *map(level_name, self.start.levels))

    @cached_property
    def owners(self) -> dict[str, str]:
        """Maps a variable to the flag without which it does not count."""
        found: dict[str, str] = {}
        for slot in self.slots.values():
            found |= dict.fromkeys((slot.stopping, *slot.args), slot.active)
        for place in self.places.values():
            found |= dict.fromkeys((place.clearing, *place.args), place.taken)
        for memory in self.memories.values():
            found |= dict.fromkeys(memory.values, memory.known)
        return found


def sort_of(kind: Type) -> Sort:
    """Return the sort of the values of a type."""
    match kind:
        case Bool():
            return "Bool"
        case Int() | Enum():
            return "Int"
        case Real():
            return "Real"
        case _:
            assert_never(kind)


def level_name(resource: str) -> str:
    """Return the variable of a consumable's level, a name that no poster can have."""
    return f"level {resource}"
