"""Reads `NAME.bind.toml`: returns a binding of a model, or mistakes with their places (docs/binding.md)."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from exover.diagnostics import Diagnostic, did_you_mean, quote
from exover.gate import schema
from exover.gate.binding import (
    KINDS,
    MEANINGS,
    SOURCES,
    STOP,
    Binding,
    CancelTool,
    Defaults,
    PosterBinding,
    ReportBinding,
    RequestBinding,
    StatusMeaning,
    Watch,
    key_of,
)
from exover.gate.consistency import note_inconsistencies
from exover.gate.fields import MISSING, FieldPath, UnreadableField, ValueField, decimal, is_value, path_of
from exover.model.model import Model, Parameter, Request
from exover.model.types import Bool, Enum, Type, Value
from exover.model.waiting import may_wait
from exover.model.wire_reading import domain
from exover.source import Source
from exover.toml import KeyPath, read_toml
from exover.toml_schema import MistakeList

K = TypeVar("K", bound=str)
MAX_LINE = 4 << 20
"""The default of `max-line`: bytes of the longest message."""


def read_binding(source: Source, model: Model) -> tuple[Binding | None, tuple[Diagnostic, ...]]:
    """Return the binding in a file, None if it has a mistake; and its mistakes and warnings in text order."""
    read = read_toml(source)
    if isinstance(read, Diagnostic):
        return None, (read,)
    content, places = read
    mistakes = MistakeList(places)
    found = _Reader(model, mistakes, mistakes.table((), content, schema.FILE, "a binding")).binding()
    told = mistakes.sorted()
    return (None if any(each.severity == "error" for each in told) else found), told


class _Reader:
    """Reads the tables of one file; notes every mistake, and leaves out the entries that have one."""

    def __init__(self, model: Model, mistakes: MistakeList, content: Mapping[str, Any]) -> None:
        self._model = model
        self._mistakes = mistakes
        self._content = content
        self._waiting = may_wait(model)
        self._gate = mistakes.table(("gate",), content.get("gate", {}), schema.GATE, "`gate`")
        self._watches = {name: self._watch(name, table) for name, table in content.get("watch", {}).items()}

    def binding(self) -> Binding:
        """Return the binding, as far as the file has no mistakes, and note those of all tables together."""
        requests, posters = tuple(self._known_requests()), tuple(self._known_posters())
        binding = Binding(self._defaults(), requests, tuple(self._watches.values()), posters)
        named, read = (self._content.get(kind, {}).keys() for kind in ("request", "poster"))
        note_inconsistencies(self._model, binding, named, read, self._mistakes)
        return binding

    # ---- [gate] ----

    def _defaults(self) -> Defaults:
        spec = self._gate.get("spec", "")
        if self._mistakes.missing(("gate",), self._gate, "spec"):
            advice = f'write spec = "{self._model.name}" below [gate]'
            self._mistakes.say("E702", "the binding does not say for which spec it is", ("gate", "spec"), advice)
        elif spec and spec != self._model.name:
            message = f"the binding is for {quote(spec)}, and the spec is {quote(self._model.name)}"
            self._mistakes.say("E703", message, ("gate", "spec"))
        given = self._gate.get
        return Defaults(
            spec,
            given("unbound", "deny"),
            tuple(given("pass", ())),
            given("hide", True),
            given("methods", "pass"),
            given("max-line", MAX_LINE),
            given("client-death", "abort"),
        )

    # ---- [watch.NAME] ----

    def _watch(self, name: str, found: Any) -> Watch:
        path: KeyPath = ("watch", name)
        table = self._mistakes.table(path, found, schema.WATCH, f"the watch {quote(name)}")
        kind = self._one(path, table, found, SOURCES, f"the watch {quote(name)}")
        if kind == "topic" and self._mistakes.missing(path, table, "type"):
            self._mistakes.say("E702", f"the topic of the watch {quote(name)} has no `type`", path)
        given = {key: table[key] for key in ("type", "arguments", "every", "stale", "latched") if key in table}
        return Watch(name, kind, table.get(kind, ""), **given)

    def _one(self, path: KeyPath, table: Mapping[str, Any], found: Any, keys: tuple[K, ...], what: str) -> K:
        """Return the first of these keys that the table has, else the first key; note a mistake unless it has one."""
        there = [key for key in keys if key in table]
        if len(there) > 1:
            self._mistakes.say("E706", f"{what} is both {' and '.join(there)}", (*path, there[1]), "write one of them")
        if not there and not (isinstance(found, dict) and any(key in found for key in keys)):
            listed = ", ".join(f"`{key}`" for key in keys)
            self._mistakes.say("E702", f"{what} has none of {listed}", path)
        return there[0] if there else keys[0]

    # ---- [request."NAME"] ----

    def _known_requests(self) -> Iterator[RequestBinding]:
        known = self._model.request
        for name, found in self._content.get("request", {}).items():
            if name in known:
                yield self._request(known[name], found)
            else:
                advice = did_you_mean(name, known) or 'requests are written as [request."MODULE.REQUEST"]'
                self._mistakes.say("E701", f"the spec has no request {quote(name)}", ("request", name), advice)

    def _request(self, request: Request, found: Any) -> RequestBinding:
        path: KeyPath = ("request", request.name)
        table = self._mistakes.table(path, found, schema.REQUEST, quote(request.name))
        kind = self._one(path, table, found, KINDS, quote(request.name))
        if kind != "tool" and self._mistakes.missing(path, table, "type"):
            self._mistakes.say(
                "E702", f"{quote(request.name)} has no `type`", path, "as nav2_msgs/action/NavigateToPose"
            )
        report = self._report(request, table)
        idle = "start" in table or ("start" in self._gate and report.watch is None)
        self._needed(path, request, table, report, idle)
        return RequestBinding(
            request.name,
            kind,
            table.get(kind, ""),
            table.get("inner", table.get(kind, "")),
            table.get("type"),
            _paths(table.get("when", {})),
            self._fields((*path, "arguments"), table.get("arguments", {}), request.params, "parameter", request.name),
            _paths(table.get("constants", {})),
            table.get("wait", self._gate.get("wait")),
            table.get("answer", self._gate.get("answer")),
            table.get("stop", self._gate.get("stop", STOP)),
            self._cancel(path, table),
            table.get("started", False),
            idle,
            report,
            _paths(table.get("refused", {})),
        )

    def _needed(
        self, path: KeyPath, request: Request, table: Mapping[str, Any], report: ReportBinding, idle: bool
    ) -> None:
        """Note the keys that a request needs and does not have."""
        name = quote(request.name)
        missing = self._mistakes.missing
        watched = report.watch is not None or self._spoilt_watch(path)
        untimed = missing(path, table, "wait") and missing(("gate",), self._gate, "wait")
        if untimed and request.name in self._waiting:
            self._mistakes.say("E702", f"{name} can wait, and nothing says how long", path, "write wait = SECONDS")
        if table.get("started") and not watched:
            advice = f'write [request."{request.name}".report] with watch, status and running'
            self._mistakes.say("E702", f"nothing tells when {name} has ended", (*path, "started"), advice)
        unsaid = missing(path, table, "start") and missing(("gate",), self._gate, "start")
        if not idle and unsaid and not watched and "action" not in table:
            advice = 'write start = "idle" if starting the server stops it, or a report with a watch'
            self._mistakes.say("E702", f"nothing tells whether {name} runs when the gate starts", path, advice)
        if "service" in table and missing(path, table, "refused"):
            advice = 'write refused = { success = false, message = "{reason}" } with fields of its response'
            self._mistakes.say("E702", f"nothing tells a client that {name} was refused", path, advice)
        self._tools_only(path, name, table)
        ends = table.get("cancel", {}).get("ends", False) is not False or not missing(path, {}, "cancel")
        if "tool" in table and not watched and not ends:
            advice = "write a report with a watch, or cancel = { tool = …, ends = true }"
            message = f"a cancelled {name} may never be known to end: MCP servers do not answer what is cancelled"
            self._mistakes.say("E707", message, path, advice, "warning")

    def _spoilt_watch(self, path: KeyPath) -> bool:
        """Return whether a request has a `report`, or a `watch` in it, of the wrong type."""
        return not {(*path, "report"), (*path, "report", "watch")}.isdisjoint(self._mistakes.spoilt)

    def _tools_only(self, path: KeyPath, name: str, table: Mapping[str, Any]) -> None:
        """Note keys that do not belong to this kind of request: tool, action or service."""
        if "cancel" in table and ("action" in table or "service" in table):
            self._mistakes.say("E706", f"{name} is no tool: it has no `cancel`", (*path, "cancel"))
        if "action" in table and "started" in table:
            self._mistakes.say("E706", f"{name} is an action: it tells its end", (*path, "started"))
        if "action" in table and "watch" in table.get("report", {}):
            self._mistakes.say("E706", f"{name} is an action: it tells its end", (*path, "report", "watch"))
        if "refused" in table and "service" not in table:
            self._mistakes.say("E706", f"{name} is no service: it has no `refused`", (*path, "refused"))

    def _cancel(self, path: KeyPath, table: Mapping[str, Any]) -> CancelTool | None:
        if "cancel" not in table:
            return None
        path = (*path, "cancel")
        found = self._mistakes.table(path, table["cancel"], schema.CANCEL, "`cancel`")
        if "tool" not in table["cancel"]:
            self._mistakes.say("E702", "`cancel` has no `tool`", path)
        return CancelTool(found.get("tool", ""), found.get("arguments", {}), found.get("ends", False))

    def _report(self, request: Request, table: Mapping[str, Any]) -> ReportBinding:
        path: KeyPath = ("request", request.name, "report")
        found = self._mistakes.table(path, table.get("report", {}), schema.REPORT, "`report`")
        watch = self._named_watch((*path, "watch"), found.get("watch"))
        if watch is not None:
            if request.instances > 1:
                message = f"a watch cannot tell the {request.instances} instances of {quote(request.name)} apart"
                self._mistakes.say("E706", message, (*path, "watch"))
            for key in ("status", "running"):
                if self._mistakes.missing(path, found, key):
                    self._mistakes.say("E702", f"a report with a watch has no `{key}`", path)
        meanings: dict[tuple[bool, Any], StatusMeaning] = {}
        fails: dict[tuple[bool, Any], str] = {}
        for meaning in MEANINGS:
            for status in found.get(meaning, ()):
                self._once((*path, meaning), meanings, status, meaning)
        for name, statuses in found.get("fails", {}).items():
            if name not in request.statuses:
                advice = did_you_mean(name, request.statuses)
                message = f"{quote(request.name)} does not fail as {quote(name)}"
                self._mistakes.say("E701", message, (*path, "fails", name), advice)
            for status in statuses:
                self._once((*path, "fails", name), meanings, status, "failed")
                fails[key_of(status)] = name
        results = self._fields((*path, "results"), found.get("results", {}), request.results, "result", request.name)
        status = path_of(found["status"]) if "status" in found else None
        return ReportBinding(watch, status, meanings, fails, results)

    def _once(
        self, path: KeyPath, meanings: dict[tuple[bool, Any], StatusMeaning], status: Any, meaning: StatusMeaning
    ) -> None:
        before = meanings.get(key_of(status))
        if before is not None:
            advice = "once" if before == meaning else f"as {quote(meaning)} or as {quote(before)}"
            message = f"the status {status!r} {'is listed twice' if before == meaning else 'has two meanings'}"
            self._mistakes.say("E705", message, path, f"leave it in one list, {advice}")
        meanings[key_of(status)] = meaning

    def _named_watch(self, path: KeyPath, name: str | None) -> str | None:
        if name is not None and name not in self._watches:
            self._mistakes.say("E704", f"there is no watch {quote(name)}", path, did_you_mean(name, self._watches))
        return name

    # ---- fields ----

    def _fields(
        self, path: KeyPath, table: Mapping[str, Any], parameters: tuple[Parameter, ...], word: str, owner: str
    ) -> tuple[ValueField, ...]:
        """Return the field of each parameter, in order; one that the table does not list is at its own name."""
        known = [parameter.name for parameter in parameters]
        for name in table:
            if name not in known:
                message = f"{quote(owner)} has no {word} {quote(name)}"
                self._mistakes.say("E701", message, (*path, name), did_you_mean(name, known))
        return tuple(self._field((*path, each.name), each.name, each.type, table.get(each.name)) for each in parameters)

    def _field(self, path: KeyPath, name: str, kind: Type, found: Any) -> ValueField:
        if found is None or isinstance(found, str):
            return ValueField(name, kind, path_of(found or name))
        table = self._mistakes.table(path, found, schema.FIELD, f"the field of {quote(name)}")
        field = self._scaled(path, name, kind, table)
        if "default" in table and len(table) == len(found):
            self._default((*path, "default"), field)
        return field

    def _default(self, path: KeyPath, field: ValueField) -> None:
        """Note a default that gives no value of the field's type: each call that needs it would be refused."""
        code = "E701" if isinstance(field.type, Enum) and isinstance(field.default, str) else "E603"
        try:
            inner = field.read({})
        except UnreadableField as why:
            self._mistakes.say(code, f"the default of {quote(field.name)} cannot be read: {why}", path)
            return
        if not is_value(field.type, inner):
            message = f"the default of {quote(field.name)} is read as {inner!s:.60}, not {domain(field.type)}"
            self._mistakes.say(code, message, path)

    def _scaled(self, path: KeyPath, name: str, kind: Type, table: Mapping[str, Any]) -> ValueField:
        named = isinstance(kind, Enum | Bool)
        for key in ("scale", "offset") if named else ("values",):
            if key in table:
                what = "no number" if named else "a number"
                self._mistakes.say("E706", f"{quote(name)} is {what}: it has no `{key}`", (*path, key))
        values = {} if not named else table.get("values", {})
        for outer, inner in values.items():
            self._value((*path, "values", outer), kind, inner)
        return ValueField(
            name,
            kind,
            path_of(table.get("field", name)),
            decimal(table.get("scale", 1)),
            decimal(table.get("offset", 0)),
            values,
            table.get("default", MISSING),
        )

    def _value(self, path: KeyPath, kind: Type, inner: Value) -> None:
        if isinstance(kind, Enum) and inner not in kind.values:
            advice = did_you_mean(str(inner), kind.values) or f"it is one of {', '.join(kind.values)}"
            self._mistakes.say("E701", f"there is no value {quote(str(inner))}", path, advice)
        if isinstance(kind, Bool) and not isinstance(inner, bool):
            self._mistakes.say("E603", f"{quote(str(inner))} is neither true nor false", path)

    # ---- [poster."NAME"] ----

    def _known_posters(self) -> Iterator[PosterBinding]:
        known = self._model.observable
        for name, found in self._content.get("poster", {}).items():
            path: KeyPath = ("poster", name)
            if name not in known:
                advice = did_you_mean(name, known)
                self._mistakes.say("E701", f"the spec has no poster {quote(name)}", path, advice)
                continue
            table = self._mistakes.table(path, found, schema.POSTER, quote(name))
            if isinstance(found, dict) and "watch" not in found:
                self._mistakes.say("E702", f"nothing says where {quote(name)} is read", path, 'write watch = "…"')
            watch = self._named_watch((*path, "watch"), table.get("watch"))
            yield PosterBinding(name, watch or "", self._scaled(path, name, known[name], table))


def _paths(table: Mapping[str, Any]) -> tuple[tuple[FieldPath, Any], ...]:
    return tuple((path_of(path), value) for path, value in table.items())
