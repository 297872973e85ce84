"""The inner loops of simulation in C, if there is a compiler."""

import ctypes
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from threading import Thread

from exover.dataclass import dataclass
from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler, loaded

SOURCE = "simulate.c"
WORTH = 1000
"""The number of nodes from which on the loops in C are worth it."""
FLAGS = ("-std=c99", "-O3", "-pipe", "-shared", "-fPIC")

CFunction = Callable[..., int]


@dataclass(frozen=True, slots=True)
class Kernel:
    """The functions of simulate.c, where their arguments are described."""

    mark: CFunction
    place: CFunction
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
    library.mark.argtypes = at, size, at, size, at
    library.place.argtypes = at, size, at, size, at, at
    library.simulate.argtypes = at, size, size, size, at
    library.follow.argtypes = at, size, size, at, at, at
    library.cover.argtypes = at, size, at, size, size, at, at
    library.sign.argtypes = at, size, size, at, at
    library.somewhere.argtypes = at, size, size, at, at, at
    library.mark.restype = library.simulate.restype = library.follow.restype = library.sign.restype = None
    library.place.restype = library.cover.restype = library.somewhere.restype = size
    return Kernel(
        library.mark,
        library.place,
        library.simulate,
        library.follow,
        library.cover,
        library.sign,
        library.somewhere,
    )


def kernel_for(nodes: int) -> Kernel | None:
    """Return the functions if they are worth it for a circuit or cone of so many nodes; None otherwise."""
    return kernel() if nodes >= WORTH else None


def held(memory: bytearray) -> "ctypes.Array[ctypes.c_char]":
    """Return memory as C takes it."""
    return (ctypes.c_char * len(memory)).from_buffer(memory)


def address(numbers: "array[int]") -> int:
    """Return where numbers begin in memory."""
    return numbers.buffer_info()[0]


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
