"""Signals that wait until what is being done is done: a message that is half taken would leave a goal half known."""

import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from exover.engines.process import ENDING


class DeferredSignals:
    """A context in which the first signal to end is only noted, and raised again at the end. A second one is not kept.

    Only in the main thread.
    """

    def __init__(self) -> None:
        self.heard = 0
        """The number of the signal that has come, 0 if none has."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "DeferredSignals":
        """Begin."""
        self._before = {number: signal.signal(number, self._note) for number in ENDING}
        return self

    def _note(self, number: int, frame: FrameType | None) -> None:
        before: Callable[[int, FrameType | None], Any] | int | None = self._before[number]
        if self.heard and callable(before):
            before(number, frame)
        self.heard = self.heard or number

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Hear signals as before, and raise the one that has come."""
        for number, before in self._before.items():
            signal.signal(number, before)
        if self.heard and error is None:
            signal.raise_signal(self.heard)
