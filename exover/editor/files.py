"""The texts that an editor has open, and the files on disk that belong to them: specs, parts and properties files."""

import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import field, replace
from pathlib import Path

from exover.dataclass import dataclass
from exover.diagnostics import Diagnostic
from exover.editor.analysis import TextAnalysis, analyse_part, analyse_properties, analyse_spec
from exover.places import (
    SPEC,
    SUFFIX,
    find_including,
    find_properties,
    find_specs,
    is_part,
    named_after,
    read_part,
    refuse_irregular,
)
from exover.source import Source
from exover.syntax.decode import decode, unread
from exover.syntax.includes import ReadPart
from exover.syntax.lex import tokens

Together = list[tuple[str, TextAnalysis]]
"""Path and analysis of a spec, then of each of its properties files; or of a text that belongs to no spec."""


def texts_of(group: Together) -> list[list[str]]:
    """Return the texts of a spec with its parts, then those of its properties files."""
    return [[file.text for file in found.source.files] for _, found in group]


def closed_files(groups: list[Together], opened: set[str]) -> dict[str, list[tuple[Source, tuple[Diagnostic, ...]]]]:
    """Return for each file that is not open its text and diagnostics in each spec that it belongs to."""
    found: dict[str, list[tuple[Source, tuple[Diagnostic, ...]]]] = {}
    for group in groups:
        for _, analysis in group:
            for file in analysis.source.files:
                if file.name not in opened:
                    found.setdefault(file.name, []).append((file, analysis.of(file)))
    return found


@dataclass(slots=True)
class TextFile:
    """The text of a path: the editor's while it is `open`, else that on disk when the file had this `stamp`."""

    path: str
    text: str
    analysis: TextAnalysis | None = None
    open: bool = True
    version: int | None = None
    """The version number that the editor gave the text."""
    stamp: tuple[int, int] = (0, 0)
    unread: Diagnostic | None = None
    """Why the file cannot be read; None if it can."""
    spec: TextAnalysis | None = None
    """Of a properties file or a part, the analysis of its spec."""
    parts: dict[str, str | tuple[int, int] | None] = field(default_factory=dict)
    """The paths read as parts of a spec, each with its state then: the editor's text, the file's stamp, or None."""

    @property
    def is_properties(self) -> bool:
        """Whether it is a properties file."""
        return self.path.endswith(SUFFIX)

    @property
    def is_part(self) -> bool:
        """Whether it is a part of specs."""
        return not self.is_properties and next(tokens(self.text, [])).text == "part"


