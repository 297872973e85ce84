"""All checks of whole specs on the command line: with ABC, with the embedded engine alone, and what others take.

`make system` installs ABC where it may. Without it the rows that want it are measured with what there is, and say so.
"""

import tempfile
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from benchmarks import dala, families
from benchmarks.command import Checked, check
from benchmarks.measure import ROOT, Row
from exover.engines.aig.abc import prover
from exover.engines.process import NotRunnable
from exover.engines.smv import program

OTHERS = 60.0
"""Seconds that diagrams and NuSMV get."""
PATIENCE = 60.0
"""Seconds that a row gets whose limit is smaller."""
TEAMS = (
    "agent_tools",
    "lab_automation",
    "mobile_manipulator",
    "planetary_rover",
    "satellite_ops",
    "surgical_arm",
    "uav",
)
FIELDS = tuple(sorted((ROOT / "benchmarks" / "specs").glob("*.exo")))
"""Specs of other fields, for which nothing was tuned."""
VECTORS = ("corners", "mixed1", "mixed2", "mixed3", "mixed4", "mixed5", "mixed6")
COUPLED = (2, 3, 4, 6, 8, 16)
EMBEDDED = ("--abc=none",)


def team(spec: Path) -> Iterator[Row]:
    """Yield what a spec as teams write them takes, all its checks with its properties."""
    with_abc = check(spec, PATIENCE, *best())
    yield _row(f"{spec.stem}: all checks, {_way()}", with_abc, 10)
    yield _row("    the embedded engine alone", check(spec, PATIENCE, *EMBEDDED), 20)
    first = PATIENCE if with_abc.first is None else with_abc.first
    note = "of the clock" if with_abc.first is not None else "none was shown"
    yield Row("    time to the first error", first, "s", 1, note=note, whole=with_abc.first is not None)
    yield _row("    diagrams alone", _diagrams(spec))
    if _nusmv():
        yield _row("    NuSMV alone", check(spec, OTHERS, "--engine=nusmv"))
    else:
        print("    NuSMV: not measured, there is none")


def modules(size: dala.Size) -> Iterator[Row]:
    """Yield what a module takes that is as large as one whose freedom of deadlocks D-Finder proved."""
    what = f"{size.name}: all checks of {size.components} components, {size.locations} locations"
    with _written(dala.spec(size)) as spec:
        yield _row(f"{what}, {_way()}", check(spec.path, PATIENCE, *best()), 5, f"{size.time} {size.name}")
        yield _row("    the embedded engine alone", check(spec.path, PATIENCE, *EMBEDDED), 15)


def vector(name: str) -> Iterator[Row]:
    """Yield what a spec of all kinds of rules takes."""
    yield _row(f"{name}: all checks", check(ROOT / "tests" / "vectors" / f"{name}.exo", PATIENCE, *best()), 5)


def shown(name: str) -> Iterator[Row]:
    """Yield what a spec of the documents takes, beside the diagrams."""
    spec = ROOT / "specs" / f"{name}.exo"
    diagrams = _diagrams(spec)
    beside = f"bdd {diagrams.seconds:.1f} s" if diagrams.whole else f"bdd {diagrams.unknown.total()} unknown"
    yield _row(f"{name}: all checks", check(spec, PATIENCE, *best()), None, beside)


def mutexes() -> Iterator[Row]:
    """Yield what random mutexes with fail contexts take, and their memory."""
    with _written(families.guarded(1000, 3000, 100)) as spec:
        found = check(spec.path, 120, *best())
    yield _row("all checks: 1000 requests, 3000 mutexes, 100 fail contexts", found, 40)
    yield Row("    its memory", found.megabytes, "MiB", 1024, whole=not found.failure)


def waiting() -> Iterator[Row]:
    """Yield what requests take that wait for each other."""
    with _written(families.queues(64)) as spec:
        found = check(spec.path, PATIENCE, *best())
    yield _row("all checks: 64 requests waiting in a graph of degree 2.5", found, 10)


def coupled() -> Iterator[Row]:
    """Yield what modules take that look at their neighbours, the smallest first, until it is too much."""
    for size in COUPLED:
        with _written(families.coupled(size)) as spec:
            found = check(spec.path, 120, *best())
        bits = f", {found.state_bits} bits" if found.state_bits else ""
        yield _row(f"all checks: {size} coupled modules{bits}", found, 60 if size <= 8 else None)
        if not found.whole:
            print(f"    breaks at {size} modules: {found.said}")
            return
    print(f"    does not break up to {COUPLED[-1]} modules")


@cache
def best() -> tuple[str, ...]:
    """Return the options with which the command is as fast as it can be here."""
    try:
        return (f"--abc={prover.find()}",)
    except NotRunnable:
        return EMBEDDED


def _way() -> str:
    return "without ABC, there is none" if best() == EMBEDDED else "with ABC"


@cache
def _nusmv() -> bool:
    try:
        program.find()
    except NotRunnable:
        return False
    return True


def _diagrams(spec: Path) -> Checked:
    return check(spec, OTHERS, "--engine=bdd")


def _row(what: str, found: Checked, limit: float | None = None, beside: str = "") -> Row:
    return Row(what, found.seconds, "s", limit, beside, found.said, found.whole)


class _written:
    """A spec in a file while it is asked about."""

    def __init__(self, text: str) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.path = Path(self._folder.name, "family.exo")
        self.path.write_text(text)

    def __enter__(self) -> "_written":
        return self

    def __exit__(self, *raised: object) -> None:
        self._folder.cleanup()


def groups() -> dict[str, dict[str, Callable[[], Iterator[Row]]]]:
    """Return the rows by the names with which they can be chosen, in groups that have names too."""
    return {
        "teams": {name: partial(team, ROOT / "tests" / "specs" / f"{name}.exo") for name in TEAMS},
        "fields": {spec.stem: partial(team, spec) for spec in FIELDS},
        "dala": {size.name: partial(modules, size) for size in dala.SIZES},
        "vectors": {name: partial(vector, name) for name in VECTORS},
        "specs": {path.stem: partial(shown, path.stem) for path in sorted((ROOT / "specs").glob("*.exo"))},
        "large": {"all-mutexes": mutexes, "all-queues": waiting},
        "coupled": {"ring": coupled},
    }
