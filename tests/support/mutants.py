"""Damaged tables with a right checksum, and who notices.

A mutant *changes a decision* if the walker of its tables answers some stream of events otherwise than the reference
interpreter, or gives up. Each of those must be noticed by the comparison of the bytes with the rules, which runs the
`tables` check on what a second decoder reads, or by the closed loop; `verify` must refuse each with the certificate of
the sound tables, also where the digests in it are made to fit.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from random import Random
from typing import Any

from exover.certificate.check import SolverGaveUp
from exover.certificate.table import Refused
from exover.certificate.verify import verify
from exover.model.property import NO_PROPERTIES
from exover.ocrd import packing
from exover.ocrd import tables as t
from exover.ocrd.machine import Machine
from exover.ocrd.packing import decode, pack
from exover.ocrd.tables import NONE, Node, Tables
from exover.pipeline import Build, build
from exover.proofs.bytes import UndecidedBytes, differences
from exover.proofs.certify import certificate
from exover.run.simulate import simulate
from tests.support.diagrams import check_by_diagrams
from tests.support.engines import model_of
from tests.support.events import Stream
from tests.support.small import small_spec_of

SPECS = Path(__file__).parents[2] / "specs"
STREAMS, EVENTS = 8, 60
"""How many streams of how many events tell whether a mutant changes a decision."""


@dataclass
class Subject:
    """A spec whose tables are damaged."""

    text: str

    @cached_property
    def built(self) -> Build:
        """The sound tables."""
        return build(model_of(self.text))

    @cached_property
    def streams(self) -> list[tuple[list[str], list[str]]]:
        """Streams of events with what the reference interpreter answers."""
        found = []
        for seed in range(STREAMS):
            lines, answers = zip(*Stream(self.built.model, seed).answered(EVENTS), strict=True)
            found.append((list(lines), list(answers)))
        return found

    @cached_property
    def certificate(self) -> dict[str, Any]:
        """The certificate of the sound tables."""
        outcome = check_by_diagrams(self.built.compiled)
        return certificate(
            self.built.compiled, self.built.data, outcome.findings, NO_PROPERTIES, "0", lambda what: None
        )

    def changes(self, mutant: Tables) -> bool:
        """Return whether the walker of damaged tables is seen to answer otherwise than the reference."""
        for lines, answers in self.streams:
            try:
                if list(simulate(self.built.model, Machine(self.built.model, mutant), lines)) != answers:
                    return True
            except (AssertionError, IndexError, KeyError, ValueError, RecursionError):
                return True
        return False

    def noticed(self, data: bytes) -> bool:
        """Return whether the bytes are seen not to be the rules."""
        try:
            return next(iter(differences(self.built.model, data)), None) is not None
        except UndecidedBytes:
            return False

    def refused(self, data: bytes) -> bool:
        """Return whether `verify` refuses the certificate of the sound tables, its digest made to fit."""
        forged = self.certificate | {"table_sha256": sha256(data).hexdigest()}
        try:
            verify(data, forged, None, 20)
        except (Refused, SolverGaveUp):
            return True
        return False


def mutants(tables: Tables, random: Random) -> Iterator[tuple[str, Tables]]:
    """Yield damaged tables without end, with what was done to them."""
    ways = (_bound, _swapped, _dropped, _other_reason, _other_child, _record, _record, _word, _real)
    while True:
        way = random.choice(ways)
        made = way(tables, random)
        if made is not None and made != tables:
            yield way.__name__.strip("_"), made


def _tests(tables: Tables) -> list[int]:
    return [number for number, node in enumerate(tables.nodes) if node.code >= 0]


def _acts(tables: Tables) -> list[int]:
    return [number for number, node in enumerate(tables.nodes) if node.code < 0]


def _with(tables: Tables, number: int, node: Node) -> Tables:
    return replace(tables, nodes=(*tables.nodes[:number], node, *tables.nodes[number + 1 :]))


def _bound(tables: Tables, random: Random) -> Tables | None:
    number = random.choice(_tests(tables))
    node = tables.nodes[number]
    return _with(tables, number, replace(node, bound=node.bound + random.choice((-1, 1))))


def _swapped(tables: Tables, random: Random) -> Tables | None:
    number = random.choice(_tests(tables))
    node = tables.nodes[number]
    return _with(tables, number, replace(node, low=node.high, high=node.low))


def _dropped(tables: Tables, random: Random) -> Tables | None:
    """Let every path that comes to an action go on behind it."""
    gone = random.choice(_acts(tables))
    after = tables.nodes[gone].low
    if after == NONE and tables.nodes[gone].code != -t.KILL:
        return None  # a decision that decides nothing is found when tables are loaded

    def past(child: int) -> int:
        return after if child == gone else child

    nodes = [replace(n, low=past(n.low), high=past(n.high) if n.code >= 0 else n.high) for n in tables.nodes]
    return replace(tables, nodes=tuple(nodes))


def _other_reason(tables: Tables, random: Random) -> Tables | None:
    number = random.choice(_acts(tables))
    node = tables.nodes[number]
    if node.code in (-t.LAUNCH, -t.AGREE):
        return None
    return _with(tables, number, replace(node, bound=random.randrange(len(tables.reasons))))


def _other_child(tables: Tables, random: Random) -> Tables | None:
    number = random.choice(_tests(tables))
    children = [NONE, *range(number + 1, len(tables.nodes))]
    return _with(
        tables, number, replace(tables.nodes[number], **{random.choice(("low", "high")): random.choice(children)})
    )


def _record(tables: Tables, random: Random) -> Tables | None:
    section = random.choice(
        [name for name, _ in packing.SECTIONS if name not in ("nodes", "limits") and getattr(tables, name)]
    )
    rows = getattr(tables, section)
    number = random.randrange(len(rows))
    field = random.choice(rows[number].__slots__)
    changed = replace(rows[number], **{field: getattr(rows[number], field) + random.choice((-1, 1))})
    return replace(tables, **{section: (*rows[:number], changed, *rows[number + 1 :])})


def _word(tables: Tables, random: Random) -> Tables | None:
    if not tables.lists:
        return None
    number = random.randrange(len(tables.lists))
    word = tables.lists[number] + random.choice((-1, 1))
    return replace(tables, lists=(*tables.lists[:number], word, *tables.lists[number + 1 :]))


def _real(tables: Tables, random: Random) -> Tables | None:
    if not tables.reals:
        return None
    number = random.randrange(len(tables.reals))
    value = tables.reals[number] + random.choice((-0.25, 0.25))
    return replace(tables, reals=(*tables.reals[:number], value, *tables.reals[number + 1 :]))


@dataclass(frozen=True)
class Tally:
    """What became of mutants: how many there were, changed a decision, and were noticed by whom; the missed ones."""

    made: int
    counts: Counter[str]
    missed: tuple[str, ...]


def tally(subject: Subject, count: int, seed: int, proofs: int) -> Tally:
    """Return what became of so many mutants of a spec; the first `proofs` of them are shown to `verify` too."""
    counts: Counter[str] = Counter()
    missed = []
    source = mutants(subject.built.tables, Random(seed))
    for number in range(count):
        way, mutant = next(source)
        data = pack(mutant)
        noticed, changes = subject.noticed(data), subject.changes(decode(data))
        counts["noticed by the tables check"] += noticed
        counts["changes a decision"] += changes
        if number < proofs:
            counts["shown to verify"] += 1
            counts["refused by verify"] += subject.refused(data)
        if changes and not noticed:
            missed.append(f"{way} {number} of seed {seed}")
    return Tally(count, counts, tuple(missed))


SUBJECTS: tuple[str | int, ...] = ("rover", "assistant", "satellite", 3, 7, 11, 15, 22)
"""The specs whose tables are damaged: names, and seeds of small ones."""


def subject_of(spec: str | int) -> Subject:
    """Return one of `SUBJECTS`."""
    return Subject(small_spec_of(spec) if isinstance(spec, int) else (SPECS / f"{spec}.exo").read_text())
