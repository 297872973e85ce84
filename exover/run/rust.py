"""An engine that runs the emitted Rust: compiles the crate and `runner.rs` with rustc, and talks to it as to the C."""

from collections.abc import Sequence
from pathlib import Path
from shutil import which

from exover.emit.artefact import runtime_file
from exover.emit.rust import emit_sources
from exover.engines.compiler import NativeUnavailable, command_in, compile_in
from exover.model.model import Model
from exover.ocrd.tables import Tables
from exover.run.native import NativeEngine

FLAGS = ("-Copt-level=0", "-Ccodegen-units=1", "-Cembed-bitcode=no")
"""Without optimization, since compiling takes longer than running a few thousand events; overflow panics so, too."""
EDITION = "--edition=2021"


def find_rustc() -> list[str]:
    """Return the command of the Rust compiler: `$RUSTC`, else rustc; raises `NativeUnavailable`."""
    command = command_in("RUSTC") or ["rustc"]
    if which(command[0]) is None:
        raise NativeUnavailable(f"no Rust compiler is there: install {command[0]}, or name one in $RUSTC")
    return command


def build(model: Model, tables: Tables, folder: Path, flags: Sequence[str] = FLAGS) -> Path:
    """Return the path of the checker's program, compiled in `folder`; raises `NativeUnavailable`."""
    rustc = find_rustc()
    build_crate(model, tables, "native", folder, flags)
    (folder / "runner.rs").write_bytes(runtime_file("runner.rs"))
    compile_in(folder, [*rustc, EDITION, *flags, "--extern=native=libnative.rlib", "runner.rs"], "runner", "Rust")
    return folder / "runner"


def build_crate(model: Model, tables: Tables, name: str, folder: Path, flags: Sequence[str] = FLAGS) -> None:
    """Compile the crate to `libNAME.rlib` in `folder`; raises `NativeUnavailable`."""
    for artefact in emit_sources(model, tables, name):
        (folder / artefact.name).write_bytes(artefact.content)
    known = ['--check-cfg=cfg(feature, values("names", "black-box"))', "--crate-type=rlib", f"--crate-name={name}"]
    compile_in(folder, [*find_rustc(), EDITION, *flags, *known, "lib.rs"], None, "Rust")  # flags say what it makes


def engine_of(model: Model, tables: Tables) -> NativeEngine:
    """Return the emitted Rust of a model as an engine."""
    return NativeEngine(model, tables, FLAGS, build)
