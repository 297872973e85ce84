"""The tables as JSON: every number of the bytes, with names and meanings."""

import json
from dataclasses import asdict

from exover.bounds.events import EventBounds
from exover.bounds.sizes import sizes, state_bytes, word_bytes
from exover.emit.artefact import Artefact
from exover.emit.describe import Description
from exover.model.model import Model, Parameter
from exover.model.types import Bool, Enum, Int, Real
from exover.model.wire import Json
from exover.ocrd.packing import FIELDS, SECTIONS, VERSION, row
from exover.ocrd.tables import NONE, UNCHECKED, Node, Tables


def emit(model: Model, tables: Tables, most: EventBounds | None = None) -> tuple[Artefact, ...]:
    """Return `NAME.json`."""
    found = document(model, tables, most)
    lines = ",\n".join(f"  {json.dumps(key)}: {_value(value)}" for key, value in found.items())
    return (Artefact(f"{model.name}.json", f"{{\n{lines}\n}}\n".encode()),)


def _value(value: object) -> str:
    """Return a value as JSON, a list with one element on each line."""
    if not isinstance(value, list) or not value:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    return "[\n" + ",\n".join(f"    {json.dumps(v, ensure_ascii=False, allow_nan=False)}" for v in value) + "\n  ]"


def document(model: Model, tables: Tables, most: EventBounds | None = None) -> Json:
    """Return the document: the header, names and meanings, then the sections as they are packed."""
    words = Description(model, tables)
    roots: dict[str, list[Json]] = {"roots": [{"event": label, "node": node} for label, node in words.roots()]}
    return {
        "spec": model.name,
        "format": VERSION,
        "sha256": tables.digest.hex(),
        "unchecked": bool(tables.flags & UNCHECKED),
        "width": word_bytes(tables),
        "state_width": state_bytes(tables),
        "sizes": asdict(sizes(tables, most)),
        **roots,
        "nodes": [_node(words, number, node) for number, node in enumerate(tables.nodes)],
        "entries": [
            {"entry": number, "is": text, "initial": entry.initial}
            for number, (text, entry) in enumerate(zip(words.entries, tables.entries, strict=True))
        ],
        "reasons": [asdict(reason) for reason in words.reasons],
        "requests": [
            {
                "name": request.name,
                "instances": request.instances,
                "params": [_parameter(parameter) for parameter in request.params],
                "results": [_parameter(parameter) for parameter in request.results],
                "statuses": list(request.statuses),
            }
            for request in model.requests
        ],
        "variables": [_parameter(Parameter(*variable)) for variable in words.variables],
        "stocks": list(words.stocks),
        "fields": {name: FIELDS[name] for name, _ in SECTIONS},
        **{f"section_{name}": [row(record) for record in getattr(tables, name)] for name, _ in SECTIONS},
        "section_sums": [list(pair) for pair in tables.sums],
        "section_lists": list(tables.lists),
        "section_reals": [real if abs(real) != float("inf") else repr(real) for real in tables.reals],
    }


def _node(words: Description, number: int, node: Node) -> Json:
    if node.code < 0:
        return {"node": number, "do": words.action(node), "then": _child(node.low)}
    return {"node": number, "if": words.test(node), "then": _child(node.low), "else": _child(node.high)}


def _child(node: int) -> int | None:
    return None if node == NONE else node


def _parameter(parameter: Parameter) -> Json:
    match parameter.type:
        case Bool():
            kind: Json = {"type": "bool"}
        case Int(low, high):
            kind = {"type": "int", "low": low, "high": high}
        case Enum(values):
            kind = {"type": "enum", "values": list(values)}
        case Real(low, high):
            bounds = {"low": low, "high": high}
            kind = {"type": "real", **{side: b for side, b in bounds.items() if abs(b) != float("inf")}}
    return {"name": parameter.name, **kind}
