"""Sets of states of the closed loop as terms of SMT-LIB over the state that the checker of certificates knows."""

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from itertools import combinations, product
from math import prod

from exover.dataclass import dataclass
from exover.engines.bdd.manager import Set
from exover.engines.bdd.space import Space
from exover.loop.exact.term import numeral
from exover.model.event import Args
from exover.model.model import Parameter
from exover.model.types import Real, Value, ordinal
from exover.ocrd import tables as t
from exover.ocrd.entries import compare
from exover.ocrd.vector import rank
from exover.proofs.statement import Statement, Unsaid, conjunction, constant, disjunction

MOST_TUPLES = 2000
"""At most so many tuples of sample values are tried to tell which arguments are of one class."""


@dataclass
class Sets:
    """Writes sets of states of one space as formulas."""

    space: Space
    statement: Statement
    _bits: dict[str, str] = field(default_factory=dict)
    _sorted: dict[tuple[object, ...], list[str]] = field(default_factory=dict)

    def text(self, states: Set, promises: Mapping[str, str] | None = None) -> str:
        """Return a formula that is true exactly in these states; raises `Unsaid` if the checker cannot tell them apart.

        `promises`: by bit that is no part of the state, the name that stands for it.
        """
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
                bit = (promises or {}).get(node.var) or self._bit(node.var)
                bound.append(ite(bit, known[high], known[low]))
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
        """Return the condition that a variable of the loop has this value."""
        loop = self.space.loop
        match key:
            case ("phase" | "place" | "level" | "last" as kind, number):
                return f"(= {kind}.{number} {value})"
            case ("reading", int(number)):
                return self._reading(number, value)
            case ("class", int(slot)):
                request = loop.tables.request_of(slot)
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
                pasts, split = loop.arguments[request].pasts, len(loop.arguments[request].params)
                held = self._kinds(
                    key, request, f"past.{request}", lambda args: pasts.number(args[:split], args[split:]), True
                )
                return conjunction([f"past.{request}", held[value - 1]])
            case ("happened", int(number)):
                fact = self.statement.moment(loop.observed[number])
                return fact if value else f"(not {fact})"
            case ("pair", int(left), int(right)):
                return ordered(f"reading.{left}", f"reading.{right}", value)
            case ("order", int(slot), int(which)):
                request = loop.tables.request_of(slot)
                return self._order(request, f"arg.{slot}", f"(= phase.{slot} 0)", which, value)
            case ("standing", int(request), int(which)):
                return self._order(request, f"held.{request}", f"(= place.{request} 0)", which, value)
            case _:
                raise Unsaid("a set tells states apart by what a step remembers")

    def _order(self, request: int, held: str, absent: str, which: int, value: int) -> str:
        """Return the condition that an argument compares with a poster as `ordered` says; 0: or that there is none."""
        order = self.space.loop.arguments[request].poster_orders[which]
        found = ordered(f"{held}.{order.left}", f"reading.{-1 - order.right}", value)
        return disjunction([absent, found]) if value == 0 else conjunction([f"(not {absent})", found])

    def _reading(self, number: int, cell: int) -> str:
        loop, name = self.space.loop, f"reading.{number}"
        if loop.tables.variables[number].type == t.REAL:
            return inside(name, loop.posters[number].samples[cell], loop.posters[number].cuts)
        values = loop.ordinals(number)
        return between(name, values, values[cell])

    def _kinds(
        self, key: tuple[object, ...], request: int, prefix: str, kind_of: Callable[[Args], int], results: bool
    ) -> list[str]:
        """Return by kind the condition that the arguments at `prefix`, with `results` also the results, are of it."""
        if key not in self._sorted:
            arguments = self.space.loop.arguments[request]
            fields = (*arguments.params, *arguments.results) if results else arguments.params
            samples = (arguments.samples, arguments.result_samples) if results else (arguments.samples,)
            axes = [list(dict.fromkeys(each)) for tuples in samples for each in zip(*tuples, strict=True)]
            if prod(map(len, axes)) > MOST_TUPLES:
                raise Unsaid("a set tells too many kinds of arguments apart")
            texts = [self._axis(request, k, fields[k], f"{prefix}.{k}", axis) for k, axis in enumerate(axes)]
            pairs = self._compared(request, fields)
            texts += [{n: ordered(f"{prefix}.{i}", f"{prefix}.{j}", n) for n in range(3)} for i, j in pairs]
            kinds: dict[tuple[Value, ...], int] = {}
            for args in product(*axes):
                cells = (self._cell(request, k, value) for k, value in enumerate(args))
                place = (*cells, *(compare(float(args[i]), float(args[j])) for i, j in pairs))
                if kinds.setdefault(place, kind_of(args)) != kind_of(args):
                    raise Unsaid("a set tells arguments apart by how reals compare")
            self._sorted[key] = [tree(texts, kinds, number) for number in range(1 + max(kinds.values()))]
        return self._sorted[key]

    def _compared(self, request: int, fields: Sequence[Parameter]) -> list[tuple[int, int]]:
        """Return the pairs of arguments that a test compares as reals, or a condition of the properties may."""
        loop = self.space.loop
        arguments, name = loop.arguments[request], loop.model.requests[request].name
        tracked = [k for k, each in enumerate(fields) if (name, each.name) in loop.tracked.compared]
        found = {
            (order.left, order.right) for order in arguments.inner_orders if 0 <= order.left < len(fields) > order.right
        }
        return sorted(found | {*combinations(tracked, 2)})

    def _cell(self, request: int, k: int, value: Value) -> Value:
        """Return the cell of a value of the k-th argument: of a real its rank among the cuts, else the value itself."""
        arguments = self.space.loop.arguments[request]
        field = (*arguments.params, *arguments.results)[k]
        return rank(arguments.sampler.cuts(k), float(value)) if isinstance(field.type, Real) else value

    def _axis(self, request: int, k: int, parameter: Parameter, name: str, axis: Sequence[Value]) -> dict[Value, str]:
        """Return, by cell of the sample values, the condition that the k-th argument is in that cell."""
        if isinstance(parameter.type, Real):
            cuts = self.space.loop.arguments[request].sampler.cuts(k)
            return {self._cell(request, k, value): inside(name, value, cuts) for value in axis}
        numbers = sorted(ordinal(parameter.type, value) for value in axis)
        return {value: between(name, numbers, ordinal(parameter.type, value)) for value in axis}


