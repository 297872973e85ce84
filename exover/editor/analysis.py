"""Analyses a text while it is edited: its diagnostics, its names and, without mistakes, its model."""

import os
from dataclasses import replace
from functools import cached_property

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.editor.symbols import Index, index_of
from exover.model.model import Model
from exover.model.property import Properties
from exover.resolve import resolve
from exover.resolve.properties import resolve_properties
from exover.source import Source, Span
from exover.syntax import tree
from exover.syntax.includes import Gathered, ReadPart, gather
from exover.syntax.parse import parse_file, parse_properties
from exover.syntax.reparse import SpecTree, reparse

Root = tree.Spec | tree.Part | tree.Properties


@dataclass(frozen=True, slots=True)
class ReadText:
    """A text that could be parsed, and its tree."""

    source: Source
    root: Root


@dataclass(frozen=True)
class TextAnalysis:
    """The analysis of a text; `last` is the newest text up to this one that could be parsed, if there was one.

    `model` is None iff it has mistakes; of a properties file it is the model of `spec`.
    For a part that one spec includes, it is the analysis of that spec, and `document` is the text of the part.
    """

    source: Source
    diagnostics: tuple[Diagnostic, ...] = ()
    last: ReadText | None = None
    model: Model | None = None
    properties: Properties | None = None
    spec: "TextAnalysis | None" = None
    order: tuple[Span, ...] = ()
    """Of a spec, the spans that make up its text with all parts, in order."""
    part: Source | None = None
    own: SpecTree | None = None
    """Of a spec, the newest text up to this one that could be parsed, without its parts, and its tree."""

    @property
    def document(self) -> Source:
        """The text of the file that was analysed, without its parts."""
        return self.part or self.source

    @property
    def mistakes(self) -> tuple[Diagnostic, ...]:
        """The diagnostics of the file that was analysed."""
        return self.of(self.document)

    def of(self, file: Source) -> tuple[Diagnostic, ...]:
        """Return the diagnostics that are placed in one of the files."""
        places = [(self.source.at(each.span.start) if each.span else self.source, each) for each in self.diagnostics]
        return tuple(each for place, each in places if place.name == file.name)

    @property
    def gathered(self) -> Gathered:
        """The spec with its parts, as one text."""
        return Gathered(self.source, None, (), self.order or (self.source.span,))

    @property
    def current(self) -> bool:
        """Whether this very text could be parsed."""
        return self.last is not None and self.last.source is self.source

    @property
    def root(self) -> Root | None:
        """The tree; None iff the text could not be parsed."""
        return self.last.root if self.last and self.current else None

    @cached_property
    def index(self) -> Index:
        """The names of the last text that could be parsed. Computed on demand, since diagnostics do not need it."""
        return index_of(self.last.root, self.spec.index if self.spec else None) if self.last else Index()


def analyse_spec(source: Source, before: TextAnalysis | None = None, read: ReadPart | None = None) -> TextAnalysis:
    """Return the analysis of a spec with its parts, incremental from that of the text `before` the change.

    If the text cannot be parsed, the names are those of `before`. `read` reads the parts.
    """
    own = before.own if before else None

    def parsed(text: Source) -> tuple[tree.Spec | None, tuple[Diagnostic, ...]]:
        nonlocal own
        found, mistakes = reparse(text, own)
        own = SpecTree(text, found) if found else own
        return found, mistakes

    whole, root, mistakes, order = gather(source, read, parsed)
    if root is None:
        return TextAnalysis(whole, mistakes, before.last if before else None, order=order, own=own)
    model, more = resolve(root, whole)
    return TextAnalysis(whole, mistakes + more, ReadText(whole, root), model, order=order, own=own)


def analyse_part(source: Source, spec: TextAnalysis | None, before: TextAnalysis | None) -> TextAnalysis:
    """Return the analysis of a part in its spec; if that does not include it, the part is only parsed."""
    place = os.path.realpath(source.name)
    part = next((each for each in spec.source.parts if os.path.realpath(each.name) == place), None) if spec else None
    if spec and part and part.text == source.text:
        return replace(spec, part=part)
    root, mistakes, _ = parse_file(source)
    if root is None:
        return TextAnalysis(source, mistakes, before.last if before else None)
    return TextAnalysis(source, mistakes, ReadText(source, root))


def analyse_properties(source: Source, spec: TextAnalysis | None, before: TextAnalysis | None = None) -> TextAnalysis:
    """Return the analysis of a properties file with its spec; without a model of that, the file is only parsed."""
    root, mistakes = parse_properties(source)
    if root is None:
        return TextAnalysis(source, mistakes, before.last if before else None, spec=spec)
    if spec is None or spec.model is None:
        return TextAnalysis(source, mistakes, ReadText(source, root), spec=spec)
    properties, more = resolve_properties(root, source, spec.model)
    return TextAnalysis(source, mistakes + more, ReadText(source, root), spec.model, properties, spec)