@dataclass(slots=True)
class Files:
    """Caches the analyses of texts. Not thread-safe: use one thread."""

    known: dict[str, TextFile] = field(default_factory=dict)
    _specs: dict[str, list[str]] = field(default_factory=dict)
    """The specs found for properties files and parts, until `look_anew`."""

    def put(self, path: str, text: str, version: int | None) -> None:
        """Take a text from the editor, with its version number."""
        before = self.known.get(path)
        file = self.known[path] = TextFile(path, text, version=version)
        if before:
            file.analysis, file.spec, file.parts = before.analysis, before.spec, before.parts

    def numbered(self, path: str) -> tuple[TextAnalysis | None, int | None]:
        """Return the analysis of a text, and its version number in the editor; None each if there is none."""
        found = self.analysis(path)
        return found, self.known[path].version if path in self.known else None

    def supposed(self, path: str, text: str) -> TextAnalysis | None:
        """Return the analysis of a text as it would be if it were another one."""
        known = {each: replace(file, parts=dict(file.parts)) for each, file in self.known.items()}
        others = Files(known, dict(self._specs))
        others.put(path, text, None)
        return others.analysis(path)

    def drop(self, path: str) -> None:
        """Forget a text that the editor has closed; the file on disk counts again."""
        self.known.pop(path, None)
        self.look_anew()

    def look_anew(self) -> None:
        """Forget which specs were found, since files may have been made or removed."""
        self._specs.clear()

    def analysis(self, path: str) -> TextAnalysis | None:
        """Return the analysis of a text, from the cache if it is still valid; None if there is no such file."""
        file = self._file(path)
        if file is None:
            return None
        spec = self.spec_of(path) if self._belongs(path) else None
        if file.analysis is None or not self._fresh(file, file.analysis) or file.spec is not spec:
            file.parts.clear()
            file.analysis, file.spec = self._analysed(file, spec), spec
        return file.analysis

    def _fresh(self, file: TextFile, analysis: TextAnalysis) -> bool:
        """Return whether an analysis is of this very text and the current state of its parts."""
        return analysis.document.text == file.text and all(self._state(path) == of for path, of in file.parts.items())

    def _state(self, path: str) -> str | tuple[int, int] | None:
        file = self.known.get(path)
        if file and file.open:
            return file.text
        try:
            return _stamp(path)
        except OSError:
            return None

    def _reader(self, file: TextFile) -> ReadPart:
        """Return a function that reads the parts of a spec, from the editor if they are open there, else from disk."""

        def read(path: str, most: int) -> bytes:
            state = file.parts[path] = self._state(path)
            if isinstance(state, str):
                return state.encode("utf-8", "surrogatepass")[:most]
            return read_part(path, most)

        return read

    def _analysed(self, file: TextFile, spec: TextAnalysis | None) -> TextAnalysis:
        if file.unread:
            return TextAnalysis(Source(file.path, ""), (file.unread,))
        source = decode(file.path, file.text.encode("utf-8", "surrogatepass"))
        if isinstance(source, Diagnostic):
            return TextAnalysis(Source(file.path, file.text), (source,))
        source = Source(file.path, file.text)
        if file.is_properties:
            return analyse_properties(source, spec, file.analysis)
        if file.is_part:
            return analyse_part(source, spec, file.analysis)
        return analyse_spec(source, file.analysis, self._reader(file) if os.path.isabs(file.path) else None)

    def spec_of(self, path: str) -> TextAnalysis | None:
        """Return the analysis of the spec that a properties file or a part belongs to; None if of none or several."""
        specs = self._found(path)
        if not path.endswith(SUFFIX):
            specs = self._open_including(path) or specs
        return self.analysis(specs[0]) if len(specs) == 1 else None

    def owners(self, path: str) -> set[str]:
        """Return the real paths of all specs that a part or a properties file belongs to.

        What specs include is what the editor has of them if it can be read, else what is on disk.
        """
        read = {each for each in self._open_specs() if (known := self.analysis(each)) and known.current}
        found = [*self._open_including(path), *(each for each in self._found(path) if each not in read)]
        return set(map(os.path.realpath, found))

    def _found(self, path: str) -> list[str]:
        """Return the specs on disk that a properties file or a part belongs to, without those that are parts now."""
        if path not in self._specs:
            with suppress(OSError):  # a folder cannot be read
                self._specs[path] = find_specs(path) if path.endswith(SUFFIX) else find_including(path)
        found = [_from(os.path.dirname(path), each) for each in self._specs.get(path, [])]
        return [each for each in found if not self._belongs(each)]

    def _open_including(self, part: str) -> list[str]:
        return [each for each in self._open_specs() if self.analysis(each) and part in self.known[each].parts]

    def _open_specs(self) -> list[str]:
        return [path for path, file in self.known.items() if file.open and path.endswith(SPEC) and not file.is_part]

    def together(self, path: str) -> Together:
        """Return path and analysis of the spec that a text is or belongs to, then of its properties files and the text.

        Parts are left out: the analysis of their spec has them.
        """
        return self._together(self._spec_path(path), [path])

    def groups(self, paths: Iterable[str]) -> list[Together]:
        """Return what is `together` with texts, each spec once."""
        members: dict[str, list[str]] = {}
        for path in paths:
            members.setdefault(self._spec_path(path), []).append(path)
        return [found for spec, those in members.items() if (found := self._together(spec, those))]

    def _spec_path(self, path: str) -> str:
        """Return the path of the spec that a text belongs to; its own if it is one, or belongs to none or several."""
        found = self.spec_of(path) if self._belongs(path) else None
        return found.source.name if found else path

    def _together(self, spec: str, paths: Iterable[str]) -> Together:
        properties = [] if self._belongs(spec) else self.properties_of(spec)
        every = dict.fromkeys([spec, *properties, *paths])
        return [(each, found) for each in every if (found := self.analysis(each)) and not found.part]

    def is_part(self, path: str) -> bool:
        """Return whether a file is a part, as the editor has it if it is open, else as it is on disk."""
        file = self.known.get(path)
        if file and file.open:
            return file.is_part
        try:
            return is_part(path)
        except OSError:
            return False

    def _belongs(self, path: str) -> bool:
        """Return whether a text is a properties file or a part, which belong to specs."""
        file = self._file(path)
        return file is not None and (file.is_properties or file.is_part)

    def properties_of(self, spec: str) -> list[str]:
        """Return the paths of the properties files of a spec on disk, or just of the first that cannot be read."""
        try:
            name = named_after(Path(spec), "spec") or ""
            return [os.path.abspath(each) for each in find_properties(spec, name)]
        except OSError as error:
            return [os.path.abspath(error.filename)] if str(error.filename).endswith(SUFFIX) else []

    def _file(self, path: str) -> TextFile | None:
        """Return a text, read again if it is not open and has changed on disk; None if it cannot be read, except for an
        existing properties file.
        """
        file = self.known.get(path)
        if file and file.open:
            return file
        try:
            refuse_irregular(path)
            stamp = _stamp(path)
            if file is None or file.stamp != stamp:
                content = Path(path).read_bytes()
                source = decode(path, content)
                text = source.text if isinstance(source, Source) else content.decode(errors="surrogateescape")
                file = self.known[path] = TextFile(path, text, open=False, stamp=stamp)
        except OSError as error:
            if not (path.endswith(SUFFIX) and os.path.lexists(path)):
                return None
            return TextFile(path, "", open=False, unread=unread(error))
        return file


def _from(folder: str, file: str) -> str:
    """Return the path of a file as an editor spells it that has a folder near it open, perhaps behind a link."""
    place, name = os.path.split(os.path.abspath(file))
    near = os.path.relpath(os.path.realpath(place), os.path.realpath(folder))
    spelt = os.path.normpath(os.path.join(folder, near, name))
    return spelt if os.path.realpath(spelt) == os.path.realpath(file) else os.path.join(place, name)


def _stamp(path: str) -> tuple[int, int]:
    status = os.stat(path)
    return status.st_mtime_ns, status.st_size
