"""The bytes of the tables that a C source holds: what a compiler makes of it, written out."""

import re
import tempfile
from pathlib import Path

from exover.gateway.native import FLAGS, NativeUnavailable, compile_in, find_compiler
from exover.verify.process import NotRunnable, run

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


def embedded(path: Path) -> bytes:
    """Return the bytes of the tables in an emitted C source, whose headers lie beside it.

    Raises `NativeUnavailable` if there is no compiler, or if it does not take the source.
    """
    named = TABLES.search(path.read_text(encoding="utf-8", errors="replace"))
    if named is None:
        raise NativeUnavailable(f"{path} defines no tables")
    with tempfile.TemporaryDirectory(prefix="exover-") as folder:
        (Path(folder) / "dump.c").write_text(DUMP.format(name=named[1]), encoding="ascii")
        where = path.resolve()
        command = [*find_compiler(), *FLAGS, "-I", str(where.parent), "dump.c", str(where), "-o", "dump"]
        compile_in(Path(folder), command)
        try:
            written = run([str(Path(folder) / "dump")], Path(folder))
        except NotRunnable as reason:
            raise NativeUnavailable(f"the program that writes the tables out does not run: {reason}") from reason
        return bytes.fromhex(written.printed)
