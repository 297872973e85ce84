"""The tables as bytes, the same bytes that every other form has (docs/runtime.md)."""

from exover.emit.artefact import Artefact
from exover.model.model import Model
from exover.ocrd.packing import pack
from exover.ocrd.tables import Tables


def emit(model: Model, tables: Tables) -> tuple[Artefact, ...]:
    """Return `NAME.bin`."""
    return (Artefact(f"{model.name}.bin", pack(tables)),)
