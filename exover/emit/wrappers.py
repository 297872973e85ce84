"""The C source of the typed API of a spec: each function is defined by one call of the generic API."""

from collections.abc import Iterable, Iterator

from exover.bounds.events import EventBounds
from exover.emit.ctyped import CHECKER, CApi, initializer
from exover.emit.events import EventCall, Field, calls, structs
from exover.emit.identifiers import SpecIdentifiers, constants, figure, prefix
from exover.emit.typed import readers, viewers
from exover.model.model import Model


def source(model: Model, name: str, most: EventBounds) -> str:
    """Return the text of `NAME_api.c`."""
    known, start = constants(model, name), prefix(name)
    capi = CApi(known, start)
    every = [event for _, group in calls(model, most, known.taken) for event in group]
    lines = [
        f"/* The checker of the spec {model.name}: see {name}_api.h. */",
        f'#include "{name}_api.h"',
        "",
        *_recorded(start),
        f"exover_status {start}_start({start}_checker *r2c)",
        "{",
        f"    return begun(r2c, exover_load(&r2c->generic, &{start}_tables, r2c->memory, sizeof r2c->memory));",
        "}",
        "",
        f"exover_status {start}_start_stopped({start}_checker *r2c)",
        "{",
        f"    return begun(r2c, exover_load_stopped(&r2c->generic, &{start}_tables, r2c->memory, sizeof r2c->memory));",
        "}",
        "",
        f"exover_status {start}_resume({start}_checker *r2c, const void *record, size_t bytes)",
        "{",
        f"    return begun(r2c, exover_resume(&r2c->generic, &{start}_tables, r2c->memory, sizeof r2c->memory, record,",
        "                                    bytes));",
        "}",
        "",
    ]
    if every:
        lines += _answered(start)
    for event in every:
        lines += _definition(event, capi)
    for definition in _reading(model, capi):
        lines += definition
    lines += _viewing(model, known, start)
    if every:
        lines += [*_taking(every, capi), *_cycling(start, figure(name, "ROOM"))]
    return "\n".join(lines)


def _recorded(start: str) -> Iterator[str]:
    """Yield the lines by which each event goes through the black box if EXOVER_BOX is defined."""
    yield "#ifdef EXOVER_BOX /* every event goes through the black box */"
    for event in ("ask", "report", "observe", "level", "abort", "abort_waiting"):
        yield f"#undef exover_{event}"
        yield f"#define exover_{event} exover_box_{event}"
    yield f"#define {CHECKER} &r2c->box, &r2c->generic"
    yield ""
    yield f"bool {start}_record({start}_checker *r2c, void *memory, size_t size)"
    yield "{"
    yield "    return exover_box_open(&r2c->box, &r2c->generic, memory, size);"
    yield "}"
    yield ""
    yield "/* What began is recorded once the box is opened again. */"
    yield f"static exover_status begun({start}_checker *r2c, exover_status found)"
    yield "{"
    yield "    if (found != EXOVER_LIVE)"
    yield "        r2c->box.memory = NULL;"
    yield "    return found;"
    yield "}"
    yield "#else"
    yield f"#define {CHECKER} &r2c->generic"
    yield "#define begun(r2c, found) (found)"
    yield "#endif"
    yield ""


def _answered(start: str) -> list[str]:
    return f"""static exover_status answered({start}_checker *r2c, size_t count, {start}_answer *answer)
{{
    const size_t verified = exover_verify(&r2c->generic, count);
    if (answer != NULL) {{
        answer->actions = r2c->generic.actions;
        answer->count = verified;
    }}
    return exover_fault(&r2c->generic);
}}
""".split("\n")


def _definition(event: EventCall, capi: CApi) -> Iterator[str]:
    yield capi.signature(event)
    yield "{"
    if event.fields and event.does in ("ask", "ok"):
        yield f"    const exover_value values[] = {{{', '.join(map(initializer, event.fields))}}};"
    yield f"    return answered(r2c, {capi.generic(event)}, answer);"
    yield "}"
    yield ""


def _reading(model: Model, capi: CApi) -> Iterator[list[str]]:
    heads = readers(model, capi.known, capi.start)
    every = structs(model, capi.known.taken)
    pairs = zip(model.requests, capi.known.requests, every, heads, strict=True)
    for request, (constant, _), (args, _), reader in pairs:
        if reader:
            slot = "slot" if request.instances > 1 else "0"
            yield [
                reader,
                "{",
                f"    const exover_value *values = exover_args(&r2c->generic, {constant}, {slot});",
                "    if (values == NULL)",
                "        return false;",
                *(
                    f"    args->{field.name} = {_read(field, number, capi)};"
                    for number, field in enumerate(args.fields)
                ),
                "    return true;",
                "}",
                "",
            ]


def _viewing(model: Model, known: SpecIdentifiers, start: str) -> Iterator[str]:
    heads = viewers(model, known, start)
    for request, (constant, _), (slot, place) in zip(model.requests, known.requests, heads, strict=True):
        number = "slot" if request.instances > 1 else "0"
        yield from (slot, "{", f"    return exover_slot(&r2c->generic, {constant}, {number});", "}", "")
        yield from (place, "{", f"    return exover_place(&r2c->generic, {constant});", "}", "")


def _read(field: Field, number: int, capi: CApi) -> str:
    if field.type == "double":
        return f"values[{number}].real"
    return (
        f"values[{number}].integer != 0"
        if field.type == "bool"
        else f"({capi.type(field.type)})values[{number}].integer"
    )


def _taking(every: Iterable[EventCall], capi: CApi) -> Iterator[str]:
    start = capi.start
    yield f"static void take({start}_checker *r2c, const {start}_event *event, {start}_answer *answer)"
    yield "{"
    yield "    switch (event->kind) {"
    for event in every:
        values = capi.members(event, f"event->of.{capi.member(event)}")
        arguments = ["r2c", *(["event->slot"] if event.has_slot else []), *values, "answer"]
        call = capi.call(event)
        yield f"    case {call.event}: (void){call.function}({', '.join(arguments)}); break;"
    yield f"    default: (void)answered(r2c, exover_ask({CHECKER}, -1, NULL, 0), answer); /* no such event */"
    yield "    }"
    yield "}"
    yield ""


def _cycling(start: str, room: str) -> list[str]:
    before = f"size_t {start}_cycle("
    return f"""{before}{start}_checker *r2c, const {start}_event *events, size_t count,
{" " * len(before)}exover_action *actions, size_t room, size_t *said)
{{
    size_t taken = 0, used = 0;
    while (taken < count && room - used >= {room}) {{
        {start}_answer answer = {{NULL, 0}};
        take(r2c, &events[taken++], &answer);
        for (size_t i = 0; i < answer.count; i++)
            actions[used++] = answer.actions[i];
    }}
    for (size_t i = used; i < room; i++)
        actions[i].kind = 0;
    *said = used;
    return taken;
}}
""".split("\n")
