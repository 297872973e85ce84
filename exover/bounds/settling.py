"""A bound on the passes of a step: which actions of steps 3 to 5 may wake each other, and the longest chain of these.

A pass restores rules, tries required launches, and decides again on what waits, in this order. Its *actions* are: to
kill for a rule; to try a launch; to empty a waiting place, to turn it between waiting and clearing, to kill for what
waits there. Between steps none of them is due. So an action is done only after a move (costs.py) that *wakes* it: a
move that may turn a walk to a path that leads to the action. An event wakes the actions that its moves wake, and these
wake others by their own moves. Besides, each step tries required launches anew, and what fell from clearing to waiting
may clear again: these actions are *spontaneous*.

An action is done a bounded number of times in a step: a slot is killed once, a launch is tried once, a place is emptied
once for each time that it is taken, and it clears and falls once each. The cause of an action is an action before it
in the same pass, or one in the pass before. So the longest chain of causes bounds the passes. Actions that may wake
each other are a strongly connected component of the relation "wakes". In a component each time that an action is done
may take a pass of its own; between components the relation is acyclic.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import chain

from exover.bounds.costs import Costs
from exover.components import strong_components
from exover.dataclass import dataclass
from exover.ocrd import tables as t
from exover.ocrd.tables import NONE, Tables


@dataclass(frozen=True, slots=True)
class PassAction:
    """An action that a step does at most `times`: the moves that wake it and that it makes, and its cost in a step."""

    position: int
    """Where it stands in a pass: rules, then launches, then requests."""
    times: int
    woken_by: frozenset[int]
    moves: frozenset[int]
    answers: int = 0
    """Answers, but for kills and for what leaves a waiting place."""
    tests: int = 0
    """Tests, but for kills and for what leaves a waiting place."""
    slots: frozenset[int] = frozenset()
    """The slots that it may kill."""
    places: frozenset[int] = frozenset()
    """The waiting places that it may empty."""
    spontaneous: bool = False
    """Whether it may be done although no move has woken it."""


@dataclass(frozen=True, slots=True)
class StrongComponent:
    """A strongly connected component of actions that may wake each other: their cost in one step, and their passes."""

    passes: int
    answers: int
    tests: int
    slots: frozenset[int]
    places: frozenset[int]
    first: int
    """Where the earliest of its actions stands in a pass."""
    last: int
    after: set[int] = field(default_factory=set)
    """The numbers of the other components that it wakes."""


@dataclass(frozen=True, slots=True)
class WokenActions:
    """What an event wakes: the last pass in which something may change, 0 for none, and what all of it costs."""

    passes: int
    answers: int
    tests: int
    slots: frozenset[int]
    places: frozenset[int]


@dataclass
class Settling:
    """The actions of passes, and which of them an event wakes."""

    tables: Tables
    cost: Costs
    _known: dict[frozenset[int], WokenActions] = field(default_factory=dict)
    """What is woken, by the components that moves wake and that are not spontaneous: few sets for many events."""

    def woken(self, moves: Iterable[int]) -> WokenActions:
        """Return what these moves wake, and what is spontaneous."""
        woken = {component for move in moves for component in self._woken.get(move, ())}
        key = frozenset(woken.difference(self._spontaneous))
        if key not in self._known:
            passes, reached = self._reached(key)
            self._known[key] = WokenActions(
                passes,
                sum(component.answers for component in reached),
                sum(component.tests for component in reached),
                frozenset().union(*(component.slots for component in reached)),
                frozenset().union(*(component.places for component in reached)),
            )
        return self._known[key]

    def _reached(self, woken: Iterable[int]) -> tuple[int, list[StrongComponent]]:
        """Return the last pass in which something may change after components were woken, and all that this wakes."""
        pass_of = dict.fromkeys(woken, 1)
        pass_of |= dict.fromkeys(self._spontaneous, 1)
        pending, last, reached = [-number for number in pass_of], 0, []
        heapify(pending)
        while pending:  # components have smaller numbers than those that wake them
            number = -heappop(pending)
            component = self._components[number]
            reached.append(component)
            ended = pass_of[number] + component.passes - 1
            last = max(last, ended)
            for after in component.after:
                if after not in pass_of:
                    heappush(pending, -after)
                begins = ended if component.last < self._components[after].first else ended + 1
                pass_of[after] = max(pass_of.get(after, 1), begins)
        return last, reached

    @cached_property
    def waiting(self) -> list[int]:
        """The requests that may come to wait."""
        return [request for request, may_wait in enumerate(self.tables.may_wait()) if may_wait]

    def taken(self, request: int) -> int:
        """Return how often a waiting place can be left in a step: once, and once more for each launch rule of it."""
        return 1 + self._required.get(request, 0)

    @cached_property
    def _required(self) -> dict[int, int]:
        found: dict[int, int] = {}
        for launch in self.tables.launches:
            found[launch.request] = found.get(launch.request, 0) + 1
        return found

    # ---- actions ----

    @cached_property
    def _actions(self) -> list[PassAction]:
        """All actions in the order of a pass."""
        rules, launches = self.tables.rules, self.tables.launches
        found = [self._kills(n, rule.root) for n, rule in enumerate(rules) if t.KILL in self.tables.actions(rule.root)]
        found += [self._launch(n, launch) for n, launch in enumerate(launches, len(rules))]
        falls = self.tables.may_fall()
        return [*found, *(action for request in self.waiting for action in self._place(request, falls[request]))]

    def _kills(self, position: int, root: int, spontaneous: bool = False) -> PassAction:
        """Return the action of the kills of a diagram; a slot that starts to run wakes it too."""
        killed = self.cost.killed(root)
        slots = frozenset().union(*killed.values())
        moves = frozenset(move for request in killed for move in self.cost.kill(request).moves)
        woken_by = self._moves_to(root, {t.KILL}) | frozenset(map(self.cost.running, killed))
        return PassAction(position, len(slots), woken_by, moves, slots=slots, spontaneous=spontaneous)

    def _launch(self, position: int, launch: t.LaunchRow) -> PassAction:
        """Return the action of a required launch: one answer, and one more if what waited may be superseded."""
        request = launch.request
        doing, answers = self.cost.decision(request), 1 + self.tables.requests[request].interrupts_self
        tests = doing.tests + 2 * self.cost.place[request] + self.cost.looking(doing.moves)
        woken_by, moves = self._moves_to(launch.condition, {t.AGREE}), frozenset(doing.moves)
        return PassAction(position, 1, woken_by, moves, answers, tests, doing.slots, doing.places, spontaneous=True)

    def _place(self, request: int, turns: bool) -> Iterator[PassAction]:
        """Yield the actions on a waiting place: to empty it, to turn it between its phases if it `turns`, to kill."""
        cost, decide, taken = self.cost, self.tables.requests[request].decide, self.taken(request)
        position = len(self.tables.rules) + len(self.tables.launches) + request
        doing, launch = cost.decision(request), cost.launch(request)
        dismissed = (move for other in doing.places for move in cost.placed(other))
        moves = frozenset(chain(launch.moves, cost.placed(request), dismissed))
        tests = taken * (launch.tests + cost.looking(launch.moves))
        woken_by = self._moves_to(decide, {t.LAUNCH, t.DISMISS, t.REJECT})
        yield PassAction(position, taken, woken_by, moves, tests=tests, places=doing.places | {request})
        if turns:
            moves = frozenset(cost.turn(request, "waiting", "clearing") | cost.turn(request, "clearing", "waiting"))
            tests = 2 * (cost.place[request] + cost.leaving[request])
            yield PassAction(
                position, 2, self._moves_to(decide, {t.CLEAR, t.SETTLE, t.WAIT}), moves, tests=tests, spontaneous=True
            )
        if t.KILL in self.tables.actions(decide):
            yield self._kills(position, decide, turns)

    def _moves_to(self, root: int, codes: set[int]) -> frozenset[int]:
        """Return the moves that may turn a walk to a path that leads to one of these actions."""
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
    def _components(self) -> list[StrongComponent]:
        """The components by number, each behind all that it wakes."""
        members: list[list[PassAction]] = [[] for _ in range(1 + max(self._component_of, default=-1))]
        makers: dict[int, set[int]] = {}
        for action, number in zip(self._actions, self._component_of, strict=True):
            members[number].append(action)
            for move in action.moves & self._woken.keys():
                makers.setdefault(move, set()).add(number)
        found = list(map(_joined, members))
        for move, numbers in makers.items():
            for number in numbers:
                found[number].after.update(self._woken[move] - {number})
        return found

    @cached_property
    def _woken(self) -> dict[int, set[int]]:
        """By move the numbers of the components that it wakes."""
        found: dict[int, set[int]] = {}
        for action, number in zip(self._actions, self._component_of, strict=True):
            for move in action.woken_by:
                found.setdefault(move, set()).add(number)
        return found

    @cached_property
    def _spontaneous(self) -> set[int]:
        return {number for action, number in zip(self._actions, self._component_of, strict=True) if action.spontaneous}

    @cached_property
    def _component_of(self) -> list[int]:
        """The number of the component of each action; edges: action to move, move to what it wakes."""
        actions, woken = self._actions, dict[int, list[int]]()
        for number, action in enumerate(actions):
            for move in sorted(action.woken_by):
                woken.setdefault(move, []).append(number)
        at = {move: len(actions) + place for place, move in enumerate(woken)}
        following = [[at[move] for move in sorted(action.moves) if move in at] for action in actions]
        found = strong_components([*following, *woken.values()])[: len(actions)]
        known = {component: number for number, component in enumerate(sorted(set(found)))}
        return [known[component] for component in found]


def _joined(actions: Sequence[PassAction]) -> StrongComponent:
    """Return the component of these actions; one action that does not wake itself takes a single pass."""
    wakes = len(actions) > 1 or bool(actions[0].woken_by & actions[0].moves)
    positions = [action.position for action in actions]
    return StrongComponent(
        sum(action.times for action in actions) if wakes else 1,
        sum(action.answers for action in actions),
        sum(action.tests for action in actions),
        frozenset().union(*(action.slots for action in actions)),
        frozenset().union(*(action.places for action in actions)),
        min(positions),
        max(positions),
    )
