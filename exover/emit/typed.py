"""The C header of the typed API of a spec: a function for each event, and one for a buffer of the events of a cycle."""

from collections.abc import Iterable, Iterator, Sequence
from textwrap import wrap

from exover.bounds.events import EventBounds
from exover.emit.cheader import header
from exover.emit.ctyped import CApi
from exover.emit.events import EventCall, Struct, calls, structs
from exover.emit.identifiers import Enumeration, SpecIdentifiers, constants, figure, prefix
from exover.escaping import visible
from exover.model.model import Model
from exover.ocrd.reasons import reasons

WIDTH = 118
"""The most characters of a line of a comment."""
PREFACE = """Each function tells of one event, which is decided at once. It returns EXOVER_READY, or why everything is
denied: then what runs can still be reported and aborted, until the checker is started again. A value that is out of
range is answered by EXOVER_INVALID and does nothing else, unless the poster has an `else` value, which is then taken.
`answer` may be NULL. The bound of a call is the most tests of its diagrams and the most answers, whatever the state.
Nothing is allocated; a checker belongs to one thread at a time, and is neither moved nor copied."""
ANSWERS = """What answers an event: actions in the order in which they were decided, valid until the next event. Of an
action, `kind` is one of the following, and exover_holds() tells whether it, or a copy of it, has changed since"""
KINDS = (
    ("EXOVER_LAUNCH", "start `slot` of `request` with its arguments; `reason` if a launch rule starts it at once"),
    ("EXOVER_WAIT", "`request` waits, for `reason`; it will be launched or rejected"),
    ("EXOVER_REJECT", "`request` is refused, or given up while it waited, for `reason`"),
    ("EXOVER_KILL", "stop `slot` of `request`, for `reason`, and report how it ended"),
    ("EXOVER_VIOLATION", "the rule `reason` could not be restored"),
    ("EXOVER_INVALID", "the event was none, and did nothing: `reason` is an exover_invalid"),
)
CYCLE = """The events of a cycle, in order of arrival, one after another. Their answers are copied to `actions`, which
has `room` places, and `said` is how many. An event is taken if {room} places are free, so that no answer is lost;
returns how many were. The places behind have the kind 0, which is no answer. The others are for the next call.
Bound: that of each event, and `room`."""

ARGUMENTS = """They are kept when it has ended; before its first launch all are 0, whatever their ranges: the phase of
the slot tells whether it is active. False if there is no such slot, if the checker was never started, or if they have
changed since, which is a fault. Bound: constant."""


def api(model: Model, name: str, most: EventBounds) -> str:
    """Return the text of `NAME_api.h`, which documents the API for a host."""
    known, start = constants(model, name), prefix(name)
    capi, every = CApi(known, start), tuple(calls(model, most, known.taken))
    declarations = [
        "/* ---- values ---- */",
        "",
        *_types(model, capi),
        "/* ---- the checker ---- */",
        "",
        *_checker(start, figure(name, "MEMORY_BYTES")),
        *_answers(model, known, start),
        *_declarations(model, capi, every),
        *(_cycle(every, capi, figure(name, "ROOM")) if every else ()),
    ]
    return header(
        _preface(model, name, capi, every), figure(name, "API_H"), [f"{name}_tables.h"], declarations, _recording(start)
    )


def _preface(model: Model, name: str, capi: CApi, every: Sequence[tuple[str, tuple[EventCall, ...]]]) -> Iterator[str]:
    start = prefix(name)
    yield f"/* {name}_api.h - the checker of the spec {model.name}: what it is told, and what it answers."
    yield " *"
    yield f" *     static {start}_checker r2c;"
    yield f" *     {start}_answer answer;"
    yield f" *     if ({start}_start(&r2c) != EXOVER_READY) ...;"
    for _, events in every[:1]:
        arguments = ", ".join(["&r2c", *(field.name for field in events[0].fields), "&answer"])
        yield f" *     {capi.call(events[0]).function}({arguments});"
    yield " *     for (size_t i = 0; i < answer.count; i++) obey(&answer.actions[i]);"
    yield " *"
    yield from _paragraph(PREFACE)
    yield " */"


