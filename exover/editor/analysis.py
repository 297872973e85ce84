"""What is known of a text while it is written: its mistakes, its names and, without mistakes, its model."""

from dataclasses import dataclass
from functools import cached_property

from exover.diagnostics import Diagnostic
from exover.editor.symbols import Index, index_of
from exover.model.model import Model
from exover.model.property import Properties
from exover.resolve import resolve
from exover.resolve.properties import resolve_properties
from exover.source import Source
from exover.syntax import tree
from exover.syntax.parse import parse, parse_properties


@dataclass(frozen=True, slots=True)
class ReadText:
    """A text that could be read, and its tree."""

    source: Source
    root: tree.Spec | tree.Properties


@dataclass(frozen=True)
class TextAnalysis:
    """A text and what is known of it; `last` is the newest text up to this one that could be read, if there was one.

    `model` is None iff it has mistakes; of a properties file it is the model of `spec`.
    """

    source: Source
    diagnostics: tuple[Diagnostic, ...] = ()
    last: ReadText | None = None
    model: Model | None = None
    properties: Properties | None = None
    spec: "TextAnalysis | None" = None

    @property
    def current(self) -> bool:
        """Whether this very text could be read."""
        return self.last is not None and self.last.source is self.source

    @property
    def root(self) -> tree.Spec | tree.Properties | None:
        """The tree; None iff the text could not be read."""
        return self.last.root if self.last and self.current else None

    @cached_property
    def index(self) -> Index:
        """The names of the last text that could be read. Made when it is asked for: mistakes are told without it."""
        return index_of(self.last.root, self.spec.index if self.spec else None) if self.last else Index()


def analyse_spec(source: Source, before: TextAnalysis | None = None) -> TextAnalysis:
    """Return what is known of a spec, and of the text `before` it if it cannot be read."""
    root, mistakes = parse(source)
    if root is None:
        return TextAnalysis(source, mistakes, before.last if before else None)
    model, more = resolve(root, source)
    return TextAnalysis(source, mistakes + more, ReadText(source, root), model)


def analyse_properties(source: Source, spec: TextAnalysis | None, before: TextAnalysis | None = None) -> TextAnalysis:
    """Return what is known of a properties file beside that of its spec; without its spec, only how it is written."""
    root, mistakes = parse_properties(source)
    if root is None:
        return TextAnalysis(source, mistakes, before.last if before else None, spec=spec)
    if spec is None or spec.model is None:
        return TextAnalysis(source, mistakes, ReadText(source, root), spec=spec)
    properties, more = resolve_properties(root, source, spec.model)
    return TextAnalysis(source, mistakes + more, ReadText(source, root), spec.model, properties, spec)
