"""The decoded tables in words: entries, tests, actions, roots."""

from collections.abc import Iterator
from functools import cached_property
from itertools import islice

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.index import ModelIndex
from exover.model.model import Model, Parameter
from exover.model.types import Bool, Enum, Type
from exover.ocrd import tables as t
from exover.ocrd.reasons import reasons
from exover.ocrd.tables import ALWAYS, NONE, Node, Tables
from exover.ocrd.vector import OUTCOMES

PHASES = {"running": "running", "stopping": "stopping", "waiting": "queued", "clearing": "clearing"}
"""The words for the counters of a feature; in the language, `waiting` includes what is clearing."""
TOGETHER = (("running", "stopping", "active"), ("queued", "clearing", "waiting"))
"""Two counters, and the word of the language for their sum."""
ACTIONS = {
    t.REJECT: "reject",
    t.WAIT: "wait",
    t.CLEAR: "clear",
    t.SETTLE: "settle",
    t.KILL: "kill",
    t.DISMISS: "dismiss",
    t.LAUNCH: "launch",
    t.VIOLATION: "violation",
    t.AGREE: "agree",
}
MOST_PATHS = 4
"""A predicate with more paths than this is named by its node."""


@dataclass(frozen=True, slots=True)
class Scale:
    """How the values of an entry are written: as values of `kind`, or as ranks of a real among `cuts`."""

    kind: Type | None
    cuts: tuple[float, ...] = ()