def _paragraph(text: str, start: str = " * ", then: str = " * ") -> list[str]:
    """Return a text as lines of a comment, with `*/` and `/*` in it taken apart."""
    harmless = visible(" ".join(text.split())).replace("*/", "* /").replace("/*", "/ *")
    return wrap(harmless, WIDTH, initial_indent=start, subsequent_indent=then, break_long_words=False)


def _comment(text: str) -> list[str]:
    lines = _paragraph(text, "/* ")
    return [*lines[:-1], f"{lines[-1]} */"]


# ---- types ----


def _types(model: Model, capi: CApi) -> Iterator[str]:
    for enumeration in capi.known.enums.values():
        yield from _enum(enumeration)
    for request, names in zip(model.requests, capi.known.typed, strict=True):
        if request.statuses:
            yield f"/* Why {request.name} has failed. */"
            yield from _enum(names.statuses)
    for (args, results), names in zip(structs(model, capi.known.taken), capi.known.typed, strict=True):
        yield from _struct(args, names.args, capi)
        yield from _struct(results, names.results, capi)


def _enum(enumeration: Enumeration) -> Iterator[str]:
    yield f"typedef enum {enumeration.type} {{"
    yield ",\n".join(f"    {name} = {number}" for name, number in enumeration.constants)
    yield f"}} {enumeration.type};"
    yield ""


def _struct(struct: Struct, name: str, capi: CApi) -> Iterator[str]:
    if struct.fields:
        yield f"/* {struct.about}. */"
        yield f"typedef struct {name} {{"
        for field in struct.fields:
            yield f"    {capi.type(field.type)} {field.name};{f' /* {field.range} */' if field.range else ''}"
        yield f"}} {name};"
        yield ""


def _checker(start: str, memory: str) -> Iterator[str]:
    yield "/* A checker with all its memory; `generic` is what exover.h speaks of. */"
    yield f"typedef struct {start}_checker {{"
    yield "    exover generic;"
    yield f"    uint64_t memory[({memory} + 7) / 8];"
    yield "#ifdef EXOVER_BOX"
    yield "    exover_box box;"
    yield "#endif"
    yield f"}} {start}_checker;"
    yield ""
    yield "/* Start. A checker that was started already is EXOVER_LIVE, and goes on as it was: the second starts it"
    yield " * anew, and says that everything it has launched was stopped. The third goes on from a record of"
    yield " * exover_export."
    yield " * Bound: one look at every byte of the tables, of the memory and of the record. */"
    yield f"exover_status {start}_start({start}_checker *r2c);"
    yield f"exover_status {start}_start_stopped({start}_checker *r2c);"
    yield f"exover_status {start}_resume({start}_checker *r2c, const void *record, size_t bytes);"
    yield ""
    yield "#ifdef EXOVER_BOX"
    yield "/* Record from now on, in this memory, where it outlives a restart. False if there is no room for a line."
    yield " * Bound: one look at every byte of the memory. */"
    yield f"bool {start}_record({start}_checker *r2c, void *memory, size_t size);"
    yield "#endif"
    yield ""


def _recording(start: str) -> Iterator[str]:
    yield "/* With EXOVER_BOX events and answers are recorded, for host and checker alike: else they do not link. */"
    yield "#ifdef EXOVER_BOX"
    yield '#include "exover_box.h"'
    yield f"#define {start}_start {start}_start_recorded"
    yield "#endif"
    yield ""


