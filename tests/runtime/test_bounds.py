"""A debug build of the C runtime counts what each event costs; none exceeds its bound, and one that did would stop.

A walk of the same tables counts too, and runs that are to cost as much as they can come near. All is here since to
find the bounds takes longer than most of the events.
"""

import subprocess
from functools import cache
from pathlib import Path

import pytest

from exover.bounds.events import EventBounds, bounds
from exover.bounds.sizes import actions_per_event, sizes
from exover.emit import c
from exover.emit.artefact import runtime_file
from exover.engines.aig.costs import tightened
from exover.model.event import Event
from exover.ocrd.machine import Machine
from exover.pipeline import Build
from exover.run.native import NativeEngine
from tests.bounds.adversary import reached
from tests.bounds.counting import bound_of, most_of, random_events
from tests.runtime.compiling import QUICK, ROOT, SPECS, WARNINGS, built, compile_c
from tests.support.constructs import seldom

EVENTS = 400
"""Events that the C takes, and a walk of the tables."""
FEW = tuple(path for path in SPECS if path.parent.name == "specs" or path.stem in ("corners", "corners2", "mixed6"))
"""Those that have every construct of all: to find their bounds takes half a second each."""
TIMES = 3
"""How many times what is reached the bounds of the worst event are, at most."""
DEBUG = (*WARNINGS, "-O0", "-DEXOVER_DEBUG")


def test_few_specs_have_every_construct() -> None:
    few, many = ([(built(path).model,) for path in paths] for paths in (FEW, SPECS))
    assert not seldom(few, many, 1)


@cache
def tight(path: Path) -> EventBounds:
    """Return the bounds of the events of a spec file."""
    return tightened(built(path).compiled)


@cache
def events_of(path: Path) -> list[Event]:
    """Return random events of a spec file."""
    return random_events(built(path).model, 11, EVENTS)


def program(found: Build, known: EventBounds, folder: Path, patch: tuple[str, str] | None = None) -> Path:
    """Return the program that prints costs; `patch`: a line of the configuration that is another one."""
    for artefact in c.emit_tables(found.model, found.tables, "native", (), known):
        text = artefact.content.decode()
        if patch and artefact.name == "exover_config.h":
            assert patch[0] in text
            text = text.replace(*patch)
        (folder / artefact.name).write_text(text)
    (folder / "runner.c").write_bytes(runtime_file("runner.c"))
    sources = [Path(__file__).parent / "costs.c", folder / "native_tables.c", folder / "exover.c"]
    compile_c(QUICK, [*DEBUG, f"-I{folder}"], sources, folder / "costs")
    return folder / "costs"


@pytest.mark.parametrize("path", FEW, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_no_event_exceeds_its_bound_in_c(path: Path, tmp_path: Path) -> None:
    found, known = built(path), tight(path)
    engine, machine = NativeEngine(found.model, found.tables), Machine(found.model, found.tables)
    events = events_of(path)
    lines = "\n".join(map(engine.line, events))
    done = subprocess.run([program(found, known, tmp_path)], input=lines, capture_output=True, text=True, check=True)
    costs = [tuple(map(int, line.split())) for line in done.stdout.splitlines()]
    assert len(costs) == len(events) and max(costs)[0] > 0
    for event, (tests, answers, passes) in zip(events, costs, strict=True):
        bound = bound_of(found.model, known, event)
        assert answers == len(machine.step(event))
        assert tests <= bound.tests and answers <= bound.answers and passes <= bound.passes


@pytest.mark.parametrize("path", FEW, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_no_event_of_a_spec_exceeds_its_bound(path: Path) -> None:
    found = built(path)
    most = most_of(found, tight(path), events_of(path))
    worst = bounds(found.tables).worst
    assert most.tests > 0 and worst.answers <= actions_per_event(found.tables)
    assert worst.passes <= found.tables.limits[0].passes


@pytest.mark.parametrize("path", sorted((ROOT / "specs").glob("*.exo")), ids=lambda path: path.stem)
def test_bounds_are_near_to_what_is_reached(path: Path) -> None:
    worst, most = tight(path).worst, reached(built(path), runs=4)
    assert most.tests <= worst.tests <= TIMES * most.tests
    assert most.answers <= worst.answers <= TIMES * most.answers
    assert most.passes <= worst.passes <= TIMES * most.passes


@pytest.mark.parametrize("figure", ["TESTS", "ACTIONS", "PASSES"])
def test_a_debug_build_stops_where_a_bound_is_exceeded(figure: str, tmp_path: Path) -> None:
    path = next(path for path in SPECS if path.stem == "diligent")
    found, known = built(path), tight(path)
    number = getattr(sizes(found.tables, known), figure.lower())
    lines = "\n".join(map(NativeEngine(found.model, found.tables).line, events_of(path)))
    command = [program(found, known, tmp_path, (f"EXOVER_{figure} {number}\n", f"EXOVER_{figure} 1\n"))]
    done = subprocess.run(command, input=lines, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and f"EXOVER_{figure}" in done.stderr
