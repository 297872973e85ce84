"""Sets of the closed loop's states as SMT-LIB over the state that the checker of certificates knows."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from exover.model.event import Args
from exover.model.model import Parameter
from exover.model.types import Real, Value, ordinal
from exover.ocrd import tables as t
from exover.ocrd.vector import rank
from exover.proofs.statement import Statement, Unsaid, conjunction, constant, disjunction, number
from exover.verify.bdd.space import Set, Space

MOST_TUPLES = 2000
"""So many tuples of sample values are looked at to say which arguments are of one class."""


@dataclass
class Sets:
    """Writes sets of one space."""

    space: Space
    statement: Statement
    _bits: dict[str, str] = field(default_factory=dict)
    _sorted: dict[tuple[object, ...], list[str]] = field(default_factory=dict)

    def text(self, states: Set) -> str:
        """Return a formula that is true exactly in these states; raises `Unsaid` if what they tell apart is unknown."""
        bdd, bound = self.space.bdd, list[str]()
        known: dict[Set, str] = {bdd.true: "true", bdd.false: "false"}
        stack = [states]
        while stack:
            node = stack[-1]
            if node in known:
                stack.pop()
                continue
            low, high = (bdd.let({node.var: side}, node) for side in (False, True))
            missing = [child for child in (low, high) if child not in known]
            stack += missing
            if not missing:
                known[node] = f"n{len(bound)}"
                bound.append(ite(self._bit(node.var), known[high], known[low]))
        whole = known[states]
        for at, part in reversed([*enumerate(bound)]):
            whole = f"(let ((n{at} {part})) {whole})"
        return whole

    def _bit(self, name: str) -> str:
        if name not in self._bits:
            var = self.space.owner(name)
            variable = self.space.loop.variables[var]
            values = [value for value in range(variable.size) if self.space.literals(var, value)[name]]
            self._bits[name] = disjunction([self._value(variable.key, value) for value in values])
        return self._bits[name]

    def _value(self, key: tuple[object, ...], value: int) -> str:
        """Return that a variable of the loop has this value."""
        loop = self.space.loop
        match key:
            case ("phase" | "place" | "level" | "last" as kind, number):
                return f"(= {kind}.{number} {value})"
            case ("reading", int(number)):
                return self._reading(number, value)
            case ("class", int(slot)):
                request = max(n for n, row in enumerate(loop.tables.requests) if row.slots <= slot)
                arguments = loop.arguments[request]
                held = self._kinds(key, request, f"arg.{slot}", lambda args: arguments.cell_of(args).slot_class, False)
                idle = f"(= phase.{slot} 0)"
                return disjunction([idle, held[0]]) if value == 0 else conjunction([f"(not {idle})", held[value]])
            case ("cell", int(request)):
                arguments = loop.arguments[request]
                held = self._kinds(key, request, f"held.{request}", lambda args: arguments.cell_of(args).number, False)
                there = f"(= place.{request} 0)"
                return disjunction([there, held[0]]) if value == 0 else conjunction([f"(not {there})", held[value]])
            case ("past", int(request)):
                if value == 0:
                    return f"(not past.{request})"
                arguments, split = loop.arguments[request], len(loop.arguments[request].params)
                held = self._kinds(
                    key, request, f"past.{request}", lambda args: arguments.past_kind(args[:split], args[split:]), True
                )
                return conjunction([f"past.{request}", held[value - 1]])
            case ("happened", int(number)):
                fact = self.statement.moment(loop.observed[number])
                return fact if value else f"(not {fact})"
            case ("tried" | "fallen" | "chosen", _):
                raise Unsaid("a set tells states apart by what a step remembers")
            case _:
                raise Unsaid("a set tells states apart by how reals compare")

    def _reading(self, number: int, cell: int) -> str:
        loop, name = self.space.loop, f"reading.{number}"
        if loop.tables.variables[number].type == t.REAL:
            return inside(name, loop.posters[number].samples[cell], loop.posters[number].cuts)
        kind = loop.model.variables[number].type if number < len(loop.model.variables) else None
        values = [ordinal(kind, value) if kind else int(value) for value in loop.samples[number]]
        return between(name, values, values[cell])

    def _kinds(
        self, key: tuple[object, ...], request: int, prefix: str, kind_of: Callable[[Args], int], results: bool
    ) -> list[str]:
        """Return for each kind of arguments, with results or without, the formula that they are of it."""
        if key not in self._sorted:
            arguments = self.space.loop.arguments[request]
            if arguments.inner_orders or self.space.loop.told.compared:
                raise Unsaid("a set tells arguments apart by how reals compare")
            axes = [
                sorted({args[k] for args in arguments.samples}, key=self._key(p))
                for k, p in enumerate(arguments.params)
            ]
            if results:
                axes += [
                    sorted({each[k] for each in arguments.result_samples}, key=self._key(p))
                    for k, p in enumerate(arguments.results)
                ]
            tuples = list(product(*axes))
            if len(tuples) > MOST_TUPLES:
                raise Unsaid("a set tells too many kinds of arguments apart")
            kinds = {args: kind_of(args) for args in tuples}
            fields = (*arguments.params, *arguments.results)
            texts = [
                [self._axis(request, k, fields[k], f"{prefix}.{k}", axis, v) for v in axis]
                for k, axis in enumerate(axes)
            ]
            self._sorted[key] = [tree(axes, texts, kinds, (), number) for number in range(1 + max(kinds.values()))]
        return self._sorted[key]

    def _key(self, parameter: Parameter) -> Callable[[Value], Any]:
        return float if isinstance(parameter.type, Real) else lambda value: ordinal(parameter.type, value)

    def _axis(self, request: int, k: int, parameter: Parameter, name: str, axis: Sequence[Value], value: Value) -> str:
        if isinstance(parameter.type, Real):
            return inside(name, value, self.space.loop.arguments[request].cuts(k))
        return between(name, [ordinal(parameter.type, v) for v in axis], ordinal(parameter.type, value))


def ite(cond: str, high: str, low: str) -> str:
    """Return `high` where the condition holds, else `low`."""
    return f"(ite {cond} {high} {low})"


def inside(name: str, sample: Value, cuts: Sequence[float]) -> str:
    """Return that a real lies between the same cuts as a sample."""
    place, kind = rank(tuple(cuts), float(sample)), Real()
    if place % 2:
        return f"(= {name} {constant(kind, cuts[place // 2])})"
    above = [f"(< {constant(kind, cuts[place // 2 - 1])} {name})"] if place else []
    below = [f"(< {name} {constant(kind, cuts[place // 2])})"] if place // 2 < len(cuts) else []
    return conjunction([*above, *below])


def between(name: str, values: Sequence[int], value: int) -> str:
    """Return that an integer is at least this one of the values, and less than the next of them."""
    place = bisect_right(values, value)
    above = [f"(<= {number(value)} {name})"] if place > 1 else []
    below = [f"(< {name} {number(values[place])})"] if place < len(values) else []
    return conjunction([*above, *below])


def tree(
    axes: Sequence[Sequence[Value]], texts: Sequence[Sequence[str]], kinds: dict[Args, int], first: Args, wanted: int
) -> str:
    """Return that the values of the axes from `len(first)` on make, after `first`, a tuple of the kind `wanted`."""
    rest = axes[len(first) :]
    if len({kinds[first + more] == wanted for more in product(*rest)}) == 1:
        return "true" if kinds[first + tuple(axis[0] for axis in rest)] == wanted else "false"
    below: dict[str, list[str]] = {}
    for text, value in zip(texts[len(first)], rest[0], strict=True):
        below.setdefault(tree(axes, texts, kinds, (*first, value), wanted), []).append(text)
    found = [
        disjunction(where) if then == "true" else conjunction([disjunction(where), then])
        for then, where in below.items()
    ]
    if set(below) == {"true"}:
        return "true"
    return disjunction([each for each, then in zip(found, below, strict=True) if then != "false"])
