"""The engines that answer events, by name; each imports what it needs when it is chosen."""

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Literal, assert_never, get_args

if TYPE_CHECKING:
    from exover.gateway.simulate import Engine
    from exover.model.model import Model

EngineName = Literal["reference", "tables", "c"]
ENGINES: tuple[EngineName, ...] = get_args(EngineName)


def engine(name: EngineName, model: "Model") -> "AbstractContextManager[Engine]":
    """Return an engine in its initial state, to be left when it is no longer needed.

    `reference` is the reference interpreter, `tables` walks the packed tables, `c` runs the emitted C, which it compiles
    with the system's compiler.
    """
    match name:
        case "reference":
            from exover.gateway.simulate import ReferenceEngine

            return nullcontext(ReferenceEngine(model))
        case "tables":
            from exover.ocrd.machine import Machine

            return nullcontext(Machine(model, tables_of(model)))
        case "c":
            from exover.gateway.native import NativeEngine

            return NativeEngine(model, tables_of(model))
        case _:
            assert_never(name)
