"""The language server: answers an editor about specs and properties files over standard input and output.

The editor sends whole texts (full synchronization), since pygls counts lines in another way than the protocol. One
thread analyses them in order, only the newest of each; findings come from a process that the next change ends.
"""

import asyncio
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams, PyglsError
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path

from exover import __version__
from exover.diagnostics import Diagnostic
from exover.editor import convert
from exover.editor.analysis import TextAnalysis
from exover.editor.completion import proposals
from exover.editor.convert import path_of
from exover.editor.files import Files, Together, closed_files, texts_of
from exover.editor.findings import PlacedFinding, TextFindings, findings
from exover.editor.fixes import fixes
from exover.editor.hover import hover
from exover.editor.includes import included_at, proposed_paths, written_at
from exover.editor.protocol import SpecProtocol, unreadable
from exover.editor.rename import RenameRefused, rename_everywhere
from exover.editor.symbols import SpecSymbol
from exover.editor.text import EditorText, PositionEncoding, without_mark
from exover.places import SPEC, SUFFIX
from exover.source import Source, Span
from exover.syntax.layout import formatted, start_of

WATCHED = ("**/*.exo", "**/*.prop", "**/exover.toml")
RULE_USE = "rule-use"
PAUSE = 0.3
"""Seconds without a change before checks are started."""
SECONDS = 1.0
"""The default of `checkSeconds`: seconds that checks have; with 0 none are started."""

T = TypeVar("T")


