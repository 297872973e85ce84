"""What is known of a text while it is written: its mistakes, its names and, without mistakes, its model."""

from dataclasses import dataclass, field

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
class TextAnalysis:
    """A text and what is known of it.

    `root` is None iff it cannot be read, `model` iff it has mistakes (of a properties file: the model is that of its
    spec). `index` has the names of the text `named`: this very one, or the last one that could be read.
    """

    source: Source
    diagnostics: tuple[Diagnostic, ...] = ()
    root: tree.Spec | tree.Properties | None = None
    model: Model | None = None
    properties: Properties | None = None
    index: Index = field(default_factory=Index)
    named: Source | None = None

    @property
    def current(self) -> bool:
        """Whether the names are those of this text."""
        return self.named is self.source


def analyse_spec(source: Source, before: TextAnalysis | None = None) -> TextAnalysis:
    """Return what is known of a spec; if it cannot be read, its names are those of the text before."""
    root, mistakes = parse(source)
    if root is None:
        return _unread(source, mistakes, before)
    model, more = resolve(root, source)
    return TextAnalysis(source, mistakes + more, root, model, None, index_of(root), source)


def analyse_properties(source: Source, spec: TextAnalysis | None, before: TextAnalysis | None = None) -> TextAnalysis:
    """Return what is known of a properties file beside that of its spec; without its spec, only how it is written."""
    root, mistakes = parse_properties(source)
    if root is None:
        return _unread(source, mistakes, before)
    index = index_of(root, spec.index if spec else None)
    if spec is None or spec.model is None:
        return TextAnalysis(source, mistakes, root, None, None, index, source)
    properties, more = resolve_properties(root, source, spec.model)
    return TextAnalysis(source, mistakes + more, root, spec.model, properties, index, source)


def _unread(source: Source, mistakes: tuple[Diagnostic, ...], before: TextAnalysis | None) -> TextAnalysis:
    if before is None:
        return TextAnalysis(source, mistakes)
    return TextAnalysis(source, mistakes, index=before.index, named=before.named)
