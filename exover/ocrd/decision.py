"""The actions of diagrams, and how the demands of rules are composed to a decision."""

from collections.abc import Iterable
from itertools import groupby

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.ocrd.diagram import NO, Manager
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


Do = DoReject | DoWait | DoClear | DoSettle | DoKill | DoDismiss | DoLaunch | DoViolation | DoAgree
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
        """
        result = manager.act(DoLaunch(), NO)
        dismissals = [demand for demand in reversed(self.demands) if isinstance(demand[1], DoDismiss)]
        for where, group in groupby(dismissals, key=lambda demand: demand[0]):
            dismissed = result
            for _, do in group:
                dismissed = manager.act(do, dismissed)
            result = manager.ite(where, dismissed, result)
        result = self._first(manager, DoSettle, result)
        none, some = result, NO
        for hit, targets, reason in reversed(self.hits):
            first = manager.act(DoClear(reason), kills(manager, targets, reason, some))
            none = manager.ite(hit, first, none)
            some = manager.ite(hit, kills(manager, targets, reason, some), some)
        return self._first(manager, DoReject, self._first(manager, DoWait, none))

    def _first(self, manager: Manager, kind: type[Do], otherwise: int) -> int:
        for where, do in reversed(self.demands):
            if isinstance(do, kind):
                otherwise = manager.ite(where, manager.act(do, NO), otherwise)
        return otherwise


def kills(manager: Manager, targets: Iterable[KillTarget], reason: Reason, then: int) -> int:
    """Return the diagram that kills the targets in order, then goes on with `then`."""
    for target in reversed(list(targets)):
        then = manager.act(DoKill(target, reason), then)
    return then
