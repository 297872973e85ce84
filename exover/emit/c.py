"""The tables as C sources, with the C runtime, which is copied beside them."""

from collections.abc import Iterable, Iterator, Sequence

from exover.bounds.events import EventBounds, bounds
from exover.bounds.sizes import (
    STACK,
    STACK_TARGET,
    Sizes,
    actions_per_event,
    memory_bytes,
    record_bytes,
    scrub_steps,
    sizes,
    stack_bytes,
    word_bytes,
)
from exover.emit import buildfiles, cnames, config, typed, wrappers
from exover.emit.artefact import Artefact, runtime_file
from exover.emit.cheader import header
from exover.emit.config import Needs
from exover.emit.identifiers import NamedConstant, constants, figure, prefix
from exover.model.model import Model
from exover.ocrd.packing import FIELDS, bits, checks, head, rows, words
from exover.ocrd.tables import Tables

RUNTIME = ("exover.h", "exover.c", "exover_form.h", "exover_resume.h")
BOX = ("exover_box.h", "exover_box.c")
SUFFIX = {2: "{}", 4: "{}", 8: "INT64_C({})"}
LEAST = {4: "(-INT32_C(2147483647) - 1)", 8: "(-INT64_C(9223372036854775807) - 1)"}
"""By width, the least number, which C has no literal for."""


def emit(
    model: Model, tables: Tables, name: str, beside: tuple[Needs, ...] = (), most: EventBounds | None = None
) -> tuple[Artefact, ...]:
    """Return the tables, the typed API, the names, the configuration, the runtime, and the files for build systems.

    The configuration, the runtime and CMakeLists.txt also serve the tables `beside`, which are in the same folder.
    `most`: tighter bounds of events, if known, than those of the tables alone.
    """
    most = most or bounds(tables)
    return (
        *emit_tables(model, tables, name, beside, most),
        Artefact(f"{name}_api.h", typed.api(model, name, most).encode()),
        Artefact(f"{name}_api.c", wrappers.source(model, name, most).encode()),
        *(Artefact(file, runtime_file(file)) for file in BOX),
        Artefact(f"{name}_names.h", cnames.declarations(model, name).encode()),
        Artefact(f"{name}_names.c", cnames.source(model, name).encode()),
        Artefact(buildfiles.CMAKE, buildfiles.cmake(sorted([name, *(each.name for each in beside)])).encode()),
        Artefact(f"exover_{name}.pc", buildfiles.pkgconfig(name).encode()),
    )


def emit_tables(
    model: Model, tables: Tables, name: str, beside: tuple[Needs, ...] = (), most: EventBounds | None = None
) -> tuple[Artefact, ...]:
    """Return the tables, the configuration and the runtime, which run without names and typed API."""
    figures = sizes(tables, most)
    return (
        Artefact(f"{name}_tables.h", _header(model, tables, name, figures).encode()),
        Artefact(f"{name}_tables.c", _source(model, tables, name).encode()),
        Artefact(config.FILE, config.config(tables, name, beside, figures).encode()),
        *(Artefact(file, runtime_file(file)) for file in RUNTIME),
    )


def _header(model: Model, tables: Tables, name: str, most: Sizes) -> str:
    known = constants(model, name)
    figures = [
        *_figures(tables, name, most),
        (figure(name, "SCRUB_STEPS"), scrub_steps(tables), "steps that find any bit that changed"),
    ]
    declarations = [
        f"extern const exover_tables {prefix(name)}_tables;",
        "",
        *(f"#define {macro} {value} /* {text} */" for macro, value, text in figures),
        *_stack(figure(name, "STACK_BYTES"), stack_bytes(tables)),
        "",
        *_enum("requests", known.requests),
        *_enum("posters, for exover_observe", known.posters),
        *_enum("consumable resources, for exover_level", known.stocks),
        *_enum("reasons of answers", known.reasons),
    ]
    about = f"/* The tables of the spec {model.name}: what a host needs to know of them. */"
    return header([about], figure(name, "TABLES_H"), ["exover.h"], declarations)


