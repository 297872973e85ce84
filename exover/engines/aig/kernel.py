"""The inner loops of simulation in C, if there is a compiler."""

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from threading import Thread

from exover.dataclass import dataclass
from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler, loaded

SOURCE = "simulate.c"
FLAGS = ("-std=c99", "-O3", "-pipe", "-shared", "-fPIC")

CFunction = Callable[..., int]


@dataclass(frozen=True, slots=True)
class Kernel:
    """The functions of simulate.c, where their arguments are described."""

    simulate: CFunction
    follow: CFunction
    cover: CFunction
    sign: CFunction
    somewhere: CFunction


@cache
def kernel() -> Kernel | None:
    """Return the functions, compiled once a process; None if they cannot be compiled or loaded."""
    try:
        library = loaded(_make, "cannot load it")
    except NativeUnavailable:
        return None
    size, at = ctypes.c_size_t, ctypes.c_void_p
    library.simulate.argtypes = at, size, size, size, at
    library.follow.argtypes = at, size, size, at, at, at
    library.cover.argtypes = at, size, at, size, size, at, at
    library.sign.argtypes = at, size, size, at, at
    library.somewhere.argtypes = at, size, size, at, at, at
    library.simulate.restype = library.follow.restype = library.sign.restype = None
    library.cover.restype = library.somewhere.restype = size
    return Kernel(library.simulate, library.follow, library.cover, library.sign, library.somewhere)


@contextmanager
def compiled_beside() -> Iterator[None]:
    """Compile the loops in a thread while the body does other work, and join the thread at its end.

    If the body raises, the compiler is not waited for.
    """
    thread = Thread(target=kernel, daemon=True)
    thread.start()
    yield
    thread.join()


def _make(folder: Path) -> Path:
    (folder / SOURCE).write_bytes(files(__package__).joinpath(SOURCE).read_bytes())
    compile_in(folder, [*find_compiler(), *FLAGS, SOURCE, "-o", "simulate.so"], "simulate.so")
    return folder / "simulate.so"
