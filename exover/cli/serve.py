"""`exover serve`: the checker of a spec at a socket, for programs in any language."""

import argparse
import os
import socket
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Literal

from exover.cli.files import read_spec
from exover.cli.simulate import start
from exover.cli.status import CliError
from exover.cli.streams import complain, unwaited_complaints
from exover.model.model import Model
from exover.pipeline import CheckerName, engine
from exover.run.serve import CheckerServer
from exover.run.simulate import Engine

QUEUE = 128
"""The most clients that may wait to be accepted."""


def run(arguments: argparse.Namespace) -> int:
    """Serve clients until a signal ends the process."""
    model = read_spec(arguments.spec)
    with ExitStack() as stack:
        stack.enter_context(unwaited_complaints())
        chosen, name = _engine(stack, arguments.engine, model)
        listener = stack.enter_context(_listening(arguments.socket))
        server = CheckerServer(model, chosen, listener, lambda text: complain(f"exover: warning: {text}"))
        stack.callback(server.close)
        complain(f"exover: note: {model.name} is served at {arguments.socket} by the engine {name}")
        _ready()
        server.serve()


def _engine(stack: ExitStack, name: CheckerName | Literal["auto"], model: Model) -> tuple[Engine, CheckerName]:
    """Return an engine that runs until the stack is left, and its name; `auto` is C if there is a compiler."""
    if name != "auto":
        return start(stack, name, model), name
    from exover.engines.compiler import NativeUnavailable

    try:
        return stack.enter_context(engine("c", model)), "c"
    except NativeUnavailable as reason:
        complain(f"exover: note: the tables are walked in Python, which is slower: {reason}")
        return stack.enter_context(engine("tables", model)), "tables"


@contextmanager
def _listening(path: str) -> Iterator[socket.socket]:
    """Yield a socket that listens at a path and is accessible to its owner alone; its file is removed afterwards."""
    if not hasattr(socket, "AF_UNIX"):
        raise CliError("this system has no Unix sockets")
    with _locked(path), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        try:
            _clear(path)
            _bind(listener, path)
            mine = os.lstat(path).st_ino
        except OSError as error:
            raise CliError(f"cannot listen at {path}: {error.strerror or error}") from error
        listener.setblocking(False)
        try:
            yield listener
        finally:
            with suppress(OSError):
                if os.lstat(path).st_ino == mine:  # whatever else stands there now is not ours
                    os.unlink(path)


@contextmanager
def _locked(path: str) -> Iterator[None]:
    """Keep other servers from a path, even if its socket is removed; `CliError` if one serves there."""
    name = f"{path}.lock"
    try:
        file = _lock(name)
    except BlockingIOError as error:
        raise CliError(f"another exover serves at {path}, and locks {name}: end it first") from error
    except OSError as error:
        raise CliError(f"cannot listen at {path}: cannot lock {name}: {error.strerror or error}") from error
    try:
        yield
    finally:
        with suppress(OSError):
            if _stands_at(file, name):
                os.unlink(name)
        os.close(file)


def _lock(name: str) -> int:
    """Return a file that is locked, and stands at this name: another server may remove its own in between."""
    import fcntl

    while True:
        with ExitStack() as stack:
            file = os.open(name, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
            stack.callback(os.close, file)
            status = os.fstat(file)
            if not stat.S_ISREG(status.st_mode) or status.st_size:
                raise CliError(f"{name} is there and is no lock file")
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _stands_at(file, name):
                stack.pop_all()
                return file


def _stands_at(file: int, name: str) -> bool:
    try:
        return os.path.samestat(os.fstat(file), os.lstat(name))
    except FileNotFoundError:
        return False


def _bind(listener: socket.socket, path: str) -> None:
    before = os.umask(0o177)
    try:
        listener.bind(path)
    finally:
        os.umask(before)
    listener.listen(QUEUE)


def _clear(path: str) -> None:
    """Remove the socket file of a process that has ended; `CliError` if the path is anything else that exists."""
    try:
        mode = os.lstat(path).st_mode
    except OSError:
        return
    if not stat.S_ISSOCK(mode):
        raise CliError(f"{path} is there and is no socket")
    try:
        if _is_left(path):
            os.unlink(path)
            return
    except FileNotFoundError:  # another process has removed it
        return
    except OSError as error:
        raise CliError(f"cannot replace {path}, which may be in use: {error.strerror or error}") from error
    raise CliError(f"another process listens at {path}")


def _is_left(path: str) -> bool:
    """Return whether no process listens at a socket any more; `OSError` if that cannot be found out."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asked:
        asked.setblocking(False)
        try:
            asked.connect(path)
        except ConnectionRefusedError:
            return True
        except BlockingIOError:  # the queue is full, so a process listens
            pass
        return False


def _ready() -> None:
    """Notify systemd that the server is ready, if it has started this process."""
    path = os.environ.get("NOTIFY_SOCKET", "")
    if path and hasattr(socket, "AF_UNIX"):
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as told:
            told.sendto(b"READY=1", f"\0{path[1:]}" if path.startswith("@") else path)
