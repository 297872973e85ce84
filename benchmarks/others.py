"""The same mutexes asked of Cedar and of OPA, in the same run, beside the C runtime.

What those do more: they evaluate any policy over any data, typed or not, that come with the question, and can tell
which policies decided. What they do not do: they remember nothing, so the host tells them with every question what is
active; nobody waits and nothing is killed. Only deciding is timed, what it reads is made beforehand.
"""

import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from shutil import which

from benchmarks import families, runtime
from benchmarks.measure import ROOT, Row
from benchmarks.robot import nanoseconds
from exover.model.event import Ask, Launched, Report
from exover.model.model import Model
from exover.ocrd.conflicts import conflicts
from exover.ocrd.machine import Machine
from exover.pipeline import build as compiled
from exover.pipeline import load
from exover.run.native import NativeEngine, build
from exover.source import Source

SIZES = (10, 50, 200, 1000)
SHARE = 1 / 3
"""How many of the events are reports."""
QUESTIONS, ROUNDS = 500, 5
BUILT = ROOT / "build" / "others"
MINUTES = 45
"""How long a build may take: Cedar is 150 crates."""


@dataclass(frozen=True, slots=True)
class Other:
    """Another checker: what it is called, the tool that builds it, how, and where the program is then."""

    name: str
    tool: str
    folder: str
    command: tuple[str, ...]
    program: Path

    def missing(self) -> str:
        """Build it if need be; return why there is none, nothing if there is."""
        if which(self.tool) is None:
            return f"no {self.tool}"
        folder = ROOT / "benchmarks" / "others" / self.folder
        try:
            subprocess.run(self.command, cwd=folder, capture_output=True, text=True, check=True, timeout=60 * MINUTES)
        except subprocess.TimeoutExpired:
            return f"{self.tool} took more than {MINUTES} minutes"
        except subprocess.CalledProcessError as failed:
            return f"{self.tool} failed: {failed.stderr.strip().splitlines()[-1]}"
        return ""

    def ask(self, text: str) -> tuple[float, int]:
        """Return the mean nanoseconds of a decision, and how many were allowed."""
        command = [str(self.program), str(ROUNDS)]
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
        spent, allowed = done.stdout.split()
        return float(spent), int(allowed)


CARGO = ("cargo", "build", "--release", "--locked", "--quiet", "--jobs=1", f"--target-dir={BUILT / 'cedar'}")
OTHERS = (
    Other("Cedar 4.14, sliced by action", "cargo", "cedar", CARGO, BUILT / "cedar" / "release" / "others-cedar"),
    Other("OPA 1.22, prepared query", "go", "opa", ("go", "build", "-p=1", f"-o={BUILT}/opa", "."), BUILT / "opa"),
)


def decisions(rounds: int) -> Iterator[Row]:
    """Yield the time of a decision of each; that of one of the C runtime, its state included, stands beside it."""
    ready = []
    for other in OTHERS:
        if why := other.missing():
            print(f"{other.name}: not measured, {why}")
        else:
            ready.append(other)
    for size in SIZES if ready else ():
        model = load(Source("mutexes.exo", families.mutexes(size))).model
        assert model is not None
        here = _here(model, rounds)
        text, expected = questions(model)
        for other in ready:
            spent, allowed = other.ask(text)
            assert allowed == expected, f"{other.name} allows {allowed} of {QUESTIONS}, not {expected}"
            title = f"{other.name}: {size} requests in mutexes"
            yield Row(title, spent / 1000, "µs", note=f"{here:.0f} ns in C: {spent / here:.0f} times")


def questions(model: Model) -> tuple[str, int]:
    """Return the conflicts of all requests and the first asks of random events, and how many of these are launched."""
    machine = Machine(model, compiled(model).tables)
    number = {request.name: index for index, request in enumerate(model.requests)}
    lines = [str(len(number)), *(" ".join(map(str, sorted(row))) for row in conflicts(model))]
    active: set[int] = set()
    asked = launched = 0
    for event in runtime.stream(model, machine.tables, SHARE):
        started = {number[action.request] for action in machine.step(event) if isinstance(action, Launched)}
        match event:
            case Ask(request) if asked < QUESTIONS:
                lines.append(" ".join(map(str, [number[request], *sorted(active)])))
                asked, launched = asked + 1, launched + len(started)
            case Report(request):
                active.discard(number[request])
            case _:
                pass
        active |= started
    return "\n".join(lines) + "\n", launched


def _here(model: Model, rounds: int) -> float:
    tables = compiled(model).tables
    with tempfile.TemporaryDirectory(prefix="exover-") as folder, NativeEngine(model, tables) as engine:
        program = build(model, tables, Path(folder), runtime.FLAGS)
        lines = [engine.line(event) for event in runtime.stream(model, tables, SHARE)]
        return nanoseconds(program, lines, rounds)
