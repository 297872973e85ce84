"""The typed API of a spec in Rust: a method for each event, named as its function in C, and one for a whole cycle."""

from collections.abc import Iterator
from functools import cached_property
from typing import assert_never

from exover.bounds.events import EventBounds
from exover.dataclass import dataclass
from exover.emit.events import EventCall, Field, Statuses, Struct, calls, function_of, structs
from exover.emit.identifiers import SpecIdentifiers, constants
from exover.emit.rustnames import START, enum, plain, variants
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.types import Enum
from exover.ocrd.tables import Tables

SCALARS = {"bool": "bool", "int32": "i32", "int64": "i64", "double": "f64"}
USED = (
    "Action", "Checker", "Event", "Outcome", "Poster", "Request", "Stock", "Value", "View", "Option", "Some", "None",
    "FnMut",
)  # fmt: skip
"""Types that the module `api` uses: no type that it defines gets one of these names."""
GENERIC = "observe_level"
"""The one method of the generic API whose name an event could get."""
KEYWORDS = frozenset((
    "abstract", "as", "async", "await", "become", "box", "crate", "dyn", "final", "fn", "gen", "impl", "in", "let",
    "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "self", "super", "trait", "type",
    "unsafe", "unsized", "use", "where", "yield",
))  # fmt: skip
"""Names that no parameter gets, beside those that none gets in C."""
PATTERNS = frozenset(("Self", "None", "Some", "Ok", "Err", "Value"))
"""Names that are constants in a pattern, so that no parameter can be bound to them."""

ARGUMENTS = (
    "They are kept when it has ended; before its",
    "first launch all are 0, whatever their ranges: the phase of the slot tells whether it is active.",
    "None if there is no such slot, if nothing was loaded, or if they have changed since, which is a fault.",
    "Bound: constant.",
)


def typed(model: Model, tables: Tables, most: EventBounds) -> str:
    """Return the source of the module `api`."""
    return "\n".join(_Typed(model, tables, most).lines()) + "\n"


