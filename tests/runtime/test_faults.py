"""After a fault everything is denied, but what runs can still be reported and aborted, and no kill is lost.

Tables that contradict themselves are made here by hand, and so is damage to what a running checker knows.
"""

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from exover.emit import c
from exover.ocrd import tables as t
from exover.ocrd.tables import Node, Tables
from exover.pipeline import build as build_tables
from exover.run.codec import ABORTED, FAULTY, INVALID, KILL, LAUNCH, REJECT, VIOLATION
from tests.runtime.compiling import (
    COMPILERS,
    FAULT_ACTIONS,
    FAULT_CHANNELS,
    FAULT_CHECKER,
    FAULT_DECISION,
    FAULT_INDEX,
    FAULT_PASSES,
    FAULT_PATH,
    FAULT_STATE,
    FAULT_TABLES,
    NOT_LOADED,
    READY,
    SANITIZERS,
    WARNINGS,
    compile_c,
    model_of,
    runner,
    talk,
)
from tests.runtime.contradictory import MODEL, TABLES, all_actions, edited

DENIED = f"{REJECT} %d -1 {FAULTY} -1;"


def answers(tables: Tables, folder: Path, lines: str) -> list[str]:
    return talk(runner(MODEL, tables, folder), lines)


@pytest.mark.parametrize(
    "broken",
    [
        pytest.param(all_actions(t.LAUNCH, Node(-t.AGREE, 0, -1, 0)), id="an action that is no decision"),
        pytest.param(
            edited({r.decide: Node(TABLES.nodes[r.decide].code, 0, -1, -1) for r in TABLES.requests}),
            id="a decision that decides nothing",
        ),
    ],
)
def test_a_fault_denies_from_then_on(broken: Tables, tmp_path: Path) -> None:
    assert answers(broken, tmp_path, "a 0 0 a 1 0 o 0 0 k 0 0 f") == [
        DENIED % 0,
        DENIED % 1,
        DENIED % -1,
        f"{KILL} 0 0 {ABORTED} -1;",
    ]


CAUSES = """spec causes; module m { request a(); request b(); request c(); request d(); }
poster p: bool = false;
mutex m.c over m.a, m.b;
mutex still: m.a, m.d;"""
STATUS = {
    "path": FAULT_PATH,
    "turning back": FAULT_PATH,
    "going on before": FAULT_PATH,
    "actions": FAULT_ACTIONS,
    "passes": FAULT_PASSES,
    "decision": FAULT_DECISION,
    "no slot": FAULT_DECISION,
    "only rows": FAULT_CHANNELS,
    "only diagrams": FAULT_CHANNELS,
    "not counted": FAULT_CHANNELS,
    "index": FAULT_INDEX,
    "state": FAULT_STATE,
    "active": FAULT_STATE,
    "agenda": FAULT_STATE,
    "tables": FAULT_TABLES,
    "checker": FAULT_CHECKER,
    "not loaded": NOT_LOADED,
}


@pytest.fixture(scope="module")
def causes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("causes")
    model = model_of(CAUSES)
    for artefact in c.emit(model, build_tables(model).tables, "causes"):
        (folder / artefact.name).write_bytes(artefact.content)
    flags = [*WARNINGS, *SANITIZERS, "-DEXOVER_WIDTH=2", f"-I{folder}"]
    sources = [Path(__file__).parent / "causes.c", folder / "causes_tables.c"]
    compile_c(COMPILERS[0], flags, sources, folder / "causes")
    return folder / "causes"


@pytest.mark.parametrize("cause", STATUS)
def test_every_cause_has_its_code_and_denies(cause: str, causes: Path) -> None:
    """The launch that the fault is met by is denied, and what follows; aborts and reports are taken; a load heals."""
    done = subprocess.run([causes, cause], capture_output=True, text=True, check=True)
    before, *met, status, asked, observed, aborted, reported, still, loaded, again = done.stdout.splitlines()
    assert before == f"{LAUNCH} 0 0 -1 -1;"
    assert met[-1].split(";")[-2].startswith(f"{REJECT} ") and met[-1].endswith(f" -1 {FAULTY} -1;")
    assert not any(line.startswith(f"{LAUNCH} ") for line in met)
    assert int(status) == int(still) == STATUS[cause]
    assert asked == DENIED % 1 and observed == DENIED % -1
    assert aborted == f"{KILL} 0 0 {ABORTED} -1;" and reported == DENIED % 0
    assert (int(loaded), again) == (READY, f"{LAUNCH} 1 0 -1 -1;")


MISCOUNTED = r"""
#include "causes_tables.h"
#include <stdio.h>
static uint64_t memory[CAUSES_MEMORY_BYTES / 8 + 1];
static const uint32_t shape[] = {EXOVER_SHAPE};
static exover checker;
static void count_as(exover_uint bits)
{
    checker.cells[shape[EXOVER_ACTIVE]].now = bits;
    checker.cells[shape[EXOVER_ACTIVE]].inverse = ~bits;
}
int main(int argc, char **argv)
{
    (void)argv;
    exover_load(&checker, &causes_tables, memory, CAUSES_MEMORY_BYTES);
    if (argc > 1) {
        count_as(2); /* 1 is idle, and nothing that it excludes is active */
        exover_ask(&checker, 1, NULL, 0);
    } else {
        exover_ask(&checker, 0, NULL, 0);
        count_as(0); /* 0 is active */
        exover_report(&checker, 0, 0, EXOVER_OK, -1, NULL, 0);
    }
    printf("%d %d %d", (int)exover_fault(&checker), (int)checker.actions[0].kind, (int)checker.actions[0].reason);
    return 0;
}
"""


