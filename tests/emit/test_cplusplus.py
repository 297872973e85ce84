"""A host in C++17 includes every header that is emitted without a warning, and links with what C compilers made."""

import subprocess
from pathlib import Path
from shutil import which

import pytest

from exover.emit import c
from exover.emit.identifiers import RESERVED
from exover.pipeline import Build, build
from tests.emit.odd import ODD
from tests.runtime.compiling import ROOT, WARNINGS, built, compile_c, model_of

PAIRS = (("gcc", "g++"), ("clang", "clang++"))
STRICT = ("-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
KEYWORDS = ("class", "consteval", "delete", "new", "operator", "template", "this", "char16_t", "co_await", "namespace")
HOST = """
#include "rover_api.h"
#include "rover_names.h"
#include <cstdio>

static rover_checker r2c;

static void show(const rover_answer &answer)
{
    for (std::size_t i = 0; i < answer.count; i++) {
        const exover_action &action = answer.actions[i];
        const char *verb = action.kind == EXOVER_LAUNCH ? "launch" : action.kind == EXOVER_KILL ? "kill" : "reject";
        std::printf("%s %s\\n", verb, rover_request_names[action.request]);
    }
}

int main()
{
    rover_answer answer{};
    if (rover_start(&r2c) != EXOVER_READY)
        return 1;
    rover_ask_pom_localize(&r2c, &answer);
    show(answer);
    rover_report_pom_localize_ok(&r2c, &answer);
    rover_ask_nd_goto(&r2c, 3, 4, 0.5, &answer);
    show(answer);
    rover_event caught[2] = {};
    caught[0].kind = ROVER_EVENT_OBSERVE_BATTERY;
    caught[0].of.observe_battery = 12;
    caught[1].kind = ROVER_EVENT_ASK_ARM_MOVE;
    caught[1].of.ask_arm_move.where = ROVER_ZONE_DOCK;
    exover_action said[3 * ROVER_ROOM];
    std::size_t count = 0;
    if (rover_cycle(&r2c, caught, 2, said, 3 * ROVER_ROOM, &count) != 2)
        return 2;
    const rover_answer all = {said, count};
    show(all);
    return exover_arity(&r2c.generic, ROVER_ND_GOTO) == ROVER_TABLE_BYTES;
}
"""


def pairs() -> list[object]:
    """Return a C and a C++ compiler of one maker each; those that are not there are skipped aloud."""
    missing = [[name for name in pair if which(name) is None] for pair in PAIRS]
    return [
        pytest.param(*pair, marks=pytest.mark.skipif(bool(gone), reason=f"no {', '.join(gone)}"), id=pair[1])
        for pair, gone in zip(PAIRS, missing, strict=True)
    ]


def linked(found: Build, host: str, compiler: str, cplusplus: str, folder: Path) -> str:
    """Return what a C++ program prints that is linked with everything that is emitted, compiled as C."""
    for artefact in c.emit(found.model, found.tables, found.model.name):
        (folder / artefact.name).write_bytes(artefact.content)
    (folder / "host.cpp").write_text(host, encoding="utf-8")
    objects = []
    for source in sorted(folder.glob("*.c")):
        objects.append(source.with_suffix(".o"))
        compile_c(compiler, [*WARNINGS, "-c"], [source], objects[-1])
    compile_c(cplusplus, STRICT, [folder / "host.cpp", *objects], folder / "host")
    return subprocess.run([folder / "host"], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize(("compiler", "cplusplus"), pairs())
def test_a_host_in_cplusplus_links_and_runs(compiler: str, cplusplus: str, tmp_path: Path) -> None:
    printed = linked(built(ROOT / "specs" / "rover.exo"), HOST, compiler, cplusplus, tmp_path)
    assert printed.splitlines() == ["launch pom.localize", "launch nd.goto", "kill nd.goto", "reject arm.move"]


@pytest.mark.parametrize(("compiler", "cplusplus"), pairs())
def test_odd_names_are_read_by_cplusplus(compiler: str, cplusplus: str, tmp_path: Path) -> None:
    keywords = ", ".join(f"{word}: bool" for word in KEYWORDS)
    found = build(model_of(f"{ODD} module words {{ request say({keywords}); }}"))
    host = (
        '#include "_x_api.h"\n#include "_x_names.h"\nint main() { static spec_x_checker r; return spec_x_start(&r); }'
    )
    assert linked(found, host, compiler, cplusplus, tmp_path) == ""
    assert set(KEYWORDS) <= RESERVED


@pytest.mark.parametrize("name", ["rover_tables.h", "rover_api.h", "rover_names.h", "exover.h"])
def test_every_header_that_declares_something_has_c_linkage(name: str) -> None:
    found = built(ROOT / "specs" / "rover.exo")
    (text,) = [a.content.decode() for a in c.emit(found.model, found.tables, "rover") if a.name == name]
    before, opening, after = text.partition('extern "C" {')
    assert opening and "#include" not in after and ";" not in before.split("*/")[-1]
