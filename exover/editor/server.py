"""The language server: answers an editor about specs and properties files over standard input and output.

The editor sends whole texts (full synchronization), since pygls counts lines in another way than the protocol. One
thread analyses them in order, only the newest of each; findings come from a process that the next change ends.
"""

import asyncio
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams, PyglsError
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from exover import __version__
from exover.diagnostics import Diagnostic
from exover.editor import convert
from exover.editor.analysis import TextAnalysis
from exover.editor.completion import proposals
from exover.editor.files import Files
from exover.editor.findings import Told, findings
from exover.editor.hover import hover
from exover.editor.includes import included_at
from exover.editor.protocol import SpecProtocol, unreadable
from exover.editor.rename import RenameRefused, rename
from exover.editor.symbols import SpecSymbol
from exover.editor.text import EditorText, PositionEncoding, without_mark
from exover.places import SPEC
from exover.source import Source, Span
from exover.syntax.layout import formatted, start_of

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
        self.told: dict[str, list[Told]] = {}
        """The last findings of each spec, by its path."""
        self.closed: dict[str, set[str]] = {}
        """URIs of files that are not open and have diagnostics, by the path of the spec that they belong to."""
        self.refreshes: dict[str, asyncio.Task[None]] = {}
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
        """Take the newest text of a document, and begin to publish its diagnostics."""
        path = path_of(uri)
        self._forget(path)
        self.reader.submit(self.files.put, path, without_mark(text, self.encoding), version)
        self._begin(uri)

    def _forget(self, path: str) -> None:
        """Forget the findings placed in a file, and all findings of a spec at this path."""
        self.told = {
            spec: [each for each in told if each.file != path] for spec, told in self.told.items() if spec != path
        }

    def saved(self, uri: str) -> None:
        """Analyse and check again, since a document was saved: files may be new on disk."""
        self.reader.submit(self.files.look_anew)
        self._begin(uri)

    async def close(self, uri: str) -> None:
        """Forget a closed document, withdraw its diagnostics, and analyse open files that belong to it again.

        From now on the file on disk counts.
        """
        if refresh := self.refreshes.pop(uri, None):
            refresh.cancel()
        path, opened = path_of(uri), {each: path_of(each) for each in self.refreshes}
        self._forget(path)
        self._show(uri, [])

        def dropped() -> tuple[list[str], set[str]]:
            beside = {each: self.files.beside(file) for each, file in opened.items()}
            self.files.drop(path)
            return [each for each, files in beside.items() if path in files], set().union(*beside.values())

        near, held = await self.ask(dropped)
        for spec in self.closed.keys() - held:
            for each in self.closed.pop(spec):
                self._show(each, [])
        for each in sorted(set(near) & self.refreshes.keys(), key=lambda name: not name.endswith(SPEC))[:1]:
            self._begin(each)

    def _begin(self, uri: str) -> None:
        if before := self.refreshes.pop(uri, None):
            before.cancel()
        self.refreshes[uri] = asyncio.get_running_loop().create_task(self._refresh(uri))

    async def _refresh(self, uri: str) -> None:
        """Publish the diagnostics of a document, then of other files that may depend on it, then start the checks."""
        await asyncio.sleep(0)  # of changes that come together, only the last is analysed
        found, _ = await self.analysis(uri)
        await self._publish(uri)
        path = path_of(uri)
        if found.properties is None and path.endswith(SPEC):
            for other in list(self.refreshes):
                if other != uri and other in self.refreshes:
                    await self._publish(other)
        await self._publish_closed(path)
        if self.seconds and found.model is not None and not found.diagnostics:
            await asyncio.sleep(PAUSE)
            await self._check(path)

    async def _check(self, path: str) -> None:
        """Run the checks on the spec that a text is or belongs to, and publish the findings."""
        together = await self.ask(lambda: self.files.together(path))
        if not together:
            return
        (spec, found), *others = together
        if found.model is None or any(each.diagnostics for _, each in together) or not spec.endswith(SPEC):
            return
        properties = others[0][1].source if len(others) == 1 else None
        with suppress(OSError):  # there is no such folder, or no process can be made
            self.told[spec] = await findings(found.gathered, properties, self.seconds)
        for uri in list(self.refreshes):
            if path_of(uri) in [file.name for _, each in together for file in each.source.files]:
                await self._publish(uri)
        await self._publish_closed(path)

    async def _publish(self, uri: str) -> None:
        """Publish the diagnostics of an open document."""
        found, version = await self.numbered(uri)
        self._show(uri, self._wrong(found.document, found.mistakes), version)

    async def _publish_closed(self, path: str) -> None:
        """Publish the diagnostics of files that belong to a text and are not open; withdraw those that are gone."""
        together = await self.ask(lambda: self.files.together(path))
        if not together:
            return
        spec, opened = together[0][0], {path_of(uri) for uri in self.refreshes}
        files = [(file, found.of(file)) for _, found in together for file in found.source.files]
        shown = {self.uri(file.name): self._wrong(file, wrong) for file, wrong in files if file.name not in opened}
        wrong = {uri for uri, each in shown.items() if each}
        for uri in self.closed.get(spec, set()) - wrong:
            if path_of(uri) not in opened:
                self._show(uri, [])
        for uri in wrong:
            self._show(uri, shown[uri])
        self.closed[spec] = wrong

    def _wrong(self, file: Source, mistakes: Sequence[Diagnostic]) -> list[types.Diagnostic]:
        """Return the diagnostics of a file: its mistakes, or if there are none, the violated findings in it."""
        text = self.text_of(file)
        if mistakes:
            return [convert.mistake(text, each) for each in mistakes]
        told = [each for of in self.told.values() for each in of if each.violated and each.file == file.name]
        return [convert.finding(text, each) for each in told]

    def _show(self, uri: str, shown: list[types.Diagnostic], version: int | None = None) -> None:
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, shown, version))

    # ---- questions ----

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
        opened = next((uri for uri in self.refreshes if path_of(uri) == path), None)
        return opened or from_fs_path(path) or path


