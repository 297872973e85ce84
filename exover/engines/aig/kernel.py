"""The inner loop of simulation in C, where a compiler is there."""

import ctypes
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path

from exover.engines.compiler import NativeUnavailable, compile_in, find_compiler, loaded

SOURCE = "simulate.c"
FLAGS = ("-std=c99", "-O3", "-pipe", "-shared", "-fPIC")

Kernel = Callable[[object, int, int, int, object], None]
"""`simulate` of simulate.c: values, words of a signal, signals that are known, conjunctions, and their operands."""


@cache
def kernel() -> Kernel | None:
    """Return the loop, compiled once a process, or None where that cannot be."""
    try:
        loop = loaded(_make, "cannot load it").simulate
    except NativeUnavailable:
        return None
    loop.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_void_p
    loop.restype = None
    return loop


def _make(folder: Path) -> Path:
    (folder / SOURCE).write_bytes(files(__package__).joinpath(SOURCE).read_bytes())
    compile_in(folder, [*find_compiler(), *FLAGS, SOURCE, "-o", "simulate.so"])
    return folder / "simulate.so"