class SpecServer(LanguageServer):
    """The language server of one editor."""

    def __init__(self) -> None:
        super().__init__("exover", __version__, types.TextDocumentSyncKind.Full, protocol_cls=SpecProtocol)
        self.files = Files()
        self.seconds = SECONDS
        self.opened: dict[str, str] = {}
        """The path of each open document, by its URI."""
        self.shown: dict[str, tuple[int | None, list[types.Diagnostic]]] = {}
        """What was published last of each URI, with the version; nothing of files that are not open and well."""
        self.checked: dict[str, TextFindings] = {}
        """The last findings of each spec, by its path."""
        self.checks_wanted = True
        """Whether all checks are to be started again, since files on disk may have changed."""
        self.refresh: asyncio.Task[None] | None = None
        self.reader = ThreadPoolExecutor(1, "reader")

    def report_server_error(self, error: Exception, source: type[PyglsError | JsonRpcException]) -> None:
        """Answer bytes that are no JSON with an error response; leave other errors to pygls."""
        refused = unreadable(error) if source is JsonRpcException else None
        if refused and isinstance(self.protocol, SpecProtocol):
            self.protocol.refuse(refused)
        else:
            super().report_server_error(error, source)

    # ---- texts ----

    async def ask(self, question: Callable[[], T]) -> T:
        """Return the result of a function that uses `files`, run in the one thread that may use them."""
        return await asyncio.get_running_loop().run_in_executor(self.reader, question)

    async def analysis(self, uri: str) -> tuple[TextAnalysis, EditorText]:
        """Return the analysis of a document, and its text with the places of the protocol."""
        found, _ = await self.numbered(uri)
        return found, self.text(found)

    async def numbered(self, uri: str) -> tuple[TextAnalysis, int | None]:
        """Return the analysis of a document, and its version number; raises `JsonRpcInvalidParams` if there is none."""
        path = path_of(uri)
        found, version = await self.ask(lambda: self.files.numbered(path))
        if found is None:
            raise JsonRpcInvalidParams(f"{path} is not open")
        return found, version

    def text(self, found: TextAnalysis) -> EditorText:
        """Return the text of an analysis, with places in the client's encoding."""
        return self.text_of(found.document)

    def text_of(self, file: Source) -> EditorText:
        """Return the text of a file, with places in the client's encoding."""
        return EditorText(file.text, self.encoding, file.base)

    @property
    def encoding(self) -> PositionEncoding:
        """The position encoding that client and server agreed on; UTF-16 by default."""
        chosen = self.server_capabilities.position_encoding or types.PositionEncodingKind.Utf16
        return convert.ENCODINGS[str(getattr(chosen, "value", chosen))]

    def changed(self, uri: str, text: str, version: int | None) -> None:
        """Take the newest text of a document, and begin to publish diagnostics."""
        path = self.opened[uri] = path_of(uri)
        self.reader.submit(self.files.put, path, without_mark(text, self.encoding), version)
        self._begin(uri)

    def look_anew(self) -> None:
        """Analyse and check again, since files may be new on disk, or others."""
        self.reader.submit(self.files.look_anew)
        self.checks_wanted = True
        self._begin()

    def close(self, uri: str) -> None:
        """Forget a closed document, of which from now on the file on disk counts; withdraw its diagnostics."""
        self.reader.submit(self.files.drop, self.opened.pop(uri))
        self._show(uri, [])
        self._begin()

    def _begin(self, uri: str = "") -> None:
        """Begin to publish diagnostics, first those of one document; what was begun before is ended."""
        if self.refresh:
            self.refresh.cancel()
        self.refresh = asyncio.get_running_loop().create_task(self._refresh(uri))

    async def _refresh(self, uri: str) -> None:
        """Publish what is wrong with a document, then what is wrong with all files, then start the checks."""
        await asyncio.sleep(0)  # of changes that come together, only the last is analysed
        if uri:
            found, version = await self.ask(lambda: self.files.numbered(self.opened[uri]))
            if found and found.mistakes:
                self._show(uri, self._mistakes(found.document, found.mistakes), version)
        groups = await self._publish()
        if self.seconds:
            await asyncio.sleep(PAUSE)
            for group in groups:
                await self._check(group)
            self.checks_wanted = False

    async def _check(self, group: Together) -> None:
        """Run the checks on a spec with its properties, unless they have been run, and publish the findings."""
        (spec, found), *others = group
        if found.model is None or any(each.diagnostics for _, each in group) or not spec.endswith(SPEC):
            return
        known = self.checked.get(spec)
        if known and known.texts == texts_of(group) and not self.checks_wanted:
            return
        properties = others[0][1].source if len(others) == 1 else None
        with suppress(OSError):  # there is no such folder, or no process can be made
            told = await findings(found.gathered, properties, self.seconds)
            self.checked[spec] = TextFindings(texts_of(group), told)
        await self._publish()

    async def _publish(self) -> list[Together]:
        """Publish the diagnostics of all open documents and of the files that belong to them; return these by specs."""
        paths = list(self.opened.values())
        numbered, groups = await self.ask(lambda: (list(map(self.files.numbered, paths)), self.files.groups(paths)))
        self.checked = {group[0][0]: each for group in groups if (each := self.checked.get(group[0][0]))}
        told = [each for group in groups for each in self._told(group) if each.violated]
        wanted: dict[str, tuple[int | None, list[types.Diagnostic]]] = {}
        for uri, (found, version) in zip(self.opened, numbered, strict=True):
            if found:
                wanted[uri] = version, self._wrong([(found.document, found.mistakes)], told)
        for path, places in closed_files(groups, set(paths)).items():
            if wrong := self._wrong(places, told):
                wanted[self.uri(path)] = None, wrong
        for uri in self.shown.keys() - wanted.keys():
            self._show(uri, [])
        for uri, (version, wrong) in wanted.items():
            self._show(uri, wrong, version)
        return groups

    def _told(self, group: Together) -> list[PlacedFinding]:
        """Return the findings of a spec; none if they are of other texts."""
        known = self.checked.get(group[0][0])
        return known.told if known and known.texts == texts_of(group) else []

    def _mistakes(self, file: Source, mistakes: Sequence[Diagnostic]) -> list[types.Diagnostic]:
        return [convert.mistake(self.text_of(file), each) for each in mistakes]

    def _wrong(
        self, places: Sequence[tuple[Source, Sequence[Diagnostic]]], told: list[PlacedFinding]
    ) -> list[types.Diagnostic]:
        """Return the diagnostics of a file: its mistakes in each spec, or if there are none, the findings in it."""
        mistakes = [each for file, wrong in places for each in self._mistakes(file, wrong)]
        if not mistakes:
            file = places[0][0]
            mistakes = [convert.finding(self.text_of(file), each) for each in told if each.file == file.name]
        return [each for number, each in enumerate(mistakes) if each not in mistakes[:number]]

    def _show(self, uri: str, wrong: list[types.Diagnostic], version: int | None = None) -> None:
        """Publish the diagnostics of a file if others were published before."""
        before = self.shown.get(uri)
        if before == (version, wrong) or (before is None and not wrong and uri not in self.opened):
            return
        self.shown[uri] = version, wrong
        if uri not in self.opened and not wrong:
            del self.shown[uri]
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, wrong, version))

    # ---- questions ----

    async def spec(self, uri: str) -> TextAnalysis | None:
        """Return the analysis of the spec that a properties file is read with; None if there is none."""
        path = path_of(uri)
        return await self.ask(lambda: self.files.spec_of(path)) if path.endswith(SUFFIX) else None

    def told(self, spec: TextAnalysis) -> list[PlacedFinding]:
        """Return the findings of a spec; none if they are of another text."""
        known = self.checked.get(spec.source.name)
        return known.told if known and known.texts[0] == [file.text for file in spec.source.files] else []

    async def symbol(self, uri: str, at: types.Position) -> tuple[SpecSymbol, Span, TextAnalysis] | None:
        """Return symbol, span and analysis of the name at a position; None if there is none or the text has no tree."""
        found, text = await self.analysis(uri)
        name = found.index.at(text.offset((at.line, at.character)))
        return (name.symbol, name.span, found) if name and found.current else None

    async def places(self, uri: str, at: types.Position, declared: bool | None) -> list[types.Location]:
        """Return where the symbol at a position is named, in all files of its spec.

        `declared`: True for declarations only, False for uses only, None for both.
        """
        asked = await self.symbol(uri, at)
        if asked is None:
            return []
        together = await self.ask(lambda: self.files.together(path_of(uri)))
        found = []
        for _, each in together:
            for name in each.index.of(asked[0]):
                if each.current and (declared is None or name.declares is declared):
                    file = each.source.at(name.span.start)
                    place = convert.range_of(self.text_of(file), name.span)
                    found.append(types.Location(self.uri(file.name), place))
        return found

    def uri(self, path: str) -> str:
        """Return the URI of a path: the one by which the client has opened it, if it has."""
        opened = next((uri for uri, each in self.opened.items() if each == path), None)
        return opened or from_fs_path(path) or path


