"""The actions of diagrams, and how the demands of rules are composed to a decision."""

from collections.abc import Iterable
from itertools import groupby

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.ocrd.diagram import NO, Act, Manager, TooManyNodes
from exover.ocrd.view import KillTarget


@dataclass(frozen=True, slots=True)
class DoReject:
    """The newcomer is rejected."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class DoWait:
    """The newcomer waits."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class DoClear:
    """The newcomer takes the waiting place, clearing; its kills follow on the path."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class DoSettle:
    """The newcomer takes the waiting place, clearing, with nothing to kill."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class DoKill:
    """The running slots among the target are killed."""

    target: KillTarget
    reason: Reason


@dataclass(frozen=True, slots=True)
class DoDismiss:
    """What is in the waiting place of `request` is rejected."""

    request: str
    reason: Reason


@dataclass(frozen=True, slots=True)
class DoLaunch:
    """The newcomer is launched."""


@dataclass(frozen=True, slots=True)
class DoViolation:
    """No remedy restores the rule."""

    reason: Reason


@dataclass(frozen=True, slots=True)
class DoAgree:
    """The condition holds: of a latch, of a launch rule, or a predicate of arguments."""


@dataclass(frozen=True, slots=True)
class DoNothing:
    """Nothing is done. What is asked below may have been asked above: it was not remembered."""


Do = DoReject | DoWait | DoClear | DoSettle | DoKill | DoDismiss | DoLaunch | DoViolation | DoAgree | DoNothing
LARGE = 20_000
"""Nodes that the demands of a decision may make before some are asked anew."""
SMALL = 200
"""Nodes that one demand may then make before those below it are asked anew."""
DecisionEffect = tuple[str, ...] | tuple[str, str, int]
"""An action of a decision without its reason: a verdict; `kill`, a request and a slot; or `dismiss` and a request."""


@dataclass(frozen=True, slots=True)
class DecisionList:
    """A decision before it is one diagram. Its conditions are diagrams of the manager that built them.

    `demands`: pairs of a condition and the action that it demands. `hits`: in order, a condition, the slots that it
    clears, and why. `choices` maps an element to those that it selects from. It should precede them in the variable
    order: after them, a diagram would have to remember all their values.
    """

    choices: dict[int, set[int]]
    demands: tuple[tuple[int, Do], ...]
    hits: tuple[tuple[int, tuple[KillTarget, ...], Reason], ...]

    def conditions(self) -> list[int]:
        """Return the conditions in the order in which the decision tests them."""
        ranked = [where for kind in (DoReject, DoWait) for where, do in self.demands if isinstance(do, kind)]
        ranked += [hit for hit, _, _ in self.hits]
        return ranked + [where for kind in (DoSettle, DoDismiss) for where, do in self.demands if isinstance(do, kind)]

    def copy(self, source: Manager, target: Manager) -> "DecisionList":
        """Return the same decision with its conditions in another manager."""
        found = source.copies([*(where for where, _ in self.demands), *(hit for hit, _, _ in self.hits)], target)
        demands = tuple((found[where], do) for where, do in self.demands)
        hits = tuple((found[hit], targets, reason) for hit, targets, reason in self.hits)
        return DecisionList(self.choices, demands, hits)

    def compose(self, manager: Manager) -> int:
        """Return the decision as a diagram: any reject, else any wait, else the kills of C, else any settle, else the
        launch, after the dismissals.

        A diagram asks each entry once. Where that needs too many nodes, since what later demands read has to be
        remembered until the last verdict before them is known, the later demands are asked anew, below `DoNothing`.
        """
        try:
            with manager.within(LARGE):
                return _Composition(self, manager, LARGE).diagram()
        except TooManyNodes:
            return _Composition(self, manager, SMALL).diagram()


@dataclass(frozen=True)
class _Composition:
    """A decision list that becomes a diagram, to which one demand may add `most` nodes."""

    decision: DecisionList
    manager: Manager
    most: int

    def diagram(self) -> int:
        """Return the diagram."""
        manager = self.manager
        result = manager.act(DoLaunch(), NO)
        dismissals = [demand for demand in reversed(self.decision.demands) if isinstance(demand[1], DoDismiss)]
        for where, group in groupby(dismissals, key=lambda demand: demand[0]):
            dismissed = result
            for _, do in group:
                dismissed = manager.act(do, dismissed)
            result = self._chosen(where, dismissed, result)
        result = self._first(DoSettle, result)
        none, some = result, NO
        for hit, targets, reason in reversed(self.decision.hits):
            first = manager.act(DoClear(reason), kills(manager, targets, reason, some))
            none = self._chosen(hit, first, none)
            some = self._chosen(hit, kills(manager, targets, reason, some), some)
        return self._first(DoReject, self._first(DoWait, none))

    def _first(self, kind: type[Do], otherwise: int) -> int:
        for where, do in reversed(self.decision.demands):
            if isinstance(do, kind):
                otherwise = self._chosen(where, self.manager.act(do, NO), otherwise)
        return otherwise

    def _chosen(self, where: int, do: int, otherwise: int) -> int:
        """Return the diagram of the actions `do` where the condition holds, of `otherwise` elsewhere."""
        try:
            with self.manager.within(self.most):
                return self.manager.ite(where, do, otherwise)
        except TooManyNodes:
            return self.manager.ite(where, do, self.manager.act(DoNothing(), otherwise))


def asked_anew(manager: Manager, root: int) -> bool:
    """Return whether the diagram of a decision asks anew what it may have asked."""
    return any(
        isinstance(node, Act) and node.action == DoNothing() for node in map(manager.node, manager.below([root]))
    )


def kills(manager: Manager, targets: Iterable[KillTarget], reason: Reason, then: int) -> int:
    """Return the diagram that kills the targets in order, then goes on with `then`."""
    for target in reversed(list(targets)):
        then = manager.act(DoKill(target, reason), then)
    return then
