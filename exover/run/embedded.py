"""Extracts the tables from an emitted C or Rust source: compiles it with a program that prints their bytes."""

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

from exover.emit.rust import RECORDS
from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler
from exover.engines.process import NotRunnable, run
from exover.ocrd.packing import FIELDS, START
from exover.run import rust
from exover.run.native import FLAGS

TABLES = re.compile(r"^const exover_tables (\w+) =", re.MULTILINE)
DUMP = """#include "exover.h"
#include <stdio.h>

extern const exover_tables {name};

static void put(uint64_t number, int bytes)
{{
    for (; bytes > 0; bytes--, number >>= 8)
        printf("%02x", (unsigned)(number & 255));
}}

int main(void)
{{
    for (size_t i = 0; i < EXOVER_HEAD_WORDS; i++)
        put({name}.head[i], 4);
    for (size_t i = 0; i < {name}.real_count; i++)
        put({name}.reals[i].bits, 8);
    for (size_t i = 0; i < {name}.word_count; i++)
        put((uint64_t){name}.words[i], EXOVER_WIDTH);
    return 0;
}}
"""


WRITER = """mod records;
mod tables;

fn put(number: i64, bytes: usize) {
    for byte in number.to_le_bytes().iter().take(bytes) {
        print!("{byte:02x}");
    }
}

fn main() {
    let tables = &tables::TABLES;
    tables.head.iter().for_each(|&number| put(i64::from(number), 4));
    tables.reals.iter().for_each(|&bits| put(bits as i64, 8));
    tables.words(|word| put(i64::from(word), std::mem::size_of::<tables::Word>()));
}
"""


def embedded(path: Path) -> bytes:
    """Return the bytes of the tables in an emitted source: C with its headers beside it, or Rust.

    Raises `NativeUnavailable` if there is no compiler, it rejects the source, or the program does not run.
    """
    with tempfile.TemporaryDirectory(prefix="exover-") as folder:
        (_compile_rust if path.suffix == ".rs" else _compile_c)(path.resolve(), Path(folder))
        try:
            written = run([str(Path(folder) / "dump")], Path(folder))
        except NotRunnable as reason:
            raise NativeUnavailable(f"the program that writes the tables out does not run: {reason}") from reason
        return bytes.fromhex(written.printed)


def _compile_c(source: Path, folder: Path) -> None:
    named = TABLES.search(source.read_text(encoding="utf-8", errors="replace"))
    if named is None:
        raise NativeUnavailable(f"{source.name} defines no tables")
    (folder / "dump.c").write_text(DUMP.format(name=named[1]), encoding="ascii")
    compile_in(
        folder, [*find_compiler(), *FLAGS, "-I", str(source.parent), "dump.c", str(source), "-o", "dump"], "dump"
    )


def _compile_rust(source: Path, folder: Path) -> None:
    """Compile the program with its own module `records`, so that the records are those of the packed tables."""
    (folder / "tables.rs").write_bytes(source.read_bytes())
    (folder / "records.rs").write_text("\n".join(_records()), encoding="ascii")
    (folder / "dump.rs").write_text(WRITER, encoding="ascii")
    compile_in(folder, [*rust.find_rustc(), rust.EDITION, *rust.FLAGS, "-Awarnings", "dump.rs"], "dump", "Rust")


def _records() -> Iterator[str]:
    """Yield the lines of the module `records`: the types that `tables.rs` uses, and a visitor of its words in order."""
    named = list(zip(FIELDS, RECORDS, strict=True))
    yield "use crate::tables::*;"
    yield from (f"pub struct {kind}(pub [Word; {len(FIELDS[title])}]);" for title, kind in named)
    yield "pub struct Tables {"
    yield f"    pub head: [u32; {START // 4}],"
    yield "    pub reals: [u64; REALS],"
    yield from (f"    pub {title}: [{kind}; {title.upper()}]," for title, kind in named)
    yield "    pub checks: [Word; CHECKS],"
    yield "}"
    yield "impl Tables {"
    yield "    pub fn words(&self, mut visit: impl FnMut(Word)) {"
    yield from (f"        self.{title}.iter().flat_map(|record| record.0).for_each(&mut visit);" for title in FIELDS)
    yield "        self.checks.iter().copied().for_each(visit);"
    yield "    }"
    yield "}"
