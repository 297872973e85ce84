"""Proof that tables, given by their bytes, decide as the rules of a spec say."""

from collections.abc import Iterator

from exover.certificate.table import Refused, decode
from exover.engines.bdd.loopsets import LoopSets
from exover.equivalence import path_equivalence as paths
from exover.equivalence.entry_equivalence import plain_entries
from exover.equivalence.path_feasibility import PathFeasibility
from exover.equivalence.record_equivalence import different_records, kinds_of_events
from exover.equivalence.state_equivalence import StateComparison
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.canonical import digest
from exover.model.model import Model
from exover.model.property import NO_PROPERTIES
from exover.ocrd import packing
from exover.ocrd import tables as t
from exover.ocrd.compile import DecodedTables
from exover.ocrd.structure import verify


class UndecidedBytes(Exception):
    """It is not decided whether the bytes decide as the rules do; the text says why."""


def differences(model: Model, data: bytes) -> Iterator[str]:
    """Yield how the tables of these bytes differ from the rules of a model; nothing iff they decide the same.

    Raises `UndecidedBytes` if the rules distinguish too many values.
    """
    try:
        tables = _tables(data)
        if tables.digest != digest(model):
            yield "they were made of another spec: its sha256 is in their header"
            return
        verify(tables, model)
    except (Refused, packing.DamagedTable) as reason:
        yield str(reason)
        return
    try:
        misplaced = list(_misplaced(tables))
        yield from misplaced or _otherwise(model, tables)
    except TooLarge as reason:
        raise UndecidedBytes(str(reason)) from reason
    except (IndexError, KeyError, ValueError):
        yield "their records do not fit together as the rules call for"


def _otherwise(model: Model, tables: t.Tables) -> Iterator[str]:
    """Yield how the tables decide otherwise than the rules; each diagram must have only actions of its kind."""
    plain = plain_entries(model, tables)
    entries = tuple(plain[entry] for entry in sorted(plain))
    if len(entries) != len(tables.entries):  # what predicates of arguments mean is asked of the compiler, then proved
        from exover.ocrd.compile import compile_model

        compiled = compile_model(model, tables.digest)
        if packing.counts(compiled.tables)[1:-2] != packing.counts(tables)[1:-2]:
            yield "they have other numbers of records than the rules call for"
            return
        entries = compiled.entries
    try:
        yield from _beside(DecodedTables(model, tables, entries))
        return
    except paths.UndecidedPaths:
        pass
    loop = ClosedLoop(model, tables, entries)
    equivalence = StateComparison(LoopSets(loop, NO_PROPERTIES))
    for kind, name, _ in kinds_of_events(model):
        yield from different_records(equivalence.records, kind, name)
    yield from (f"the decision on `{request.name}`" for request in model.requests if not equivalence.decides(request))
    yield from equivalence.differences()


def _beside(read: DecodedTables) -> tuple[str, ...]:
    """Return how the two differ, by following the paths of their diagrams; raises `UndecidedPaths`."""
    beside = paths.PathComparison(read, PathFeasibility(read))
    found = dict.fromkeys(
        what for kind, name, _ in kinds_of_events(read.model) for what in beside.different(kind, name)
    )
    return tuple(found)


def _misplaced(tables: t.Tables) -> Iterator[str]:
    """Yield the diagrams that have an action which is not allowed in a diagram of their kind."""
    decisions = {t.REJECT, t.WAIT, t.CLEAR, t.SETTLE, t.KILL, t.DISMISS, t.LAUNCH}
    conditions = [row.predicate for row in tables.features] + [row.predicate for row in tables.pasts]
    conditions += [row.predicate for row in tables.amounts] + [row.condition for row in tables.launches]
    conditions += [row.condition for row in tables.latches]
    roots = [(row.decide, decisions, f"the decision on request {n}") for n, row in enumerate(tables.requests)]
    roots += [(row.root, {t.KILL, t.VIOLATION}, f"the diagram of rule {n}") for n, row in enumerate(tables.rules)]
    roots += [(row.root, {t.VIOLATION}, f"the diagram of invariant {n}") for n, row in enumerate(tables.invariants)]
    for root, codes, what in (*roots, *((root, {t.AGREE}, f"the condition at node {root}") for root in conditions)):
        for number in tables.below(root):
            if tables.nodes[number].code < 0 and -tables.nodes[number].code not in codes:
                yield f"{what} comes to node {number}, which is no action of its kind"


def _tables(data: bytes) -> t.Tables:
    """Return the tables of these bytes; raises `Refused` if the decoder of the checker reads them otherwise."""
    found = decode(data)
    tables = packing.decode(data)
    if packing.words(tables) != list(found.words) or found.spec != tables.digest.hex() or found.doubles != tables.reals:
        raise Refused("two programs that decode the bytes do not read the same")
    return tables