@dataclass(frozen=True)
class _Typed:
    """Writes the module `api` of one spec."""

    model: Model
    tables: Tables
    most: EventBounds

    @cached_property
    def known(self) -> SpecIdentifiers:
        """The names of the typed API, after the prefix START, which `bare` cuts off."""
        return constants(self.model, START)

    @cached_property
    def groups(self) -> list[tuple[str, tuple[EventCall, ...]]]:
        """The events of each request, poster and consumable."""
        return list(calls(self.model, self.most, taken(self.known)))

    @cached_property
    def args(self) -> list[Struct]:
        """The arguments of each request."""
        return [args for args, _ in structs(self.model, taken(self.known))]

    @cached_property
    def types(self) -> "TypeNames":
        """The names of the types that this module defines."""
        return type_names(self.known)

    @cached_property
    def things(self) -> dict[str, list[str]]:
        """By enum of names.rs, the variants of requests, posters and consumables."""
        index = ModelIndex(self.model)
        posters = [poster.name for _, poster in index.posters]
        return {"Request": variants(index.requests), "Poster": variants(posters), "Stock": variants(index.stocks)}

    def lines(self) -> Iterator[str]:
        """Yield the lines of the module."""
        yield f"//! The events of the spec {self.model.name}: a method of [`Checker`] for each."
        yield "//!"
        yield "//! Each is one call of the generic API underneath; both can be mixed."
        yield ""
        yield "#![allow(non_camel_case_types, non_snake_case, unused_imports)]"
        yield "#![allow(clippy::enum_variant_names, clippy::too_many_arguments, clippy::upper_case_acronyms)]"
        yield ""
        yield "use crate::answers::{Action, Outcome, Value, View};"
        yield "use crate::checker::Checker;"
        yield "use crate::names::{Poster, Request, Stock};"
        yield ""
        yield from self._enums()
        yield from self._structs()
        if self.kinds:
            yield from self._methods()
            yield from self._events()

    def _methods(self) -> Iterator[str]:
        yield "impl Checker<'_> {"
        for _, events in self.groups:
            for event in events:
                yield from self._method(event)
        for number, args in enumerate(self.args):
            if args.fields:
                yield from self._reader(number, args)
            yield from self._viewers(number)
        yield from self._cycle()
        yield "}"

    # ---- types ----

    def _enums(self) -> Iterator[str]:
        for kind in self.known.enums:
            yield from enum(self.types.enums[kind], "Values of the spec", enumerate(kind.values))
        for number, request in enumerate(self.model.requests):
            if request.statuses:
                title = f"Why `{plain(request.name)}` has failed"
                yield from enum(self.types.enums[Statuses(number)], title, enumerate(request.statuses))

    def _structs(self) -> Iterator[str]:
        for args, name, request in zip(self.args, self.types.args, self.model.requests, strict=True):
            if args.fields:
                yield f"/// The arguments of `{plain(request.name)}`."
                yield "#[derive(Clone, Copy, Debug, PartialEq)]"
                yield f"pub struct {name} {{"
                for field in args.fields:
                    yield f"    /// {self._range(field)}."
                    yield f"    pub {field.name}: {self._type(field)},"
                yield "}"
                yield ""

    def _type(self, field: Field) -> str:
        return self.types.enums[field.type] if isinstance(field.type, Enum | Statuses) else SCALARS[field.type]

    def _range(self, field: Field) -> str:
        kind = field.type
        return field.range or f"Any {bare(self.known.enums[kind].type) if isinstance(kind, Enum) else kind}"

    # ---- methods ----

    def _method(self, event: EventCall) -> Iterator[str]:
        ranges = "; ".join(f"`{field.name}`: {field.range}" for field in event.fields if field.range)
        yield f"    /// {plain(event.about)}.{f' {ranges}.' if ranges else ''}"
        yield f"    /// Bound: {event.bound.tests} tests, {event.bound.answers} answers."
        given = "".join(f", {parameter}" for parameter in self._parameters(event))
        yield f"    pub fn {method(event, self.known)}(&mut self{given}) -> &[Action] {{"
        yield f"        {self._generic(event)}"
        yield "    }"
        yield ""

    def _parameters(self, event: EventCall) -> list[str]:
        found = ["slot: u32"] if event.has_slot else []
        for field in event.fields:
            kind = self._type(field)
            found.append(f"{field.name}: {f'Option<{kind}>' if event.does == 'failed' else kind}")
        return found

    def _generic(self, event: EventCall) -> str:
        """Return the call of the generic API."""
        owner = {"observe": "Poster", "level": "Stock"}.get(event.does, "Request")
        subject = f"{owner}::{self.things[owner][event.number]}"
        slot, values = "slot" if event.has_slot else "0", ", ".join(map(self._value, event.fields))
        match event.does:
            case "ask":
                return f"self.ask({subject}, &[{values}])"
            case "ok":
                return f"self.report({subject}, {slot}, Outcome::Ok(&[{values}]))"
            case "failed":
                status = "status.map(|status| status as u32)" if event.fields else "None"
                return f"self.report({subject}, {slot}, Outcome::Failed({status}))"
            case "interrupted":
                return f"self.report({subject}, {slot}, Outcome::Interrupted)"
            case "abort":
                return f"self.abort({subject}, {slot})"
            case "abort_waiting":
                return f"self.abort_waiting({subject})"
            case "observe":
                return f"self.observe({subject}, {values})"
            case "level":
                return f"self.observe_level({subject}, {event.fields[0].name}.into())"
            case _:
                assert_never(event.does)

    def _value(self, field: Field) -> str:
        """Return the expression that converts a parameter to a value of the generic API."""
        name, kind = field.name, self._type(field)
        if kind == "i32":
            return f"i64::from({name}).into()"
        return f"({name} as i64).into()" if isinstance(field.type, Enum | Statuses) else f"{name}.into()"

    def _reader(self, number: int, args: Struct) -> Iterator[str]:
        """Yield the lines of the method that reads the arguments of a request."""
        subject, names = self.model.requests[number].name, self.known.typed[number]
        several, kind = self.model.requests[number].instances > 1, self.types.args[number]
        bound = ", ".join(field.name for field in args.fields)
        yield f"    /// The arguments that {plain(subject)} was launched with last. {ARGUMENTS[0]}"
        yield from (f"    /// {line}" for line in ARGUMENTS[1:])
        slot = ", slot: u32" if several else ""
        yield f"    pub fn {bare(names.read)}(&self{slot}) -> Option<{kind}> {{"
        values = f"self.args(Request::{self.things['Request'][number]}, {'slot' if several else '0'})"
        yield f"        let [{bound}] = *<&[Value; {len(args.fields)}]>::try_from({values}?).ok()?;"
        yield f"        Some({kind} {{"
        yield from (f"            {field.name}: {self._read(field)}," for field in args.fields)
        yield "        })"
        yield "    }"
        yield ""

    def _viewers(self, number: int) -> Iterator[str]:
        """Yield the lines of the methods that return what a slot, and the waiting place, of a request hold."""
        subject, names = self.model.requests[number].name, self.known.typed[number]
        several, request = self.model.requests[number].instances > 1, f"Request::{self.things['Request'][number]}"
        slot, place = bare(names.slot), bare(names.place)
        yield f"    /// What a slot of {plain(subject)} holds. Bound: constant."
        yield f"    pub fn {slot}(&self{', slot: u32' if several else ''}) -> Option<View> {{"
        yield f"        self.view({request}, {'slot' if several else '0'})"
        yield "    }"
        yield ""
        yield f"    /// What the waiting place of {plain(subject)} holds. Bound: constant."
        yield f"    pub fn {place}(&self) -> Option<View> {{"
        yield f"        self.view_waiting({request})"
        yield "    }"
        yield ""

    def _read(self, field: Field) -> str:
        name, kind = field.name, self._type(field)
        match kind:
            case "f64":
                return f"{name}.real()"
            case "bool":
                return f"{name}.integer() != 0"
            case "i64":
                return f"{name}.integer()"
            case "i32":
                return f"i32::try_from({name}.integer()).ok()?"
            case _:
                return f"*{kind}::ALL.get(usize::try_from({name}.integer()).ok()?)?"

    # ---- cycles ----

    @cached_property
    def kinds(self) -> list[tuple[EventCall, str]]:
        """The events, each with its variant of the enum `Event`."""
        events = [event for _, group in self.groups for event in group]
        return list(zip(events, variants(method(event, self.known) for event in events), strict=True))

    def _cycle(self) -> Iterator[str]:
        yield "    /// The events of a cycle, one after another; `obey` is given each with its answers."
        yield "    /// Bound: that of each event."
        yield "    pub fn cycle(&mut self, events: &[Event], mut obey: impl FnMut(&Event, &[Action])) {"
        yield "        for event in events {"
        yield "            let answers = match *event {"
        for event, variant in self.kinds:
            names = [*(["slot"] if event.has_slot else []), *(field.name for field in event.fields)]
            pattern = f" {{ {', '.join(names)} }}" if names else ""
            yield f"                Event::{variant}{pattern} => self.{method(event, self.known)}({', '.join(names)}),"
        yield "            };"
        yield "            obey(event, answers);"
        yield "        }"
        yield "    }"

    def _events(self) -> Iterator[str]:
        yield ""
        yield "/// An event in a buffer, called like the method that raises it."
        yield "#[derive(Clone, Copy, Debug, PartialEq)]"
        yield "#[allow(missing_docs)]"
        yield "pub enum Event {"
        for event, variant in self.kinds:
            members = ", ".join(self._parameters(event))
            yield f"    {variant}{f' {{ {members} }}' if members else ''},"
        yield "}"


