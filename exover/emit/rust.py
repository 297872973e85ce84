"""A Rust crate without dependencies: the runtime, the same for every spec, with the tables and names of one spec."""

import re
from collections.abc import Iterator

from exover.bounds.events import EventBounds, bounds
from exover.bounds.sizes import record_bytes, scrub_steps, shape, sizes, slot_count, state_bytes, word_bytes
from exover.emit.artefact import Artefact, runtime_file
from exover.emit.rustnames import names
from exover.emit.rusttyped import typed
from exover.model.model import Model
from exover.ocrd.packing import FIELDS, bits, checks, counts, head, rows
from exover.ocrd.tables import Tables

RUNTIME = (
    "lib.rs", "answers.rs", "blackbox.rs", "cells.rs", "checker.rs", "decisions.rs", "events.rs", "features.rs",
    "recording.rs", "records.rs", "resume.rs", "state.rs",
)  # fmt: skip
RECORDS = (
    "NodeRow", "EntryRow", "RequestRow", "ParamRow", "OrderRow", "FeatureRow", "PastRow", "AmountRow", "EffectRow",
    "VariableRow", "LatchRow", "StockRow", "RuleRow", "LaunchRow", "LimitsRow", "ConflictRow", "ReasonRow",
    "InvariantRow", "SumRow", "ListRow",
)  # fmt: skip
"""The type in `records.rs` of the records of each section, in the order of the sections."""
RUST_VERSION = "1.73"
RESERVED = {
    "abstract", "alloc", "as", "async", "await", "become", "box", "break", "build", "const", "continue", "core",
    "crate", "deps", "do", "dyn", "else", "enum", "examples", "extern", "false", "final", "fn", "for", "gen",
    "if", "impl", "in", "incremental", "let", "loop", "macro", "match", "mod", "move", "mut", "override",
    "priv", "proc_macro", "pub", "ref", "return", "self", "static", "std", "struct", "super", "test", "trait",
    "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
}  # fmt: skip
"""Names that no package may have."""
MANIFEST, ROOT = "Cargo.toml", "src/lib.rs"
MARKS = {MANIFEST: "# The checker of the spec ", ROOT: "//! The checker of an exover spec"}
"""The first text of these files if some version of exover has written the crate, so that it may be replaced."""


def emit(model: Model, tables: Tables, name: str, most: EventBounds | None = None) -> tuple[Artefact, ...]:
    """Return the files of the crate."""
    return (
        Artefact(MANIFEST, _manifest(model, name).encode()),
        *emit_sources(model, tables, name, "src/", most),
    )


def emit_sources(
    model: Model, tables: Tables, name: str, folder: str = "", most: EventBounds | None = None
) -> tuple[Artefact, ...]:
    """Return the sources, in a folder; `most`: tighter bounds of events, if known, than those of the tables alone."""
    most = most or bounds(tables)
    return (
        *(Artefact(f"{folder}{file}", runtime_file(f"rust/{file}")) for file in RUNTIME),
        Artefact(f"{folder}api.rs", typed(model, tables, most).encode()),
        Artefact(f"{folder}names.rs", names(model).encode()),
        Artefact(f"{folder}tables.rs", _tables(model, tables, name, most).encode()),
    )


def package(name: str) -> str:
    """Return the name of the package of a spec: its name in lower case, or `spec_NAME` if cargo refuses that."""
    clean = re.sub(r"\W", "_", name, flags=re.ASCII).lower()
    return clean if clean[:1].isalpha() and clean not in RESERVED else f"spec_{clean.lstrip('_')}"


def _manifest(model: Model, name: str) -> str:
    return f"""{MARKS[MANIFEST]}{model.name}: `no_std`, no dependencies.
[package]
name = "{package(name)}"
version = "0.0.0"
edition = "2021"
rust-version = "{RUST_VERSION}"
publish = false

[features]
# What things are called, and why: texts that a small target does without.
names = []
# A record of the last events and answers, in memory that the host lends.
black-box = []

[profile.release]
panic = "abort"
"""


def _tables(model: Model, tables: Tables, name: str, most: EventBounds) -> str:
    figures, width, state = sizes(tables, most), 8 * word_bytes(tables), 8 * state_bytes(tables)
    lines = [
        f"//! The tables of the spec {model.name}; their bytes are those of `{name}.bin`.",
        "",
        "use crate::records::*;",
        "",
        f"pub type Word = i{width};",
        f"pub type Int = i{state};",
        f"pub type Uint = u{state};",
        "",
        *(f"pub const {title}: usize = {count};" for title, count in _counts(tables)),
        f"pub const CHECKSUM: u32 = 0x{head(tables)[3]:08x};",
        "",
        "/// Tests that no event exceeds.",
        f"pub const TESTS: u64 = {figures.tests};",
        "/// Answers that no event exceeds.",
        f"pub const ACTIONS: usize = {figures.actions};",
        "/// Passes of settling that no event exceeds.",
        f"pub const PASSES: usize = {figures.passes};",
        "/// Bytes of the tables, as they are laid out here.",
        "pub const TABLE_BYTES: usize = core::mem::size_of::<Tables>();",
        "/// Bytes of the record of a state.",
        f"pub const RECORD_BYTES: usize = {record_bytes(tables)};",
        "/// Steps that find any bit that changed.",
        f"pub const SCRUB_STEPS: usize = {scrub_steps(tables)};",
        "",
        "/// The tables.",
        "pub static TABLES: Tables = Tables {",
        *_body(tables),
        "};",
    ]
    return "\n".join(lines) + "\n"


def _counts(tables: Tables) -> Iterator[tuple[str, int]]:
    """Yield the names and values of the constants for the lengths of arrays: of the tables, and of the state."""
    *_, kept, values, _, answers, path = shape(tables)
    given = (max(r.results - r.params, r.params_end - r.results) for r in tables.requests)
    yield from zip(map(str.upper, FIELDS), counts(tables), strict=True)
    yield "REALS", len(tables.reals)
    yield "CHECKS", len(checks(tables))
    yield "SLOTS", slot_count(tables)
    yield "KEPT", kept
    yield "VALUES", values
    yield "GIVEN", max(given, default=0)
    yield "CAPACITY", answers
    yield "PATH", path


def _body(tables: Tables) -> Iterator[str]:
    numbers = head(tables)
    words = [f"0x{number:08x}" for number in numbers[:13]]
    yield "    head: ["
    yield f"        {', '.join(words[:5])}, // magic, version and width, flags, CRC-32, doubles"
    yield f"        {', '.join(words[5:])}, // sha256 of the spec"
    yield f"        {', '.join(map(str, numbers[13:]))}, // numbers of records, and of check words"
    yield "    ],"
    yield "    reals: ["
    for value in tables.reals:
        yield f"        0x{bits(value):016x}, // {value!r}"
    yield "    ],"
    for title, records, kind in zip(FIELDS, rows(tables), RECORDS, strict=True):
        yield f"    {title}: ["
        yield from (f"        {kind}([{', '.join(map(str, record))}])," for record in records)
        yield "    ],"
    yield f"    checks: [{', '.join(map(str, checks(tables)))}],"
