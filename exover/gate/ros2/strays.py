"""Stray goals: finds goals at an action server that this gate did not launch, cancels them, and notes their end."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import chain, count, repeat

from exover.gate.binding import RequestBinding
from exover.gate.outer import SlotSaid
from exover.gate.ros2 import cdr
from exover.gate.ros2.goals import ActionGoal
from exover.gate.ros2.names import PortPart
from exover.gate.ros2.outside import Outside
from exover.model.state import SlotId

AGAIN = 0.5
"""Seconds after which a request to a server is repeated that it has not answered."""
ToServer = Callable[[PortPart, bytes, object], None]


class Strays:
    """Stray goals at one server. The status array tells their ids; what runs when the server comes, its answer to a
    cancel of all goals tells.

    No slot counts as idle before the server has answered. A server that has not discovered the gate's readers yet loses
    its answers.
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
        self._shown: dict[bytes, SlotId] = {}
        """The stray goals in the status array, with the slot that each is assigned."""
        self._listed: frozenset[bytes] = frozenset()
        """The stray goals in the last status array, with a slot or not yet."""
        self._asked_about: SlotId | None = None
        """The slot that stands for whatever the answer to the question says to run."""
        self._starts_idle = all(each.starts_idle for each in bounds)
        self._question = cdr.NO_ID
        """The id of the goal that the server is asked to cancel; `NO_ID` means all."""
        self._before = False
        """Whether the process of the server has served before."""
        self._array_due = math.inf
        """Until when a status array may come that is older than an answer; infinite before the first answer, and past
        once an array has come."""
        self.due = math.inf
        """When the server is asked again; infinite once it has answered that nothing stray runs."""

    def gone(self) -> None:
        """Forget all stray goals, since the server has gone."""
        self._shown.clear()
        self._listed = frozenset()
        self._asked_about = None
        self.due = math.inf

    # ---- the question ----

    def came(self, active: Iterable[bytes], before: bool) -> None:
        """Ask a server that has come what runs; `active`: the stray goals in its status array; `before` iff its process
        has served before.
        """
        self._before, self._array_due = before, math.inf
        self._question = self._outside.new_id() if self._starts_idle else cdr.NO_ID
        self.shown(active)
        self.ask()

    def ask(self) -> None:
        """Ask the server to cancel all goals: those that it cancels are those that run. A server that starts idle is
        asked to cancel a goal that does not exist: only the fact that it answers matters.
        """
        self.due = self._outside.gate.clock() + AGAIN
        self._to_server("cancel_goal", cdr.cancel_request(self._question), "question")

    def answered(self, code: int, ids: Sequence[bytes]) -> None:
        """Take the answer to the question: the return code, and the ids of the goals that it cancels.

        A goal that is being cancelled already is in no answer: the status array tells that it runs. The answer may come
        before that array: until one has come, or `AGAIN` has passed, no answer says that nothing stray runs.
        """
        if self.due == math.inf:
            return
        if self._starts_idle:
            self._reached()
            return
        now = self._outside.gate.clock()
        self._array_due = min(self._array_due, now + AGAIN)
        lost = {goal.id: slot for slot, goal in self._slots.items()}
        for id, slot in lost.items():
            self._lost(slot, self._before or id in ids)
        foreign = any(id not in lost and id not in self._shown for id in ids)
        if foreign or (code == cdr.CANCEL_REJECTED and not self._shown and not lost):
            self._asked_about = self._asked_about or self._free()
            self._outside.gate.tell(SlotSaid(self._asked_about, True))
        elif now < self._array_due:
            self.due = self._array_due
            return
        else:
            self.due, self._asked_about = math.inf, None
            self.shown(self._listed)
        self._idle({self._asked_about, *self._shown.values(), *self._slots})

    def _reached(self) -> None:
        """Tell the gate that a server that starts idle runs nothing, but for goals from before it came back."""
        self.due = math.inf
        again = self._slots if self._before else {}
        for slot in self._mine(self._outside.gate.state.unsaid & again.keys()):
            self._to_server("get_result", again[slot].id, again[slot])
            if again[slot].stop:
                self._to_server("cancel_goal", cdr.cancel_request(again[slot].id), again[slot])
        self._idle({*self._shown.values(), *again})

    def _idle(self, kept: Collection[SlotId | None]) -> None:
        """Tell the gate that nothing runs in the slots of this action, but for those that are kept."""
        state = self._outside.gate.state
        for slot in self._mine(state.unsaid | state.strays):
            if slot not in kept:
                self._outside.gate.tell(SlotSaid(slot, False))

    def _lost(self, slot: SlotId, active: bool) -> None:
        """Tell the gate whether its lost goal in a slot may still run at a server that has come back."""
        if not self._outside.gate.state.slots[slot].lost:
            return
        if active:
            self._to_server("get_result", self._slots[slot].id, self._slots[slot])
        self._outside.gate.tell(SlotSaid(slot, active))

    # ---- the status array ----

    def listed(self, ids: Iterable[bytes]) -> None:
        """Take the ids of the stray goals that a status array which has come shows as active."""
        self._array_due = -math.inf
        self.shown(ids)

    def shown(self, ids: Iterable[bytes]) -> None:
        """Take the ids of the stray goals that the status array shows as active."""
        self._listed = frozenset(ids)
        for id in self._listed - self._shown.keys():
            if self._asked_about is None:
                slot = self._shown[id] = self._free()
                again = slot in self._outside.gate.state.strays
                self._outside.gate.tell(SlotSaid(slot, True))
                if again:
                    self.stop(slot)
        for id in self._shown.keys() - self._listed:
            slot = self._shown.pop(id)
            if self.due == math.inf:  # else the answer to the question tells it
                self._outside.gate.tell(SlotSaid(slot, False))

    def stop(self, slot: SlotId) -> None:
        """Cancel the stray goal of the status array in a slot; the question itself cancels what it is about."""
        for id, each in self._shown.items():
            if each == slot:
                self._to_server("cancel_goal", cdr.cancel_request(id), "stray")

    def _free(self) -> SlotId:
        """Return a slot for a stray goal: before the gate has started one of this action in which nothing runs as far
        as the gate knows; later, one beyond those of the first request, since a launch rule may launch in any other.
        """
        gate = self._outside.gate
        taken = {*gate.state.slots, *self._shown.values()}
        slots = {name: gate.model.request[name].instances for name in self._requests}
        every = [(name, slot) for name in self._requests if not gate.state.started for slot in range(slots[name])]
        beyond = zip(repeat(self._requests[0]), count(slots[self._requests[0]]))
        return next(slot for slot in chain(every, beyond) if slot not in taken)

    def _mine(self, slots: Iterable[SlotId]) -> list[SlotId]:
        return sorted(slot for slot in slots if slot[0] in self._requests)
