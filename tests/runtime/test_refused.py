"""Tables with one fault and all checksums right: each is refused for its own reason, or harmless.

Also by runtimes that are compiled for fewer sections, and of numbers that only wide words hold.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from exover.bounds.sizes import uses
from exover.ocrd import packing
from exover.ocrd import tables as t
from exover.ocrd.packing import pack
from exover.ocrd.tables import Node, Tables
from exover.pipeline import build
from tests.runtime.compiling import (
    BAD_CHECKSUM,
    BAD_INDEX,
    BAD_LIMITS,
    BAD_NODE,
    COMPILERS,
    FAULT_DECISION,
    OTHER_USES,
    READY,
    RUNTIME,
    SANITIZERS,
    WARNINGS,
    Harness,
    compile_c,
    model_of,
    sealed,
)

RICH = """spec rich;
poster top: real in 0 .. 2 = 1 else 0;
poster low: real in 0 .. 2 = 0.5 else 2;
poster n: int in 0 .. 3 = 0;
latch l: when n == 2 until m.b;
module m {
    state s: int in 0 .. 1 = 0;
    request a(v: real in 0 .. 2, w: real in 0 .. 2, i: int in 0 .. 3, k: int in 0 .. 3) instances 2 {
        fail fast: when v > top;
        check v <= w;
        check low <= top;
        check s == 0;
        on ok set s = 1;
    }
    request b(v: real in 0 .. 2) { wait until not active(m.a); check not l; }
}
launch go: m.b(0.5) when n == 3;"""


@cache
def rich() -> Tables:
    """Return the tables of `RICH`; by number, variables are top, low, n, m.s, l, and requests m.a, m.b."""
    return build(model_of(RICH), unchecked=True).tables


def edited(section: str, record: int, **numbers: int) -> Tables:
    """Return the tables of `RICH` with other numbers in one record."""
    rows = list(getattr(rich(), section))
    rows[record] = replace(rows[record], **numbers)
    return replace(rich(), **{section: tuple(rows)})


def with_word(index: int, value: int) -> Tables:
    """Return the tables of `RICH` with another word in its lists."""
    lists = list(rich().lists)
    lists[index] = value
    return replace(rich(), lists=tuple(lists))


def first(section: str, **numbers: int) -> int:
    """Return the first record of a section with these numbers."""
    rows = getattr(rich(), section)
    return next(k for k, row in enumerate(rows) if all(getattr(row, name) == n for name, n in numbers.items()))


def raw_swapped() -> Tables:
    """Return the tables of `RICH` with the values of its real posters kept in the other order."""
    top, low, *rest = rich().variables
    return replace(rich(), variables=(replace(top, raw=low.raw), replace(low, raw=top.raw), *rest))


REFUSED: dict[str, tuple[Callable[[], Tables], int]] = {
    "as they are": (rich, READY),
    "values of posters in another order": (raw_swapped, READY),
    "a reason that there is not": (lambda: edited("nodes", first("nodes", code=-t.REJECT), bound=1000), BAD_NODE),
    "a comparison with no parameter": (lambda: edited("orders", 0, left=4), BAD_INDEX),
    "a comparison with no poster": (lambda: edited("orders", 0, left=-100), BAD_INDEX),
    "a comparison with a poster that is not kept": (lambda: edited("orders", 0, right=-3), BAD_INDEX),
    "a comparison of posters with a parameter": (
        lambda: edited("orders", rich().variables[0].orders, left=0),
        BAD_INDEX,
    ),
    "a value that is kept of no real": (lambda: edited("variables", 2, raw=0), BAD_INDEX),
    "a state that is a real": (lambda: edited("variables", 3, type=t.REAL, low=0, high=0, initial=0), BAD_INDEX),
    "a poster whose features are those of no request": (
        lambda: with_word(rich().variables[0].refresh, 2),
        BAD_INDEX,
    ),
    "a latch that is a poster": (lambda: edited("latches", 0, variable=0), BAD_INDEX),
    "an effect on a poster": (lambda: edited("effects", 0, target=2), BAD_INDEX),
    "an effect that forgets": (lambda: edited("effects", 0, kind=t.FORGET, target=1), READY),
    "arguments behind the lists": (lambda: edited("launches", 0, args=len(rich().lists)), BAD_INDEX),
    "an argument that is no double": (lambda: with_word(rich().launches[0].args, 100), BAD_INDEX),
    "no limits": (lambda: replace(rich(), limits=()), BAD_LIMITS),
    "two limits": (lambda: replace(rich(), limits=2 * rich().limits), BAD_LIMITS),
    "more actions than nodes": (lambda: edited("limits", 0, actions=len(rich().nodes) + 1), BAD_LIMITS),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_one_fault_is_refused_for_its_own_reason(fault: str, harness: Harness) -> None:
    make, status = REFUSED[fault]
    (outcome,) = harness.run([pack(make())], events=50)
    assert (outcome.status, outcome.fault) == (status, status)


def test_check_words_that_are_wrong_are_refused(harness: Harness) -> None:
    """Of a record, and of a double; the checksum of all bytes is right."""
    data = pack(rich())
    records = len(packing.checks(rich())) - len(rich().reals)
    damaged = []
    for check in (0, records):
        at = len(data) - 2 * len(packing.checks(rich())) + 2 * check
        damaged.append(sealed(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]))
    assert [outcome.status for outcome in harness.run(damaged)] == [BAD_CHECKSUM, BAD_CHECKSUM]


# ---- runtimes that take less ----


def compiled(folder: Path, *flags: str, sanitized: bool = True) -> Harness:
    program = folder / "harness"
    sources = [Path(__file__).parent / "harness.c", RUNTIME / "exover.c"]
    checks = SANITIZERS if sanitized else ("-O0",)
    compile_c(COMPILERS[0], [*WARNINGS, *checks, *flags, f"-I{RUNTIME}"], sources, program)
    return Harness(program)


MUTEXES = "spec plain; module m { request a(); request b(); request c(); } mutex m.a, m.b, m.c;"
WAITING = "spec waits; module m { request a(); request b(); } mutex m.a, m.b by wait;"
KILLING = "spec kills; poster p: bool = false; module m { request a(); } forbid x: p and active(m.a) by kill m.a;"
LAST = "spec last; module m { request a(); request b() { check last(m.a) != failed; } } mutex m.a, m.b;"
CHECKS, WAITS, KILLS, LASTS = 1 << 21, 1 << 22, 1 << 23, 1 << 24


@pytest.mark.parametrize("text", [MUTEXES, WAITING, KILLING, LAST, RICH], ids=lambda text: text.split(";")[0][5:])
def test_a_runtime_without_what_tables_do_not_use_answers_alike(text: str, harness: Harness, tmp_path: Path) -> None:
    """Hosts of `test_resume`, `test_calls` and `test_swap` have such runtimes with sanitizers."""
    tables = build(model_of(text), unchecked=True).tables
    small = compiled(tmp_path, "-DEXOVER_WIDTH=2", f"-DEXOVER_USES={uses(tables)}", sanitized=False)
    assert small.run([pack(tables)], events=500) == harness.run([pack(tables)], events=500)


LESS: dict[str, tuple[int, dict[str, int]]] = {
    "variables": (1 << 9, {MUTEXES: READY, RICH: OTHER_USES}),
    "check words": (CHECKS, {MUTEXES: READY, LAST: OTHER_USES}),
    "waiting": (WAITS, {MUTEXES: READY, KILLING: READY, WAITING: BAD_NODE}),
    "kills": (KILLS, {MUTEXES: READY, WAITING: READY, KILLING: BAD_NODE}),
    "last outcomes": (LASTS, {MUTEXES: READY, LAST: BAD_INDEX}),
}


@pytest.mark.parametrize("what", LESS)
def test_a_runtime_that_is_compiled_without_refuses_what_needs_it(what: str, tmp_path: Path) -> None:
    bit, wanted = LESS[what]
    refused_by_head = OTHER_USES in wanted.values()  # what is read behind it is what the whole runtime reads
    flags = ("-DEXOVER_WIDTH=2", f"-DEXOVER_USES={0x1FFFFFF & ~bit}")
    small = compiled(tmp_path, *flags, sanitized=refused_by_head)
    outcomes = small.run([pack(build(model_of(text), unchecked=True).tables) for text in wanted])
    assert [outcome.status for outcome in outcomes] == list(wanted.values())


def test_a_decision_that_is_none_is_a_fault_where_nothing_waits_and_nothing_is_killed(tmp_path: Path) -> None:
    tables = build(model_of(MUTEXES)).tables
    nodes = tuple(Node(-t.AGREE, 0, -1, 0) if node.code == -t.LAUNCH else node for node in tables.nodes)
    small = compiled(tmp_path, "-DEXOVER_WIDTH=2", f"-DEXOVER_USES={uses(tables)}", sanitized=False)
    (outcome,) = small.run([pack(replace(tables, nodes=nodes))], events=50)
    assert (outcome.status, outcome.fault) == (READY, FAULT_DECISION)


# ---- numbers that only wide words hold ----


def wide() -> Iterator[Tables]:
    """Yield tables with more slots than are allowed, and with more arguments of these."""
    yield edited("requests", 0, instances=0x1000001)
    yield edited("requests", 0, instances=0x1000000)


def test_more_slots_or_arguments_than_a_memory_holds_are_refused(tmp_path: Path) -> None:
    outcomes = compiled(tmp_path, "-DEXOVER_WIDTH=4").run([pack(tables) for tables in wide()])
    assert [outcome.status for outcome in outcomes] == [BAD_INDEX, BAD_INDEX]
