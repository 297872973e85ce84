"""The toolkit on one page: text -> Model -> Tables -> Findings -> Artefacts.

Every step is a pure function from one value to the next; nothing here prints or touches a file. Steps import what they
need when they are taken, so that a simulation on the reference interpreter pays for no diagram.
"""

from dataclasses import dataclass

from exover.diagnostics import Diagnostic
from exover.model.model import Model
from exover.source import Source


@dataclass(frozen=True, slots=True)
class Loaded:
    """What became of a text: its model iff nothing is wrong with it, and its diagnostics in the order of the text."""

    model: Model | None
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Artefact:
    """A file to be written: its name without a folder, and its bytes."""

    name: str
    content: bytes


def load(source: Source) -> Loaded:
    """Return the model of a spec, or what is wrong with it."""
    from exover.resolve import resolve
    from exover.syntax.parse import parse

    spec, mistakes = parse(source)
    if spec is None:
        return Loaded(None, mistakes)
    model, more = resolve(spec, source)
    return Loaded(model, mistakes + more)
