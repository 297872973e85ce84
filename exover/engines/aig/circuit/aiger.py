"""Circuits as files in the format AIGER 1.9 (Biere, Heljanko, Wieringa 2011), binary and ASCII."""

from collections.abc import Iterator

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import Circuit, Literal


@dataclass(frozen=True, slots=True)
class Names:
    """A symbol table: names in the order of what is named; "" for none, and names at the end may be left out."""

    inputs: tuple[str, ...] = ()
    latches: tuple[str, ...] = ()
    bad: tuple[str, ...] = ()
    justice: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Document:
    """The contents of a file.

    `justice`: for each question literals; is there a run in which each of them, and each of `fairness`, is true again
    and again? `comment`: lines.
    """

    circuit: Circuit
    justice: tuple[tuple[Literal, ...], ...] = ()
    fairness: tuple[Literal, ...] = ()
    names: Names = Names()
    comment: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Numbered:
    """A circuit with the numbers of the format: inputs, then latches, then conjunctions, from 1."""

    inputs: int
    following: tuple[tuple[Literal, bool], ...]
    """By latch what it becomes, and its value at the start."""
    conjunctions: tuple[tuple[Literal, Literal], ...]
    """Their larger literal first."""
    bad: tuple[Literal, ...]
    justice: tuple[tuple[Literal, ...], ...]
    fairness: tuple[Literal, ...]

    @property
    def header(self) -> str:
        """The figures of the header; those at the end that are 0 are left out, as older readers want it."""
        latches, ands = len(self.following), len(self.conjunctions)
        figures = [self.inputs + latches + ands, self.inputs, latches, 0, ands]
        more = [len(self.bad), 0, len(self.justice), len(self.fairness)]
        while more and not more[-1]:
            more.pop()
        return " ".join(map(str, figures + more))

    @property
    def asked(self) -> Iterator[int]:
        """The lines of bad states, justice and fairness, as literals and lengths."""
        yield from self.bad
        yield from map(len, self.justice)
        for literals in self.justice:
            yield from literals
        yield from self.fairness


def _numbered(document: Document) -> _Numbered:
    circuit = document.circuit
    roots = [latch.next for latch in circuit.latches]
    roots += [*circuit.bad, *document.fairness, *(each for some in document.justice for each in some)]
    number = {0: 0}
    for node in (*circuit.inputs, *(latch.node for latch in circuit.latches)):
        number[node] = len(number)
    pairs = []

    def literal(old: Literal) -> Literal:
        return 2 * number[old >> 1] + (old & 1)

    for node, left, right in circuit.fanins.conjunctions(circuit.cone(roots)):
        one, other = literal(left), literal(right)
        pairs.append((max(one, other), min(one, other)))
        number[node] = len(number)
    return _Numbered(
        len(circuit.inputs),
        tuple((literal(latch.next), latch.initial) for latch in circuit.latches),
        tuple(pairs),
        tuple(map(literal, circuit.bad)),
        tuple(tuple(map(literal, some)) for some in document.justice),
        tuple(map(literal, document.fairness)),
    )


def binary(document: Document) -> bytes:
    """Return the file in the binary format; conjunctions that nothing depends on are left out."""
    numbered = _numbered(document)
    lines = [f"aig {numbered.header}"]
    lines += [_latch(literal, initial) for literal, initial in numbered.following]
    lines += map(str, numbered.asked)
    deltas = bytearray()
    first = numbered.inputs + len(numbered.following) + 1
    for node, (large, small) in enumerate(numbered.conjunctions, first):
        deltas += _packed(2 * node - large) + _packed(large - small)
    return "".join(f"{line}\n" for line in lines).encode() + bytes(deltas) + _symbols(document)


def _packed(number: int) -> bytes:
    """Return a number in groups of seven bits, the lowest first; the high bit marks all but the last."""
    found = bytearray()
    while number > 127:
        found.append(number & 127 | 128)
        number >>= 7
    return bytes([*found, number])


def text(document: Document) -> bytes:
    """Return the file in the ASCII format; conjunctions that nothing depends on are left out."""
    numbered = _numbered(document)
    first = numbered.inputs + 1
    lines = [f"aag {numbered.header}", *(str(2 * node) for node in range(1, first))]
    for node, (literal, initial) in enumerate(numbered.following, first):
        lines.append(f"{2 * node} {_latch(literal, initial)}")
    lines += map(str, numbered.asked)
    for node, (large, small) in enumerate(numbered.conjunctions, first + len(numbered.following)):
        lines.append(f"{2 * node} {large} {small}")
    return "".join(f"{line}\n" for line in lines).encode() + _symbols(document)


def _latch(literal: Literal, initial: bool) -> str:
    return f"{literal} 1" if initial else str(literal)


def _symbols(document: Document) -> bytes:
    names = document.names
    given = (("i", names.inputs), ("l", names.latches), ("b", names.bad), ("j", names.justice))
    lines = [f"{kind}{place} {name}" for kind, some in given for place, name in enumerate(some) if name]
    if document.comment:
        lines += ["c", *document.comment]
    if any("\n" in line for line in lines):
        raise ValueError("a name or a line of a comment breaks the line")
    return "".join(f"{line}\n" for line in lines).encode()
