"""From a model to its tables: the numbered nodes of the forest, and all else that the machine reads, as records."""

from collections.abc import Iterable, Sequence
from dataclasses import field
from itertools import accumulate
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.event import Args
from exover.model.expression import Param, Reading
from exover.model.index import ModelIndex
from exover.model.model import Consumption, Effect, Forget, Model, Parameter, Request, SetState, Share
from exover.model.types import Bool, Enum, Int, Real, Type, Value, ordinal
from exover.ocrd import conflicts
from exover.ocrd import decision as do
from exover.ocrd import tables as t
from exover.ocrd.diagram import deep
from exover.ocrd.entries import Entries
from exover.ocrd.features import Feature, plant_features, readers
from exover.ocrd.forest import Branch
from exover.ocrd.numbering import longest, number
from exover.ocrd.reasons import reasons
from exover.ocrd.roots import Roots, grow
from exover.ocrd.tables import ALWAYS, NONE, Node, Tables
from exover.ocrd.vector import (
    Arg,
    ArgRank,
    Element,
    HasPast,
    InPlace,
    LastOutcome,
    Order,
    PlaceValue,
    Rank,
    Slots,
    SlotValue,
    Stock,
    VariableValue,
    ordinal_range,
)


@dataclass(frozen=True, slots=True)
class Figures:
    """Sizes of the diagrams: nodes, nodes on the longest path, most tests before the first action of a path."""

    nodes: int
    depth: int
    tests: int


@dataclass(frozen=True)
class DecodedTables:
    """The tables of a model, and the element that each entry of the state vector holds."""

    model: Model
    tables: Tables
    entries: tuple[Element, ...]


@dataclass(frozen=True)
class Compiled(DecodedTables):
    """Tables just compiled, with the reasons by number and the sizes of the diagrams."""

    reasons: tuple[Reason, ...]
    figures: Figures


def compile_model(model: Model, digest: bytes, flags: int = 0) -> Compiled:
    """Return the tables of a model; `digest` is the SHA-256 of the canonical spec, `flags` those of the header."""
    with deep():
        return _Assembly(model, grow(model)).compiled(digest, flags)


def most_passes(model: Model) -> int:
    """Return a bound on the passes (steps 3 to 5) of one event: every pass but the last changes something.

    A slot changes at most twice in a step. What is in a waiting place before the step, or is put there by the event or
    a required launch, changes at most four times, counted with its entering and leaving.
    """
    slots = sum(request.instances for request in model.requests)
    return 1 + 2 * slots + 4 * (len(model.requests) + len(model.launches))


