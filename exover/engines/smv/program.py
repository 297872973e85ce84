"""The program NuSMV or nuXmv: to find it, and to run it."""

import os
import shutil
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from ctypes.util import find_library
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from exover.dataclass import dataclass
from exover.engines.process import NotRunnable, run

NAMES = ("NuSMV", "nuXmv", "nusmv", "nuxmv")
LINKED = "libreadline.so.6"
"""What the program in the wheel was linked with; what is installed today does as well."""
IDLE_WORDS = ("***", "aborting", "WARNING")
"""Beginnings of lines on standard error that do not say why the program ended."""
UNLOADED = "error while loading shared libraries"
CHECKS = {"INVARSPEC": "check_invar", "CTLSPEC": "check_ctlspec", "LTLSPEC": "check_ltlspec"}
HEAD = """set on_failure_script_quits
set default_trace_plugin 4
unset traces_show_defines
{traces}
set cone_of_influence
unset forward_search
set input_order_file model.ord
read_model -i model.smv
flatten_hierarchy
encode_variables
build_flat_model
"""


@dataclass(frozen=True, slots=True)
class ProgramAnswers:
    """The output for each specification, by name, as far as the program came, and why it came no further."""

    of: Mapping[str, str]
    stopped: str = ""


def find(given: str | None = None) -> str:
    """Return the path of the program: the one given, else one on PATH, else that in the wheel of pyboolnet.

    Raises `NotRunnable` if there is none.
    """
    if given is not None:
        found = shutil.which(given)
        if found is None:
            raise NotRunnable(f"cannot run {given}: it is no program")
        return os.path.abspath(found)
    for name in NAMES:
        found = shutil.which(name)
        if found is not None:
            return os.path.abspath(found)
    wheel = in_wheel()
    if wheel is None:
        raise NotRunnable("no NuSMV or nuXmv was found, neither on PATH nor in the extra exover[nusmv]")
    _start(str(wheel))
    return str(wheel)


def _start(program: str) -> None:
    """Raise `NotRunnable` if a library is missing that the program was linked with."""
    with TemporaryDirectory(prefix="exover-") as name:
        complained = run([program, "-h"], Path(name), environment(Path(name)), seconds=60).complained
    missing = [line for line in complained.splitlines() if UNLOADED in line]
    if missing:
        raise NotRunnable(f"cannot run {program}: {missing[0].split(UNLOADED)[1].strip(' :')}")


def in_wheel() -> Path | None:
    """Return where the program of the wheel is, if that is installed."""
    package = find_spec("pyboolnet")
    folders = (package.submodule_search_locations if package else None) or ()
    places = [Path(folder, "binaries", "linux64", "NuSMV-a", "NuSMVa_linux64") for folder in folders]
    return next((place for place in places if place.exists()), None)


def environment(folder: Path) -> dict[str, str]:
    """Return the variables with which the program of the wheel finds its library, by a link in this folder."""
    library = _readline()
    if library:
        with suppress(FileExistsError):
            (folder / LINKED).symlink_to(library)
    paths = [str(folder), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(paths)}


@cache
def _readline() -> str | None:
    """Return where the library is that is installed today."""
    known = ""
    with suppress(OSError):  # there is no such program outside of Linux
        known = subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True, text=True, check=False).stdout
    wanted = find_library("readline") or "libreadline.so.8"
    found = (line.split("=>")[1].strip() for line in known.splitlines() if line.strip().startswith(f"{wanted} "))
    return next(found, None)


def ask(
    program: str, model: str, order: str, names: Mapping[str, str], seconds: float | None, traces: bool
) -> ProgramAnswers:
    """Return what the program says of a model: of each of `names`, with the kind of the specification.

    `traces`: it shows runs, which may take it far longer than to see that there are some. `order`: the variables in the
    order of the diagrams. What it has not come to after so many seconds is left out.
    """
    with TemporaryDirectory(prefix="exover-") as name:
        folder = Path(name)
        (folder / "model.smv").write_text(model, encoding="utf-8")
        (folder / "model.ord").write_text(order, encoding="utf-8")
        head = HEAD.format(traces=f"{'' if traces else 'un'}set counter_examples")
        checks = [f"{CHECKS[kind]} -P {name} -o {n}.txt\n" for n, (name, kind) in enumerate(names.items())]
        (folder / "script").write_text(f"{head}{''.join(checks)}quit\n", encoding="utf-8")
        stopped = ""
        try:
            command = [program, "-source", "script"]
            ended = run(command, folder, environment(folder) if os.name == "posix" else None, seconds)
            if ended.status:
                stopped = f"{program} {ended.how}{_told(ended.complained)}"
        except (NotRunnable, TimeoutError) as reason:
            stopped = str(reason)
        files = [(each, folder / f"{n}.txt") for n, each in enumerate(names)]
        return ProgramAnswers(
            {each: file.read_text("utf-8", "replace") for each, file in files if file.exists()}, stopped
        )


def _told(complained: str) -> str:
    """Return what a program complained of, in a few words; its greetings and news are no complaints."""
    lines = [line.strip() for line in complained.splitlines()]
    telling = [line for line in lines if line and not line.startswith(IDLE_WORDS)]
    return f": {telling[0][:200]}" if telling else ""
