"""The MCP proxy: decides what is done with each message between client and server, without I/O (docs/gate.md)."""

from collections.abc import Callable
from dataclasses import field
from itertools import count

from exover.dataclass import dataclass
from exover.gate.binding import BindingKind, RequestBinding, Watch
from exover.gate.fields import UnreadableField
from exover.gate.gate import Gate, Tell
from exover.gate.mcp import lines
from exover.gate.mcp.calls import Pending
from exover.gate.mcp.client import McpClient
from exover.gate.mcp.lines import BadLine, Message, PreparedCall
from exover.gate.mcp.results import document, ending, own_call, succeeded, without_unbound
from exover.gate.mcp.server import McpServer
from exover.gate.outer import (
    Alarm,
    CallId,
    Cancelled,
    CancelRefused,
    ClientGone,
    Finish,
    Forward,
    Hold,
    ModuleGone,
    OuterEffect,
    Refuse,
    SlotSaid,
    Stop,
    reason_text,
)
from exover.gate.watching import Watching
from exover.model.event import Args
from exover.model.state import SlotId
from exover.model.wire import Json

NEEDED = ("initialize", "ping", "server/discover", "tools/list")
"""Methods that always pass, since without them no client finds a tool."""
NOTIFICATIONS = "notifications/"
"""How the methods of notifications begin; every other one is that of a request."""