def make() -> SpecServer:
    """Return a server with all its features registered."""
    server = SpecServer()

    @server.feature(types.INITIALIZE)
    def begin(params: types.InitializeParams) -> None:
        options = params.initialization_options
        given = options.get("checkSeconds") if isinstance(options, dict) else None
        if isinstance(given, int | float) and not isinstance(given, bool) and 0 <= given <= 600:
            server.seconds = float(given)

    @server.feature(types.INITIALIZED)
    def begun(_: types.InitializedParams) -> None:
        _watch(server)

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def opened(params: types.DidOpenTextDocumentParams) -> None:
        server.reader.submit(server.files.look_anew)
        server.changed(params.text_document.uri, params.text_document.text, params.text_document.version)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(params: types.DidChangeTextDocumentParams) -> None:
        uri = params.text_document.uri
        server.changed(uri, server.workspace.get_text_document(uri).source, params.text_document.version)

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def saved(_: types.DidSaveTextDocumentParams) -> None:
        server.look_anew()

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    async def seen(_: types.DidChangeWatchedFilesParams) -> None:
        server.look_anew()

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(params: types.DidCloseTextDocumentParams) -> None:
        server.close(params.text_document.uri)

    _names(server)
    _changes(server)
    return server


def _watch(server: SpecServer) -> None:
    """Ask the editor to tell which files change on disk, if it can."""
    workspace = server.client_capabilities.workspace
    watched = workspace.did_change_watched_files if workspace else None
    if watched and watched.dynamic_registration:
        options = types.DidChangeWatchedFilesRegistrationOptions(list(map(types.FileSystemWatcher, WATCHED)))
        registration = types.Registration("watched", types.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
        server.client_register_capability(types.RegistrationParams([registration]))


def _names(server: SpecServer) -> None:
    """Register hover, definition, references, symbols and completion."""

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    async def hovered(params: types.HoverParams) -> types.Hover | None:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        spec = await server.spec(uri)
        uses = {each.subject: each for each in server.told(spec or found) if each.check == RULE_USE}
        told = hover(found, text.offset((at.line, at.character)), spec, uses)
        if told is None:
            return None
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, told[0]), convert.range_of(text, told[1]))

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    async def defined(params: types.DefinitionParams) -> list[types.Location]:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        offset = text.offset((at.line, at.character))
        file = None if path_of(uri).endswith(SUFFIX) else included_at(found.document, offset)
        if file and os.path.isfile(file):
            return [types.Location(server.uri(file), convert.range_of(EditorText(""), Span(0, 0)))]
        return await server.places(uri, at, True)

    @server.feature(types.TEXT_DOCUMENT_REFERENCES)
    async def referred(params: types.ReferenceParams) -> list[types.Location]:
        declared = None if params.context.include_declaration else False
        return await server.places(params.text_document.uri, params.position, declared)

    @server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def outlined(params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        found, text = await server.analysis(params.text_document.uri)
        return convert.outline(text, found)

    @server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", "/", '"']))
    async def completed(params: types.CompletionParams) -> list[types.CompletionItem]:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        offset = text.offset((at.line, at.character))
        is_spec = not path_of(uri).endswith(SUFFIX)
        if is_spec and (written := await server.ask(partial(written_at, found.document, offset))):
            paths = partial(proposed_paths, found.document.name, written.before, server.files.is_part)
            return [convert.path_completion(text, written, each) for each in await server.ask(paths)]
        spec = await server.spec(uri)
        offered = await server.ask(lambda: proposals(found, offset, start_of(found.document), spec))
        return [convert.completion([found, *([spec] if spec else [])], each) for each in offered]


def _changes(server: SpecServer) -> None:
    """Register rename, formatting and code actions."""

    @server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    async def prepared(params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder | None:
        asked = await server.symbol(params.text_document.uri, params.position)
        if asked is None:
            return None
        _, span, found = asked
        return types.PrepareRenamePlaceholder(convert.range_of(server.text(found), span), found.source.slice(span))

    @server.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
    async def renamed(params: types.RenameParams) -> types.WorkspaceEdit:
        uri = params.text_document.uri
        asked = await server.symbol(uri, params.position)
        if asked is None:
            raise JsonRpcInvalidParams("no name stands here")
        try:
            changes = await server.ask(lambda: rename_everywhere(server.files, path_of(uri), asked[0], params.new_name))
        except RenameRefused as reason:
            raise JsonRpcInvalidParams(str(reason)) from reason
        edits = {}
        for change in changes:
            ranges = [convert.range_of(server.text_of(change.file), span) for span in change.spans]
            edits[server.uri(change.path)] = [types.TextEdit(each, params.new_name) for each in ranges]
        return types.WorkspaceEdit(edits)

    @server.feature(types.TEXT_DOCUMENT_FORMATTING)
    async def laid_out(params: types.DocumentFormattingParams) -> list[types.TextEdit]:
        found, text = await server.analysis(params.text_document.uri)
        result, _ = await server.ask(lambda: formatted(found.document))
        if result is None or result == text.text:
            return []
        return [types.TextEdit(convert.range_of(text, found.document.span), result)]

    @server.feature(
        types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix])
    )
    async def offered(params: types.CodeActionParams) -> list[types.CodeAction]:
        uri = params.text_document.uri
        found, text = await server.analysis(uri)
        start, end = (text.offset((at.line, at.character)) for at in (params.range.start, params.range.end))

        def touched(each: Diagnostic) -> bool:
            return each.span is not None and each.span.start <= end and start <= each.span.end

        near = list(filter(touched, found.mistakes))
        found_fixes = await server.ask(lambda: list(fixes(server.files, path_of(uri), found.document, near)))
        return [convert.action(text, uri, each, change) for each, change in found_fixes]