@dataclass
class _Assembly:
    """Collects the records; every section is a list that only grows."""

    model: Model
    roots: Roots
    reals: list[float] = field(default_factory=list)
    lists: list[int] = field(default_factory=list)
    params: list[t.ParamRow] = field(default_factory=list)
    orders: list[t.OrderRow] = field(default_factory=list)
    features: list[t.FeatureRow] = field(default_factory=list)
    pasts: list[t.PastRow] = field(default_factory=list)
    amounts: list[t.AmountRow] = field(default_factory=list)
    effects: list[t.EffectRow] = field(default_factory=list)
    conflicts: list[t.ConflictRow] = field(default_factory=list)

    def __post_init__(self) -> None:
        index = ModelIndex(self.model)
        self.request, self.variable, self.stock = index.request, index.reading, index.stock
        self.starts = list(accumulate((request.instances for request in self.model.requests), initial=0))[:-1]
        self.values = [0, *accumulate(len(r.params) * (r.instances + 1) for r in self.model.requests)]
        self.conflicting = conflicts.conflicts(self.model)
        self.reason = {reason: index for index, reason in enumerate(reasons(self.model))}
        self.counted = plant_features(self.model, self.roots)
        self.readers = readers(self.counted)
        self.order = number(self.roots.forest, self.roots.all())
        self.place = {node: index for index, node in enumerate(self.order)} | {NONE: NONE, ALWAYS: ALWAYS}
        self.entries = Entries(self.roots.questions.numbers)
        self.entries.needed_by(self.roots.forest, self.order)
        self.compared: dict[str | None, list[Order]] = {}
        self.pasts_kept: dict[str, list[HasPast]] = {}
        for quantity in self.entries.quantities():
            match quantity:
                case Order(request):
                    self.compared.setdefault(request, []).append(quantity)
                case HasPast(request):
                    self.pasts_kept.setdefault(request, []).append(quantity)
                case _:
                    pass

    def compiled(self, digest: bytes, flags: int) -> Compiled:
        """Return the tables made of all records."""
        forest = self.roots.forest
        entries, sums, self.lists = self.entries.rows(forest, [root for root, _ in self.roots.rules])
        rules = tuple(t.RuleRow(self.place[root], self.reason[reason]) for root, reason in self.roots.rules)
        requests = tuple(self._request(*pair) for pair in zip(self.model.requests, self.starts, strict=True))
        invariants = tuple(t.InvariantRow(self.place[root], self.reason[why]) for root, why in self.roots.invariants)
        nodes, tests, actions, first = longest(forest, self.roots.of_events(), self.order)
        tables = Tables(
            digest=digest,
            flags=flags,
            nodes=tuple(self._node(node) for node in self.order),
            entries=tuple(entries),
            requests=requests,
            variables=tuple(self._variables()),
            latches=tuple(self._latches()),
            stocks=tuple(self._stocks()),
            launches=tuple(self._launches()),
            rules=rules,
            params=tuple(self.params),
            orders=tuple(self.orders),
            features=tuple(self.features),
            pasts=tuple(self.pasts),
            amounts=tuple(self.amounts),
            effects=tuple(self.effects),
            conflicts=tuple(self.conflicts),
            reasons=tuple(map(t.ReasonRow, conflicts.denials(self.model, tuple(self.reason)))),
            invariants=invariants,
            limits=(t.LimitRow(tests, actions, most_passes(self.model), len({rule.reason for rule in rules})),),
            sums=tuple(sums),
            lists=tuple(self.lists),
            reals=tuple(self.reals),
        )
        figures = Figures(len(tables.nodes), nodes, first)
        return Compiled(self.model, tables, tuple(self.entries.elements), reasons(self.model), figures)

    # ---- nodes ----

    def _node(self, index: int) -> Node:
        node = self.roots.forest.nodes[index]
        if isinstance(node, Branch):
            return Node(self.entries.index[node.element], node.bound, self.place[node.low], self.place[node.high])
        code, reason, target = self._action(node.action)
        return Node(-code, self.reason[reason] if reason else 0, self.place[node.child], target)

    def _action(self, action: do.Do) -> tuple[int, Reason | None, int]:
        match action:
            case do.DoReject(reason):
                return t.REJECT, reason, 0
            case do.DoWait(reason):
                return t.WAIT, reason, 0
            case do.DoClear(reason):
                return t.CLEAR, reason, 0
            case do.DoSettle(reason):
                return t.SETTLE, reason, 0
            case do.DoKill((name, slot), reason):
                request = self.request[name]
                return t.KILL, reason, request if slot is None else -1 - (self.starts[request] + slot)
            case do.DoDismiss(name, reason):
                return t.DISMISS, reason, self.request[name]
            case do.DoLaunch():
                return t.LAUNCH, None, 0
            case do.DoViolation(reason):
                return t.VIOLATION, reason, 0
            case do.DoAgree():
                return t.AGREE, None, 0
            case do.DoNothing():
                raise AssertionError("what does nothing is no node of a forest")
            case _:
                assert_never(action)

    # ---- requests ----

    def _request(self, request: Request, slots: int) -> t.RequestRow:
        name = request.name
        params = len(self.params)
        self.params += [self._param(request, parameter) for parameter in (*request.params, *request.results)]
        orders, features, pasts = len(self.orders), len(self.features), len(self.pasts)
        self.orders += self._orders_of(request)
        self.features += [self._feature(request, feature) for feature in self.counted[name]]
        self.pasts += self._pasts_of(name)
        consumes = len(self.amounts)
        self.amounts += self._amounts(name, request.consumptions)
        produces = len(self.amounts)
        self.amounts += self._amounts(name, request.productions)
        edges = [len(self.effects)]
        for effects in (request.on_launch, request.on_ok, request.on_failed, request.on_interrupted):
            for effect in effects:
                self.effects += self._effect(effect)
            edges.append(len(self.effects))
        row = len(self.conflicts)
        self.conflicts += conflicts.row(self.conflicting[self.request[name]])
        return t.RequestRow(
            decide=self.place[self.roots.decide[self.request[name]]],
            slots=slots,
            instances=request.instances,
            values=self.values[self.request[name]],
            interrupts_self=int(request.interrupts_self),
            statuses=len(request.statuses),
            params=params,
            results=params + len(request.params),
            params_end=len(self.params),
            orders=orders,
            orders_end=len(self.orders),
            features=features,
            features_end=len(self.features),
            pasts=pasts,
            pasts_end=len(self.pasts),
            consumes=consumes,
            produces=produces,
            produces_end=len(self.amounts),
            on_launch=edges[0],
            on_ok=edges[1],
            on_failed=edges[2],
            on_interrupted=edges[3],
            effects_end=edges[4],
            last=self.entries.of(LastOutcome(name)),
            conflicts=row,
            conflicts_end=len(self.conflicts),
        )

    def _param(self, request: Request, parameter: Parameter) -> t.ParamRow:
        kind, low, high = self._domain(parameter.type)
        cuts, cuts_end = self._cuts(request.name, parameter.name)
        value = self.entries.of(Arg(request.name, parameter.name))
        rank = self.entries.of(ArgRank(request.name, parameter.name))
        return t.ParamRow(kind, low, high, cuts, cuts_end, value, rank)

    def _domain(self, kind: Type) -> tuple[int, int, int]:
        """Return the code of a type and the ends of its range: ordinals, for a real indices of doubles."""
        match kind:
            case Real(low, high):
                return t.REAL, self._real(low), self._real(high)
            case Bool() | Int() | Enum():
                code = {Bool: t.BOOL, Int: t.INT, Enum: t.ENUM}[type(kind)]
                return code, *ordinal_range(kind)
            case _:
                assert_never(kind)

    def _real(self, value: float) -> int:
        self.reals.append(value)
        return len(self.reals) - 1

    def _cuts(self, request: str | None, name: str) -> tuple[int, int]:
        cuts = self.roots.questions.vocabulary.thresholds.get((request, name), ())
        start = len(self.reals)
        self.reals += cuts
        return start, len(self.reals)

    def _orders_of(self, request: Request) -> list[t.OrderRow]:
        names = [parameter.name for parameter in (*request.params, *request.results)]

        def side(term: Param | Reading) -> int:
            return names.index(term.name) if isinstance(term, Param) else -1 - self.variable[term.name]

        mine = self.compared.get(request.name, [])
        return [t.OrderRow(side(order.left), side(order.right), self.entries.of(order)) for order in mine]

    def _feature(self, request: Request, feature: Feature) -> t.FeatureRow:
        where, slot, weight = feature
        at = NONE if slot is None else slot
        if weight is not None:
            index = [parameter.name for parameter in request.params].index(weight)
            if slot is None:
                entry = self.entries.of(PlaceValue(request.name, weight))
                return t.FeatureRow(ALWAYS, at, index, NONE, NONE, entry, entry)
            entry = self.entries.of(SlotValue(request.name, slot, weight))
            return t.FeatureRow(ALWAYS, at, index, entry, entry, NONE, NONE)
        running, stopping = (self.entries.of(Slots(request.name, slot, where, p)) for p in ("running", "stopping"))
        waiting, clearing = NONE, NONE
        if slot is None:
            waiting, clearing = (self.entries.of(InPlace(request.name, where, p)) for p in ("waiting", "clearing"))
        predicate = self.place[self.roots.predicate(request.name, where)]
        return t.FeatureRow(predicate, at, NONE, running, stopping, waiting, clearing)

    def _pasts_of(self, name: str) -> list[t.PastRow]:
        return [
            t.PastRow(self.place[self.roots.predicate(name, past.where)], self.entries.of(past))
            for past in self.pasts_kept.get(name, [])
        ]

    def _amounts(self, name: str, clauses: Iterable[Share | Consumption]) -> list[t.AmountRow]:
        return [
            t.AmountRow(self.stock[clause.resource], clause.amount, self.place[self.roots.predicate(name, clause.when)])
            for clause in clauses
        ]

    def _effect(self, effect: Effect) -> list[t.EffectRow]:
        match effect:
            case SetState(state, value):
                kind = self.model.variable[state].type
                return [t.EffectRow(t.SET, self.variable[state], ordinal(kind, value))]
            case Forget(requests):
                return [t.EffectRow(t.FORGET, self.request[name], 0) for name in requests]
            case _:
                assert_never(effect)

    # ---- variables, latches, stocks, launches ----

    def _variables(self) -> Iterable[t.VariableRow]:
        raws = self._raw_names()
        for variable in self.model.variables:
            role = t.POSTER if variable.kind == "poster" else t.STATE
            yield self._variable(variable.name, role, variable.type, variable.initial, variable.fallback, raws)
        for latch in self.model.latches:
            initial = self.roots.questions.start.readings[latch.name]
            yield self._variable(latch.name, t.LATCH, Bool(), initial, None, raws)

    def _raw_names(self) -> list[str]:
        """Return the real posters that are compared with other reals, so that their values must be kept."""
        sides = [side for orders in self.compared.values() for o in orders for side in (o.left, o.right)]
        return list(dict.fromkeys(side.name for side in sides if isinstance(side, Reading)))

    def _variable(
        self, name: str, role: int, kind: Type, initial: Value, fallback: Value | None, raws: Sequence[str]
    ) -> t.VariableRow:
        code, low, high = self._domain(kind)
        cuts, cuts_end = self._cuts(None, name)
        refresh = len(self.lists)
        self.lists += [self.request[request] for request in self.readers.get(name, ())]
        orders = len(self.orders)
        mine = [o for o in self.compared.get(None, []) if name in (o.left.name, o.right.name)]
        self.orders += [
            t.OrderRow(-1 - self.variable[o.left.name], -1 - self.variable[o.right.name], self.entries.of(o))
            for o in mine
        ]
        return t.VariableRow(
            role=role,
            type=code,
            low=low,
            high=high,
            initial=self._constant(kind, initial),
            has_fallback=int(fallback is not None),
            fallback=0 if fallback is None else self._constant(kind, fallback),
            cuts=cuts,
            cuts_end=cuts_end,
            value=self.entries.of(VariableValue(name)),
            rank=self.entries.of(Rank(name)),
            raw=raws.index(name) if name in raws else NONE,
            refresh=refresh,
            refresh_end=len(self.lists),
            orders=orders,
            orders_end=len(self.orders),
        )

    def _constant(self, kind: Type, value: Value) -> int:
        """Return the ordinal of a value; for a real, the index of a double that is added for it."""
        return self._real(float(value)) if isinstance(kind, Real) else ordinal(kind, value)

    def _latches(self) -> Iterable[t.LatchRow]:
        for latch, root in zip(self.model.latches, self.roots.latches, strict=True):
            start = len(self.lists)
            self.lists += [self.request[name] for name in latch.resets]
            yield t.LatchRow(self.variable[latch.name], self.place[root], start, len(self.lists))

    def _stocks(self) -> Iterable[t.StockRow]:
        for resource in self.model.resources:
            if resource.consumable:
                yield t.StockRow(resource.capacity, resource.initial, self.entries.of(Stock(resource.name)))

    def _launches(self) -> Iterable[t.LaunchRow]:
        for launch, root in zip(self.model.launches, self.roots.launches, strict=True):
            start = len(self.lists)
            self.lists += self._arguments(self.model.request[launch.request], launch.args)
            reason = self.reason[Reason(launch.name, launch.because)]
            yield t.LaunchRow(self.place[root], self.request[launch.request], start, reason)

    def _arguments(self, request: Request, args: Args) -> list[int]:
        return [self._constant(p.type, value) for p, value in zip(request.params, args, strict=True)]
