"""Tables that contradict themselves, made by hand."""

from dataclasses import replace

from exover.ocrd.tables import Node, Tables
from exover.pipeline import build as build_tables
from tests.runtime.compiling import (
    model_of,
)

MODEL = model_of("spec s; module m { request a(); request b(); request c(); } mutex m.c over m.a, m.b;")
TABLES = build_tables(MODEL).tables


def edited(change: dict[int, Node]) -> Tables:
    return replace(TABLES, nodes=tuple(change.get(number, node) for number, node in enumerate(TABLES.nodes)))


def all_actions(code: int, to: Node) -> Tables:
    """Return the tables with every action of this code replaced."""
    return edited({number: to for number, node in enumerate(TABLES.nodes) if node.code == -code})