@dataclass(slots=True)
class McpProxy:
    """The transport for one MCP client and one server; `to_client` and `to_server` take whole lines."""

    gate: Gate
    to_client: Callable[[bytes], None]
    to_server: Callable[[bytes], None]
    tell: Tell
    name: str = "mcp"
    kinds: tuple[BindingKind, ...] = ("tool",)
    _numbers: "count[int]" = field(default_factory=lambda: count(1))
    _carries: dict[SlotId, int] = field(default_factory=dict)
    """The number of the open request to the server that carries out a slot."""
    _ready: bool = False
    """Whether the client has begun its session, before which the server answers no call of a tool."""
    _cancels: dict[str, PreparedCall] = field(default_factory=dict)
    """The call that stops a request, by request."""
    _polls: dict[str, PreparedCall] = field(default_factory=dict)
    """The call of a watch's tool, by watch."""
    _awaited: set[SlotId] = field(default_factory=set)
    """Slots that were active when the client went and have not ended since."""
    _client: McpClient = field(init=False)
    _server: McpServer = field(init=False)
    _watching: Watching = field(init=False)

    def __post_init__(self) -> None:
        for bound in self.gate.binding.requests:
            if bound.cancel:
                self._cancels[bound.request] = lines.prepared(bound.cancel.tool, bound.cancel.arguments)
        for watch in self.gate.binding.watches:
            if watch.kind == "tool":
                self._polls[watch.name] = lines.prepared(watch.source, watch.arguments)
        self._client = McpClient(self.to_client)
        self._server = McpServer(self.to_server, self._numbers)
        self._watching = Watching(self.gate, self._poll)
        self.gate.attach(self)

    # ---- what happens ----

    def start(self) -> None:
        """Tell the gate that slots are idle whose request is unbound or bound with `start = "idle"`."""
        for slot in sorted(self.gate.state.unsaid):
            bound = self.gate.binding.of(slot[0])
            if bound is None or bound.starts_idle:
                self.gate.tell(SlotSaid(slot, False))

    def from_client(self, line: bytes) -> None:
        """Take one line from the client; answer a bad one with an error."""
        if not line.strip():
            return
        try:
            message = lines.read(line, self.gate.binding.gate.max_line)
        except BadLine as bad:
            self._client.error(None, bad.code, str(bad))
            return
        match message.kind:
            case "request":
                self._request(message)
            case "notification":
                self._notice(message)
            case "response":
                self._answered_by_client(message)

    def from_server(self, line: bytes) -> None:
        """Take one line from the server; drop a bad one."""
        if not line.strip():
            return
        try:
            message = lines.read(line, self.gate.binding.gate.max_line)
        except BadLine as bad:
            self.tell(f"a message of the server was dropped: {bad}")
            return
        match message.kind:
            case "request":
                self._client.request(message)
            case "notification":
                self._notice_of_server(message)
            case "response":
                self._response(message)

    def tick(self) -> None:
        """Tell the gate and the watches of deadlines that have passed."""
        self.gate.tick()
        self._watching.tick(self._ready and self._server.alive)

    @property
    def due(self) -> float:
        """The next time at which `tick` has something to do; infinite if there is none."""
        return min(self._watching.due(self._ready and self._server.alive), self.gate.state.due)

    def client_gone(self) -> None:
        """Tell the gate that the client has gone, and note what is active, whose end is to be waited for."""
        self._awaited = set(self.gate.state.slots)
        self.gate.tell(ClientGone(self.name))

    def server_gone(self) -> None:
        """Tell the gate that the server has died, and answer the client's open requests with errors."""
        unanswered = self._server.gone()
        self.gate.tell(ModuleGone(frozenset(bound.request for bound in self.gate.binding.requests)))
        for pending in unanswered:
            if pending.client_id is not None and pending.slot is None:
                self._reply(pending, {"error": {"code": lines.SERVER_GONE, "message": "the server is gone"}})

    @property
    def active(self) -> bool:
        """Whether the server is alive and something that was active when the client went has not ended."""
        return self._server.alive and bool(self._awaited)

    def give_up(self) -> None:
        """Tell the person which slots still run though their end is not waited for any longer."""
        for name, slot in sorted(self._awaited if self._server.alive else ()):
            self.tell(f"{name}[{slot}] still ran when the gate gave up waiting for its end")

    # ---- the client ----

    def _request(self, message: Message) -> None:
        if not self._client.admits(message.id):
            return
        if message.method == "tools/call":
            self._tool_call(message)
        elif message.method.startswith(NOTIFICATIONS):
            self._client.error(message.id, lines.INVALID_REQUEST, "this method is a notification: send no id")
        elif self.gate.binding.gate.methods == "deny" and message.method not in NEEDED:
            self._client.error(message.id, lines.METHOD_NOT_FOUND, "the gate does not pass this method")
        else:
            self._pass(message)

    def _pass(self, message: Message) -> None:
        if not self._server.alive:
            self._client.error(message.id, lines.SERVER_GONE, "the server is gone")
            return
        self._server.remember(message.params)
        number = self._server.request(message.body, Pending(message.method, message.id))
        self._client.passed(message.id, number)

    def _tool_call(self, message: Message) -> None:
        name, arguments = message.params.get("name"), message.params.get("arguments", {})
        arguments = {} if arguments is None else arguments
        if not isinstance(name, str) or not isinstance(arguments, dict):
            text = "tools/call needs a `name`, and `arguments` that are an object"
            self._client.error(message.id, lines.INVALID_PARAMS, text)
            return
        candidates = self.gate.binding.called("tool", name)
        if not candidates and self.gate.binding.passes(name):
            self._pass(message)
            return
        self._server.remember(message.params)
        call = CallId(self.name, next(self._numbers))
        self._client.called(call, message)
        bound = next((each for each in candidates if each.meant(arguments)), None)
        if bound is not None:
            self._ask(call, bound, message.params, arguments)
        else:
            text = "its arguments are those of no request" if candidates else "no request is bound to this tool"
            self.gate.refuse(call, name, "unbound", text)

    def _ask(self, call: CallId, bound: RequestBinding, params: Json, arguments: Json) -> None:
        if self._polls and not self._ready:
            self.gate.refuse(call, bound.request, "starting", "the client has not sent notifications/initialized yet")
            return
        if "task" in params:
            self.gate.refuse(call, bound.request, "unreadable", "call it without a task")
            return
        try:
            args = {each.name: each.read(arguments) for each in bound.arguments}
        except UnreadableField as why:
            self.gate.refuse(call, bound.request, "unreadable", str(why))
        else:
            self.gate.call(call, bound.request, args)

    def _notice(self, message: Message) -> None:
        if not message.method.startswith(NOTIFICATIONS):
            self._unanswerable(message)
            return
        if message.method == "notifications/cancelled":
            self._cancelled(message)
            return
        if message.method == "notifications/initialized":
            self._ready = True
        self._server.send(message.body)

    def _unanswerable(self, message: Message) -> None:
        """Drop a request without an id, which the server may carry out though nobody can be told of a refusal."""
        self.tell(f"a message of the client was dropped: {message.method!r:.60} without an id")
        if message.method == "tools/call":
            name, arguments = message.params.get("name"), message.params.get("arguments")
            outer = name if isinstance(name, str) else message.method
            bound = next((each for each in self.gate.binding.called("tool", outer) if each.meant(arguments)), None)
            call = CallId(self.name, next(self._numbers))
            text = "it has no id, so it cannot be answered"
            self.gate.refuse(call, bound.request if bound else outer, "unreadable", text)

    def _cancelled(self, message: Message) -> None:
        """Cancel an open request of the client; an id that is not open is ignored."""
        id = message.params.get("requestId")
        known = self._client.known(id)
        if isinstance(known, CallId):
            self._client.forget(known)
            self.gate.tell(Cancelled(known))
        elif known is not None and (pending := self._server.pending(known)):
            pending.cancelled = True
            self._client.close(id)
            self._server.send({**message.body, "params": {**message.params, "requestId": known}})

    def _answered_by_client(self, message: Message) -> None:
        for id in self._client.answered(message.id):
            self._server.send({**message.body, "id": id})

    # ---- the server ----

    def _response(self, message: Message) -> None:
        pending = self._server.close(message.id) if isinstance(message.id, int) else None
        if pending is None:
            self.tell("an answer of the server was dropped: nobody waits for it")
        elif pending.watch is not None:
            self._polled(pending.watch, message)
        elif pending.stops is not None:
            self._stopped(pending.stops, message)
        elif pending.slot is not None:
            self._carried_out(pending.slot, message)
        else:
            self._ready = self._ready or (self._server.stateless and "result" in message.body)
            self._reply(pending, message.body)

    def _reply(self, pending: Pending, body: Json) -> None:
        """Give the client the response to a request that was passed on, unless it has cancelled that."""
        if pending.cancelled:
            return
        if pending.method == "tools/list" and self.gate.binding.gate.hide:
            body = without_unbound(body, self.gate.binding)
        self._client.answer(pending.client_id, body)

    def _carried_out(self, slot: SlotId, message: Message) -> None:
        """Take the response to a call that carries out a slot: it tells the end, or that it has started."""
        if self._carries.get(slot) != message.id:
            return  # its end was reported in another way before
        del self._carries[slot]
        held, bound = self.gate.state.slots.get(slot), self.gate.binding.of(slot[0])
        if held is None or bound is None:
            return
        call = self._client.call(held.call)
        if call:
            call.answer = message.body
        entries, strange = (None, "") if bound.started and succeeded(message) else ending(bound, message)
        if strange:
            self.gate.tell(Alarm("unknown-status", *slot, strange))
        if entries is not None:
            self.gate.report(slot, entries)
            return
        if bound.report.watch is not None:
            self._watching.begun(slot, bound.report.watch)
        self._finish(held.call)

    def _stopped(self, slot: SlotId, message: Message) -> None:
        """Take the response to a call that stops a slot: an error is a refusal; with `ends`, success is the end."""
        if not succeeded(message):
            self.gate.tell(CancelRefused(slot))
            return
        bound = self.gate.binding.of(slot[0])
        if bound and bound.cancel and bound.cancel.ends:
            held = self.gate.state.slots.get(slot)
            if held is not None and held.phase == "stopping":
                self.gate.report(slot, {"outcome": "interrupted"})
            elif held is None:
                self.gate.tell(SlotSaid(slot, False))

    def _polled(self, watch: Watch, message: Message) -> None:
        if succeeded(message):
            self._watching.shown(watch, document(message))
        else:
            self._watching.failed(watch, "its tool fails")

    def _notice_of_server(self, message: Message) -> None:
        if message.method == "notifications/cancelled":
            self._client.withdraw(message)
            return
        for watch in self.gate.binding.watches:
            if watch.kind == "notification" and watch.source == message.method:
                self._watching.shown(watch, message.params)
        self._client.send(message.body)

    # ---- what goes out ----

    def do(self, effect: OuterEffect) -> None:
        """Do an effect of the gate: send the messages that it stands for."""
        match effect:
            case Forward(call, slot, args):
                self._forward(call, slot, args)
            case Hold(call, rule, because):
                self._client.hold(call, rule, because)
            case Refuse(call, rule, because):
                self._client.refuse(call, rule, because, self._server.stateless)
            case Stop(slot, rule, because):
                self._stop(slot, rule, because)
            case Finish(call, slot, _):
                self._ended(slot)
                self._finish(call)
            case Alarm():
                self.tell(str(effect))

    def _ended(self, slot: SlotId) -> None:
        """Forget the request that carried out a slot. Without a cancel tool, a cancelled one is never answered."""
        number, bound = self._carries.pop(slot, 0), self.gate.binding.of(slot[0])
        if bound and not bound.cancel:
            self._server.close(number)
        self._awaited.discard(slot)
        self._watching.forget(slot)

    def _forward(self, call: CallId | None, slot: SlotId, args: Args) -> None:
        bound = self.gate.binding.of(slot[0])
        assert bound is not None, "what is not bound is neither asked for nor required"
        self._server.forget(lambda each: each.stops == slot)  # of earlier launches, these say nothing of this one
        self._watching.forget(slot)
        found = self._client.call(call)
        params = {**found.params, "name": bound.inner} if found else self._server.own(own_call(bound, args))
        body = {"jsonrpc": "2.0", "method": "tools/call", "params": params}
        self._carries[slot] = self._server.request(body, Pending("tools/call", slot=slot))

    def _stop(self, slot: SlotId, rule: str, because: str | None) -> None:
        held, cancel = self.gate.state.slots.get(slot), self._cancels.get(slot[0])
        call = self._client.call(held.call) if held else None
        if call:
            call.stopped = rule, because
        if cancel:
            self._server.call(cancel, Pending("tools/call", stops=slot))
        elif slot in self._carries:
            params = {"requestId": self._carries[slot], "reason": reason_text(rule, because)}
            self._server.send(lines.notification("notifications/cancelled", params))
        else:
            self.gate.tell(CancelRefused(slot))

    def _finish(self, call: CallId | None) -> None:
        if call:
            self._client.finish(call, self._server.stateless)

    def _poll(self, watch: Watch) -> None:
        """Call the tool of a watch; an answer to an earlier call, which would be older, is not taken any more."""
        self._server.forget(lambda each: each.watch is watch)
        self._server.call(self._polls[watch.name], Pending("tools/call", watch=watch))