def _figures(tables: Tables, name: str, figures: Sizes) -> Iterator[tuple[str, int | str, str]]:
    fixed, by_state = memory_bytes(tables)
    memory = f"({fixed} + {by_state} * EXOVER_STATE)"
    yield figure(name, "MEMORY_BYTES"), memory, f"that exover_load demands: {figures.ram}, if nothing else is beside"
    yield figure(name, "TABLE_BYTES"), figures.rom, "of constants"
    yield figure(name, "RECORD_BYTES"), record_bytes(tables), "of what exover_export writes"
    yield figure(name, "TESTS"), figures.tests, "that no event exceeds"
    yield figure(name, "ACTIONS"), figures.actions, "that no event exceeds"
    yield figure(name, "PASSES"), figures.passes, "of settling that no event exceeds"
    yield (
        figure(name, "ROOM"),
        actions_per_event(tables) + 1,
        "answers for which there is room, more than any event has",
    )


def _stack(macro: str, most: int) -> Iterator[str]:
    """Yield the macro of the stack of a call: `most` if the runtime is compiled for these tables alone, else STACK."""
    about = f"that no call exceeds with {STACK_TARGET}"
    if most == STACK:
        yield f"#define {macro} {most} /* {about} */"
    else:
        yield f"#ifdef EXOVER_SHAPE /* {about} */"
        yield f"#define {macro} {most}"
        yield "#else"
        yield f"#define {macro} {STACK}"
        yield "#endif"


def _enum(title: str, known: tuple[NamedConstant, ...]) -> list[str]:
    if not known:
        return []
    body = ",\n".join(f"    {name} = {number}" for name, number in known)
    return [f"enum {{ /* {title} */", body, "};", ""]


def _source(model: Model, tables: Tables, name: str) -> str:
    start, width = prefix(name), word_bytes(tables)
    total = len(words(tables)) + len(checks(tables))
    reals = [f"    {{.bits = UINT64_C(0x{bits(value):016x})}}, /* {value!r} */" for value in tables.reals]
    lines = [
        f"/* The tables of the spec {model.name}; their bytes are those of {name}.bin. */",
        f'#include "{name}_tables.h"',
        "",
        f"#if EXOVER_WIDTH != {width}",
        f'#error "these tables are for EXOVER_WIDTH {width}"',
        "#endif",
        "",
        *([f"static const exover_value {start}_reals[] = {{", *reals, "};", ""] if reals else []),
        f"static const exover_word {start}_words[] = {{",
        *_records(tables, width),
        "};",
        "",
        f"const exover_tables {start}_tables = {{",
        "    {",
        *_head(tables),
        "    },",
        f"    {f'{start}_reals' if reals else 'NULL'}, {len(reals)}, {start}_words, {total}",
        "};",
    ]
    return "\n".join(lines) + "\n"


def _head(tables: Tables) -> Iterator[str]:
    numbers = head(tables)
    yield f"        {_hex(numbers[:5])} /* magic, version and width, flags, CRC-32, doubles */"
    yield f"        {_hex(numbers[5:13])}"
    yield "        /* sha256 of the spec; then the numbers of records, and of check words */"
    yield f"        {', '.join(f'{count}u' for count in numbers[13:])}"


def _hex(numbers: Iterable[int]) -> str:
    return " ".join(f"0x{number:08x}u," for number in numbers)


def _records(tables: Tables, width: int) -> Iterator[str]:
    *records_of, _ = zip(FIELDS.items(), rows(tables), strict=True)
    sections = [(f"{title}: {', '.join(names)}", list(records)) for (title, names), records in records_of]
    sections += [("lists", _lines(tables.lists)), ("checks", _lines(checks(tables)))]
    for title, records in sections:
        if records:
            yield f"    /* {title} */"
        for record in records:
            yield f"    {', '.join(_number(number, width) for number in record)},"


def _lines(words: Sequence[int]) -> list[tuple[int, ...]]:
    return [tuple(words[i : i + 16]) for i in range(0, len(words), 16)]


def _number(number: int, width: int) -> str:
    return LEAST[width] if width > 2 and number == -(1 << (8 * width - 1)) else SUFFIX[width].format(number)
