"""The C compiler of the system: to find it, to run it, and to load the library that it makes."""

import ctypes
import os
import shlex
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from shutil import which

from exover.engines.process import NotRunnable, run

COMPILERS = ("cc", "gcc", "clang")


class NativeUnavailable(Exception):
    """There is no compiler, or it fails; the message is for the user."""


def find_compiler() -> list[str]:
    """Return the command of the C compiler: `$CC`, else the first of cc, gcc, clang; raises `NativeUnavailable`."""
    wanted = command_in("CC")
    if wanted:
        if which(wanted[0]) is None:
            raise NativeUnavailable(f"the C compiler of $CC, {wanted[0]}, is not there")
        return wanted
    for name in COMPILERS:
        if which(name):
            return [name]
    raise NativeUnavailable("no C compiler is there: install cc, gcc or clang, or name one in $CC")


def command_in(variable: str) -> list[str]:
    """Return the words of a command in an environment variable, none if it is not set; raises `NativeUnavailable`."""
    command = os.environ.get(variable, "")
    try:
        return shlex.split(command)
    except ValueError as error:  # a quote is not closed
        raise NativeUnavailable(f"${variable} is no command, {str(error).lower()}: {command}") from error


def compile_in(folder: Path, command: Sequence[str], makes: str | None, language: str = "C") -> None:
    """Run a compiler in a folder to make the file `makes` there (`None`: the command knows which).

    Its temporary files are in the folder, too, so that it leaves none elsewhere if it is killed. Raises
    `NativeUnavailable` if that fails.
    """
    try:
        ended = run(command, folder, {**os.environ, "TMPDIR": str(folder.absolute())})
    except NotRunnable as reason:
        raise NativeUnavailable(f"there is no {language} compiler: {reason}") from reason
    if ended.status:
        said = (ended.complained or ended.printed).rstrip()
        raise NativeUnavailable(f"the {language} compiler {command[0]} failed:\n{said}")
    if makes is not None and not (folder / makes).is_file():
        raise NativeUnavailable(f"the {language} compiler {command[0]} ended well, and made nothing")


def loaded(make: Callable[[Path], Path], failed: str) -> ctypes.CDLL:
    """Make a library in a temporary folder, load it, remove the folder, and return the library.

    Raises `NativeUnavailable`, whose message begins with `failed` if the folder or the library cannot be had.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="exover-", ignore_cleanup_errors=True) as folder:
            return ctypes.CDLL(str(make(Path(folder))))
    except OSError as error:
        raise NativeUnavailable(f"{failed}: {error}") from error
