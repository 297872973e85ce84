"""Hosts around a checker of a spec, whose records go out and come back."""

import re
import subprocess
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from shutil import which

import pytest

from exover.bounds.sizes import word_bytes
from exover.emit import c
from exover.engines.compiler import compile_in
from exover.pipeline import Build
from exover.run import rust
from exover.run.native import NativeEngine
from tests.runtime.compiling import COMPILERS, RUNTIME, SANITIZERS, WARNINGS, compile_c
from tests.support.events import Stream

HERE = Path(__file__).parent
FAST = ("-Copt-level=3", *rust.FLAGS[1:], "-Cpanic=abort")
FAST_CRATE = (*FAST, "-Coverflow-checks=on", "--emit=link,obj")
"""How optimized crates are compiled, which also leave an object to look at, so that each is compiled once."""
needs_rustc = pytest.mark.skipif(which("rustc") is None, reason="rustc is not installed")


@dataclass(frozen=True)
class Host:
    """A program around a checker of a spec, with records as files beside it."""

    found: Build
    folder: Path

    def run(self, *arguments: str, lines: str = "") -> list[str]:
        command = [self.folder / "resume", *arguments]
        done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    def record(self, events: int = 0, lines: str = "") -> bytes:
        """Return the record after so many events."""
        return bytes.fromhex(self.run("show", str(events), lines=lines)[0])

    def outcome(self, *records: bytes) -> list[tuple[int, bool]]:
        """Return for each record the status of resuming it, and whether everything is denied then."""
        for number, record in enumerate(records):
            (self.folder / f"{number}.record").write_bytes(record)
        names = [str(self.folder / f"{number}.record") for number in range(len(records))]
        return [(int(status), denied == "1") for status, denied in map(str.split, self.run("try", *names))]


def host_of(found: Build, folder: Path, fixed: bool = True) -> Host:
    """Return a host whose runtime takes only the tables of the spec, as it is emitted, or all of their width.

    Of the latter there is one for many specs, so it is compiled once.
    """
    for artefact in c.emit_tables(found.model, found.tables, "native"):
        (folder / artefact.name).write_bytes(artefact.content)
    runner = (RUNTIME / "runner.c").read_text().replace("int main(", "int runner_main(int, char **);\nint runner_main(")
    (folder / "resume.c").write_text(runner + (HERE / "resume.c").read_text())
    sources = [folder / name for name in ("resume.c", "native_tables.c", "exover.c")]
    told = [] if fixed else [f"-DEXOVER_WIDTH={word_bytes(found.tables)}"]
    flags = [*WARNINGS, "-Wno-conversion", *SANITIZERS, *told, f"-I{folder}"]
    compile_c(COMPILERS[0], flags, sources, folder / "resume")
    return Host(found, folder)


def lines_of(found: Build, count: int, seed: int = 3) -> str:
    """Return random events in the words of the runner."""
    engine = NativeEngine(found.model, found.tables)
    events = islice(Stream(found.model, seed).events(4 * count), count)
    return "\n".join([*(engine.line(event) for event, _ in events), ""])


def rust_host_of(found: Build, folder: Path) -> Host:
    rust.build_crate(found.model, found.tables, "native", folder)
    runner = re.sub(r"^//!.*\n|^#!\[.*\n", "", (RUNTIME / "runner.rs").read_text(), flags=re.MULTILINE)
    source = runner.replace("fn main()", "fn runner_main()") + (HERE / "resume.rs").read_text()
    (folder / "resume.rs").write_text(f"#![allow(dead_code, unreachable_code)]\n{source}")
    flags = [rust.EDITION, *rust.FLAGS, "--extern=native=libnative.rlib"]
    compile_in(folder, [*rust.find_rustc(), *flags, "resume.rs"], "resume", "Rust")
    return Host(found, folder)
