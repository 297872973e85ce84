"""Messages to a stream that perhaps nobody reads, which hold nothing up."""

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from select import select
from threading import Lock, Thread

MOST = 1 << 20
"""The most characters that wait to be written."""


class MessageWriter:
    """Writes texts to a descriptor in a thread of its own, so that no call waits for whoever reads there.

    A text that does not fit is dropped, and so is each after it until all that waited is written; then their number,
    in the words of `lost`, is written in their place. Errors of the descriptor are ignored.
    """

    def __init__(self, file: int, encoding: str, lost: Callable[[int], str]) -> None:
        self._file = file
        self._encoding = encoding
        self._lost = lost
        self._queue: SimpleQueue[str | None] = SimpleQueue()
        self._lock = Lock()
        self._characters = 0
        self._dropped = 0
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def __call__(self, text: str) -> None:
        """Queue a text, or drop it; one that is longer than `MOST` is queued if nothing waits."""
        with self._lock:
            if self._dropped or (self._characters and self._characters + len(text) > MOST):
                self._dropped += 1
            else:
                self._characters += len(text)
                self._queue.put(text)

    def close(self, patience: float) -> bool:
        """Return whether all is written; wait for that at most `patience` seconds."""
        self._queue.put(None)
        self._thread.join(patience)
        return not self._thread.is_alive()

    def _run(self) -> None:
        if hasattr(signal, "pthread_sigmask"):  # signals are for the main thread, which may wait for nothing else
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        while (text := self._queue.get()) is not None:
            self._write(text)
            if dropped := self._written(text):
                self._write(self._lost(dropped))

    def _written(self, text: str) -> int:
        """Count a text as written, and return how many were dropped if nothing waits any more, else 0."""
        with self._lock:
            self._characters -= len(text)
            if self._characters:
                return 0
            dropped, self._dropped = self._dropped, 0
            return dropped

    def _write(self, text: str) -> None:
        rest = text.encode(self._encoding, "backslashreplace")
        with suppress(OSError):
            while rest:
                try:
                    rest = rest[os.write(self._file, rest) :]
                except BlockingIOError:  # another process that has the stream does not wait for it
                    select([], [self._file], [])
