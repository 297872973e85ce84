"""Proof that bytes are rules: tables from anywhere, decoded by code of its own, decide as a spec says."""

from collections.abc import Iterator
from dataclasses import replace

from exover.certificate.table import Refused, decode
from exover.checks import tables as check
from exover.checks.question import Context, Question
from exover.model.property import NO_PROPERTIES
from exover.model.semantics import Reference
from exover.ocrd import tables as t
from exover.ocrd.compile import Compiled
from exover.ocrd.tables import ALWAYS, NONE
from exover.verify.bdd.analysis import Analysis
from exover.verify.cells import TooLarge


class Undecided(Exception):
    """Whether the bytes are the rules is more than can be followed; the text says why."""


def differences(compiled: Compiled, data: bytes) -> Iterator[str]:
    """Yield in what the tables of these bytes are not the rules of the model; nothing iff they are.

    `compiled`: what this program makes of the model, of which only the meaning of the entries is taken. Raises
    `Undecided` if the rules tell more apart than can be followed.
    """
    try:
        tables = _tables(data)
    except Refused as reason:
        yield str(reason)
        return
    if tables.digest != compiled.tables.digest:
        yield "they were made of another spec: its sha256 is in their header"
        return
    if t.decode(data) != tables:
        yield "two programs that decode the bytes do not read the same"
        return
    if t.counts(compiled.tables)[1:-2] != t.counts(tables)[1:-2]:
        yield "they have other numbers of records than the rules call for"
        return
    misplaced = list(_misplaced(tables))
    if misplaced:
        yield from misplaced
        return
    given = replace(compiled, tables=tables)
    context = Context(given, Analysis(given, Reference(compiled.model), lambda what: None))
    try:
        for subject, location in check.subjects(compiled.model, NO_PROPERTIES):
            found = check.decide(context, Question("tables", "error", subject, location))
            if found.verdict != "holds":
                yield f"{subject}: {found.message}"
    except TooLarge as reason:
        raise Undecided(str(reason)) from reason
    except (IndexError, KeyError, ValueError):
        yield "their records do not fit together as the rules call for"


def _misplaced(tables: t.Tables) -> Iterator[str]:
    """Yield the diagrams in which actions stand that are none of their kind."""
    decisions = {t.REJECT, t.WAIT, t.CLEAR, t.SETTLE, t.KILL, t.DISMISS, t.LAUNCH}
    conditions = [row.predicate for row in tables.features] + [row.predicate for row in tables.pasts]
    conditions += [row.predicate for row in tables.amounts] + [row.condition for row in tables.launches]
    conditions += [row.condition for row in tables.latches]
    roots = [(row.decide, decisions, f"the decision on request {n}") for n, row in enumerate(tables.requests)]
    roots += [(row.root, {t.KILL, t.VIOLATION}, f"the diagram of rule {n}") for n, row in enumerate(tables.rules)]
    for root, codes, what in (*roots, *((root, {t.AGREE}, f"the condition at node {root}") for root in conditions)):
        seen, stack = {NONE, ALWAYS}, [root]
        while stack:
            number = stack.pop()
            if number not in seen:
                seen.add(number)
                node = tables.nodes[number]
                stack += (node.low,) if node.code < 0 else (node.low, node.high)
                if node.code < 0 and -node.code not in codes:
                    yield f"{what} comes to node {number}, which is no action of its kind"


def _tables(data: bytes) -> t.Tables:
    """Return the tables of these bytes as the checks take them, decoded without `exover.ocrd`."""
    found = decode(data)
    sections = {name: tuple(kind(*row) for row in found.sections[name]) for name, kind in t.SECTIONS}
    return t.Tables(
        digest=bytes.fromhex(found.spec),
        flags=found.flags,
        sums=tuple((row.entry, row.factor) for row in found.sums),
        lists=tuple(row.word for row in found.lists),
        reals=tuple(float(value) for value in found.reals),
        **sections,
    )
