"""What runs at an action server and was not launched by this gate: found, stopped, and known to have ended."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from exover.gate.binding import RequestBinding
from exover.gate.outer import Alarm, SlotSaid
from exover.gate.ros2 import cdr
from exover.gate.ros2.goals import ActionGoal
from exover.gate.ros2.names import PortPart
from exover.gate.ros2.outside import Outside
from exover.model.state import SlotId

AGAIN = 0.5
"""Seconds after which a server that has not answered is asked again."""
ToServer = Callable[[PortPart, bytes, object], None]


class Strays:
    """Goals of others at one server. Those that it names in its status are known by id; what it has when it comes, by
    the answer to a cancel of all goals.

    Nothing is believed of a server before it has answered: one that does not know the readers of the gate yet sends
    what is lost.
    """

    def __init__(
        self,
        outside: Outside,
        bounds: Sequence[RequestBinding],
        to_server: ToServer,
        slots: Mapping[SlotId, ActionGoal],
    ) -> None:
        self._outside = outside
        self._requests = [each.request for each in bounds]
        self._to_server = to_server
        self._slots = slots
        self._shown: dict[bytes, SlotId | None] = {}
        """Goals of others that the status array shows, and the slot that is taken for each."""
        self._asked_about: SlotId | None = None
        """The slot that stands for what the server has said to run."""
        self._starts_idle = all(each.starts_idle for each in bounds)
        self._question = cdr.NO_ID
        """Which goal the server is asked to cancel; `NO_ID` stands for all."""
        self._before = False
        """Whether the process of the server has been there before."""
        self.due = math.inf
        """When the server is asked again; infinite once it has answered."""

    def gone(self) -> None:
        """Forget what ran: the server is gone."""
        self._shown.clear()
        self._asked_about = None
        self.due = math.inf

    # ---- the question ----

    def came(self, active: Iterable[bytes], before: bool) -> None:
        """Ask a server that is there now, whose status shows goals of others to be `active`; `before` iff its process
        has been there before.
        """
        self._before = before
        self._question = self._outside.new_id() if self._starts_idle else cdr.NO_ID
        self.shown(active)
        self.ask()

    def ask(self) -> None:
        """Ask the server to cancel all goals: what it cancels is what runs. One that starts idle is asked to cancel a
        goal that nobody has: that it answers is all that it says.
        """
        self.due = self._outside.clock() + AGAIN
        self._to_server("cancel_goal", cdr.cancel_request(self._question), "question")

    def answered(self, code: int, ids: Sequence[bytes]) -> None:
        """Take the answer: which goals run, or that something runs and is not stopped."""
        if self.due == math.inf:
            return
        if self._starts_idle:
            self._reached()
            return
        lost = {goal.id: slot for slot, goal in self._slots.items()}
        for id, slot in lost.items():
            self._lost(slot, id in ids)
        foreign = any(id not in lost and id not in self._shown for id in ids)
        if foreign or (code == cdr.CANCEL_REJECTED and not self._shown):
            self._asked_about = self._asked_about or self._free()
            if self._asked_about:
                self._outside.gate.tell(SlotSaid(self._asked_about, True))
        else:
            self.due, self._asked_about = math.inf, None
        kept = {self._asked_about, *self._shown.values(), *self._slots}
        for slot in self._mine(self._outside.gate.state.unsaid):
            if slot not in kept:
                self._outside.gate.tell(SlotSaid(slot, False))

    def _reached(self) -> None:
        """Believe a server that starts idle to run nothing, but for what its process may have had before."""
        self.due = math.inf
        for slot in self._mine(self._outside.gate.state.unsaid):
            goal = self._slots.get(slot)
            if goal is not None and self._before:
                self._to_server("get_result", goal.id, goal)
            elif slot not in self._outside.gate.state.strays:
                self._outside.gate.tell(SlotSaid(slot, False))

    def _lost(self, slot: SlotId, active: bool) -> None:
        """Say of a goal of this gate whether it still runs at a server that has come back."""
        if not self._outside.gate.state.slots[slot].lost:
            return
        if active:
            self._to_server("get_result", self._slots[slot].id, self._slots[slot])
        self._outside.gate.tell(SlotSaid(slot, active))

    # ---- the status array ----

    def shown(self, ids: Iterable[bytes]) -> None:
        """Take which goals of others are active, as the server shows them."""
        now = set(ids)
        for id in now - self._shown.keys():
            if self._asked_about is None:
                slot = self._shown[id] = self._free()
                if slot is None:
                    self._outside.gate.tell(Alarm("stray", self._requests[0], None, f"the goal {id.hex()} runs"))
                    self._cancel(id)
                else:
                    self._outside.gate.tell(SlotSaid(slot, True))
        for id in self._shown.keys() - now:
            slot = self._shown.pop(id)
            if slot is not None:
                self._outside.gate.tell(SlotSaid(slot, False))

    def stop(self, slot: SlotId) -> None:
        """Cancel what the status array has shown in a slot; what was asked about is cancelled by the question."""
        for id, each in self._shown.items():
            if each == slot:
                self._cancel(id)

    def _cancel(self, id: bytes) -> None:
        self._to_server("cancel_goal", cdr.cancel_request(id), "stray")

    def _free(self) -> SlotId | None:
        """Return a slot in which nothing runs that the gate knows of."""
        state = self._outside.gate.state
        taken = {*state.slots, *self._shown.values()}
        model = self._outside.gate.model
        every = [(name, slot) for name in self._requests for slot in range(model.request[name].instances)]
        return next((slot for slot in every if slot not in taken), None)

    def _mine(self, slots: Iterable[SlotId]) -> list[SlotId]:
        return sorted(slot for slot in slots if slot[0] in self._requests)
