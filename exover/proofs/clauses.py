"""Clauses over the latches of a graph as formulas over the state that the checker of certificates knows."""

from collections.abc import Iterable, Iterator
from dataclasses import field

from exover.dataclass import dataclass
from exover.engines.aig.circuit.answer import Clause
from exover.engines.aig.circuit.words import Grid
from exover.engines.aig.encoding.state import AllocatedRange, Latches
from exover.loop.exact.layout import level_name
from exover.loop.exact.term import numeral
from exover.model.types import Bool, Real
from exover.proofs.statement import Statement, Unsaid, conjunction, constant, disjunction

MOST_PIECES = 256
"""A clause that needs more ranges of a number than this is not written."""
Piece = tuple[int, int]


@dataclass
class Clauses:
    """Writes clauses over the latches of one encoding as formulas."""

    latches: Latches
    statement: Statement
    _flags: dict[str, str] = field(default_factory=dict)
    """By variable of one latch that tells a phase or whether there is a past: the condition that the latch is true."""
    _values: dict[str, tuple[str, str]] = field(default_factory=dict)
    """By variable that is a value: its term, and the condition under which something holds the value."""

    def __post_init__(self) -> None:
        statement, latches = self.statement, self.latches
        self._values |= {name: (here, "true") for name, (here, _) in statement.readings.items()}
        self._values |= {level_name(name): (here, "true") for name, here in statement.levels.items()}
        for (request, slot), names in latches.slots.items():
            here = statement.slots(request)[slot]
            self._two(names.active, names.stopping, f"phase.{here}")
            self._held(names.args, f"arg.{here}", self._flags[names.active])
        for request, place in latches.places.items():
            here = statement.request[request]
            self._two(place.taken, place.clearing, f"place.{here}")
            self._held(place.args, f"held.{here}", self._flags[place.taken])
        for request, memory in latches.memories.items():
            here = statement.request[request]
            self._flags[memory.known] = f"past.{here}"
            self._values[memory.last] = f"last.{here}", "true"
            self._held(memory.values, f"past.{here}", f"past.{here}")
        self._first = {node: bool(initial) for node, initial in latches.terms.graph.latches}
        self._owner = {bit >> 1: (name, k) for name, bits in latches.literals.items() for k, bit in enumerate(bits)}

    def _two(self, there: str, leaving: str, name: str) -> None:
        self._flags |= {there: f"(not (= {name} 0))", leaving: f"(= {name} 2)"}

    def _held(self, names: tuple[str, ...], prefix: str, counts: str) -> None:
        self._values |= {name: (f"{prefix}.{k}", counts) for k, name in enumerate(names)}

    def text(self, clause: Clause) -> str:
        """Return a clause as a formula; raises `Unsaid` if it reads what the checker does not know."""
        literals: dict[str, dict[int, bool]] = {}
        for literal in clause:
            if literal >> 1 not in self._owner:
                raise Unsaid("a clause is about what a step remembers")
            name, bit = self._owner[literal >> 1]
            if literals.setdefault(name, {}).setdefault(bit, not literal & 1) == bool(literal & 1):
                return "true"
        return disjunction([self._some(name, bits) for name, bits in literals.items()])

    def _some(self, name: str, bits: dict[int, bool]) -> str:
        """Return the condition that some bit of a variable has its value in `bits`, which are by number."""
        if name in self._flags:
            return self._flags[name] if bits[0] else _not(self._flags[name])
        here, counts = self._values[name]
        span, kind = self.latches.spans[name], self.latches.types[name]
        if isinstance(kind, Bool):
            found = f"(= {here} {int(bits[0])})"
        else:
            found = disjunction([_between(here, span, piece) for piece in pieces(span, bits)])
        if counts == "true":
            return found
        first = any(self._first[self.latches.literals[name][k] >> 1] == value for k, value in bits.items())
        return disjunction([_not(counts), found]) if first else conjunction([counts, found])


def _not(text: str) -> str:
    return text[len("(not ") : -1] if text.startswith("(not ") else f"(not {text})"


def pieces(span: AllocatedRange, bits: dict[int, bool]) -> list[Piece]:
    """Return the ranges, of numbers or of cells of a grid, in which some bit has its value in `bits`.

    Raises `Unsaid` if they are too many, or if the bits distinguish places within a cell.
    """
    places = 0 if span.grid is None else span.grid.places
    lowest = min(bits)
    if lowest < places or (span.low | span.high) & ((1 << places) - 1):
        raise Unsaid("a clause is about places of reals that are compared with each other")
    count, width = (span.high - span.low >> lowest) + 1, 1 << lowest
    if count > 4 * MOST_PIECES:
        raise Unsaid("a clause tells too many numbers apart")
    found: list[Piece] = []
    for block in range(count):
        if any(bool(block << lowest >> k & 1) == value for k, value in bits.items()):
            low = span.low + block * width
            high = min(low + width - 1, span.high)
            found[-1:] = [(found[-1][0], high)] if found and found[-1][1] == low - 1 else [*found[-1:], (low, high)]
    if len(found) > MOST_PIECES:
        raise Unsaid("a clause tells too many numbers apart")
    return [(low >> places, high >> places) for low, high in found]


def _between(name: str, span: AllocatedRange, piece: Piece) -> str:
    """Return the condition that a number, or the cell of a real, is in a range."""
    places = 0 if span.grid is None else span.grid.places
    ends = span.low >> places, span.high >> places
    low, high = piece
    bounds = [] if low == ends[0] else [_least(name, low, span.grid)]
    bounds += [] if high == ends[1] else [_most(name, high, span.grid)]
    return conjunction(bounds)


def _least(name: str, low: int, grid: Grid | None) -> str:
    if grid is None:
        return f"(<= {numeral(low)} {name})"
    return f"(<= {_constant(grid, low // 2)} {name})" if low % 2 else f"(< {_constant(grid, low // 2 - 1)} {name})"


def _most(name: str, high: int, grid: Grid | None) -> str:
    if grid is None:
        return f"(<= {name} {numeral(high)})"
    return f"({'<=' if high % 2 else '<'} {name} {_constant(grid, high // 2)})"


def _constant(grid: Grid, which: int) -> str:
    return constant(Real(), float(grid.constants[which]))


def written(clauses: Iterable[Clause], writer: Clauses) -> Iterator[str]:
    """Yield the formulas of the clauses that can be written, but no tautologies."""
    for clause in clauses:
        try:
            text = writer.text(clause)
        except Unsaid:
            continue
        if text != "true":
            yield text
