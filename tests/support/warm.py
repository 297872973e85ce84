"""The command `exover` forked from a process that has imported it, as a program that begins in a tenth of the time.

What it is asked and where it reads and writes are those of its caller, whose other files it has as well. It is no child
of its caller and hears none of its signals: what is about these runs `python -m exover`. Other programs in Python may
be forked so, too.

`python -m tests.support.warm FOLDER VERB…` is the process: it answers at a socket in the folder until its input ends.
A verb that is a file, the only one, is a program in Python.
"""

import atexit
import fcntl
import gc
import json
import os
import select
import shutil
import socket
import subprocess
import sys
import tempfile
from array import array
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from runpy import run_path

from tests.support.compiled import STORE, kept_in, store

SHIM = """#!{python} -IS
import array, json, os, socket, sys
files = []
for number in map(int, os.listdir("/dev/fd")):
    try:
        os.fstat(number)
        files.append(number)
    except OSError:
        pass
server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
server.connect({path!r})
asked = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ), files]).encode()
rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", files))]
server.sendmsg([b"%10d" % len(asked)], rights)
server.sendall(asked)
sys.exit(int(server.recv(10) or b"137"))
"""
"""What a caller runs. It asks the process, and ends as the child of that does."""
PACKAGES = ("checks", "engines", "resolve", "run")
VERBS = ("check", "emit", "explain", "simulate", "trace", "report", "diff", "verify", "gate")
SERVER = "lsp"
"""It imports more than the others, most of which takes a second, and nothing of what they decide by."""
MOST_FILES = 100
Main = Callable[[list[str]], int]


@cache
def command(seed: str = "random", verbs: tuple[str, ...] = VERBS) -> Path:
    """Return the program, which begins at once with these verbs; texts are hashed with this seed.

    The only verb may be a file: a program in Python that has what it imports at once.
    """
    folder = Path(tempfile.mkdtemp(prefix="warm-"))
    program = folder / "exover"
    program.write_text(SHIM.format(python=sys.executable, path=str(folder / "socket")))
    program.chmod(0o755)
    words = [sys.executable, "-m", "tests.support.warm", str(folder), *verbs]
    environment = {STORE: str(folder / "compiled"), **os.environ, "PYTHONHASHSEED": seed}
    where = {"cwd": Path(__file__).parents[2], "env": environment}
    server = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, **where)  # type: ignore[call-overload]
    atexit.register(server.communicate)
    assert server.stdout.readline() == b"ready\n"
    return program


# ---- the process ----


def serve(folder: Path, verbs: Sequence[str]) -> None:
    """Answer at the socket, each caller in a process of its own, until the input ends."""
    if verbs[0].endswith(".py"):
        main = partial(run_script, verbs[0])
        run_path(verbs[0], run_name="imported")
    else:
        main = command_of(verbs)
    gc.freeze()
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(str(folder / "socket"))
    listener.listen(100)
    os.write(1, b"ready\n")
    while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
        caller, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            try:
                answer(caller, main)
            except BaseException:
                sys.excepthook(*sys.exc_info())
            finally:
                os._exit(137)
        caller.close()
        _reap()


def command_of(verbs: Sequence[str]) -> Main:
    """Return the command, once all is imported that these verbs may need."""
    for verb in verbs:
        import_module(f"exover.cli.{verb}")
    for package in ("editor",) if SERVER in verbs else PACKAGES:
        for each in walk_packages(import_module(f"exover.{package}").__path__, f"exover.{package}."):
            import_module(each.name)
    from exover.cli.main import main

    return main


def run_script(file: str, words: list[str]) -> int:
    """Run a program in Python, and return 0 if it comes to its end."""
    sys.argv = [file, *words]
    run_path(file, run_name="__main__")
    return 0


def _reap() -> None:
    """Let go of the processes that have ended."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass


def answer(caller: socket.socket, main: Main) -> None:
    """Become the command that a caller asks for, and tell it the status."""
    size, rights, *_ = caller.recvmsg(10, socket.CMSG_SPACE(MOST_FILES * array("i").itemsize))
    given = array("i", rights[0][2])
    asked = b""
    while len(asked) < int(size):
        asked += caller.recv(65536)
    words, folder, environment, numbers = json.loads(asked)
    place = socket.socket(fileno=_above(caller.detach(), numbers))
    given = [_above(file, numbers) for file in given]
    for file, number in zip(given, numbers, strict=True):
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["exover", *words]
    status = main(words)
    atexit._run_exitfuncs()
    sys.stdout.flush()
    place.sendall(b"%d" % status)
    os._exit(status)


def _above(file: int, numbers: list[int]) -> int:
    """Return a file under a number that none of these is."""
    found = fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, max(numbers) + 1)
    os.close(file)
    return found


if __name__ == "__main__":
    try:
        with kept_in(store()):
            serve(Path(sys.argv[1]), sys.argv[2:])
    finally:
        shutil.rmtree(sys.argv[1])
