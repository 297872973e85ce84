"""An artefact: a file that is to be written, or a file of the runtime that comes with exover."""

from importlib.resources import files

from exover.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Artefact:
    """A file to be written: its name without a folder, and its bytes."""

    name: str
    content: bytes


def runtime_file(name: str) -> bytes:
    """Return a file of the runtime, in C or, by a name in `rust/`, in Rust."""
    return files("exover").joinpath("runtime", *name.split("/")).read_bytes()
