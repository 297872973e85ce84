"""Checks whether a binding can be served on ROS 2: its names, its types, and the fields that it names."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from exover.gate.binding import Binding, RequestBinding, Watch
from exover.gate.fields import BOOLS, FieldPath, UnreadableField, ValueField
from exover.gate.ros2.interfaces import Interfaces, UnknownType
from exover.gate.ros2.names import absolute, is_name, is_type
from exover.model.model import Model
from exover.model.types import Bool, Enum
from exover.model.wire_reading import domain

KINDS = {"action": "action", "service": "srv"}


def mistakes(binding: Binding, interfaces: Interfaces, apart: bool) -> Iterator[str]:
    """Yield the mistakes of a binding, and load its types; `apart` iff inner names have a DDS domain of their own."""
    for bound in binding.requests:
        if bound.kind == "tool":
            yield f"{bound.request} is bound to a tool of MCP, and this gate serves ROS 2"
        else:
            yield from _request(bound, interfaces, apart)
    for watch in binding.watches:
        if watch.kind != "topic":
            yield f"the watch {watch.name} is a {watch.kind} of MCP, and this gate serves ROS 2"
        else:
            yield from _topic(binding, watch, interfaces)
    yield from _shared(binding)


def _request(bound: RequestBinding, interfaces: Interfaces, apart: bool) -> Iterator[str]:
    about, kind = f"{bound.request}: ", KINDS[bound.kind]
    for name in (bound.outer, bound.inner):
        if not is_name(absolute(name)):
            yield f"{about}`{name}` is no name of ROS 2"
    if absolute(bound.outer) == absolute(bound.inner) and not apart:
        yield f"{about}`{bound.inner}` is the outer name as well: write `inner`, or name an --inner-domain"
    if unknown := _unknown(str(bound.type), kind, interfaces):
        yield f"{about}{unknown}"
        return
    going, coming = ("Goal", "Result") if kind == "action" else ("Request", "Response")
    asked = [each.path for each in bound.arguments] + [path for path, _ in (*bound.when, *bound.constants)]
    results = bound.report.results if bound.report.watch is None else ()
    told = [each.path for each in results]
    told += [bound.report.status] if bound.report.status and bound.report.watch is None else []
    told += [path for path, _ in bound.refused]
    yield from _missing(about, interfaces, f"{bound.type}_{going}", asked)
    yield from _missing(about, interfaces, f"{bound.type}_{coming}", told)
    yield from _unread(about, interfaces, f"{bound.type}_{going}", bound.arguments)
    yield from _unread(about, interfaces, f"{bound.type}_{coming}", results)
    wrong = [
        *_unfit(about, interfaces, f"{bound.type}_{going}", (*bound.when, *bound.constants)),
        *_unfit(about, interfaces, f"{bound.type}_{coming}", bound.refused),
    ]
    yield from wrong or _unwritten(about, interfaces, f"{bound.type}_{coming}", bound.refused)


def unmade(model: Model, binding: Binding, interfaces: Interfaces) -> Iterator[str]:
    """Yield the launch rules whose calls the gate cannot make, of a binding without mistakes."""
    for launch in model.launches:
        bound = binding.of(launch.request)
        if bound is not None:
            about, type_ = f"{launch.name}: ", f"{bound.type}_{'Goal' if bound.kind == 'action' else 'Request'}"
            values = bound.own_values(launch.args)
            yield from list(_unfit(about, interfaces, type_, values)) or _unwritten(about, interfaces, type_, values)


def _topic(binding: Binding, watch: Watch, interfaces: Interfaces) -> Iterator[str]:
    about = f"the watch {watch.name}: "
    if not is_name(absolute(watch.source)):
        yield f"{about}`{watch.source}` is no name of ROS 2"
    if unknown := _unknown(str(watch.type), "msg", interfaces):
        yield f"{about}{unknown}"
        return
    fields = [each.field for each in binding.posters if each.watch == watch.name]
    fields += [each for bound in binding.watched_by(watch.name) for each in bound.report.results]
    read = [each.path for each in fields]
    read += [bound.report.status or () for bound in binding.watched_by(watch.name)]
    yield from _missing(about, interfaces, str(watch.type), read)
    yield from _unread(about, interfaces, str(watch.type), fields)


def _unknown(type_: str, kind: str, interfaces: Interfaces) -> str:
    """Load a type; return why it cannot be loaded, an empty text if it is."""
    if not is_type(type_, kind):
        return f"the type is `{type_}`, and not as in package/{kind}/Name"
    try:
        interfaces.load(type_)
    except UnknownType as why:
        return str(why)
    return ""


def _missing(about: str, interfaces: Interfaces, type_: str, paths: Iterable[FieldPath]) -> Iterator[str]:
    for path in paths:
        if not interfaces.has(type_, path):
            yield f"{about}{type_} has no field `{'.'.join(path)}`"


def _unread(about: str, interfaces: Interfaces, type_: str, fields: Iterable[ValueField]) -> Iterator[str]:
    """Yield the fields of which no value can be one of the type in the spec."""
    for each in fields:
        base = interfaces.base(type_, each.path)
        if interfaces.has(type_, each.path) and not _reads(each, base):
            found = f"`{'.'.join(each.path)}` of {type_} is {base or 'no number, bool or text'}"
            expected = f"one of {', '.join(each.values)}" if each.values else domain(each.type)
            yield f"{about}{found}, and `{each.name}` is read from {expected}"


def _reads(field: ValueField, base: str | None) -> bool:
    if field.values or isinstance(field.type, Enum):
        return base == "string" or (base == "bool" and not BOOLS.isdisjoint(field.values))
    if isinstance(field.type, Bool):
        return base == "bool"
    return base not in (None, "bool", "string")


def _unfit(about: str, interfaces: Interfaces, type_: str, values: Iterable[tuple[FieldPath, Any]]) -> Iterator[str]:
    for path, value in values:
        if interfaces.has(type_, path) and not interfaces.fits(type_, path, value):
            yield f"{about}`{'.'.join(path)}` of {type_} is of another type than {value!r:.60}"


def _unwritten(
    about: str, interfaces: Interfaces, type_: str, values: Sequence[tuple[FieldPath, Any]]
) -> Iterator[str]:
    try:
        interfaces.write(type_, values)
    except UnreadableField as why:
        yield f"{about}{why}"


def _shared(binding: Binding) -> Iterator[str]:
    """Yield mistakes in names that several requests, or watches, share."""
    known: dict[tuple[str, str], RequestBinding] = {}
    inner: dict[tuple[str, str], str] = {}
    for bound in binding.requests:
        outer = absolute(bound.outer)
        first = known.setdefault((bound.kind, outer), bound)
        if (first.type, absolute(first.inner)) != (bound.type, absolute(bound.inner)):
            yield f"{bound.request}: {first.request} has the same {bound.kind} `{outer}` with another `type` or `inner`"
        if inner.setdefault((bound.kind, absolute(bound.inner)), outer) != outer:
            yield f"{bound.request}: the inner {bound.kind} `{bound.inner}` has two outer names"
    sources = [absolute(each.source) for each in binding.watches]
    for name in sorted({each for each in sources if sources.count(each) > 1}):
        yield f"the topic `{name}` is watched twice"