@dataclass(frozen=True)
class Description:
    """The words for the tables of a model."""

    model: Model
    tables: Tables

    @cached_property
    def reasons(self) -> tuple[Reason, ...]:
        """The reasons by index."""
        return reasons(self.model)

    @cached_property
    def variables(self) -> tuple[tuple[str, Type], ...]:
        """The names and types of posters, states and latches, by index."""
        return ModelIndex(self.model).typed_readings

    @cached_property
    def stocks(self) -> tuple[str, ...]:
        """The names of the consumable resources, by index."""
        return ModelIndex(self.model).stocks

    # ---- entries ----

    @cached_property
    def entries(self) -> tuple[str, ...]:
        """By number, what each entry of the state vector measures."""
        plain, parts = self._plain, self.tables.parts()
        return tuple(
            _sum([(factor, plain.get(part, f"v[{part}]")) for part, factor in parts.get(entry, [(entry, 1)])])
            for entry in range(len(self.tables.entries))
        )

    @cached_property
    def _plain(self) -> dict[int, str]:
        """The words for entries that are no sums."""
        counted: dict[int, list[tuple[int, str]]] = {}
        for entry, text in self._counters():
            counted.setdefault(entry, []).append((1, text))
        named = {**self._measured, **{entry: _sum(parts) for entry, parts in counted.items()}}
        for row, request in zip(self.tables.requests, self.model.requests, strict=True):
            named[row.last] = f"last({request.name})"
            for order in self.tables.orders[row.orders : row.orders_end]:
                named[order.entry] = self._order(order, (*request.params, *request.results))
            for past in self.tables.pasts[row.pasts : row.pasts_end]:
                named[past.entry] = f"past({request.name}{self._where(past.predicate)})"
        for variable in self.tables.variables:
            for order in self.tables.orders[variable.orders : variable.orders_end]:
                named[order.entry] = self._order(order, ())
        for stock, name in zip(self.tables.stocks, self.stocks, strict=True):
            named[stock.entry] = f"level({name})"
        named.pop(NONE, None)
        return named

    @cached_property
    def _measured(self) -> dict[int, str]:
        """The words for entries that are values."""
        named = {}
        for row, request in zip(self.tables.requests, self.model.requests, strict=True):
            rows = self.tables.params[row.params : row.params_end]
            for param, parameter in zip(rows, (*request.params, *request.results), strict=True):
                named[param.value] = named[param.rank] = parameter.name
        for variable, (name, _) in zip(self.tables.variables, self.variables, strict=True):
            named[variable.value] = named[variable.rank] = name
        named.pop(NONE, None)
        return named

    def _counters(self) -> Iterator[tuple[int, str]]:
        for row, request in zip(self.tables.requests, self.model.requests, strict=True):
            for feature in self.tables.features[row.features : row.features_end]:
                name = request.name if feature.slot == NONE else f"{request.name}[{feature.slot}]"
                if feature.weight != NONE:
                    param = request.params[feature.weight].name
                    yield feature.running, f"{name}.{param}"
                    yield feature.waiting, f"waiting({name}).{param}"
                    continue
                where = self._where(feature.predicate)
                for phase, word in PHASES.items():
                    yield getattr(feature, phase), f"{word}({name}{where})"

    def _order(self, order: t.OrderRow, params: tuple[Parameter, ...]) -> str:
        sides = [params[k].name if k >= 0 else self.variables[-1 - k][0] for k in (order.left, order.right)]
        return f"order({sides[0]}, {sides[1]})"

    def _where(self, predicate: int) -> str:
        """Return ` with CONDITION` of a predicate of arguments, ` with node N` if that is long, "" if always true."""
        if predicate == ALWAYS:
            return ""
        found = list(islice(self._paths(predicate, ()), MOST_PATHS + 1))
        if len(found) > MOST_PATHS:
            return f" with node {predicate}"
        return f" with {' or '.join(' and '.join(path) or 'true' for path in found) or 'false'}"

    def _paths(self, node: int, tests: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
        if node == NONE:
            return
        row = self.tables.nodes[node]
        if row.code < 0:
            yield tests
            return
        what = self._measured.get(row.code, f"v[{row.code}]")
        test = self._test(what, row.code, row.bound)
        yield from self._paths(row.low, (*tests, test))
        yield from self._paths(row.high, (*tests, f"not {test}"))

    # ---- tests ----

    @cached_property
    def _scales(self) -> dict[int, Scale]:
        """By entry that is a value, how its values are written."""
        scales = {}
        for row, request in zip(self.tables.requests, self.model.requests, strict=True):
            scales[row.last] = Scale(Enum(OUTCOMES))
            rows = self.tables.params[row.params : row.params_end]
            for param, parameter in zip(rows, (*request.params, *request.results), strict=True):
                scales[param.value] = Scale(parameter.type)
                scales[param.rank] = Scale(parameter.type, self.tables.reals[param.cuts : param.cuts_end])
        for variable, (_, kind) in zip(self.tables.variables, self.variables, strict=True):
            scales[variable.value] = Scale(kind)
            scales[variable.rank] = Scale(kind, self.tables.reals[variable.cuts : variable.cuts_end])
        return scales

    def test(self, node: Node) -> str:
        """Return the condition of a test node: the path goes to `low` iff it is true."""
        return self._test(self.entries[node.code], node.code, node.bound)

    def _test(self, what: str, entry: int, bound: int) -> str:
        scale = self._scales.get(entry, Scale(None))
        if scale.cuts:
            return f"{what} {'<=' if bound % 2 else '<'} {scale.cuts[bound // 2]!r}"
        match scale.kind:
            case Bool():
                return f"not {what}"
            case Enum(values):
                return f"{what} == {values[0]}" if bound == 0 else f"{what} in {{{', '.join(values[: bound + 1])}}}"
            case _:
                return f"{what} <= {bound}"

    # ---- actions and roots ----

    def action(self, node: Node) -> str:
        """Return an action node in words."""
        code = -node.code
        words = [ACTIONS[code]]
        if code == t.KILL and node.high < 0:
            words.append(self._slot(-1 - node.high))
        elif code in (t.KILL, t.DISMISS):
            words.append(self.model.requests[node.high].name)
        if code not in (t.LAUNCH, t.AGREE):
            words.append(f"({self.reasons[node.bound].rule})")
        return " ".join(words)

    def _slot(self, number: int) -> str:
        request = self.tables.request_of(number)
        return f"{self.model.requests[request].name}[{number - self.tables.requests[request].slots}]"

    def roots(self) -> Iterator[tuple[str, int]]:
        """Yield for each diagram, but predicates of arguments, the event or question that it answers, and its root."""
        for row, request in zip(self.tables.requests, self.model.requests, strict=True):
            yield f"ask {request.name}", row.decide
        for rule in self.tables.rules:
            yield f"recover {self.reasons[rule.reason].rule}", rule.root
        for launch in self.tables.launches:
            yield f"launch {self.reasons[launch.reason].rule}", launch.condition
        for latch in self.tables.latches:
            yield f"latch {self.variables[latch.variable][0]}", latch.condition
        for invariant in self.tables.invariants:
            yield f"broken {self.reasons[invariant.reason].rule}", invariant.root


def _sum(parts: list[tuple[int, str]]) -> str:
    """Return the text of a sum; counters of two phases in TOGETHER are joined under their common word."""
    left = list(parts)
    texts: list[tuple[int, str]] = []
    while left:
        factor, text = left.pop(0)
        for first, second, both in TOGETHER:
            for mine, other in ((first, second), (second, first)):
                partner = (factor, text.replace(mine, other, 1))
                if text.startswith(f"{mine}(") and partner in left:
                    left.remove(partner)
                    text = text.replace(mine, both, 1)
                    break
            else:
                continue
            break
        texts.append((factor, text))
    words = [text if abs(factor) == 1 else f"{abs(factor)} * {text}" for factor, text in texts]
    signs = ["-" if factor < 0 else "+" for factor, _ in texts]
    rest = "".join(f" {sign} {word}" for sign, word in zip(signs[1:], words[1:], strict=True))
    return f"{'-' if signs[0] == '-' else ''}{words[0]}{rest}"