@pytest.fixture(scope="module")
def miscounted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("miscounted")
    model = model_of("spec causes; module m { request a(); request b(); } mutex m.a, m.b;")
    for artefact in c.emit(model, build_tables(model).tables, "causes"):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "main.c").write_text(MISCOUNTED)
    sources = [folder / name for name in ("main.c", "causes_tables.c", "exover.c")]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS], sources, folder / "main")
    return folder / "main"


@pytest.mark.parametrize("arguments", [(), ("idle",)], ids=["active", "idle"])
def test_a_single_slot_that_is_counted_wrong_is_a_fault(arguments: tuple[str, ...], miscounted: Path) -> None:
    """Where every request has one slot the bits of the second channel are its counts."""
    done = subprocess.run([miscounted, *arguments], capture_output=True, text=True, check=True)
    assert done.stdout == f"{FAULT_CHANNELS} {REJECT} {FAULTY}"


def test_what_runs_can_be_aborted_and_reported(tmp_path: Path) -> None:
    """The second launch finds no idle slot: its decision launches whatever the test of the slot says."""
    root = TABLES.requests[0].decide
    launch = next(number for number, node in enumerate(TABLES.nodes) if node.code == -t.LAUNCH)
    broken = edited({root: Node(TABLES.nodes[root].code, 0, launch, launch)})
    got = answers(broken, tmp_path, "a 0 0 a 0 0 a 1 0 k 0 0 r 0 0 1 -1 0 r 0 0 1 -1 0 f")
    assert got == [
        f"{LAUNCH} 0 0 -1 -1;",
        DENIED % 0,
        DENIED % 1,
        f"{KILL} 0 0 -3 -1;",
        DENIED % 0,
        f"{INVALID} -1 -1 8 -1;",
    ]


FLIPPED = r"""
#include "flipped_tables.h"
#include <stdio.h>
static uint64_t memory[FLIPPED_MEMORY_BYTES / 8 + 1];
static exover checker;
int main(void)
{
    exover_load(&checker, &flipped_tables, memory, FLIPPED_MEMORY_BYTES);
    checker.values[1].bits ^= UINT64_C(1) << 62; /* top is 1, and becomes infinite */
    exover_observe(&checker, FLIPPED_POSTER_LOW, (exover_value){.real = 1.5});
    exover_ask(&checker, FLIPPED_M_A, NULL, 0);
    printf("%d %d %d", (int)exover_fault(&checker), (int)checker.actions[0].kind, (int)checker.actions[0].reason);
    return 0;
}
"""


def test_a_poster_that_has_changed_is_a_fault_where_no_request_has_parameters(tmp_path: Path) -> None:
    """Of two posters that are compared with each other, one changes, and the other is read."""
    model = model_of(
        "spec flipped; poster top: real in 0 .. 2 = 1; poster low: real in 0 .. 2 = 0; "
        "module m { request a() { check low <= top; } }"
    )
    for artefact in c.emit_tables(model, build_tables(model).tables, "flipped"):
        (tmp_path / artefact.name).write_bytes(artefact.content)
    (tmp_path / "main.c").write_text(FLIPPED)
    sources = [tmp_path / name for name in ("main.c", "flipped_tables.c", "exover.c")]
    compile_c(COMPILERS[0], [*WARNINGS, *SANITIZERS], sources, tmp_path / "main")
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    assert done.stdout == f"{FAULT_STATE} {REJECT} {FAULTY}"


def test_copies_of_a_rule_that_stay_broken_are_told_once(tmp_path: Path) -> None:
    """Two rules that nothing restores, with the reasons that they have and with one for both."""
    model = model_of("spec s; poster p: bool = false; module m { request a(); } forbid x: p; forbid y: p;")
    tables = build_tables(model, unchecked=True).tables
    copies = replace(tables, rules=tuple(replace(rule, reason=tables.rules[0].reason) for rule in tables.rules))
    (tmp_path / "copies").mkdir()
    told = [
        talk(runner(model, known, folder), "o 0 1 f")[0].count(f"{VIOLATION} ")
        for known, folder in ((tables, tmp_path), (copies, tmp_path / "copies"))
    ]
    assert told == [2, 1]


def test_a_fault_loses_no_kill(tmp_path: Path) -> None:
    """The way of m.c is cleared, then a second kill of its path is made to be no action."""
    kills = [number for number, node in enumerate(TABLES.nodes) if node.code == -t.KILL]
    last = max(kills, key=lambda number: TABLES.nodes[number].low == t.NONE)
    broken = edited({last: Node(-t.AGREE, 0, -1, 0)})
    lines = "a 0 0 a 1 0 a 2 0 f"
    got = answers(broken, tmp_path, lines)
    assert got[:2] == [f"{LAUNCH} 0 0 -1 -1;", f"{LAUNCH} 1 0 -1 -1;"]
    assert got[2].startswith(f"{KILL} ") and got[2].endswith(DENIED % 2)
    assert str(LAUNCH) + " 2" not in got[2]
