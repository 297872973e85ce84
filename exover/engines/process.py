"""Processes that do not outlive exover, even if it is killed: foreign programs, and forks of its own."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from exover.dataclass import dataclass

PR_SET_PDEATHSIG = 1
"""The option of `prctl` (Linux) that sets the signal which a process gets when its parent ends."""
LOOK = 0.1
"""Seconds between two looks of the keeper whether its parent is still there."""
BEHIND = 3
"""What `step_back` adds to the nice value: beside two busy processes on two processors, two fifths of one are left."""
KILL = int(getattr(signal, "SIGKILL", 9))
RESTORED = [int(getattr(signal, name)) for name in ("SIGPIPE", "SIGXFSZ") if hasattr(signal, name)]
"""Signals that Python ignores, and that are reset to their default in a program that it starts."""
KEEPER = f"""
import os, select, sys
parent, command = int(sys.argv[1]), sys.argv[2:]
try:
    child = os.posix_spawnp(command[0], command, os.environ, setsigdef={RESTORED})
except OSError as error:
    os.write(2, f"cannot run {{command[0]}}: {{error.strerror}}".encode("utf-8", "replace"))
    sys.exit(127)
try:
    ending, pause = [os.pidfd_open(child)], {LOOK}
except (AttributeError, OSError):
    ending, pause = [], {LOOK} / 10
while os.getppid() == parent:
    select.select(ending, [], [], pause)
    ended, status = os.waitpid(child, os.WNOHANG)
    if ended:
        code = os.waitstatus_to_exitcode(status)
        sys.exit(code if code >= 0 else 128 - code)
os.killpg(0, {KILL})
"""
"""A program that runs a command, and kills its process group, itself included, once its parent is gone.

It starts with every command, so it imports nothing slow: to import `subprocess` takes longer than the interpreter does.
"""


class NotRunnable(Exception):
    """The program does not exist or cannot be started; the message is for the user."""


@dataclass(frozen=True, slots=True)
class Ended:
    """The exit status of a program (128 + signal, as in a shell), its standard output and its standard error."""

    status: int
    printed: str
    complained: str

    @property
    def how(self) -> str:
        """How it ended, in words that follow the name of the program."""
        with suppress(ValueError):
            return f"was ended by {signal.Signals(self.status - 128).name}"
        return f"ended with status {self.status}"


def run(
    command: Sequence[str], folder: Path, environment: Mapping[str, str] | None = None, seconds: float | None = None
) -> Ended:
    """Run a command in this folder without input, and return how it ended; its output is decoded as UTF-8.

    When this returns or raises, no process of the command's group is left, and none a moment after this process is
    killed. Raises `NotRunnable`, and `TimeoutError` after so many seconds. Without process groups (Windows), processes
    that the command has started may outlive this one.
    """
    groups = hasattr(os, "killpg")
    keeper = [sys.executable, "-I", "-S", "-c", KEEPER, str(os.getpid())] if groups else []
    try:
        process = subprocess.Popen(
            [*keeper, *command],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            start_new_session=groups,
        )
    except OSError as error:
        raise NotRunnable(f"cannot run {command[0]}: {error.strerror}") from error
    with process:
        try:
            printed, complained = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired as late:
            raise TimeoutError(f"{command[0]} took longer than {seconds:g} s") from late
        finally:
            _end(process, groups)
    if groups and process.returncode == 127 and complained.startswith("cannot run "):
        raise NotRunnable(complained)
    return Ended(process.returncode, printed, complained)


def _end(process: "subprocess.Popen[str]", groups: bool) -> None:
    """Kill a process or, with `groups`, its whole process group, parts of which may outlive it."""
    if groups:
        with suppress(ProcessLookupError, PermissionError):  # no process of the group is left
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def step_back() -> None:
    """Lower the priority of this process by `BEHIND`, where the system can."""
    if hasattr(os, "nice"):
        os.nice(BEHIND)


@contextmanager
def uninterrupted(*signals: int) -> Iterator[None]:
    """Block signals of this thread until the end of the body; another thread of the process may still get them.

    A process that is started in the body inherits the mask and never gets them: its parent handles them.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def die_with(parent: int) -> bool:
    """Have this process killed when its parent ends (Linux only); return whether the parent is still there."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        return os.getppid() == parent  # else it ended before
    return True
