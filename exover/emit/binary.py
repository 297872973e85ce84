"""The tables as bytes, the same bytes that every other form has (docs/runtime.md)."""

from exover.emit.artefact import Artefact
from exover.ocrd.packing import pack
from exover.ocrd.tables import Tables


def emit(tables: Tables, name: str) -> tuple[Artefact, ...]:
    """Return `name.bin`."""
    return (Artefact(f"{name}.bin", pack(tables)),)
