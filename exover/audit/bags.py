"""Reads missions from ROS 2 bags by a binding (docs/audit.md, "Bags"; extra `exover[ros]`)."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader as BagReader

from exover.audit.binary import NoMission
from exover.audit.decoding import decoded, reason
from exover.audit.mission import Item, KillDeed, LaunchDeed, Noted, RejectDeed, ToldMark, Unread, read_noted
from exover.audit.seen_goals import SeenGoal, SeenGoals
from exover.audit.shapes import CALL_SHAPE, GOAL_SHAPE, RESULT_SHAPE, STATUS_SHAPE, Shape, lacking
from exover.gate.binding import Binding, RequestBinding
from exover.gate.fields import UnreadableField, ValueField, select
from exover.gate.ros2.cdr import ACCEPTED, CANCELING, OUTCOME_OF, SUCCEEDED
from exover.gate.ros2.names import absolute
from exover.model.event import Invalid, Report
from exover.model.model import Model
from exover.model.wire import Json

RESPONSES = (2, 3)
"""Event types of service_msgs/msg/ServiceEventInfo for responses: sent, received."""
GOALS, STATUS, CALLS = "/_action/send_goal/_service_event", "/_action/status", "/_service_event"
RESULTS = "/_action/get_result/_service_event"
MOST_DONE = 1000
"""How many answered calls are remembered, since client and server may both have recorded one."""
Reader = Callable[[Any], Iterator[Item]]


class Bag:
    """Reads one bag by a binding."""

    def __init__(self, model: Model, binding: Binding, path: str) -> None:
        self._model, self._binding, self._path = model, binding, path
        self._free = {each.name: list(range(each.instances)) for each in model.requests}
        self._known: dict[str, SeenGoals] = {}
        self._readers: dict[str, list[tuple[Shape, Reader]]] = {}
        self._lacking: set[str] = set()
        self._topics: dict[str, str] = {}
        """The type of each topic."""
        self._watched: dict[str, SeenGoal] = {}
        """Service calls, by request, that have started and whose end a watch tells."""
        self._results: dict[tuple[int, ...], Any] = {}
        """Results by goal id, read before all else, since they come behind the statuses that end their goals."""
        self._faults: dict[str, Invalid] = {}
        """The first fault of the results on each topic."""

    def messages(self) -> Iterator[tuple[int, Noted]]:
        """Yield number and content of each message that says something, in order of time; raises `NoMission`.

        Messages of the topics that are read are numbered from 1. Faults of results come with number 1.
        """
        try:
            reader = BagReader(Path(self._path))
            reader.open()
        except Exception as error:  # a damaged file may raise anything
            raise NoMission(reason(error)) from error
        try:
            self._topics = {each.topic: each.msgtype for each in reader.connections}
            self._bind()
            self._results = self._results_in(reader)
            self._find_goals(reader)
            if self._faults:
                yield 1, Noted(tuple(map(Unread, self._faults.values())))
            wanted = [each for each in reader.connections if each.topic in self._readers]
            if wanted:
                yield from self._messages(reader, wanted)
        finally:
            reader.close()

    def _messages(self, reader: BagReader, wanted: list[Any]) -> Iterator[tuple[int, Noted]]:
        for number, (topic, stamp, message) in enumerate(decoded(reader, wanted), 1):
            items = tuple(
                item for shape, read in self._readers[topic] for item in self._read(topic, message, shape, read)
            )
            if items:
                yield number, Noted(items, stamp / 1e9)

    def _read(self, topic: str, message: Any, shape: Shape, read: Reader) -> Iterator[Item]:
        fault = self._fault(topic, message, shape)
        yield from (Unread(fault),) if fault else read(message)

    def _fault(self, topic: str, message: Any, shape: Shape) -> Invalid | None:
        lack = lacking(message, shape)
        return Invalid("wrong-type", f"{topic} is of {self._topics[topic]}: {lack}") if lack else None

    def _results_in(self, reader: BagReader) -> dict[tuple[int, ...], Any]:
        """Return the first recorded result of each goal, by goal id."""
        wanted = [each for each in reader.connections if each.topic in {f"{name}{RESULTS}" for name in self._known}]
        goals: dict[Any, tuple[int, ...]] = {}
        found: dict[tuple[int, ...], Any] = {}
        try:
            for topic, _, message in decoded(reader, wanted) if wanted else ():
                fault = self._fault(topic, message, RESULT_SHAPE)
                if fault:
                    self._faults.setdefault(topic, fault)
                    continue
                for sent in message["request"]:
                    goals[topic, _call(message)] = _uuid(sent["goal_id"])
                for answer in message["response"]:
                    goal = goals.get((topic, _call(message)))
                    if goal is not None and answer["status"] >= SUCCEEDED:
                        found.setdefault(goal, answer["result"])
        except NoMission as why:
            self._faults[""] = Invalid("bad-event", f"of the results of goals, {why}")
        return found

    def _find_goals(self, reader: BagReader) -> None:
        """Note the goals whose arguments were recorded; what is wrong with their messages is told in their turn."""
        known = {f"{name}{GOALS}": each for name, each in self._known.items()}
        wanted = [each for each in reader.connections if each.topic in known]
        with suppress(NoMission):
            for topic, _, message in decoded(reader, wanted) if wanted else ():
                for sent in () if self._fault(topic, message, GOAL_SHAPE) else message["request"]:
                    goal = known[topic].sent.setdefault(_uuid(sent["goal_id"]), SeenGoal(None))
                    self._identify(known[topic], goal, sent["goal"])

    def notes(self) -> Iterator[str]:
        """Yield notes on topics that the bag lacks, and what follows from that."""
        for name, known in self._known.items():
            kind = known.bounds[0].kind
            there = known.has_status if kind == "action" else known.has_goals
            if not there:
                yield f"it has no topic of the {kind} {name}"
            elif not known.has_goals:
                yield f"it has no arguments of the goals of {name}: {name}{GOALS} was not recorded"
        for name in sorted(self._lacking):
            yield f"it has no results of {name}: its ends are taken as failed"
        for watch in self._binding.watches:
            if watch.kind == "topic" and absolute(watch.source) not in self._topics:
                yield f"it has no topic {absolute(watch.source)}: the posters read there stay as they are"
                for bound in self._binding.watched_by(watch.name):
                    yield f"it has no ends of {bound.request}: a response is taken as one"

    # ---- who reads which topic ----

    def _bind(self) -> None:
        for bound in self._binding.requests:
            if bound.kind != "tool":
                inner, outer = absolute(bound.inner), absolute(bound.outer)
                name = next((name for name in (inner, outer) if self._has(name, bound.kind)), inner)
                known = self._known.setdefault(name, SeenGoals(()))
                known.bounds = (*known.bounds, bound)
        for name, known in self._known.items():
            if known.bounds[0].kind == "action":
                known.has_goals = self._on(f"{name}{GOALS}", self._goals(known), GOAL_SHAPE)
                known.has_status = self._on(f"{name}{STATUS}", self._statuses(known), STATUS_SHAPE)
            else:
                known.has_goals = self._on(f"{name}{CALLS}", self._calls(known), CALL_SHAPE)
        for watch in self._binding.watches:
            posters = [each for each in self._binding.posters if each.watch == watch.name]
            if watch.kind == "topic" and posters:
                self._on(absolute(watch.source), self._readings([(each.poster, each.field) for each in posters]))
            ended = self._binding.watched_by(watch.name)
            if watch.kind == "topic" and ended:
                self._on(absolute(watch.source), self._ends(ended))

    def _has(self, name: str, kind: str) -> bool:
        ends = (STATUS, GOALS) if kind == "action" else (CALLS,)
        return any(name + end in self._topics for end in ends)

    def _on(self, topic: str, reader: Reader, shape: Shape = object) -> bool:
        if topic in self._topics:
            self._readers.setdefault(topic, []).append((shape, reader))
        return topic in self._topics

    # ---- posters ----

    def _readings(self, posters: list[tuple[str, ValueField]]) -> Reader:
        def read(message: Any) -> Iterator[Item]:
            for poster, where in posters:
                try:
                    value = where.read(message)
                except UnreadableField as reason:
                    yield Unread(Invalid("wrong-type", f"{poster}: {reason}"))
                else:
                    yield from read_noted(self._model, {"observe": poster, "value": value}).items

        return read

    # ---- actions ----

    def _goals(self, known: SeenGoals) -> Reader:
        """Return a reader of the `send_goal` introspection topic, which tells arguments and refusals of goals."""
        calls: dict[Any, SeenGoal] = {}

        def read(message: Any) -> Iterator[Item]:
            key = _call(message)
            if message["info"]["event_type"] not in RESPONSES:
                for sent in message["request"]:
                    calls[key] = known.goal(_uuid(sent["goal_id"]))
                return
            answered = calls.pop(key, None)
            for answer in message["response"]:
                if answered and answered.bound and not answered.asked:
                    yield from self._asked(answered)
                    if not answer["accepted"]:
                        yield from (RejectDeed(answered.bound.request), ToldMark())

        return read

    def _identify(self, known: SeenGoals, goal: SeenGoal, arguments: Any) -> None:
        """Set the request that a goal or call means, and its arguments."""
        goal.bound = next((bound for bound in known.bounds if bound.meant(arguments)), None)
        if goal.bound is None or goal.args is not None:
            return
        try:
            goal.args = {each.name: each.read(arguments) for each in goal.bound.arguments}
        except UnreadableField as reason:
            goal.args, goal.fault = {}, str(reason)

    def _asked(self, goal: SeenGoal) -> Iterator[Item]:
        goal.asked = True
        assert goal.bound
        entries: Json = {"ask": goal.bound.request, "args": goal.args or {}}
        if goal.fault:
            yield Unread(Invalid("missing-argument", goal.fault), "ask", goal.bound.request)
        else:
            yield from read_noted(self._model, entries).items

    def _statuses(self, known: SeenGoals) -> Reader:
        first = True

        def read(message: Any) -> Iterator[Item]:
            nonlocal first
            for each in message["status_list"]:
                goal = known.goal(_uuid(each["goal_info"]["goal_id"]))
                if first and each["status"] >= SUCCEEDED and not goal.status:
                    goal.status = each["status"]  # it has ended before the recording began
                if goal.bound is None and len(known.bounds) == 1:
                    goal.bound = known.bounds[0]
                yield from self._moved(goal, each["status"], self._results.get(_uuid(each["goal_info"]["goal_id"])))
            first = False
            there = {_uuid(each["goal_info"]["goal_id"]) for each in message["status_list"]}
            for key in [key for key, goal in known.goals.items() if goal.status >= SUCCEEDED and key not in there]:
                del known.goals[key]

        return read

    def _moved(self, goal: SeenGoal, status: int, result: Any) -> Iterator[Item]:
        """Yield the items for a goal's new status: ask, launch, kill, report; `result` is None if none was recorded."""
        before, goal.status = goal.status, max(status, goal.status)
        if goal.bound is None or before >= SUCCEEDED or status <= before:
            return
        if before < ACCEPTED:
            if goal.args is not None and not goal.asked:
                yield from self._asked(goal)
            yield self._start(goal)
        if goal.instance is None:
            return
        name = goal.bound.request
        if status == CANCELING:
            yield KillDeed(name, goal.instance)
        elif status >= SUCCEEDED:
            outcome = OUTCOME_OF.get(status, "failed")
            yield self._end(goal, outcome if result is None else _outcome(goal.bound, outcome, result), result)

    def _start(self, goal: SeenGoal) -> Item:
        assert goal.bound
        name = goal.bound.request
        free = self._free[name]
        if not free:
            return Unread(Invalid("out-of-range", "more of it runs than the spec has instances"), "launch", name)
        goal.instance = min(free)
        free.remove(goal.instance)
        if goal.args is None:
            return LaunchDeed(name, goal.instance, None)
        (item,) = read_noted(self._model, {"launch": name, "instance": goal.instance, "args": goal.args}).items
        return item

    def _end(self, goal: SeenGoal, outcome: str, response: Any) -> Item:
        """Return the report of a goal's instance, and free the instance."""
        assert goal.bound and goal.instance is not None
        name, instance = goal.bound.request, goal.instance
        self._free[name].append(instance)
        goal.instance = None
        entries: Json = {"report": name, "instance": instance, "outcome": outcome}
        status = None if response is None else _status(goal.bound, response)
        failure = goal.bound.report.failure(status) if outcome == "failed" else None
        if failure:
            entries["status"] = failure
        if outcome == "ok" and self._model.request[name].results:
            if response is None:
                self._lacking.add(name)
                return Report(name, instance, "failed")
            try:
                entries["results"] = {each.name: each.read(response) for each in goal.bound.report.results}
            except UnreadableField as reason:
                return Unread(Invalid("missing-argument", str(reason)), "report", name, instance)
        (item,) = read_noted(self._model, entries).items
        return item

    # ---- services ----

    def _ends(self, bounds: tuple[RequestBinding, ...]) -> Reader:
        """Return a reader of a watch's topic, for the ends of services whose response says only that they started."""

        def read(message: Any) -> Iterator[Item]:
            for bound in bounds:
                goal = self._watched.get(bound.request)
                meaning = bound.report.meaning(_status(bound, message))
                if goal is not None and goal.ends(meaning):
                    del self._watched[bound.request]
                    yield self._end(goal, meaning or "failed", message)

        return read

    def _is_watched(self, bound: RequestBinding) -> bool:
        sources = {absolute(each.source) for each in self._binding.watches if each.name == bound.report.watch}
        return bound.started and bool(sources & self._topics.keys())

    def _calls(self, known: SeenGoals) -> Reader:
        done: dict[Any, None] = {}

        def read(message: Any) -> Iterator[Item]:
            key = _call(message)
            if message["info"]["event_type"] not in RESPONSES:
                for sent in message["request"]:
                    if key not in known.goals and key not in done:
                        known.goals[key] = SeenGoal(None)
                        yield from self._called(known, known.goals[key], sent)
                return
            for response in message["response"]:
                called = known.goals.pop(key, None)
                done[key] = None
                if len(done) > MOST_DONE:
                    del done[next(iter(done))]
                if called and called.bound and called is self._watched.get(called.bound.request):
                    called.rounds = 0
                elif called and called.bound and called.instance is not None:
                    yield self._end(called, _outcome(called.bound, "ok", response), response)

        return read

    def _called(self, known: SeenGoals, call: SeenGoal, sent: Any) -> Iterator[Item]:
        """Yield the items for a new call of a service; its response is its end unless its request is watched."""
        self._identify(known, call, sent)
        if call.bound:
            yield from self._asked(call)
            yield self._start(call)
            if self._is_watched(call.bound) and call.instance is not None:
                self._watched[call.bound.request] = call


def _status(bound: RequestBinding, response: Any) -> Any:
    return None if bound.report.status is None else select(response, bound.report.status)


def _outcome(bound: RequestBinding, told: str, response: Any) -> str:
    """Return the outcome of a request that the protocol has `told`, refined by the status in its response."""
    if bound.report.status is None or told != "ok":
        return told
    meaning = bound.report.meaning(_status(bound, response))
    return meaning if meaning in ("ok", "interrupted") else "failed"


def _call(message: Any) -> tuple[Any, int]:
    """Return the key that request and response of a call share: the client's GID and the sequence number."""
    info = message["info"]
    return tuple(info["client_gid"]), info["sequence_number"]


def _uuid(goal_id: Any) -> tuple[int, ...]:
    return tuple(goal_id["uuid"])
