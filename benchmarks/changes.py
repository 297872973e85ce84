"""What a change costs every day: `exover diff` of two versions of each spec, `exover check` of what has not changed."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from shutil import copy

from benchmarks.measure import ROOT, Row, median_seconds

SPECS = ROOT / "specs"
EDITS = {
    "assistant": {
        "a rule removed": ('mutex hands: arm.grab, arm.hand_over because "there is one hand";', ""),
        "a bound changed": ("not leaning or v <= speed", "not leaning or v < speed"),
        "a wait made a reject": ("fail the_cat: when cat_near else wait", "fail the_cat: when cat_near"),
    },
    "diligent": {
        "a rule removed": ("mutex manual: teleop.drive over topo.travel", "// "),
        "a bound changed": ("lrf.age > 500", "lrf.age > 400"),
        "a wait made a reject": ("platine.point, cameras.shoot by wait", "platine.point, cameras.shoot by reject"),
    },
    "rover": {
        "a rule removed": ("interrupts self;", ""),
        "a bound changed": ("v <= 0.5", "v <= 0.6"),
        "a wait made a reject": ("resource power: 100 by wait;", "resource power: 100 by reject;"),
    },
    "satellite": {
        "a rule removed": ('check exposed: lens.protection == off because "the lens is covered";', ""),
        "a bound changed": ("sun_angle >= safe_angle", "sun_angle > safe_angle"),
        "a wait made a reject": ("attitude.point, thruster.fire by wait", "attitude.point, thruster.fire by reject"),
    },
}
"""By spec and kind of change what is replaced by what."""
ONE = {"assistant": "base.move", "diligent": "nd.goto", "rover": "pom.localize", "satellite": "attitude.point"}
"""By spec some request."""


def edited(spec: str, change: str) -> str:
    """Return the text of a spec with a change made."""
    text, (old, new) = (SPECS / f"{spec}.exo").read_text(encoding="utf-8"), EDITS[spec][change]
    assert text.count(old) == 1, f"{spec}: {old}"
    return text.replace(old, new)


def diffs(slow: bool) -> Iterator[Row]:
    """Yield how long `exover diff` takes as a process, properties of both versions included."""
    for spec, changes in EDITS.items():
        for change in changes if slow else list(changes)[:1]:
            with _project(spec) as folder:
                new = Path(folder, f"{spec}_new.exo")
                new.write_text(edited(spec, change), encoding="utf-8")
                statuses: list[int] = []
                run = partial(_run, ["diff", f"{spec}.exo", new.name], folder, "1", statuses)
                seconds = median_seconds(run, 1)
                whole = statuses == [0]
            yield Row(f"exover diff specs/{spec}.exo, {change}", seconds, "s", 10, whole=whole)


def unchanged(rounds: int) -> Iterator[Row]:
    """Yield how long `exover check` of an unchanged spec takes as a process."""
    for spec in EDITS:
        with _project(spec) as folder:
            run = partial(_run, ["check", f"{spec}.exo"], folder, "", [])
            run()
            what = f"exover check specs/{spec}.exo, unchanged"
            yield Row(what, 1000 * median_seconds(run, rounds), "ms", 300)
            yield Row(f"{what}, processor", 1000 * _processor(["check", f"{spec}.exo"], folder), "ms", 300)


def edits() -> Iterator[Row]:
    """Yield what `exover check` costs after an edit of a spec that was checked before, in seconds of the processor."""
    for spec, changes in EDITS.items():
        with _project(spec) as folder:
            file, properties = Path(folder, f"{spec}.exo"), Path(folder, f"{spec}.prop")
            text, said = file.read_text(encoding="utf-8"), properties.read_text(encoding="utf-8")
            more = f"{said}\nproperty one_more: possible (active({ONE[spec]}));\n"
            fresh = _processor(["check", file.name, "--no-cache"], folder)
            _processor(["check", file.name], folder)
            for what, now, asks in (
                ("a comment", f"// why\n{text}", said),
                ("one more property", text, more),
                ("a bound changed", text.replace(*changes["a bound changed"]), said),
            ):
                file.write_text(now, encoding="utf-8")
                properties.write_text(asks, encoding="utf-8")
                seconds = _processor(["check", file.name], folder)
                note = f"{fresh:.1f} s without the cache"
                yield Row(f"exover check specs/{spec}.exo, {what}, processor", seconds, "s", None, note=note)


def _processor(arguments: list[str], folder: str) -> float:
    """Return the seconds of the processor that a command takes, its processes included."""
    environment = {**os.environ, "EXOVER_NO_CACHE": ""}
    command = [sys.executable, "-m", "exover", *arguments]
    process = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime


def _project(spec: str) -> "tempfile.TemporaryDirectory[str]":
    """Return a folder with a spec and its properties file."""
    folder = tempfile.TemporaryDirectory()
    for file in (SPECS / f"{spec}.exo", ROOT / "properties" / f"{spec}.prop"):
        copy(file, folder.name)
    return folder


def _run(arguments: list[str], folder: str, uncached: str, statuses: list[int]) -> None:
    environment = {**os.environ, "EXOVER_NO_CACHE": uncached}
    command = [sys.executable, "-m", "exover", *arguments]
    statuses.append(subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=False).returncode)
