"""The items of a recorded mission, and the reader of its lines (docs/audit.md)."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Literal, TypeGuard

from exover.dataclass import dataclass
from exover.model.event import Args, Ask, Event, Invalid, Report
from exover.model.model import Model
from exover.model.wire import Json
from exover.model.wire_reading import read_entries, read_object, shown
from exover.run.codec import C_CODES

CODES = (*C_CODES, "wrong-type")
"""The codes of `invalid`, those of the C runtime first."""
KINDS = ("ask", "report", "observe", "abort")
DEEDS = ("launch", "kill", "wait", "reject")


@dataclass(frozen=True, slots=True)
class LaunchDeed:
    """The robot has started an instance; `args` are None if they were not recorded."""

    request: str
    instance: int
    args: Args | None


@dataclass(frozen=True, slots=True)
class KillDeed:
    """The robot has told an instance to stop."""

    request: str
    instance: int


@dataclass(frozen=True, slots=True)
class WaitDeed:
    """The robot has put an ask of this request into the waiting place."""

    request: str


@dataclass(frozen=True, slots=True)
class RejectDeed:
    """The robot has refused an ask of this request, or what waited there."""

    request: str


@dataclass(frozen=True, slots=True)
class ToldMark:
    """The deeds since the last event are all that the robot did about it: the event is told."""


@dataclass(frozen=True, slots=True)
class LostLines:
    """So many lines of the mission are missing here."""

    lines: int


@dataclass(frozen=True, slots=True)
class Unread:
    """An event, a deed or another line that cannot be read, with its fault, and its request if that is known.

    `kind`: what it is as far as that is known; an `ask`, a `report` and a `launch` are of a known request. An unread
    report with a known instance still says that the instance has ended.
    """

    fault: Invalid
    kind: Literal["ask", "report", "event", "launch", "deed", "other"] = "other"
    request: str | None = None
    instance: int | None = None

    @property
    def foreign(self) -> bool:
        """Whether this counts as a mistake, as of another spec or no mission at all; a value out of range does not."""
        return self.fault.code != "out-of-range"


@dataclass(frozen=True, slots=True)
class Void:
    """A report or an abort that the record itself answers as `invalid`."""


Deed = LaunchDeed | KillDeed | WaitDeed | RejectDeed
Item = Event | Deed | ToldMark | LostLines | Void | Unread


@dataclass(frozen=True, slots=True)
class Noted:
    """The items of a line in order, and its time in seconds; NaN if it has none, or for `fault`."""

    items: tuple[Item, ...]
    time: float = math.nan
    fault: Invalid | None = None


def read_line(model: Model, line: bytes, behind: bytes = b"") -> Noted:
    """Return the content of a line that is not blank; `behind`: the next such line, which may hold its actions."""
    entries = read_object(line)
    if isinstance(entries, Invalid):
        return Noted((Unread(entries),))
    if behind and "actions" not in entries and _is_denied(_event_of(entries), behind):
        return Noted((Void(),), *read_time(entries.get("time")))
    return read_noted(model, entries)


def _is_denied(event: object, behind: bytes) -> bool:
    """Return whether an event is a report or an abort that the actions in the next line answer as `invalid`."""
    if not _is_event(event) or not _ends(event):
        return False
    entries = read_object(behind)
    if isinstance(entries, Invalid) or any(key in entries for key in ("event", *KINDS, *DEEDS, "lost")):
        return False
    return _is_void(event, entries.get("actions"))


def read_noted(model: Model, entries: Json) -> Noted:
    """Return the content of a line, given its object."""
    return Noted(tuple(_items(model, entries)), *read_time(entries.get("time")))


def read_time(found: object) -> tuple[float, Invalid | None]:
    """Return a time in seconds, NaN if this is no finite number; and a fault if it is not None either."""
    if found is None:
        return math.nan, None
    if isinstance(found, bool) or not hasattr(found, "__float__"):
        return math.nan, Invalid("wrong-type", f"`time` is {shown(found)}, not a number of seconds")
    try:
        time = float(found) + 0.0
    except OverflowError:
        time = math.inf
    if math.isfinite(time):
        return time, None
    return math.nan, Invalid("out-of-range", "`time` is no finite number of seconds")


def _items(model: Model, entries: Json) -> Iterator[Item]:
    event = _event_of(entries)
    if _is_event(event):
        yield Void() if _is_void(event, entries.get("actions")) else read_recorded(model, event)
        if "actions" in entries:
            yield from _actions(model, entries["actions"])
    elif "event" in entries:
        yield Unread(Invalid("bad-event", "`event` is no event: none of ask, report, observe, abort is there"))
    elif any(kind in entries for kind in DEEDS):
        yield from _deed(model, entries)
    elif "lost" in entries:
        lost = entries["lost"]
        known = isinstance(lost, int) and not isinstance(lost, bool) and 0 <= lost < 1 << 63
        yield LostLines(int(lost)) if known else Unread(Invalid("bad-event", "`lost` is no number of lines"))
    elif "actions" in entries:
        yield from _actions(model, entries["actions"])
    elif "refused" not in entries and "alarm" not in entries:
        yield Unread(Invalid("bad-event", "it is neither an event nor what a robot did"))


def _event_of(entries: Json) -> object:
    return entries.get("event", entries)


def _is_event(found: object) -> TypeGuard[Json]:
    return isinstance(found, dict) and any(kind in found for kind in KINDS)


def _ends(event: Json) -> bool:
    return next(kind for kind in KINDS if kind in event) in ("report", "abort")


def _is_void(event: Json, actions: object) -> bool:
    answered = isinstance(actions, list) and any(isinstance(each, dict) and "invalid" in each for each in actions)
    return answered and _ends(event)


def _actions(model: Model, found: object) -> Iterator[Item]:
    if not isinstance(found, list):
        yield Unread(Invalid("bad-event", "`actions` is no list"))
        return
    for action in found:
        if isinstance(action, dict):
            yield from _deed(model, action)
        else:
            yield Unread(Invalid("bad-event", "an action is no object"))
    yield ToldMark()


def read_recorded(model: Model, entries: Json) -> Event | Unread:
    """Return the event in an object with a key of `KINDS`, or `Unread` with the reason."""
    event = read_entries(model, entries)
    if not isinstance(event, Invalid):
        return event
    kind = next(kind for kind in KINDS if kind in entries)
    name = entries[kind]
    if kind not in ("ask", "report") or not isinstance(name, str) or name not in model.request:
        return Unread(event, "event")
    if kind == "ask":
        return Unread(event, "ask", name)
    instance = _instance(model, name, entries)
    return Unread(event, "event") if isinstance(instance, Invalid) else Unread(event, "report", name, instance)


def _deed(model: Model, entries: Mapping[str, Any]) -> Iterator[Item]:
    kind = next((kind for kind in DEEDS if kind in entries), None)
    if kind is None:
        return
    name = entries[kind]
    if not isinstance(name, str) or name not in model.request:
        fault = read_entries(model, {"abort": name})
        assert isinstance(fault, Invalid)
        yield Unread(fault, "deed")
    elif kind == "wait":
        yield WaitDeed(name)
    elif kind == "reject":
        yield RejectDeed(name)
    else:
        instance = _instance(model, name, entries)
        if kind == "kill":
            yield Unread(instance, "deed") if isinstance(instance, Invalid) else KillDeed(name, instance)
        else:
            yield _launch(model, name, instance, entries)


def _launch(model: Model, name: str, instance: int | Invalid, entries: Mapping[str, Any]) -> Item:
    if isinstance(instance, Invalid):
        return Unread(instance, "launch", name)
    if "args" not in entries:
        return LaunchDeed(name, instance, None)
    asked = read_entries(model, {"ask": name, "args": entries["args"]})
    if isinstance(asked, Invalid):
        return Unread(asked, "launch", name, instance)
    assert isinstance(asked, Ask)
    return LaunchDeed(name, instance, asked.args)


def _instance(model: Model, name: str, entries: Mapping[str, Any]) -> int | Invalid:
    """Return the instance that an object names, 0 if it names none, or why that is none of the request."""
    given = {"instance": entries["instance"]} if "instance" in entries else {}
    read = read_entries(model, {"report": name, "outcome": "interrupted", **given})
    return read.slot if isinstance(read, Report) else read if isinstance(read, Invalid) else 0
