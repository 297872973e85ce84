"""The proxy of one action: decides what is done with each message of clients and server, without I/O (docs/gate.md)."""

import math

from exover.gate.binding import RequestBinding
from exover.gate.fields import UnreadableField
from exover.gate.outer import Alarm, CallId, Cancelled, CancelRefused
from exover.gate.ros2 import cdr
from exover.gate.ros2.cdr import HEAD, ID, NO_ID, GoalReply, Stamp
from exover.gate.ros2.goals import MAX_WAITING, ActionGoal, ActionGoals
from exover.gate.ros2.names import Port, PortPart
from exover.gate.ros2.outside import CallReader, Outside, Servers, ending
from exover.gate.ros2.strays import AGAIN, Strays
from exover.model.event import Args, Ending
from exover.model.state import SlotId

STATUS_OF = {outcome: status for status, outcome in cdr.OUTCOME_OF.items()}
"""The goal status for an outcome, where the server has not told a result."""


class ActionProxy:
    """One action, bound to one or more requests: an action server of the outer name, a client of the inner name."""

    def __init__(self, outside: Outside, bounds: tuple[RequestBinding, ...]) -> None:
        self._outside = outside
        self._gate = outside.gate
        self._bounds = {each.request: each for each in bounds}
        self._type = str(bounds[0].type)
        self.outer, self.inner = bounds[0].outer, bounds[0].inner
        self.requests = frozenset(self._bounds)
        self._meaning = CallReader(outside, bounds, f"{self._type}_Goal")
        self._goals = ActionGoals()
        self._calls: dict[CallId, ActionGoal] = {}
        self._slots: dict[SlotId, ActionGoal] = {}
        self._strays = Strays(outside, bounds, self._to_server, self._slots)
        self._servers = Servers(outside, self.inner, self.requests, "goal")
        self._shown: dict[bytes, int] = {}
        """The last status array of the server: status by goal id."""
        self._earlier: dict[bytes, int] = {}
        """The last one before the server was gone, until another comes."""

    # ---- ports ----

    def _up(self, part: PortPart, peer: int, header: bytes, body: bytes) -> None:
        """Send a client a service response; `header` is that of its request."""
        self._outside.send(Port("outer", self.outer, part), cdr.service(header, body), peer)

    def _to_server(self, part: PortPart, body: bytes, about: object) -> None:
        """Send the server a service request; `about` comes back with its reply."""
        port = Port("inner", self.inner, part)
        self._outside.send(port, cdr.service(self._outside.own.header(port, about), body), 0)

    def _publish(self) -> None:
        self._outside.send(Port("outer", self.outer, "status"), cdr.topic(self._goals.statuses()), 0)

    def from_client(self, part: PortPart, data: bytes, peer: int) -> None:
        """Take a service request of a client: `send_goal`, `cancel_goal` or `get_result`."""
        if part == "send_goal":
            self._asked(data, peer)
        elif part == "cancel_goal":
            self._cancel(data, peer)
        else:
            self._result_wanted(data, peer)

    def from_server(self, part: PortPart, data: bytes, peer: int) -> None:
        """Take a service reply, feedback or a status array of the server."""
        if part == "feedback":
            self._feedback(data)
        elif part == "status":
            self._status(data)
        else:
            about = self._outside.own.answered(Port("inner", self.inner, part), data)
            if part == "cancel_goal" and about is not None:
                self._cancelled(about, data)
            elif part == "get_result" and isinstance(about, ActionGoal):
                self._result(about, data)
            elif part == "send_goal" and isinstance(about, ActionGoal) and (reply := cdr.read_goal_reply(data)):
                self._taken(about, reply)

    # ---- clients ----

    def _asked(self, data: bytes, peer: int) -> None:
        call = self._outside.call(peer)
        goal = self._calls[call] = ActionGoal(data[HEAD : HEAD + ID], data[HEAD:], call, peer, data[cdr.BODY : HEAD])
        found = self._meaning(data[HEAD + ID :])
        if found.args is None:
            self._gate.refuse(call, found.request, found.rule, found.because)
        elif goal.id == NO_ID or self._goals.known(goal.id) or goal.id in self._shown:
            which = "is zero" if goal.id == NO_ID else "is that of another goal"
            self._gate.refuse(call, found.request, "unreadable", f"its goal id {which}")
        else:
            self._goals.add(goal)
            self._gate.call(call, found.request, found.args)

    def _cancel(self, data: bytes, peer: int) -> None:
        info = cdr.read_cancel(data)
        if info is None:
            return
        chosen = self._goals.meant_by(info)
        code = cdr.CANCEL_OK
        if not chosen and info.id != NO_ID:
            code = cdr.CANCEL_TERMINATED if self._goals.ended(info.id) else cdr.CANCEL_UNKNOWN
        self._up("cancel_goal", peer, data[cdr.BODY : HEAD], cdr.cancel_reply(code, [each.info for each in chosen]))
        for goal in chosen:
            if goal.call is not None:
                self._gate.tell(Cancelled(goal.call))
            if goal.phase == "held":
                self._end(goal, cdr.CANCELED)

    def _result_wanted(self, data: bytes, peer: int) -> None:
        id, header = data[HEAD : HEAD + ID], data[cdr.BODY : HEAD]
        goal, ended = self._goals.open(id), self._goals.ended(id)
        if ended is not None and ended.result is not None:
            self._up("get_result", peer, header, ended.result)
        elif goal is None or goal.status == cdr.UNKNOWN:
            self._up("get_result", peer, header, self._nothing(cdr.UNKNOWN))
        elif len(goal.waiting) < MAX_WAITING:
            goal.waiting.append((peer, header))

    def client_gone(self, client: str) -> None:
        """End the held goals of a client as CANCELED; the gate has been told that it is gone."""
        for goal in self._goals:
            if goal.phase == "held" and goal.call and goal.call.client == client:
                self._end(goal, cdr.CANCELED)

    # ---- effects ----

    def knows(self, call: CallId) -> bool:
        """Return whether a call is a goal of this action that has not ended."""
        return call in self._calls

    def forward(self, call: CallId | None, slot: SlotId, args: Args) -> None:
        """Send the goal of a call to the server; without a call, make a goal of the gate's own and send that."""
        goal = self._calls.get(call) if call else self._own_goal(slot, args)
        if goal is None:
            return
        goal.slot, goal.phase = slot, "sent"
        self._slots[slot] = goal
        self._servers.used()
        self._to_server("send_goal", goal.body, goal)

    def _own_goal(self, slot: SlotId, args: Args) -> ActionGoal | None:
        id = self._outside.new_id()
        try:
            body = self._outside.codec.write(f"{self._type}_Goal", self._bounds[slot[0]].own_values(args))
        except UnreadableField as why:
            self._gate.tell(Alarm("invalid", *slot, f"its goal cannot be written: {why}"))
            self._gate.report(slot, {"outcome": "failed"})
            return None
        goal = ActionGoal(id, id + body)
        self._goals.add(goal)
        return goal

    def hold(self, call: CallId) -> None:
        """Accept a goal that waits, and publish the status array."""
        goal = self._calls[call]
        goal.phase = "held"
        self._accept(goal)
        self._publish()

    def _accept(self, goal: ActionGoal) -> None:
        goal.stamp, goal.status = self._outside.now(), cdr.ACCEPTED
        if goal.header is not None:
            self._up("send_goal", goal.peer, goal.header, cdr.goal_reply(True, goal.stamp))
            goal.header = None

    def refuse(self, call: CallId, rule: str, because: str | None) -> None:
        """Do not accept a goal; one that was accepted before ends as ABORTED. No message has a field for a reason."""
        goal = self._calls[call]
        if goal.header is None:
            self._end(goal, cdr.ABORTED)
        else:
            self._deny(goal)

    def _deny(self, goal: ActionGoal) -> None:
        """Tell the client that its goal is not accepted, and forget the goal."""
        if goal.header is not None:
            self._up("send_goal", goal.peer, goal.header, cdr.goal_reply(False, self._outside.now()))
        goal.header, goal.phase = None, "ended"
        self._goals.drop(goal)
        if goal.call:
            self._calls.pop(goal.call, None)

    def stop(self, slot: SlotId) -> None:
        """Tell the server to cancel the goal in a slot: at once if it has accepted it, else as soon as it does."""
        goal = self._slots.get(slot)
        if goal is None:
            self._strays.stop(slot)
            return
        goal.stop = True
        if goal.phase in ("running", "ended"):  # its client was told an end when the server was lost
            self._to_server("cancel_goal", cdr.cancel_request(goal.id), goal)
        if goal.phase == "running":
            goal.status = cdr.CANCELING
            self._publish()

    def finish(self, slot: SlotId, call: CallId | None, outcome: Ending) -> None:
        """End the goal in a slot that has ended, with the server's result if there is one, else with zeros."""
        goal = self._slots.pop(slot, None)
        self._outside.own.close(goal)
        if goal is None or goal.phase == "ended":
            return
        if goal.header is not None or goal.status == cdr.UNKNOWN:
            self._deny(goal)
        elif goal.result is not None:
            self._end(goal, goal.result[0], goal.result)
        else:
            self._end(goal, cdr.ABORTED if goal.phase == "refused" else STATUS_OF[outcome])

    def _end(self, goal: ActionGoal, status: int, result: bytes | None = None) -> None:
        body = self._nothing(status) if result is None else result
        self._goals.end(goal, status, body)
        if goal.call:
            self._calls.pop(goal.call, None)
        for peer, header in goal.waiting:
            self._up("get_result", peer, header, body)
        goal.waiting = []
        self._publish()

    def _nothing(self, status: int) -> bytes:
        """Return the body of a `get_result` response with a status and a result of zeros."""
        return bytes((status,)) + self._outside.codec.write(f"{self._type}_GetResult_Response")[1:]

    # ---- the server ----

    def _taken(self, goal: ActionGoal, answer: GoalReply) -> None:
        """Take the server's answer to a goal, of `send_goal` or its status array; the first one counts."""
        if goal.phase != "sent" or goal.slot is None:
            return
        if goal.header is not None:
            self._up("send_goal", goal.peer, goal.header, cdr.goal_reply(*answer))
            goal.header = None
        if answer.accepted:
            self._runs(goal, goal.slot, answer.stamp)
        else:
            goal.phase = "refused"
            self._gate.report(goal.slot, {"outcome": "failed"})

    def _runs(self, goal: ActionGoal, slot: SlotId, stamp: Stamp) -> None:
        """Note that the server has accepted a goal, and ask for its result."""
        goal.phase = "running"
        if goal.status == cdr.UNKNOWN:
            goal.stamp, goal.status = stamp, cdr.ACCEPTED
        self._to_server("get_result", goal.id, goal)
        if goal.stop:
            self.stop(slot)
        else:
            self._publish()

    def _result(self, goal: ActionGoal, data: bytes) -> None:
        slot = goal.slot
        if slot is None or self._slots.get(slot) is not goal or len(data) <= HEAD:
            return
        status, body = data[HEAD], data[HEAD:]
        if goal.phase != "ended":
            goal.result = body
        if status == cdr.CANCELED:
            self._gate.report(slot, {"outcome": "interrupted"})
        elif status in (cdr.SUCCEEDED, cdr.ABORTED):
            well, bound = status == cdr.SUCCEEDED, self._bounds[slot[0]]
            self._gate.report(slot, ending(self._outside, bound, slot, well, lambda: self._read_result(body)))
        else:
            self._gate.tell(Alarm("unknown-status", *slot, f"its goal has ended with the status {status}"))
            self._gate.report(slot, {"outcome": "failed"})
            goal.slot = None  # should it begin later, it is stray

    def _read_result(self, body: bytes) -> object:
        return self._outside.codec.read(f"{self._type}_GetResult_Response", body)["result"]

    def _cancelled(self, about: object, data: bytes) -> None:
        code, goals = cdr.read_cancel_reply(data)
        if about == "question":
            mine = [goal.id for goal in self._slots.values() if self._shown.get(goal.id) in cdr.ACTIVE]
            self._strays.answered(code, (*goals, *mine))
            return
        slot = next((slot for slot, goal in self._slots.items() if goal is about), None)
        if slot and self._slots[slot].id not in goals and code != cdr.CANCEL_TERMINATED:
            self._gate.tell(CancelRefused(slot))

    def _feedback(self, data: bytes) -> None:
        goal = self._goals.open(data[cdr.BODY : cdr.BODY + ID])
        if goal is not None and goal.phase in ("sent", "running"):
            self._outside.send(Port("outer", self.outer, "feedback"), data, 0)

    def _status(self, data: bytes) -> None:
        """Take the server's status array; a goal in it was accepted, since refused goals are never in it."""
        self._shown, self._earlier, advanced = {}, {}, False
        for id, seconds, nanoseconds, status in cdr.read_statuses(data):
            self._shown[id] = status
            goal = self._goals.open(id)
            if goal is None or status == cdr.UNKNOWN:
                continue
            self._taken(goal, GoalReply(True, Stamp(seconds, nanoseconds)))
            if goal.phase == "running" and status in cdr.OUTCOME_OF:
                goal.again = min(goal.again, self._gate.clock() + AGAIN)
            elif goal.phase == "running" and goal.status < status <= cdr.CANCELING:
                goal.status, advanced = status, True
        if advanced:
            self._publish()
        if self._servers:
            self._strays.listed(self._foreign())

    def _foreign(self) -> list[bytes]:
        """Return the ids of active goals in the server's status array that this gate has not sent."""
        return [id for id, status in self._shown.items() if status in cdr.ACTIVE and not self._goals.launched(id)]

    # ---- whether the server is there ----

    def servers(self, found: frozenset[str]) -> None:
        """Take the keys of the processes that serve this action now."""
        self._servers.become(found, self._gone, self._came)

    def _gone(self, all_: bool) -> None:
        self._outside.own.forget(self.inner)
        for goal in self._slots.values():
            goal.again = math.inf
        if all_:
            self._strays.gone()
            self._earlier, self._shown = self._shown, {}

    def _came(self, used: bool) -> None:
        if self._servers.again and self._earlier:
            self._shown = self._earlier
        self._strays.came(self._foreign(), used)

    @property
    def due(self) -> float:
        """The next time at which `tick` has something to do; infinite if there is none."""
        again = min((goal.again for goal in self._slots.values()), default=math.inf)
        return min(again, self._strays.due) if self._servers else math.inf

    def tick(self) -> None:
        """Repeat the requests to the server whose answers are overdue."""
        if not self._servers:
            return
        now = self._gate.clock()
        if self._strays.due <= now:
            self._strays.ask()
        for goal in self._slots.values():
            if goal.again <= now:
                goal.again = now + AGAIN
                self._to_server("get_result", goal.id, goal)
