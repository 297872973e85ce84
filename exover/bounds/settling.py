"""What a pass of steps 3 to 5 may do, and what wakes what: how many passes a step takes at most.

A pass restores rules, tries required launches, and decides again on what waits, in this order. What it may do are
*acts*: to kill for a rule; to try a launch; to leave a waiting place, to turn it between waiting and clearing, to kill
for what waits there. Between steps none is left to be done. So one is done only after a move (costs.py) that it
*minds*, since that may turn a walk to what it does: an event wakes the acts that mind its moves, these those that mind
theirs. Besides, each step tries required launches anew, and what fell from clearing to waiting may clear again.

Acts are done only so often in a step: a slot is killed once, a launch tried once, a waiting place left once for each
time that it is taken, and it clears and falls once each. And what is done was brought about in the same pass, by
something before it, or in the pass before. So the longest chain of acts that bring about each other bounds the passes.
Acts that may wake each other make a *circle*, in which each time may take a pass of its own; from one circle to the
next leads one direction.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import chain

from exover.bounds.costs import Costs
from exover.dataclass import dataclass
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, Tables


@dataclass(frozen=True, slots=True)
class PassAction:
    """Something that a pass may do `times` in one step: the moves that it minds and makes, and what it costs."""

    position: int
    """Where it stands in a pass: rules, then launches, then requests."""
    times: int
    minds: frozenset[int]
    moves: frozenset[int]
    answers: int = 0
    """But for those to whom kills, and what leaves a waiting place, are told."""
    tests: int = 0
    """But for kills, and for what leaves a waiting place."""
    slots: frozenset[int] = frozenset()
    """Those that it may kill."""
    places: frozenset[int] = frozenset()
    """The waiting places that it may empty."""
    restless: bool = False
    """Whether it may be done although nothing moved."""


@dataclass(frozen=True, slots=True)
class Circle:
    """Acts that may wake each other, or one: all that they may do in one step, and in how many passes."""

    passes: int
    answers: int
    tests: int
    slots: frozenset[int]
    places: frozenset[int]
    first: int
    """Where the earliest of its acts stands in a pass."""
    last: int
    after: set[int] = field(default_factory=set)
    """The numbers of the other circles that it wakes."""


@dataclass
class Settling:
    """The acts of a spec, and which of them an event wakes."""

    tables: Tables
    cost: Costs

    def woken(self, moves: Iterable[int]) -> tuple[int, list[Circle]]:
        """Return the last pass in which something may change after these moves, 0 for none, and all that is woken."""
        pass_of = {circle: 1 for move in moves for circle in self._minding.get(move, ())}
        pass_of |= dict.fromkeys(self._restless, 1)
        pending, last, reached = [-number for number in pass_of], 0, []
        heapify(pending)
        while pending:  # circles have smaller numbers than those that wake them
            number = -heappop(pending)
            circle = self._circles[number]
            reached.append(circle)
            ended = pass_of[number] + circle.passes - 1
            last = max(last, ended)
            for after in circle.after:
                if after not in pass_of:
                    heappush(pending, -after)
                begins = ended if circle.last < self._circles[after].first else ended + 1
                pass_of[after] = max(pass_of.get(after, 1), begins)
        return last, reached

    @cached_property
    def waiting(self) -> list[int]:
        """The requests that may come to wait."""
        rows = enumerate(self.tables.requests)
        return [r for r, row in rows if self.cost.codes(row.decide) & {t.WAIT, t.CLEAR, t.SETTLE}]

    def taken(self, request: int) -> int:
        """Return how often a waiting place can be left in one step: what stood there, and what launches put there."""
        return 1 + self._required.get(request, 0)

    @cached_property
    def _required(self) -> dict[int, int]:
        found: dict[int, int] = {}
        for launch in self.tables.launches:
            found[launch.request] = found.get(launch.request, 0) + 1
        return found

    # ---- acts ----

    @cached_property
    def _acts(self) -> list[PassAction]:
        """All acts in the order of a pass."""
        rules, launches = self.tables.rules, self.tables.launches
        found = [self._kills(n, rule.root) for n, rule in enumerate(rules) if t.KILL in self.cost.codes(rule.root)]
        found += [self._launch(n, launch) for n, launch in enumerate(launches, len(rules))]
        return [*found, *(act for request in self.waiting for act in self._place(request))]

    def _kills(self, position: int, root: int, restless: bool = False) -> PassAction:
        """Return the kills of a diagram: it minds also that there is more to kill."""
        killed = self.cost.killed(root)
        slots = frozenset().union(*killed.values())
        moves = frozenset(move for request in killed for move in self.cost.kill(request).moves)
        minds = self._minded(root, {t.KILL}) | frozenset(map(self.cost.running, killed))
        return PassAction(position, len(slots), minds, moves, slots=slots, restless=restless)

    def _launch(self, position: int, launch: t.LaunchRow) -> PassAction:
        """Return the trial of a required launch: it is answered, and what waited may be superseded."""
        request = launch.request
        doing, answers = self.cost.decision(request), 1 + self.tables.requests[request].interrupts_self
        tests = doing.tests + 2 * self.cost.place[request] + self.cost.looking(doing.moves)
        minds, moves = self._minded(launch.condition, {t.AGREE}), frozenset(doing.moves)
        return PassAction(position, 1, minds, moves, answers, tests, doing.slots, doing.places, restless=True)

    def _place(self, request: int) -> Iterator[PassAction]:
        """Yield what becomes of a waiting place."""
        cost, decide, taken = self.cost, self.tables.requests[request].decide, self.taken(request)
        position, codes = len(self.tables.rules) + len(self.tables.launches) + request, cost.codes(decide)
        turns = t.WAIT in codes and bool(codes & {t.CLEAR, t.SETTLE})
        doing, launch = cost.decision(request), cost.launch(request)
        dismissed = (move for other in doing.places for move in cost.placed(other))
        moves = frozenset(chain(launch.moves, cost.placed(request), dismissed))
        tests = taken * (launch.tests + cost.looking(launch.moves))
        minds = self._minded(decide, {t.LAUNCH, t.DISMISS, t.REJECT})
        yield PassAction(position, taken, minds, moves, tests=tests, places=doing.places | {request})
        if turns:
            moves = frozenset(cost.turn(request, "waiting", "clearing") | cost.turn(request, "clearing", "waiting"))
            tests = 2 * (cost.place[request] + cost.leaving[request])
            yield PassAction(
                position, 2, self._minded(decide, {t.CLEAR, t.SETTLE, t.WAIT}), moves, tests=tests, restless=True
            )
        if t.KILL in codes:
            yield self._kills(position, decide, turns)

    def _minded(self, root: int, codes: set[int]) -> frozenset[int]:
        """Return the moves that may turn a walk to a way that comes to one of these actions."""
        nodes, leads, found = self.tables.nodes, {NONE: False}, set()
        for index in reversed(self.tables.below(root)):
            node = nodes[index]
            if node.code < 0:
                leads[index] = -node.code in codes or leads[node.low]
                continue
            leads[index] = leads[node.low] or leads[node.high]
            found |= {node.code} if leads[node.high] else set()
            found |= {~node.code} if leads[node.low] else set()
        return frozenset(found)

    # ---- what wakes what ----

    @cached_property
    def _circles(self) -> list[Circle]:
        """The circles, each after all that it wakes."""
        members: list[list[PassAction]] = [[] for _ in range(1 + max(self._circle_of, default=-1))]
        makers: dict[int, set[int]] = {}
        for act, number in zip(self._acts, self._circle_of, strict=True):
            members[number].append(act)
            for move in act.moves & self._minding.keys():
                makers.setdefault(move, set()).add(number)
        found = list(map(_circle, members))
        for move, numbers in makers.items():
            for number in numbers:
                found[number].after.update(self._minding[move] - {number})
        return found

    @cached_property
    def _minding(self) -> dict[int, set[int]]:
        """By move the numbers of the circles that mind it."""
        found: dict[int, set[int]] = {}
        for act, number in zip(self._acts, self._circle_of, strict=True):
            for move in act.minds:
                found.setdefault(move, set()).add(number)
        return found

    @cached_property
    def _restless(self) -> set[int]:
        return {number for act, number in zip(self._acts, self._circle_of, strict=True) if act.restless}

    @cached_property
    def _circle_of(self) -> list[int]:
        """The number of the circle of each act: acts lead to their moves, and these to the acts that mind them."""
        acts, minding = self._acts, dict[int, list[int]]()
        for number, act in enumerate(acts):
            for move in sorted(act.minds):
                minding.setdefault(move, []).append(number)
        at = {move: len(acts) + place for place, move in enumerate(minding)}
        following = [[at[move] for move in sorted(act.moves) if move in at] for act in acts]
        found = components([*following, *minding.values()])[: len(acts)]
        known = {component: number for number, component in enumerate(sorted(set(found)))}
        return [known[component] for component in found]


def _circle(acts: Sequence[PassAction]) -> Circle:
    """Return what acts do together; one that does not wake itself does all that something brings about in one pass."""
    wakes = len(acts) > 1 or bool(acts[0].minds & acts[0].moves)
    positions = [act.position for act in acts]
    return Circle(
        sum(act.times for act in acts) if wakes else 1,
        sum(act.answers for act in acts),
        sum(act.tests for act in acts),
        frozenset().union(*(act.slots for act in acts)),
        frozenset().union(*(act.places for act in acts)),
        min(positions),
        max(positions),
    )


def components(following: Sequence[Sequence[int]]) -> list[int]:
    """Return by node the number of its strongly connected component, smaller than of those that lead to it.

    Depth-first search (Tarjan 1972) with a stack of its own.
    """
    index: dict[int, int] = {}
    low, component = [0] * len(following), [-1] * len(following)
    open_nodes: list[int] = []
    count = 0
    for root in range(len(following)):
        path = [(root, iter(following[root]))] if root not in index else []
        while path:
            node, rest = path[-1]
            if node not in index:
                index[node] = low[node] = len(index)
                open_nodes.append(node)
            child = next(rest, None)
            if child is None:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    while component[node] < 0:
                        component[open_nodes.pop()] = count
                    count += 1
            elif child not in index:
                path.append((child, iter(following[child])))
            elif component[child] < 0:
                low[node] = min(low[node], index[child])
    return component
