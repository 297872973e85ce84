"""Defers signals until a turn of the loop is over, since a message taken in part would leave a goal in part known."""

import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from exover.ending import heeded


class DeferredSignals:
    """A context that notes the first signal of `ENDING` and raises it again on exit. A second one takes effect at once.

    Use it in the main thread only.
    """

    def __init__(self) -> None:
        self.heard = 0
        """The number of the signal that has come, 0 if none has."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "DeferredSignals":
        """Install the handlers."""
        self._before = {number: signal.signal(number, self._note) for number in heeded()}
        return self

    def _note(self, number: int, frame: FrameType | None) -> None:
        before: Callable[[int, FrameType | None], Any] | int | None = self._before[number]
        if self.heard and callable(before):
            before(number, frame)
        self.heard = self.heard or number

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Restore the handlers, and raise the signal that has come, unless there is an exception already."""
        for number, before in self._before.items():
            signal.signal(number, before)
        if self.heard and error is None:
            signal.raise_signal(self.heard)