def _answers(model: Model, known: SpecIdentifiers, start: str) -> Iterator[str]:
    yield from _paragraph(ANSWERS, "/* ")
    for kind, text in KINDS:
        yield f" *     {kind:<17} {text}"
    yield " * `request` is one of"
    for constant, _ in known.requests:
        yield f" *     {constant}"
    yield " * `reason` is below 0 (EXOVER_SUPERSEDED, EXOVER_ABORTED, EXOVER_FAULTY, EXOVER_UNSAID), or one of"
    for (constant, _), reason in zip(known.reasons, reasons(model), strict=True):
        text = f': "{reason.because}"' if reason.because else ""
        yield from _paragraph(f"{constant} {reason.rule}{text}", " *     ", " *         ")
    yield " * `launch_rule` is the one of these that a launch, wait or rejection comes of, or EXOVER_UNSAID"
    yield " */"
    yield f"typedef struct {start}_answer {{"
    yield "    const exover_action *actions;"
    yield "    size_t count;"
    yield f"}} {start}_answer;"
    yield ""


# ---- functions ----


def _declarations(model: Model, capi: CApi, every: Iterable[tuple[str, tuple[EventCall, ...]]]) -> Iterator[str]:
    known, start = capi.known, capi.start
    pairs = zip(model.requests, readers(model, known, start), strict=True)
    told = {request.name: reader for request, reader in pairs if reader}
    seen = {request.name: heads for request, heads in zip(model.requests, viewers(model, known, start), strict=True)}
    for subject, events in every:
        yield f"/* ---- {subject} ---- */"
        yield ""
        for event in events:
            ranges = "; ".join(f"{field.name}: {field.range}" for field in event.fields if field.range)
            cost = f"Bound: {event.bound.tests} tests, {event.bound.answers} answers."
            yield from _comment(f"{event.about}. {f'{ranges}. ' if ranges else ''}{cost}")
            yield f"{capi.signature(event)};"
            yield ""
        if subject in told:
            yield from _comment(f"The arguments that {subject} was launched with last. {ARGUMENTS}")
            yield f"{told.pop(subject)};"
            yield ""
        if subject in seen:
            yield from _comment(f"What a slot of {subject} holds, and its waiting place. Bound: constant.")
            yield from (f"{head};" for head in seen.pop(subject))
            yield ""


def readers(model: Model, known: SpecIdentifiers, start: str) -> Iterator[str]:
    """Yield for each request the head of the function that reads a slot's arguments; "" if it has no parameters."""
    for request, names in zip(model.requests, known.typed, strict=True):
        slot = "int32_t slot, " if request.instances > 1 else ""
        parameters = f"{start}_checker *r2c, {slot}{names.args} *args"
        yield f"bool {names.read}({parameters})" if request.params else ""


def viewers(model: Model, known: SpecIdentifiers, start: str) -> Iterator[tuple[str, str]]:
    """Yield for each request the heads of the functions that return what a slot, and the waiting place, hold."""
    for request, names in zip(model.requests, known.typed, strict=True):
        slot = ", int32_t slot" if request.instances > 1 else ""
        r2c = f"{start}_checker *r2c"
        yield f"exover_view {names.slot}({r2c}{slot})", f"exover_view {names.place}({r2c})"


def _cycle(every: Iterable[tuple[str, tuple[EventCall, ...]]], capi: CApi, room: str) -> Iterator[str]:
    start = capi.start
    events = [event for _, group in every for event in group]
    yield "/* ---- cycles ---- */"
    yield ""
    yield f"typedef enum {start}_event_kind {{"
    yield ",\n".join(f"    {capi.call(event).event}" for event in events)
    yield f"}} {start}_event_kind;"
    yield ""
    yield "/* An event in a buffer: its values are the member called as the function. */"
    yield f"typedef struct {start}_event {{"
    yield f"    {start}_event_kind kind;"
    yield "    int32_t slot; /* of a report or an abort, where a request has several */"
    members = [f"        {capi.member_type(event)} {capi.member(event)};" for event in events if event.fields]
    if members:
        yield from ["    union {", *members, "    } of;"]
    yield f"}} {start}_event;"
    yield ""
    yield from _comment(CYCLE.format(room=room))
    before = f"size_t {start}_cycle("
    yield f"{before}{start}_checker *r2c, const {start}_event *events, size_t count,"
    yield f"{' ' * len(before)}exover_action *actions, size_t room, size_t *said);"
    yield ""
