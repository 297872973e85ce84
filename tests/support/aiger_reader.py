"""Files in the format AIGER 1.9 (Biere, Heljanko, Wieringa 2011), binary and ASCII, read into circuits."""

from collections.abc import Sequence

from exover.engines.aig.circuit.aiger import Document, Names
from exover.engines.aig.circuit.graph import TRUE, Circuit, Fanin, Fanins, LatchNode, Literal

KINDS = "ilbjf"
"""What a line of the symbol table names: input, latch, bad, justice, fairness."""


class NoAiger(ValueError):
    """A file is not in the format, or says what a circuit cannot: constraints, latches without a start."""


def read(data: bytes) -> Document:
    """Return what a file of either format says; the names stand in their order.

    Raises `NoAiger`.
    """
    try:
        return _Reader(data).document()
    except (IndexError, KeyError, ValueError) as wrong:
        raise wrong if isinstance(wrong, NoAiger) else NoAiger("no file in the format AIGER") from wrong


class _Reader:
    """What is left of a file."""

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, 0

    def _line(self) -> str:
        end = self._data.index(b"\n", self._place)
        line = self._data[self._place : end]
        self._place = end + 1
        return line.decode()

    def _literal(self) -> Literal:
        return self._bound(int(self._line()))

    def _bound(self, literal: Literal) -> Literal:
        if not 0 <= literal <= 2 * self._largest + 1:
            raise NoAiger(f"the literal {literal} is too large")
        return literal

    def document(self) -> Document:
        """Return what the file says. Raises `NoAiger`, `ValueError`, `IndexError`, `KeyError`."""
        form, *words = self._line().split(" ")
        figures = [*map(int, words), 0, 0, 0, 0]
        self._largest, inputs, latches, outputs, ands, bad, constraints, justice, fairness = figures[:9]
        if form not in ("aig", "aag") or not 5 <= len(words) <= 9 or min(figures) < 0:
            raise NoAiger("no header of the format AIGER")
        if (outputs and bad) or constraints:
            raise NoAiger("constraints, and outputs beside bad literals, are not read")
        bad = bad or outputs  # what was asked stood among the outputs before AIGER 1.9
        ascii_form = form == "aag"
        given = [int(self._line()) for _ in range(inputs)] if ascii_form else [2 * n for n in range(1, inputs + 1)]
        state = [self._latch(ascii_form, inputs + 1 + place) for place in range(latches)]
        asked = [self._literal() for _ in range(bad)]
        lengths = [int(self._line()) for _ in range(justice)]
        justices = [tuple(self._literal() for _ in range(length)) for length in lengths]
        fair = [self._literal() for _ in range(fairness)]
        read_and = self._and if ascii_form else self._delta
        pairs = dict(read_and(2 * (inputs + latches + 1 + place)) for place in range(ands))
        names, comment = self._named((inputs, latches, bad, justice, fairness))
        place = _Placed(given, state, pairs)
        circuit = place.circuit(asked)
        return Document(
            circuit,
            tuple(tuple(map(place.literal, some)) for some in justices),
            tuple(map(place.literal, fair)),
            names,
            comment,
        )

    def _latch(self, ascii_form: bool, node: int) -> tuple[Literal, Literal, bool]:
        words = [int(word) for word in self._line().split(" ")]
        mine = words.pop(0) if ascii_form else 2 * node
        following, initial = (*words, 0) if len(words) == 1 else words
        if initial not in (0, 1):
            raise NoAiger("a latch without a value at the start")
        return mine, self._bound(following), bool(initial)

    def _and(self, _: int) -> tuple[Literal, tuple[Literal, Literal]]:
        mine, left, right = map(int, self._line().split(" "))
        return mine, (self._bound(left), self._bound(right))

    def _delta(self, mine: Literal) -> tuple[Literal, tuple[Literal, Literal]]:
        large = mine - self._number()
        small = large - self._number()
        if not 0 <= small <= large < mine:
            raise NoAiger("a conjunction of what comes after it")
        return mine, (large, small)

    def _number(self) -> int:
        found = shift = 0
        while True:
            byte = self._data[self._place]
            self._place += 1
            found |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return found

    def _named(self, counts: Sequence[int]) -> tuple[Names, tuple[str, ...]]:
        found = {kind: [""] * count for kind, count in zip(KINDS, counts, strict=True)}
        while self._place < len(self._data):
            line = self._line()
            if line == "c":
                comment = self._data[self._place :].decode().splitlines()
                return _names(found), tuple(comment)
            place, _, name = line.partition(" ")
            found["b" if place[0] == "o" else place[0]][int(place[1:])] = name
        return _names(found), ()


def _names(found: dict[str, list[str]]) -> Names:
    for names in found.values():
        while names and not names[-1]:
            names.pop()
    return Names(*(tuple(found[kind]) for kind in KINDS[:4]))


class _Placed:
    """What a file says with nodes in the order of what they are made of."""

    def __init__(
        self,
        inputs: Sequence[Literal],
        latches: Sequence[tuple[Literal, Literal, bool]],
        pairs: dict[Literal, tuple[Literal, Literal]],
    ) -> None:
        self._latches, self._inputs = latches, len(inputs)
        self._nodes = {0: 0}
        for mine in (*inputs, *(mine for mine, _, _ in latches)):
            if mine & 1 or mine >> 1 in self._nodes:
                raise NoAiger(f"the literal {mine} is defined twice")
            self._nodes[mine >> 1] = len(self._nodes)
        self._fanins: list[Fanin] = [None] * len(self._nodes)
        if any(mine & 1 or mine >> 1 in self._nodes for mine in pairs):
            raise NoAiger("a conjunction is defined twice")
        self._place(pairs)

    def _place(self, pairs: dict[Literal, tuple[Literal, Literal]]) -> None:
        stack = sorted(pairs, reverse=True)
        open_: set[Literal] = set()
        while stack:
            mine = stack[-1]
            if mine >> 1 in self._nodes:
                stack.pop()
                continue
            left, right = pairs[mine]
            missing = [2 * (each >> 1) for each in (left, right) if each >> 1 not in self._nodes]
            if not missing:
                self._nodes[mine >> 1] = len(self._fanins)
                small, large = sorted((self.literal(left), self.literal(right)))
                self._fanins.append((small, large or TRUE))
            elif mine in open_:
                raise NoAiger("a conjunction depends on itself")
            else:
                open_.add(mine)
                stack += missing

    def literal(self, old: Literal) -> Literal:
        """Return the literal with the node of the circuit."""
        return 2 * self._nodes[old >> 1] + (old & 1)

    def circuit(self, bad: Sequence[Literal]) -> Circuit:
        """Return the circuit."""
        first = 1 + self._inputs
        latches = tuple(
            LatchNode(first + place, initial, self.literal(following))
            for place, (_, following, initial) in enumerate(self._latches)
        )
        return Circuit(Fanins.of(self._fanins), tuple(range(1, first)), latches, tuple(map(self.literal, bad)))
