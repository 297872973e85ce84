"""Reads the results of MCP tool calls, and makes the calls and results that the gate sends itself."""

import json
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from exover.gate.binding import Binding, RequestBinding
from exover.gate.fields import place, select, with_lists
from exover.gate.mcp.lines import BadLine, Message
from exover.gate.outer import reason_text
from exover.gate.watching import outcome_of
from exover.model.event import Args
from exover.model.wire import Json

ENVELOPE = "io.modelcontextprotocol/"
"""The prefix of the `_meta` keys that each request of a stateless session carries."""
MAX_TEXT = 1 << 20
"""The most characters of a text content that is read as a JSON object."""


def refusal(rule: str, because: str | None, verb: str = "refused") -> Json:
    """Return the tool error for a call that was refused, or as `verb` says stopped, by a rule."""
    meta = {"exover/rule": rule} | ({"exover/because": because} if because else {})
    return {
        "content": [{"type": "text", "text": f"{verb} by {reason_text(rule, because)}"}],
        "isError": True,
        "_meta": meta,
    }


def succeeded(response: Message) -> bool:
    """Return whether MCP counts the tool call as successful: a result without `isError`."""
    found = response.body.get("result")
    return isinstance(found, dict) and found.get("isError") is not True


def document(response: Message) -> Any:
    """Return a tool result's structured content, else its first text that is a JSON object, else an empty object."""
    found = response.body.get("result")
    if not isinstance(found, dict):
        return {}
    if isinstance(found.get("structuredContent"), dict):
        return found["structuredContent"]
    content = found.get("content")
    for part in content if isinstance(content, list) else ():
        text = part.get("text") if isinstance(part, dict) else None
        with suppress(ValueError, RecursionError, BadLine):
            read = json.loads(text) if isinstance(text, str) and len(text) <= MAX_TEXT else None
            if isinstance(read, dict):
                return read
    return {}


def ending(bound: RequestBinding, response: Message) -> tuple[Json | None, str]:
    """Return the entries of the report that a response stands for, None if its status is `running`; and a complaint.

    The complaint says that the status is not in the binding; else it is empty.
    """
    found = response.body.get("result")
    if isinstance(found, dict) and found.get("resultType") == "input_required":
        return {"outcome": "interrupted"}, ""
    report, shown = bound.report, document(response)
    if report.status is None or report.watch is not None or not succeeded(response):
        return outcome_of(report, "ok" if succeeded(response) else "failed", None, shown), ""
    status = select(shown, report.status)
    meaning = report.meaning(status)
    if meaning is None:
        return {"outcome": "failed"}, f"the status {status!r:.60} is not in the binding"
    return (None, "") if meaning == "running" else (outcome_of(report, meaning, status, shown), "")


def own_call(bound: RequestBinding, args: Args) -> Json:
    """Return the parameters of a `tools/call` that the gate makes itself, for what a launch rule requires."""
    arguments: Json = {}
    for path, value in bound.own_values(args):
        place(arguments, path, value)
    return {"name": bound.inner, "arguments": {key: with_lists(value) for key, value in arguments.items()}}


def envelope(params: Mapping[str, Any]) -> Json:
    """Return the `_meta` entries of these parameters that all requests of a stateless session have to carry."""
    meta = params.get("_meta")
    if not isinstance(meta, dict):
        return {}
    return {key: value for key, value in meta.items() if key.startswith(ENVELOPE)}


def without_unbound(body: Json, binding: Binding) -> Json:
    """Return the response to `tools/list` without the tools whose calls would be refused as `unbound`."""
    found = body.get("result")
    if not isinstance(found, dict) or not isinstance(found.get("tools"), list):
        return body
    named = [tool for tool in found["tools"] if isinstance(tool, dict) and isinstance(tool.get("name"), str)]
    kept = [tool for tool in named if binding.called("tool", tool["name"]) or binding.passes(tool["name"])]
    return {**body, "result": {**found, "tools": kept}}
