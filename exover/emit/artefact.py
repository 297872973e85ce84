"""An artefact: a file that is to be written."""

from exover.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Artefact:
    """A file to be written: its name without a folder, and its bytes."""

    name: str
    content: bytes
