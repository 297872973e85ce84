"""The graph of interactions between the requests of a spec, with the rules (docs/commands.md, `exover graph`).

It is read from the rules alone: whether a state in which an edge matters is reachable is not asked.
"""

from collections.abc import Collection, Iterable, Iterator
from functools import cached_property
from itertools import chain
from typing import Literal, get_args

from exover.dataclass import dataclass
from exover.graph.exclusion import Exclusion, Member, exclusions, members
from exover.model.model import Forget, Guard, Latch, Model, Request, Rule, SetState, Wait
from exover.model.reads import Read, active_reads, in_question, reads, rule_reads, users
from exover.model.waiting import killed, may_wait_for
from exover.ocrd.conflicts import pair

InteractionKind = Literal["excludes", "interrupts", "shares", "constrains", "launches", "wakes", "sets"]
KINDS: tuple[InteractionKind, ...] = get_args(InteractionKind)
ALWAYS = "true"
"""The participant that launches if the condition of a launch rule reads nothing."""

READ_AS = {"resource": "level", "poster": "reading", "state": "reading", "latch": "reading"}
"""By kind of participant, the kind of read of it; all other reads are of requests."""


@dataclass(frozen=True, slots=True)
class Participant:
    """A node of the graph: a request, or something that a request depends on; `text`: its label."""

    name: str
    kind: Literal["request", "poster", "state", "latch", "resource", "limit", "always"]
    text: str

    @property
    def id(self) -> str:
        """A unique name; `name` is not unique, since a poster may have the name of a request."""
        return self.name if self.kind == "request" else f"{self.kind} {self.name}"

    @property
    def module(self) -> str:
        """The module that declares it; empty if it is declared outside modules."""
        inside = self.kind in ("request", "poster", "state") and "." in self.name
        return self.name.partition(".")[0] if inside else ""


@dataclass(frozen=True, slots=True)
class Interaction:
    """An edge between the ids of two participants, with the rules that are the reason, in the order of the text.

    `excludes` and `shares` have no direction. `sometimes`: it depends on arguments or readings.
    """

    kind: InteractionKind
    source: str
    target: str
    rules: tuple[str, ...]
    sometimes: bool = False


@dataclass(frozen=True, slots=True)
class InteractionGraph:
    """All requests, the other participants that have an edge, and the edges, in the order of the text."""

    name: str
    participants: tuple[Participant, ...]
    interactions: tuple[Interaction, ...]


def interactions(model: Model, kinds: Collection[InteractionKind] = KINDS) -> InteractionGraph:
    """Return the graph of a model with interactions of these kinds."""
    found = InteractionFinder(model)
    edges = tuple(edge for edge in _merged(found.all()) if edge.kind in kinds)
    touched = {end for edge in edges for end in (edge.source, edge.target)}
    participants = (each for each in found.participants if each.kind == "request" or each.id in touched)
    return InteractionGraph(model.name, tuple(participants), edges)


def _merged(edges: Iterable[Interaction]) -> Iterator[Interaction]:
    """Yield the edges; those that differ in their rules alone are one edge with all these rules."""
    rules: dict[tuple[InteractionKind, str, str, bool], dict[str, None]] = {}
    for edge in edges:
        key = edge.kind, edge.source, edge.target, edge.sometimes
        rules.setdefault(key, {}).update(dict.fromkeys(edge.rules))
    for (kind, source, target, sometimes), names in rules.items():
        yield Interaction(kind, source, target, tuple(names), sometimes)


