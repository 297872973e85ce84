"""The watches of a gate: what they show as readings of posters and as the status of requests."""

import math
from collections.abc import Callable, Iterable
from typing import Any

from exover.gate.binding import PosterBinding, ReportBinding, RequestBinding, Watch
from exover.gate.fields import Missing, UnreadableField, select
from exover.gate.gate import Gate
from exover.gate.outer import Alarm, SlotSaid
from exover.model.state import SlotId


class Watching:
    """Calls the watches of a binding when they are due, and tells the gate the readings and statuses that they show."""

    def __init__(self, gate: Gate, call: Callable[[Watch], None]) -> None:
        self._gate = gate
        self._call = call
        now = gate.clock()
        watches = gate.binding.watches
        self._rounds = {watch.name: 0 for watch in watches}
        self._due = {watch.name: now if watch.kind == "tool" else math.inf for watch in watches}
        self._shown = {watch.name: now for watch in watches}
        self._blind: set[str] = set()
        self._last: dict[str, tuple[Any, ...] | str] = {}
        """What was read of each poster last; a text if it could not be read: why, empty if its watch was blind."""
        self._seen: set[SlotId] = set()
        """Slots that a watch has shown as running since their launch."""
        self._before: dict[SlotId, int] = {}
        """Slots that were launched or have ended, with the number of the watch's latest round at that time."""
        self._since: dict[SlotId, int] = {}
        """Slots whose module has answered that they have started, with the number of the latest round at that time."""
        self._strange: set[tuple[str, str]] = set()

    # ---- time ----

    def due(self, ready: bool) -> float:
        """Return when a watch is stale next or, if `ready`, has to be called; infinite if never."""
        stale = (self._shown[watch.name] + watch.stale for watch in self._watches() if watch.name not in self._blind)
        return min((*(self._due.values() if ready else ()), *stale), default=math.inf)

    def tick(self, ready: bool) -> None:
        """Tell which watches are blind and, if `ready`, call those that are due."""
        now = self._gate.clock()
        for watch in self._watches():
            if ready and self._due[watch.name] <= now:
                self._rounds[watch.name] += 1
                self._due[watch.name] = now + watch.stale
                self._call(watch)
            if self._shown[watch.name] + watch.stale <= now and watch.name not in self._blind:
                self._lose(watch, f"no answer for {watch.stale:g} s")

    def _watches(self) -> tuple[Watch, ...]:
        return self._gate.binding.watches

    def _lose(self, watch: Watch, reason: str) -> None:
        self._blind.add(watch.name)
        self._gate.tell(Alarm("blind", detail=f"{watch.name}: {reason}"))
        for bound in self._gate.binding.posters:
            if bound.watch == watch.name:
                self._broken(bound)

    # ---- what was shown ----

    def begun(self, slot: SlotId, watch: str) -> None:
        """Note that the module of a slot has answered that it has started."""
        self._since[slot] = self._rounds[watch]

    def forget(self, slot: SlotId) -> None:
        """Forget what was shown of a slot that is launched anew or has ended, and what its open round will show."""
        self._seen.discard(slot)
        self._since.pop(slot, None)
        bound = self._gate.binding.of(slot[0])
        if bound is not None and bound.report.watch is not None:
            self._before[slot] = self._rounds[bound.report.watch]

    def failed(self, watch: Watch, reason: str) -> None:
        """Note that a watch could not be read; it becomes blind."""
        self._due[watch.name] = self._gate.clock() + watch.every
        if watch.name not in self._blind:
            self._lose(watch, reason)

    def shown(self, watch: Watch, document: Any) -> None:
        """Tell the gate the readings and statuses in a document that a watch has shown: a tool, at its latest call."""
        self._shown[watch.name] = self._gate.clock()
        self._blind.discard(watch.name)
        if watch.kind == "tool":
            self._due[watch.name] = self._gate.clock() + watch.every
        else:
            self._rounds[watch.name] += 1
        for poster in self._gate.binding.posters:
            if poster.watch == watch.name:
                self._read(poster, document)
        for bound in self._gate.binding.watched_by(watch.name):
            self._status(bound, watch, document)

    def _read(self, bound: PosterBinding, document: Any) -> None:
        try:
            value = bound.field.read(document)
        except UnreadableField as why:
            self._broken(bound, str(why))
            return
        found = type(value), value, self._gate.raised[bound.poster]
        if self._last.get(bound.poster) != found:
            self._last[bound.poster] = found
            self._gate.observe(bound.poster, value)

    def _broken(self, bound: PosterBinding, why: str = "") -> None:
        """Tell the gate, once in a row, that a poster cannot be read: `why` a document that was shown has no value."""
        before = self._last.get(bound.poster)
        self._last[bound.poster] = why
        if why and why != before and not self._gate.falls_back(bound.poster):
            self._gate.tell(Alarm("invalid", detail=f"{bound.poster}: {why}"))
        if not isinstance(before, str):
            self._gate.unread(bound.poster)

    def _status(self, bound: RequestBinding, watch: Watch, document: Any) -> None:
        slot, report = (bound.request, 0), bound.report
        if self._rounds[watch.name] == self._before.get(slot):
            return
        status = select(document, report.status or ())
        meaning = report.meaning(status)
        if meaning is None:
            self._unknown(bound, status)
            return
        state = self._gate.state
        held = state.slots.get(slot)
        active = meaning == "running"
        if active:
            self._seen.add(slot)
        if slot in state.unsaid or slot in state.strays or (held is None and active) or (held and held.lost and active):
            self._gate.tell(SlotSaid(slot, active))
        elif held is not None and not active and self._whole_round(slot, watch):
            self._gate.report(slot, outcome_of(report, meaning, status, document))

    def _whole_round(self, slot: SlotId, watch: Watch) -> bool:
        """Return whether the status must be about this launch, and cannot stem from before it."""
        if slot in self._seen or self._gate.state.slots[slot].lost:
            return True
        later = 0 if watch.kind == "tool" else 1
        return slot in self._since and self._rounds[watch.name] > self._since[slot] + later

    def _unknown(self, bound: RequestBinding, status: Any) -> None:
        text = (
            "no status is there" if isinstance(status, Missing) else f"the status {status!r:.60} is not in the binding"
        )
        if (bound.request, text) not in self._strange:
            self._strange.add((bound.request, text))
            self._gate.tell(Alarm("unknown-status", bound.request, 0, text))


def outcome_of(report: ReportBinding, meaning: str, status: Any, document: Any) -> dict[str, Any]:
    """Return the entries of a report event for a status of this meaning; results that cannot be read are left out."""
    if meaning == "ok":
        return {"outcome": "ok", "results": dict(_results(report, document))}
    name = report.failure(status) if meaning == "failed" else None
    return {"outcome": meaning} | ({"status": name} if name else {})


def _results(report: ReportBinding, document: Any) -> Iterable[tuple[str, Any]]:
    for field in report.results:
        try:
            yield field.name, field.read(document)
        except UnreadableField:
            continue
