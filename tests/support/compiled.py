"""What compilers made, kept while the tests run: the same command on the same sources is run once.

It is kept for the next run as well where a folder is named for that, as `make test` does.
"""

import hashlib
import os
import platform
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from shutil import which
from tempfile import mkdtemp
from unittest.mock import patch

from exover.engines import compiler
from exover.engines.compiler import COMPILERS, command_in, find_compiler
from exover.engines.process import Ended, run

KEPT = "EXOVER_TESTS_KEPT"
"""The folder in which is kept for the next run what compilers made, if it is."""
MOST = 1 << 30
"""Bytes of it that are kept, what was used last before the rest."""
STORE = "EXOVER_TESTS_COMPILED"
COMPILER = """#!/bin/sh
# The C compiler, but what it makes of the sources in a folder is kept: the last word says what that is.
for made; do :; done
kept={store}/$( (echo "$@"; cat *.c *.h) | sha256sum | cut -c -64)
if [ ! -f "$kept" ]; then
    {compiler} "$@" && cp "$made" "$kept.$$" && mv "$kept.$$" "$kept" || exit
fi
cp "$kept" "$made"
"""


def store() -> Path:
    """Return the folder of this run of the tests, which all of its processes share."""
    return Path(os.environ[STORE])


def stays_within(words: Sequence[str]) -> bool:
    """Return whether a command names no file that is in another folder than its own, nor in one below that."""
    return all(re.fullmatch(r"(-I|-o)?(\./)?[^/]*", word) for word in words)


def across_runs(kept: Path, most: int = MOST) -> Path:
    """Return the folder in `kept` for what the compilers of this machine make; it is empty if they have changed.

    What does not fit is removed, so no other run may be at work.
    """
    found = kept / _versions()
    found.mkdir(parents=True, exist_ok=True)
    stores = [store for store in kept.iterdir() if store != found]
    size = 0
    for made in sorted(found.iterdir(), key=lambda made: made.stat().st_mtime, reverse=True):
        size += sum(file.stat().st_size for file in (made, *made.glob("*")))
        if size > most:
            stores.append(made)
    for each in stores:
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    return found


@cache
def _versions() -> str:
    """Return what tells the compilers and the library of this machine from others."""
    commands = [*([name] for name in (*COMPILERS, "rustc")), *map(command_in, ("CC", "RUSTC"))]
    there = [each for each in commands if each and which(each[0])]
    told = [subprocess.run([*each, "--version"], capture_output=True, check=False).stdout for each in there]
    return hashlib.sha256(f"{commands} {told} {platform.libc_ver()}".encode()).hexdigest()


def keeping_compiler() -> Path:
    """Return a C compiler for commands in processes of their own: what these compile is kept with the rest.

    Where there is no sha256sum it is the compiler itself.
    """
    if which("sha256sum") is None:
        return Path(find_compiler()[0])
    program = store() / "cc"
    if not program.exists():
        begun = program.with_name(f"cc.{os.getpid()}")
        begun.write_text(COMPILER.format(store=shlex.quote(str(store())), compiler=shlex.join(find_compiler())))
        begun.chmod(0o755)
        begun.rename(program)
    return program


@contextmanager
def kept_in(store: Path) -> Iterator[None]:
    """Let the commands by which exover compiles take what they have made before from a folder, and put it there.

    Several processes may share the folder.
    """
    store.mkdir(exist_ok=True)

    def compiled(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> Ended:
        command = _quick(command)
        program = which(command[0])
        words = command[command[0] == str(store / "cc") :]
        if program is None or not stays_within(words):
            return run(command, folder, environment)  # not of the system, or it reads other folders
        made = store / _key(program, command, folder)
        if not made.is_dir():
            before = _stamps(folder)
            ended = _run(command, folder, environment)
            if ended.status:
                return ended
            _keep([file for file, stamp in _stamps(folder).items() if before.get(file) != stamp], made)
        os.utime(made)
        shutil.copytree(made, folder, dirs_exist_ok=True)
        return Ended(0, "", "")

    with patch.object(compiler, "run", compiled):
        yield


def _quick(command: Sequence[str]) -> Sequence[str]:
    """Return a command that lets clang, if it is there, compile for cc what is not optimized: in half the time."""
    is_plain = command[0] == "cc" and "-O0" in command and not any("address" in word for word in command)
    return ["clang", *command[1:]] if is_plain and which("clang") else command


def _run(command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> Ended:
    """Run a compiler without the process that would end it after us: that takes as long as a small compilation."""
    done = subprocess.run(
        command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    return Ended(done.returncode, done.stdout, done.stderr)


def _key(program: str, command: Sequence[str], folder: Path) -> str:
    """Return what tells a command and all that it may read from others."""
    said = hashlib.sha256(f"{program} {os.stat(program).st_mtime_ns} {list(command)}".encode())
    for file in sorted(_stamps(folder)):
        said.update(f" {file.name} {file.stat().st_size} ".encode() + file.read_bytes())
    return said.hexdigest()


def _stamps(folder: Path) -> dict[Path, int]:
    return {file: file.stat().st_mtime_ns for file in folder.iterdir() if file.is_file()}


def _keep(files: Sequence[Path], made: Path) -> None:
    """Put files into a folder that is there with all of them, or not at all."""
    begun = mkdtemp(dir=made.parent)
    for file in files:
        shutil.copy2(file, begun)
    with suppress(OSError):  # another process was quicker
        os.rename(begun, made)