@dataclass(frozen=True)
class InteractionFinder:
    """Finds the interactions of one model."""

    model: Model

    def all(self) -> Iterator[Interaction]:
        """Yield every edge, kind by kind; edges may differ in their rules alone."""
        yield from chain.from_iterable(map(self._excluded, self._exclusions))
        yield from self._shares()
        yield from self._constrained()
        for launch in self.model.launches:
            for source in self._sources(reads(launch.condition)) or (f"always {ALWAYS}",):
                yield Interaction("launches", source, launch.request, (launch.name,))
        yield from self._woken()
        yield from self._set()

    @cached_property
    def participants(self) -> tuple[Participant, ...]:
        """Everything that may be at an end of an edge."""
        return tuple(self._participants())

    def _participants(self) -> Iterator[Participant]:
        for request in self.model.requests:
            yield Participant(request.name, "request", request.name.partition(".")[2])
        for variable in self.model.variables:
            yield Participant(variable.name, variable.kind, variable.name.rpartition(".")[2])
        for latch in self.model.latches:
            yield Participant(latch.name, "latch", latch.name)
        for resource in self.model.resources:
            yield Participant(resource.name, "resource", f"{resource.name}: {resource.capacity}")
        for rule, limit in self._limits:
            yield Participant(rule.name, "limit", f"at most {limit.capacity}")
        yield Participant(ALWAYS, "always", ALWAYS)

    # ---- who excludes whom ----

    @cached_property
    def _exclusions(self) -> tuple[tuple[Rule, Exclusion], ...]:
        return tuple((rule, exclusion) for rule in self.model.rules for exclusion in exclusions(rule, self.model))

    def _excluded(self, found: tuple[Rule, Exclusion]) -> Iterator[Interaction]:
        """Yield the edges `interrupts` of an exclusion, or if its rule kills neither, the edge `excludes`."""
        rule, (first, second, sometimes) = found
        ended = killed(rule)
        directed = {(a, b): None for a, b in ((first, second), (second, first)) if b in ended}
        for winner, loser in directed:
            yield Interaction("interrupts", winner, loser, (rule.name,), sometimes)
        if not directed:
            yield Interaction("excludes", first, second, (rule.name,), sometimes)

    @cached_property
    def _limits(self) -> tuple[tuple[Rule, Member], ...]:
        """The limits with a capacity above 1, each with its first member."""
        found = ((rule, members(rule, self.model)) for rule in self.model.rules if rule.kind == "limit")
        return tuple((rule, member[0]) for rule, member in found if member and member[0].capacity > 1)

    def _shares(self) -> Iterator[Interaction]:
        for rule in self.model.rules:
            for member in members(rule, self.model):
                if rule.kind == "resource" or member.capacity > 1:
                    most = f"up to {member.most}" if member.most > member.least else str(member.most)
                    yield Interaction("shares", member.request, f"{rule.kind} {rule.name}", (most,), member.least == 0)
        for request in self.model.requests:
            for clause in request.consumptions:
                taken = (f"consumes {clause.amount}",)
                stock = f"resource {clause.resource}"
                yield Interaction("shares", request.name, stock, taken, clause.when is not None)

    # ---- what else decides ----

    def _constrained(self) -> Iterator[Interaction]:
        """Yield the edges `constrains`: from what guards that reject read, and what rules read besides activity."""
        for request in self.model.requests:
            for guard in request.guards:
                if guard.kind == "check":
                    yield from self._depends("constrains", request, guard, reads(guard.condition))
        for rule in self.model.rules:
            named = rule_reads(rule)
            rest = frozenset(read for read in named if read.kind in ("past", "level", "reading"))
            for name in sorted(active_reads(self.model, (rule,))) if rest else ():
                yield from self._depends("constrains", self.model.request[name], rule, rest)

    def _woken(self) -> Iterator[Interaction]:
        """Yield the edges `wakes`: from what a guard, rule or resource reads for which a request may wait."""
        asked = in_question(self.model)
        for request in self.model.requests:
            for guard in request.guards:
                if guard.kind != "check":
                    yield from self._depends("wakes", request, guard, reads(guard.condition))
            for rule in asked[request.name]:
                if may_wait_for(request, rule):
                    yield from self._depends("wakes", request, rule, rule_reads(rule))
            for clause in request.consumptions:
                if Wait() in self.model.resource[clause.resource].remedies:
                    yield Interaction("wakes", f"resource {clause.resource}", request.name, (clause.resource,))

    def _depends(
        self, kind: InteractionKind, request: Request, why: Guard | Rule, named: frozenset[Read]
    ) -> Iterator[Interaction]:
        """Yield an edge from each participant read; from the request itself only if two of its slots can matter."""
        alone = request.instances == 1 and not (isinstance(why, Rule) and pair(why) == (request.name, request.name))
        for source in self._sources(named):
            if source != request.name or not alone:
                yield Interaction(kind, source, request.name, (why.name,))

    def _set(self) -> Iterator[Interaction]:
        """Yield the edges `sets`: from what changes states, pasts, levels and latches, with the occasion."""
        for request in self.model.requests:
            for moment in ("launch", "ok", "failed", "interrupted"):
                for effect in getattr(request, f"on_{moment}"):
                    match effect:
                        case SetState(state, _):
                            yield Interaction("sets", request.name, f"state {state}", (f"on {moment}",))
                        case Forget(requests):
                            for past in requests:
                                yield Interaction("sets", request.name, past, (f"on {moment} forget",))
            for share in request.productions:
                stock, produced = f"resource {share.resource}", (f"produces {share.amount}",)
                yield Interaction("sets", request.name, stock, produced, share.when is not None)
        for latch in self.model.latches:
            yield from self._latched(latch)

    def _latched(self, latch: Latch) -> Iterator[Interaction]:
        for source in self._sources(reads(latch.condition)):
            yield Interaction("sets", source, f"latch {latch.name}", ("when",))
        for reset in latch.resets:
            yield Interaction("sets", reset, f"latch {latch.name}", ("until",))

    def _sources(self, named: frozenset[Read]) -> tuple[str, ...]:
        """Return the ids of the participants on which these reads depend, in the order of the text."""
        using = {user for read in named if read.kind == "used" for user in users(self.model, read.name)}
        other = READ_AS.values()
        found = {(read.kind if read.kind in other else "request", read.name) for read in named if read.kind != "used"}
        places = {self._places[each] for each in found | {("request", user) for user in using}}
        return tuple(self.participants[place].id for place in sorted(places))

    @cached_property
    def _places(self) -> dict[tuple[str, str], int]:
        """The index of each participant, by the kind and name of its read."""
        return {(READ_AS.get(each.kind, each.kind), each.name): at for at, each in enumerate(self.participants)}