@dataclass(frozen=True, slots=True)
class TypeNames:
    """The names of the enums, and by request of the struct of its arguments."""

    enums: dict[Enum | Statuses, str]
    args: tuple[str, ...]


def type_names(known: SpecIdentifiers) -> TypeNames:
    """Return the names of types, all distinct and none in USED."""
    wanted = [each.type for each in known.enums.values()]
    wanted += [name for names in known.typed for name in (names.statuses.type, names.args)]
    found = variants(map(bare, wanted), USED)
    count = len(known.enums)
    enums: dict[Enum | Statuses, str] = dict(zip(known.enums, found[:count], strict=True))
    enums |= {Statuses(number): name for number, name in enumerate(found[count::2])}
    return TypeNames(enums, tuple(found[count + 1 :: 2]))


def taken(known: SpecIdentifiers) -> frozenset[str]:
    """Return names that no parameter gets: keywords, constants in patterns, and, for rustc warns of them, variants."""
    return KEYWORDS | PATTERNS | {variant for kind in known.enums for variant in variants(kind.values)}


def bare(name: str) -> str:
    """Return a name of identifiers.py without the prefix START."""
    return name.removeprefix(f"{START}_")


def method(event: EventCall, known: SpecIdentifiers) -> str:
    """Return the name of the method of an event: that of its function in C, without the name of the spec."""
    name = bare(function_of(event, known).function)
    return f"{name}_" if name.rstrip("_") == GENERIC else name
