"""Tables beside the rules: diagrams that are alike, and where two diagrams differ.

Most tables ask what the rules ask, in the same order; then no set of states is needed to see that they decide alike.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from heapq import heappop, heappush
from typing import Protocol, TypeVar

from exover.model.decision import Reason
from exover.ocrd import decision as do
from exover.ocrd import tables as t
from exover.ocrd.decision import DecisionList, Do
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import NO, YES, Act, Manager, Test, deep
from exover.ocrd.tables import NONE, Node, Tables

S = TypeVar("S")
"""States, with arguments of a newcomer: a set, or a condition on them."""
CODES: dict[type, int] = {
    do.DoReject: t.REJECT,
    do.DoWait: t.WAIT,
    do.DoClear: t.CLEAR,
    do.DoSettle: t.SETTLE,
    do.DoKill: t.KILL,
    do.DoDismiss: t.DISMISS,
    do.DoLaunch: t.LAUNCH,
    do.DoViolation: t.VIOLATION,
    do.DoAgree: t.AGREE,
}


def listed(
    manager: Manager,
    decision: DecisionList,
    nodes: Sequence[Node],
    root: int,
    entry: Callable[[int], int | None],
    same: Callable[[Act, Node], bool],
) -> bool:
    """Return whether the tables are seen to ask the conditions of a decision one after another, as it does.

    That is so if each condition is one test, nothing is cleared or dismissed, and the tables have these tests in their
    order, each with what is demanded there, and then the launch. Parameters as for `alike`.
    """
    kinds = (do.DoReject, do.DoWait, do.DoSettle)
    if decision.hits or not all(isinstance(demand, kinds) for _, demand in decision.demands):
        return False

    def does(number: int, demand: Do) -> bool:
        return number != NONE and nodes[number].low == NONE and same(Act(demand, NO), nodes[number])

    for where, demand in (each for kind in kinds for each in decision.demands if isinstance(each[1], kind)):
        mine, its = manager.node(where), None if root == NONE else nodes[root]
        if its is None or not isinstance(mine, Test) or mine.children != (NO, YES):
            return False
        if its.code != entry(manager.entries[mine.level]) or (its.bound,) != mine.cuts or not does(its.high, demand):
            return False
        root = its.low
    return does(root, do.DoLaunch())


def alike(
    manager: Manager,
    diagram: int,
    nodes: Sequence[Node],
    root: int,
    entry: Callable[[int], int | None],
    same: Callable[[Act, Node], bool],
) -> bool:
    """Return whether a diagram of the rules and one of the tables are seen to do the same in every state.

    That is so if they ask the same in the same order. `entry`: the entry of the tables that is the
    element of this number; `same`: whether two actions are the same.
    """
    seen: set[tuple[int, int, int, int]] = set()
    stack = [(diagram, 0, -1, root)]
    while stack:
        pair = number, first, last, right = stack.pop()
        if (number == NO and right == NONE) or pair in seen:
            continue
        seen.add(pair)
        mine, its = manager.node(number), None if right == NONE else nodes[right]
        if isinstance(mine, Test):
            inside = mine.cuts[first:last] if last >= 0 else mine.cuts  # what is still to be asked of this entry
            if its is None or its.code != entry(manager.entries[mine.level]) or its.bound not in inside:
                return False
            middle, last = first + inside.index(its.bound), first + len(inside)
            for start, end, child in ((first, middle, its.low), (middle + 1, last, its.high)):
                stack.append((mine.children[start], 0, -1, child) if start == end else (number, start, end, child))
        elif isinstance(mine, Act) and mine.action == do.DoNothing():
            stack.append((mine.child, 0, -1, right))
        elif isinstance(mine, Act):
            if its is None or not same(mine, its):
                return False
            stack.append((mine.child, 0, -1, its.low))
        elif its is not None or number != NO:
            return False
    return True


class Split(Protocol[S]):
    """Tells states apart by what diagrams ask of them."""

    @property
    def none(self) -> S:
        """No state."""
        ...

    def either(self, one: S, other: S) -> S:
        """Return the states of both."""
        ...

    def tested(self, states: S, entry: int, bound: int) -> tuple[S, S]:
        """Return those in which the entry of the tables is at most `bound`, and the others."""
        ...

    def between(self, states: S, element: int, above: int | None, most: int | None) -> S:
        """Return those in which the element of this number is more than `above`, and `most` at most."""
        ...

    def entry(self, element: int) -> int | None:
        """Return the entry of the tables that is the element of this number; None if there is none."""
        ...

    def same(self, mine: Act, its: Node) -> bool:
        """Return whether two actions are the same."""
        ...


def differing(manager: Manager, diagram: int, nodes: Sequence[Node], root: int, states: S, split: Split[S]) -> S:
    """Return the states of `states` in which a diagram of the rules and one of the tables do different things.

    Each pair of nodes is looked at once, with all states that come to it: below an action, which stands on every
    way, there would else be as many ways as there are sets of actions above.
    """
    found = split.none
    at: dict[tuple[int, int], S] = {}
    waiting: list[tuple[int, int, int]] = []

    def go(left: int, right: int, part: S) -> None:
        if part == split.none:
            return
        pair = (left, right)
        if pair not in at:
            # Children have smaller numbers in the diagram, and larger ones in the tables: no pair comes too early.
            heappush(waiting, ((len(nodes) if right == NONE else right) - left, left, right))
        at[pair] = split.either(at.get(pair, split.none), part)

    go(diagram, root, states)
    while waiting:
        _, left, right = heappop(waiting)
        part = at.pop((left, right))
        mine = manager.node(left)
        its = None if right == NONE else nodes[right]
        # Where both ask the same, the rules are asked first, and only one way is left to go in the tables.
        alike = isinstance(mine, Test) and its is not None and its.code == split.entry(manager.entries[mine.level])
        if its is not None and its.code >= 0 and not alike:
            low, high = split.tested(part, its.code, its.bound)
            go(left, its.low, low)
            go(left, its.high, high)
        elif isinstance(mine, Act) and mine.action == do.DoNothing():
            go(mine.child, right, part)
        elif isinstance(mine, Act):
            if its is None or not split.same(mine, its):
                found = split.either(found, part)
            else:
                go(mine.child, its.low, part)
        elif mine is not None:
            element = manager.entries[mine.level]
            for above, most, child in zip((None, *mine.cuts), (*mine.cuts, None), mine.children, strict=True):
                go(child, right, split.between(part, element, above, most))
        elif its is not None or left != NO:
            found = split.either(found, part)
    return found


Build = Callable[[Decider], int]


def built(questions: DecisionContext, build: Build) -> tuple[Manager, int]:
    """Return a manager, and the diagram that a decider builds in it."""
    manager = Manager()
    with deep():
        return manager, build(Decider(questions, manager))


def different_diagrams(
    questions: DecisionContext, tables: Tables, reasons: tuple[Reason, ...], same: Callable[[Manager, int, int], bool]
) -> Iterator[str]:
    """Yield the diagrams that every step needs and the tables have otherwise: of rules, launches, latches.

    `same`: whether a diagram of the rules and one of the tables do the same in every state.
    """
    model = questions.model

    def does(root: int, build: Build) -> bool:
        return same(*built(questions, build), root)

    rows = iter(tables.rules)
    for rule in model.rules:
        if questions.restored(rule):
            for instance in questions.instances(rule, None):
                row = next(rows, None)  # a rule that cannot come to be broken has none
                if row is not None and reasons[row.reason] != instance.reason:
                    yield f"the reason of rule `{rule.name}`"
                if not does(NONE if row is None else row.root, partial(Decider.recover, instance=instance)):
                    yield f"rule `{rule.name}`"
    if next(rows, None) is not None:
        yield "rules, of which there are more than can be broken"
    yield from _different_invariants(questions, tables, reasons, does)
    for launch, required in zip(model.launches, tables.launches, strict=True):
        if not does(required.condition, partial(Decider.required, launch=launch)):
            yield f"launch `{launch.name}`"
    for latch, latching in zip(model.latches, tables.latches, strict=True):
        if not does(latching.condition, partial(Decider.condition, cond=latch.condition)):
            yield f"latch `{latch.name}`"


def _different_invariants(
    questions: DecisionContext, tables: Tables, reasons: tuple[Reason, ...], does: Callable[[int, Build], bool]
) -> Iterator[str]:
    """Yield the rules that only a launch could break, and that the tables have otherwise."""
    copies = [i for rule in questions.model.rules if questions.kept(rule) for i in questions.instances(rule, None)]
    if len(copies) != len(tables.invariants):
        yield "the number of rules that only a launch could break"
    for instance, row in zip(copies, tables.invariants, strict=False):
        if reasons[row.reason] != instance.reason or not does(row.root, partial(Decider.broken, instance=instance)):
            yield f"rule `{instance.rule.name}`"


def same_action(mine: Act, its: Node, tables: Tables, requests: Mapping[str, int], reasons: tuple[Reason, ...]) -> bool:
    """Return whether two action nodes say the same."""
    action = mine.action
    if CODES[type(action)] != -its.code:
        return False
    reason = getattr(action, "reason", None)
    if reason is not None and reasons[its.bound] != reason:
        return False
    target = concerned(action, tables, requests)
    return target is None or its.high == target


def concerned(action: object, tables: Tables, requests: Mapping[str, int]) -> int | None:
    """Return whom an action concerns, as the tables name it: a request, or a slot as `-1 - slot`; None: nobody."""
    match action:
        case do.DoKill((name, int(slot))):
            return -1 - (tables.requests[requests[name]].slots + slot)
        case do.DoKill((name, None)) | do.DoDismiss(name):
            return requests[name]
        case _:
            return None
