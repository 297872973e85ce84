"""An editor for tests: the client of pygls, speaking to `exover lsp` over standard input and output."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import Any, TypeVar

from lsprotocol import types
from pygls.lsp.client import LanguageClient

from exover.source import Source
from tests.support.warm import SERVER, command

T = TypeVar("T")
PATIENCE = 60.0


class Editor:
    """A client whose loop runs in a thread, so that tests are plain; it keeps what is said of the newest text."""

    def __init__(self, folder: Path, encodings: tuple[str, ...] = (), seconds: float = 0.0) -> None:
        self.folder = folder
        self.loop = asyncio.new_event_loop()
        self.thread = Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        self.published: dict[str, list[types.Diagnostic]] = {}
        self.versions: dict[str, int] = {}
        self.client = self._client()
        self.run(self.client.start_io(str(command(verbs=(SERVER,))), SERVER))
        general = types.GeneralClientCapabilities(position_encodings=list(encodings) or None)
        capabilities = types.ClientCapabilities(general=general)
        options = {"checkSeconds": seconds}
        params = types.InitializeParams(capabilities, initialization_options=options)
        self.server = self.run(self.client.initialize_async(params))
        self.tell(self.client.initialized, types.InitializedParams())

    def _client(self) -> LanguageClient:
        client = LanguageClient("tests", "1")

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            if params.version == self.versions.get(params.uri):
                self.published[params.uri] = list(params.diagnostics)

        @client.feature(types.WINDOW_SHOW_MESSAGE)
        def shown(params: types.ShowMessageParams) -> None:
            pass

        return client

    def run(self, work: Coroutine[Any, Any, T] | Awaitable[T]) -> T:
        """Return what a coroutine of the client returns."""

        async def awaited() -> T:
            return await work

        return asyncio.run_coroutine_threadsafe(awaited(), self.loop).result(PATIENCE)

    def tell(self, send: Callable[[T], None], params: T) -> None:
        """Send what is not answered, in the thread of the loop: the writer belongs to it alone."""

        async def sent() -> None:
            send(params)

        self.run(sent())

    def uri(self, name: str) -> str:
        return (self.folder / name).as_uri()

    def open(self, name: str, text: str) -> str:
        """Open a text, which need not be on disk, and return its name."""
        uri = self.uri(name)
        self._next(uri)
        item = types.TextDocumentItem(uri, "exover", self.versions[uri], text)
        self.tell(self.client.text_document_did_open, types.DidOpenTextDocumentParams(item))
        return uri

    def _next(self, uri: str) -> None:
        self.versions[uri] = self.versions.get(uri, 0) + 1
        self.published.pop(uri, None)

    def change(self, uri: str, text: str) -> None:
        self._next(uri)
        identifier = types.VersionedTextDocumentIdentifier(self.versions[uri], uri)
        whole = types.TextDocumentContentChangeWholeDocument(text)
        self.tell(self.client.text_document_did_change, types.DidChangeTextDocumentParams(identifier, [whole]))

    def close(self, uri: str) -> None:
        self.published.pop(uri, None)
        closed = types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(uri))
        self.tell(self.client.text_document_did_close, closed)

    def diagnostics(
        self, uri: str, wanted: Callable[[list[types.Diagnostic]], bool] = lambda _: True
    ) -> list[types.Diagnostic]:
        """Return what is published of a text, once it is as wanted."""
        until = monotonic() + PATIENCE
        while monotonic() < until:
            found = self.published.get(uri)
            if found is not None and wanted(found):
                return found
            self.run(asyncio.sleep(0.002))
        raise TimeoutError(f"nothing such is published: {self.published.get(uri)}")

    def stop(self) -> None:
        self.run(self.client.shutdown_async(None))
        self.tell(self.client.exit, None)
        self.run(self.client.stop())
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(PATIENCE)
        self.loop.close()


def place(text: str, words: str, inside: int = 0) -> types.Position:
    """Return the place of these words in a text of ASCII; `inside`: so far in them."""
    line, column = Source("", text).position(text.index(words) + inside)
    return types.Position(line - 1, column - 1)


def at(uri: str) -> types.TextDocumentIdentifier:
    return types.TextDocumentIdentifier(uri)
