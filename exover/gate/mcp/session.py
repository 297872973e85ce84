"""Runs an MCP gate: starts the server, reads and writes the streams in threads, and decides in one thread."""

import os
import queue
import subprocess
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from time import monotonic
from typing import IO, Literal

from exover.dataclass import dataclass
from exover.gate.mcp.lines import LineCutter
from exover.gate.mcp.proxy import McpProxy

CHUNK = 1 << 16
PLENTY = 1000
"""The most chunks in the inbox; with more, the reading threads wait (back-pressure)."""
AT_ONCE = 16
"""The most further chunks that are taken before the deadlines are looked at again."""
UNREAD = 64 << 20
"""The most bytes that wait to be written to a side; with more, that side counts as gone."""
PATIENCE = 5.0
"""Seconds that the server has to end after its input is closed, and again after SIGTERM."""
TURN = 1.0
"""The longest wait for input in seconds, so that signals are noticed."""

Source = Literal["client", "server"]


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes that were read from a source; empty at the end of the stream."""

    source: Source
    data: bytes


class LineWriter:
    """Writes to a stream in a thread of its own, so that a peer that does not read blocks nothing else."""

    def __init__(self, file: int, gone: Callable[[], None]) -> None:
        self._file = file
        self._gone = gone
        self._queue: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._unread = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def __call__(self, line: bytes) -> None:
        """Queue a line; if more than `UNREAD` bytes wait, call `gone` in its place."""
        with self._lock:
            self._unread += len(line)
            full = self._unread > UNREAD
        if full:
            self._gone()
        else:
            self._queue.put(line)

    def close(self, patience: float) -> None:
        """Close the stream once all lines are written; wait for that at most `patience` seconds."""
        self._queue.put(None)
        self._thread.join(patience)

    def _run(self) -> None:
        try:
            while (line := self._queue.get()) is not None:
                rest = memoryview(line)
                while rest:
                    rest = rest[os.write(self._file, rest) :]
                with self._lock:
                    self._unread -= len(line)
        except OSError:
            self._gone()
        finally:
            with suppress(OSError):
                os.close(self._file)


class McpSession:
    """A client on two streams, a server in a process, and the loop that gives their lines to the proxy."""

    def __init__(self, command: Sequence[str], client: tuple[int, int]) -> None:
        """Start the server; raises `OSError` if that fails. `client`: descriptors to read from and to write to."""
        self._inbox: queue.Queue[Chunk] = queue.Queue(PLENTY)
        self._server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self._server.stdin is not None and self._server.stdout is not None
        self._deaf: set[Source] = set()
        """The sides that cannot be written to any more."""
        self.to_client = LineWriter(client[1], lambda: self._deaf.add("client"))
        self.to_server = LineWriter(_own(self._server.stdin), lambda: self._deaf.add("server"))
        self._read("client", client[0])
        self._read("server", self._server.stdout.fileno())

    def _read(self, source: Source, file: int) -> None:
        def run() -> None:
            data = b" "
            while data:
                try:
                    data = os.read(file, CHUNK)
                except OSError:
                    data = b""
                self._inbox.put(Chunk(source, data))

        threading.Thread(target=run, daemon=True).start()

    def run(self, proxy: McpProxy, longest: int) -> bool:
        """Serve until the client has gone and what runs has ended or is given up.

        Returns whether the server is still there and nothing was given up. An exception, as of a signal, counts as the
        client's end and is raised again.
        """
        self._cutters = {source: LineCutter(longest) for source in ("client", "server")}
        self._there = {"client": True, "server": True}
        proxy.start()
        try:
            while self._there["client"]:
                self._turn(proxy, TURN)
        finally:
            self._finish(proxy)
        return self._there["server"] and not proxy.active

    def _turn(self, proxy: McpProxy, most: float) -> None:
        """Wait for input at most `most` seconds or until the next deadline; take it, and do what is due."""
        with suppress(queue.Empty):
            self._take(proxy, self._inbox.get(timeout=max(0.0, min(most, proxy.due - monotonic()))))
            for _ in range(AT_ONCE):
                self._take(proxy, self._inbox.get_nowait())
        for source in tuple(self._deaf):
            if self._there[source]:
                self._gone(proxy, source)
        if proxy.due <= monotonic():
            proxy.tick()

    def _take(self, proxy: McpProxy, chunk: Chunk) -> None:
        if not self._there[chunk.source]:
            return
        if not chunk.data:
            self._gone(proxy, chunk.source)
            return
        take = proxy.from_client if chunk.source == "client" else proxy.from_server
        for line in self._cutters[chunk.source].feed(chunk.data):
            take(line)

    def _gone(self, proxy: McpProxy, source: Source) -> None:
        self._there[source] = False
        if source == "client":
            proxy.client_gone()
        else:
            proxy.server_gone()

    def _finish(self, proxy: McpProxy) -> None:
        """Stop what runs, wait for its end, and end the server; each step is done even if the one before it fails."""
        with ExitStack() as rest:
            rest.callback(self._end)
            rest.callback(self._wait, proxy)
            if self._there["client"]:
                self._gone(proxy, "client")

    def _wait(self, proxy: McpProxy) -> None:
        """Wait for what was active when the client went, at most the longest stop deadline."""
        until = monotonic() + proxy.gate.binding.longest_stop
        while self._there["server"] and proxy.active and monotonic() < until:
            self._turn(proxy, 0.1)
        proxy.give_up()

    def _end(self) -> None:
        """Close the server's input, end it, with SIGTERM and SIGKILL if need be, and flush to the client."""
        self.to_server.close(PATIENCE)
        for end in (self._server.terminate, self._server.kill):
            try:
                self._server.wait(PATIENCE)
                break
            except subprocess.TimeoutExpired:
                end()
        self._server.wait()
        self.to_client.close(PATIENCE)


def _own(stream: IO[bytes]) -> int:
    """Return a duplicate of a stream's descriptor, and close the stream."""
    file = os.dup(stream.fileno())
    stream.close()
    return file
