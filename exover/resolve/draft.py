"""The model under construction: the parts that are resolved so far, in the order of the text."""

from collections import Counter
from dataclasses import field

from exover.dataclass import dataclass
from exover.diagnostics import quote
from exover.model.event import NO_RULES
from exover.model.model import (
    Consumption,
    Effect,
    Forget,
    Guard,
    Kill,
    Latch,
    Launch,
    Location,
    Reject,
    Remedy,
    Resource,
    Rule,
    SetState,
    Share,
    Wait,
)
from exover.resolve.conditions import meaning
from exover.resolve.mistakes import Mistakes, same_name
from exover.resolve.names import ListedRequest, Signature, SymbolTable, entries
from exover.resolve.scope import Meaning, NameScope, Standing
from exover.resolve.values import MAX_INT
from exover.source import Span
from exover.syntax import tree

MAX_ITEMS = 1_000_000
"""The most rules and guards of a spec with its lists expanded."""


@dataclass(slots=True)
class Parts:
    """The clauses of one request, from its declaration and from contexts."""

    guards: list[Guard] = field(default_factory=list)
    shares: list[Share] = field(default_factory=list)
    consumptions: list[Consumption] = field(default_factory=list)
    productions: list[Share] = field(default_factory=list)
    effects: dict[tree.Occasion, list[Effect]] = field(default_factory=dict)
    interrupts_self: bool = False

    def on(self, occasion: tree.Occasion) -> tuple[Effect, ...]:
        """Return the effects of the `on` clauses for this occasion."""
        return tuple(self.effects.get(occasion, ()))

    def affect(self, occasion: tree.Occasion, effect: SetState | Forget) -> None:
        """Add an effect for an occasion."""
        self.effects.setdefault(occasion, []).append(effect)


@dataclass(frozen=True, slots=True)
class KillCheck:
    """The requests of a kill remedy; its rule reads the requests `active`, and the users of the resources `used`."""

    entries: tuple[ListedRequest, ...]
    active: frozenset[str]
    used: frozenset[str]


@dataclass(slots=True)
class Draft:
    """The parts of a model so far; `place` numbers guards, consumptions and rules, `_taken` holds names of rules."""

    names: SymbolTable
    meanings: dict[str, Meaning | None]
    mistakes: Mistakes
    parts: dict[str, Parts]
    rules: list[Rule] = field(default_factory=list)
    launches: list[Launch] = field(default_factory=list)
    latches: list[Latch] = field(default_factory=list)
    resources: list[Resource] = field(default_factory=list)
    users: dict[str, set[str]] = field(default_factory=dict)
    """The requests that use each renewable resource."""
    totals: Counter[str] = field(default_factory=Counter)
    """A bound for the shares or the level of each resource: the sum of all amounts in clauses and the capacity."""
    kills: list[KillCheck] = field(default_factory=list)
    _taken: dict[str, Span] = field(default_factory=dict)
    _counts: Counter[str] = field(default_factory=Counter)
    _places: int = 0
    _items: int = 0

    def place(self) -> int:
        """Return the next number of a place."""
        self._places += 1
        return self._places - 1

    def where(self, span: Span) -> Location:
        """Return the start of a span as a location."""
        return Location(*self.mistakes.source.place(span.start))

    def has_room(self, number: int, span: Span) -> bool:
        """Count so many more rules and guards; return whether there are at most MAX_ITEMS, and if not, note it."""
        self._items += number
        if self._items <= MAX_ITEMS:
            return True
        self.mistakes.add("E414", f"the spec has more than {MAX_ITEMS} rules with its lists expanded", span)
        return False

    def claim(self, name: str, span: Span, labelled: bool = True) -> None:
        """Take a name for a rule, guard, resource or launch; a name that is taken or reserved is a mistake.

        `labelled`: whether the engineer has chosen it.
        """
        first = same_name(self._taken, name, span)
        if name in NO_RULES:
            hint = "answers use this name themselves"
            self.mistakes.add("E212", f"no rule can be called {quote(name)}", span, hint=hint)
        elif first:
            message = f"two rules are called {quote(name)}"
            label = f"the first stands {self.mistakes.on_line(first, span)}"
            self.mistakes.add("E211", message, span, label=label, hint="" if labelled else "leave one of the two out")

    def label(self, prefix: str, keyword: str, label: tree.Name | None, span: Span) -> str:
        """Return the name of a rule or clause, made of its label or its number, and claim it."""
        self._counts[prefix + keyword] += 1
        name = prefix + (label.text if label else f"{keyword}.{self._counts[prefix + keyword]}")
        self.claim(name, label.span if label else span)
        return name

    def meaning(
        self,
        standing: Standing,
        node: tree.Cond,
        owner: Signature | None = None,
        latches: frozenset[str] = frozenset(),
    ) -> Meaning | None:
        """Return the meaning of a condition in such a place, or None with its mistakes noted."""
        return meaning(NameScope(self.names, self.meanings, self.mistakes, standing, owner, None, latches), node)

    # ---- remedies ----

    def remedies(
        self, nodes: tuple[tree.Remedy, ...], active: frozenset[str] | None, used: frozenset[str] = frozenset()
    ) -> tuple[Remedy, ...]:
        """Return the remedies, reject if there are none; a kill is checked later against `active` and `used`.

        These are as in `KillCheck`; if `active` is None, kills are not checked.
        """
        found: list[Remedy] = []
        for node in nodes:
            match node:
                case tree.Reject():
                    found.append(Reject())
                case tree.Wait():
                    found.append(Wait())
                case tree.Kill(requests):
                    killed = entries(self.names, requests, self.mistakes)
                    found.append(Kill(tuple(entry.request for entry in killed)))
                    if active is not None:
                        self.kills.append(KillCheck(killed, active, used))
        return tuple(found) or (Reject(),)

    def check_kills(self) -> None:
        """Note every kill of a request that its rule does not read."""
        for check in self.kills:
            readable = check.active.union(*(self.users.get(resource, ()) for resource in check.used))
            for entry in check.entries:
                if entry.request not in readable:
                    message = f"the rule does not read {quote(entry.request)}, so killing it is no remedy"
                    hint = f"let the condition name {quote(f'active({entry.request})')}, or kill what it names"
                    self.mistakes.add("E404", message, entry.span, hint=hint)

    def check_totals(self) -> None:
        """Note every resource whose capacity and amounts exceed 64 bits together: no sum of it is greater."""
        for name, resource in self.names.resources.items():
            if self.totals[name] > MAX_INT:
                message = f"the capacity of {quote(name)} and the amounts of its clauses do not fit 64 bits together"
                self.mistakes.add("E310", message, resource.span)
