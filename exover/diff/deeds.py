"""The deeds of a step, what it does with each request, and the definition of the changes between two versions.

A refused required launch is a rejection in every step that refuses it, also where that is not answered again.
"""

from collections.abc import Iterable, Iterator
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.difference import DEED_KINDS, AnswerChange
from exover.model.event import AbortWaiting, Action, Args, Event, Killed, Launched, Rejected, Violated, Waits
from exover.model.model import Launch, Request
from exover.model.semantics import Reference, Step
from exover.model.state import State
from exover.model.types import Value
from exover.model.versions import Versions

Named = frozenset[tuple[str, Value]]
"""Arguments by name."""


@dataclass(frozen=True, slots=True)
class Deeds:
    """What a step does with a request: launches by slot and arguments, slots that it kills, arguments that it rejects.

    `put`: whether it puts something into the waiting place; `standing`: the arguments there after it, None if empty.
    """

    launched: frozenset[tuple[int, Named]]
    killed: frozenset[int]
    rejected: frozenset[Named]
    put: bool
    standing: Named | None


@dataclass(frozen=True, slots=True)
class Done:
    """A step: the state after it, its deeds by the name of the request in this version, whether it raises a violation.

    `broken`: whether a rule is broken after it, which raises nothing if no event came.
    """

    after: State
    deeds: dict[str, Deeds]
    violation: bool
    broken: bool


@dataclass(frozen=True)
class Noting(Reference):
    """The reference interpreter, recording the arguments of what it rejects: answers do not carry them."""

    rejected: list[tuple[str, Args]] = field(default_factory=list)

    def _update(self, step: Step, event: Event) -> Step:
        if isinstance(event, AbortWaiting):
            self._stood(step, event.request)
        return super()._update(step, event)

    def _ask(self, step: Step, name: str, args: Args, required: Launch | None = None) -> Step:
        after = super()._ask(step, name, args, required)
        for action in after.actions[len(step.actions) :]:
            if isinstance(action, Rejected) and action.request == name and action.rule != "superseded":
                self.rejected.append((name, args))
            elif isinstance(action, Rejected):
                self._stood(step, action.request)
        return after

    def _settle(self, step: Step) -> Step:
        after = super()._settle(step)
        for action in after.actions[len(step.actions) :]:
            if isinstance(action, Rejected):
                self._stood(step, action.request)
        return after

    def _stood(self, step: Step, name: str) -> None:
        place = step.state.places[name]
        if place is not None:
            self.rejected.append((name, place.args))


def done(reference: Reference, before: State, event: Event | None) -> Done:
    """Return the step by an event; None: no event, so that nothing is done."""
    if event is None:
        return Done(before, dict(_deeds(reference, before, (), ())), False, bool(reference.violations(before)))
    noting = Noting(reference.model)
    after, actions = noting.step(before.unrefused(), event)
    violation = any(isinstance(action, Violated) for action in actions)
    return Done(after, dict(_deeds(reference, after, actions, noting.rejected)), violation, violation)


def _deeds(
    reference: Reference, after: State, actions: tuple[Action, ...], rejected: Iterable[tuple[str, Args]]
) -> Iterator[tuple[str, Deeds]]:
    for request in reference.model.requests:
        name, place = request.name, after.places[request.name]
        mine = [action for action in actions if getattr(action, "request", None) == name]
        yield (
            name,
            Deeds(
                frozenset((each.slot, _named(request, each.args)) for each in mine if isinstance(each, Launched)),
                frozenset(each.slot for each in mine if isinstance(each, Killed)),
                frozenset(_named(request, args) for owner, args in rejected if owner == name),
                any(isinstance(each, Waits) for each in mine),
                None if place is None else _named(request, place.args),
            ),
        )


def _named(request: Request, args: Args) -> Named:
    return frozenset((p.name, value) for p, value in zip(request.params, args, strict=True))


def changes_of(versions: Versions, old: Done, new: Done) -> Iterator[AnswerChange]:
    """Yield the changes of answers between the steps `old` and `new`."""
    for before, request in versions.requests:
        mine, its = old.deeds[before.name], new.deeds[request.name]
        gained, lost = _only(its, mine), _only(mine, its)
        weaker = gained[1] and _weaker(mine, its)
        for deed, found in zip(DEED_KINDS, gained, strict=True):
            if found:
                yield AnswerChange(request.name, deed, weaker=weaker and deed == "launched")
        if not any(gained):
            missed = (deed for deed, found in zip(DEED_KINDS, lost, strict=True) if found)
            yield from (AnswerChange(request.name, deed, gone=True) for deed in missed)
    if (old.violation and not new.broken) or (new.violation and not old.broken):
        yield AnswerChange(None, "violation", gone=old.violation)


def _only(mine: Deeds, other: Deeds) -> tuple[bool, ...]:
    """Return for each of `DEED_KINDS`, in order, whether `mine` does something that `other` does not."""
    superseding = other.put and not mine.put and other.standing in mine.rejected
    return (
        superseding or bool(mine.rejected - other.rejected),
        bool(mine.launched - other.launched),
        (mine.put and not other.put) or (mine.standing is not None and mine.standing != other.standing),
        bool(mine.killed - other.killed),
    )


def _weaker(old: Deeds, new: Deeds) -> bool:
    """Return whether NEW launches what OLD rejects or leaves waiting."""
    refused = {*old.rejected, old.standing}
    return any(args in refused for _, args in new.launched - old.launched)
