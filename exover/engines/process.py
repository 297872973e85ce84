"""Processes that end when we do, however that is: programs of others, and parts of our own."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from exover.dataclass import dataclass

PR_SET_PDEATHSIG = 1
"""Of `prctl` in Linux: the signal that a process gets when its parent ends."""
LOOK = 0.1
"""Seconds after which the keeper looks whether we are still there."""
BEHIND = 3
"""How much nicer a process is that steps back: beside two busy ones on two processors it has two fifths of one."""
KILL = int(getattr(signal, "SIGKILL", 9))
ENDING = signal.SIGINT, signal.SIGTERM
"""Signals that end a command in good order."""
RESTORED = [int(getattr(signal, name)) for name in ("SIGPIPE", "SIGXFSZ") if hasattr(signal, name)]
"""Signals that Python ignores; a program that it starts does not."""
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
"""Runs a command in its own group of processes, which it kills, itself included, once its parent is no longer there.

It starts with every command, and so imports nothing that takes long: `subprocess` takes longer than the interpreter.
"""


class NotRunnable(Exception):
    """The program is not there or cannot be started; the message is for the user."""


@dataclass(frozen=True, slots=True)
class Ended:
    """How a program ended, with 128 and the signal if it was one, as the shell has it, and what it printed."""

    status: int
    printed: str
    complained: str

    @property
    def how(self) -> str:
        """How it ended, as it follows the name of the program."""
        with suppress(ValueError):
            return f"was ended by {signal.Signals(self.status - 128).name}"
        return f"ended with status {self.status}"


def run(
    command: Sequence[str], folder: Path, environment: Mapping[str, str] | None = None, seconds: float | None = None
) -> Ended:
    """Return how a command ended that ran in this folder, without input, and with UTF-8 or what replaces it as output.

    When it returns or raises, no process of the command is left in its group; a moment later none is either if we are
    killed. Raises `NotRunnable`, and `TimeoutError` after so many seconds. Without groups of processes (Windows) a
    command of several processes may outlive us.
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
    """End a process and, with `groups`, its whole group, which may outlive it."""
    if groups:
        with suppress(ProcessLookupError, PermissionError):  # no process of the group is left
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def step_back() -> None:
    """Let processes go first from now on that are at work beside this one, where the system can."""
    if hasattr(os, "nice"):
        os.nice(BEHIND)


@contextmanager
def uninterrupted(*signals: int) -> Iterator[None]:
    """Let signals wait for the end of the body, as long as this process has but one thread.

    A process that begins in it never gets them: it is its parent that hears of them.
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
    """Have this process killed when its parent ends, where the system can; return whether the parent is still there."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        return os.getppid() == parent  # else it ended before
    return True