def path_of(uri: str) -> str:
    """Return the path of a `file:` URI; another URI, or one whose path has a NUL, is returned as it is."""
    path = to_fs_path(uri) if uri.startswith("file:") else None
    return path if path and "\0" not in path else uri


def make() -> SpecServer:
    """Return a server with all its features registered."""
    server = SpecServer()

    @server.feature(types.INITIALIZE)
    def begin(params: types.InitializeParams) -> None:
        options = params.initialization_options
        given = options.get("checkSeconds") if isinstance(options, dict) else None
        if isinstance(given, int | float) and not isinstance(given, bool) and 0 <= given <= 600:
            server.seconds = float(given)

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def opened(params: types.DidOpenTextDocumentParams) -> None:
        server.reader.submit(server.files.look_anew)
        server.changed(params.text_document.uri, params.text_document.text, params.text_document.version)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(params: types.DidChangeTextDocumentParams) -> None:
        uri = params.text_document.uri
        server.changed(uri, server.workspace.get_text_document(uri).source, params.text_document.version)

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def saved(params: types.DidSaveTextDocumentParams) -> None:
        server.saved(params.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(params: types.DidCloseTextDocumentParams) -> None:
        await server.close(params.text_document.uri)

    _names(server)
    _changes(server)
    return server


def _names(server: SpecServer) -> None:
    """Register hover, definition, references, symbols and completion."""

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    async def hovered(params: types.HoverParams) -> types.Hover | None:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        spec = await server.ask(lambda: server.files.spec_of(path_of(uri))) if uri.endswith(".prop") else None
        uses = {each.subject: each for of in server.told.values() for each in of if each.check == RULE_USE}
        told = hover(found, text.offset((at.line, at.character)), spec, uses)
        if told is None:
            return None
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, told[0]), convert.range_of(text, told[1]))

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    async def defined(params: types.DefinitionParams) -> list[types.Location]:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        file = None if uri.endswith(".prop") else included_at(found.document, text.offset((at.line, at.character)))
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

    @server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=["."]))
    async def completed(params: types.CompletionParams) -> list[types.CompletionItem]:
        uri, at = params.text_document.uri, params.position
        found, text = await server.analysis(uri)
        spec = await server.ask(lambda: server.files.spec_of(path_of(uri))) if uri.endswith(".prop") else None
        known = [each for each in (found, spec) if each]
        offered = proposals(found, text.offset((at.line, at.character)), start_of(found.document), spec)
        return [convert.completion(known, each) for each in offered]


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
        together = await server.ask(lambda: server.files.together(path_of(uri)))
        try:
            changes = await server.ask(lambda: rename(together, asked[0], params.new_name))
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

        actions = (convert.action(text, uri, found.document, each) for each in found.mistakes if touched(each))
        return [each for each in actions if each is not None]
