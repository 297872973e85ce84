"""A million random decisions of the emitted C are those of the rules, read a second time in C; `make soak`: 10^9.

Where more than mutexes decides, random walks of tests/agreement hold reference, tables and C against each other.
"""

import os
import struct
import subprocess
from pathlib import Path

from benchmarks.families import mutexes
from exover.emit import c
from exover.ocrd.reasons import reasons
from exover.pipeline import build
from tests.runtime.compiling import COMPILERS, WARNINGS, compile_c, model_of

DECISIONS = int(os.environ.get("EXOVER_DECISIONS", "1000000"))


def test_random_decisions(tmp_path: Path) -> None:
    model = model_of(mutexes(50))
    for artefact in c.emit(model, build(model).tables, "decisions"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    sources = [Path(__file__).parent / "decisions.c", tmp_path / "decisions_tables.c", tmp_path / "exover.c"]
    compile_c(COMPILERS[0], [*WARNINGS, "-O2", f"-I{tmp_path}"], sources, tmp_path / "decisions")
    request = {name.name: number for number, name in enumerate(model.requests)}
    reason = {known.rule: number for number, known in enumerate(reasons(model))}
    numbers = [len(model.requests), len(model.rules)]
    for rule in model.rules:
        first, second = (request[part.request] for part in rule.condition.parts)  # type: ignore[union-attr]
        numbers += [first, second, reason[rule.name]]
    command = [tmp_path / "decisions", str(DECISIONS)]
    done = subprocess.run(command, input=struct.pack(f"={len(numbers)}I", *numbers), capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode()
    launched, rejected, reported = map(int, done.stdout.split())
    assert launched + rejected == DECISIONS
    assert min(launched, rejected, reported) > DECISIONS // 10