def ite(cond: str, high: str, low: str) -> str:
    """Return `high` where the condition holds, else `low`."""
    return f"(ite {cond} {high} {low})"


def inside(name: str, sample: Value, cuts: Sequence[float]) -> str:
    """Return the condition that a real lies between the same cuts as a sample, or on the same cut."""
    place, kind = rank(tuple(cuts), float(sample)), Real()
    if place % 2:
        return f"(= {name} {constant(kind, cuts[place // 2])})"
    above = [f"(< {constant(kind, cuts[place // 2 - 1])} {name})"] if place else []
    below = [f"(< {name} {constant(kind, cuts[place // 2])})"] if place // 2 < len(cuts) else []
    return conjunction([*above, *below])


def between(name: str, values: Sequence[int], value: int) -> str:
    """Return the condition that an integer is at least `value`, but for the first, and less than the next value."""
    place = bisect_right(values, value)
    above = [f"(<= {numeral(value)} {name})"] if place > 1 else []
    below = [f"(< {name} {numeral(values[place])})"] if place < len(values) else []
    return conjunction([*above, *below])


def ordered(left: str, right: str, order: int) -> str:
    """Return the condition that two reals compare so: left < right (0), left = right (1), left > right (2)."""
    return (f"(< {left} {right})", f"(= {left} {right})", f"(< {right} {left})")[order]


def tree(texts: Sequence[Mapping[Value, str]], kinds: Mapping[tuple[Value, ...], int], wanted: int) -> str:
    """Return a decision tree: true iff the tuple whose places `texts` test is one that `kinds` maps to `wanted`."""
    if len({kind == wanted for kind in kinds.values()}) == 1:
        return "true" if wanted in kinds.values() else "false"
    below: dict[str, list[str]] = {}
    for value in dict.fromkeys(place[0] for place in kinds):
        rest = {place[1:]: kind for place, kind in kinds.items() if place[0] == value}
        below.setdefault(tree(texts[1:], rest, wanted), []).append(texts[0][value])
    found = [
        disjunction(where) if then == "true" else conjunction([disjunction(where), then])
        for then, where in below.items()
    ]
    if set(below) == {"true"}:
        return "true"
    return disjunction([each for each, then in zip(found, below, strict=True) if then != "false"])
