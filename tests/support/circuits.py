"""Small random circuits, and what is true of them by enumeration."""

from itertools import product
from random import Random

from exover.engines.aig.circuit.answer import Answer, Reachable, Unreachable
from exover.engines.aig.circuit.graph import Circuit, Graph, Literal


def random_circuit(seed: int, latches: int = 6, inputs: int = 3, gates: int = 25, bad: int = 6) -> Circuit:
    """Return a circuit of guarded registers; equal seeds give equal circuits."""
    source, graph = Random(seed), Graph()
    known = [graph.input() for _ in range(inputs)] + [graph.latch(source.random() < 0.5) for _ in range(latches)]
    registers = known[inputs:]
    for _ in range(gates):
        one, other = source.choice(known[-12:]), source.choice(known)
        found = graph.conjunction(one ^ source.getrandbits(1), other ^ source.getrandbits(1))
        if found > 1:
            known.append(found)
    following = [
        graph.choose(source.choice(known), source.choice(known) ^ source.getrandbits(1), register)
        for register in registers
    ]
    asked = [
        graph.all(source.choice(known) ^ source.getrandbits(1) for _ in range(source.randint(1, 4))) for _ in range(bad)
    ]
    return graph.circuit(following, asked)


def counter(width: int, limit: int, wanted: int) -> Circuit:
    """Return a counter that an input moves on, from 0 up to `limit` and back to 0; bad is where it is `wanted`."""
    graph = Graph()
    go = graph.input()
    bits = [graph.latch(False) for _ in range(width)]
    carry, up = go, []
    for bit in bits:
        up.append(graph.differ(bit, carry))
        carry = graph.conjunction(bit, carry)
    at_limit = graph.conjunction(go, is_number(graph, bits, limit))
    return graph.circuit([graph.conjunction(bit, at_limit ^ 1) for bit in up], [is_number(graph, bits, wanted)])


def is_number(graph: Graph, bits: list[Literal], number: int) -> Literal:
    """Return where the bits, the lowest first, are a number."""
    return graph.all(bit ^ 1 ^ (number >> place & 1) for place, bit in enumerate(bits))


def reachable(circuit: Circuit) -> set[int]:
    """Return the indices of the bad literals that some run makes true, by enumeration."""
    start = tuple(latch.initial for latch in circuit.latches)
    seen, waiting, found = {start}, [start], set()
    while waiting:
        state = waiting.pop()
        for chosen in product((False, True), repeat=len(circuit.inputs)):
            leaves = dict(zip(circuit.inputs, chosen, strict=True))
            leaves |= {latch.node: value for latch, value in zip(circuit.latches, state, strict=True)}
            values: list[bool] = []
            for node, pair in enumerate(circuit.fanins):
                if pair is None:
                    values.append(leaves.get(node, False))
                else:
                    values.append(all(values[literal >> 1] != bool(literal & 1) for literal in pair))
            found |= {index for index, bad in enumerate(circuit.bad) if values[bad >> 1] != bool(bad & 1)}
            after = tuple(values[latch.next >> 1] != bool(latch.next & 1) for latch in circuit.latches)
            if after not in seen:
                seen.add(after)
                waiting.append(after)
    return found


def verdicts(answers: dict[int, Answer]) -> tuple[set[int], set[int]]:
    """Return which bad literals are reachable and which are not, as the answers say."""
    yes = {index for index, answer in answers.items() if isinstance(answer, Reachable)}
    return yes, {index for index, answer in answers.items() if isinstance(answer, Unreachable)}
