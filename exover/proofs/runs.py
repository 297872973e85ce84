"""Runs as the checker of certificates reads them: requests, slots and reasons are numbers."""

from fractions import Fraction
from functools import cached_property
from typing import Any, assert_never

from exover.certificate.step import ABORTED, SUPERSEDED, UNSAID
from exover.certificate.table import NONE
from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.event import (
    Abort,
    AbortWaiting,
    Action,
    Ask,
    Event,
    Invalid,
    Killed,
    Launched,
    Observe,
    Rejected,
    Report,
    Violated,
    Waits,
)
from exover.model.semantics import Reference
from exover.model.trace import Trace
from exover.model.types import Real, Type, Value, ordinal
from exover.ocrd.reasons import reasons
from exover.ocrd.vector import OUTCOMES
from exover.proofs.statement import Statement


@dataclass(frozen=True)
class RunWriter:
    """Writes runs of one model."""

    statement: Statement

    @cached_property
    def _reason(self) -> dict[Reason, int]:
        return {reason: number for number, reason in enumerate(reasons(self.statement.model))}

    def steps(self, trace: Trace) -> list[dict[str, Any]]:
        """Return the steps of a run, each an event with its answers; `invalid` is left out, for only readings count.

        A step has all its refusals of required launches, repeated or not: the checker does not remember refusals.
        """
        reference, steps = Reference(self.statement.model), []
        state = reference.start()
        for event in trace.events:
            state, actions = reference.step(state.unrefused(), event)
            answers = [self._answer(action) for action in actions if not isinstance(action, Invalid)]
            steps.append({"event": self.event(event), "answers": answers})
        return steps

    def event(self, event: Event) -> list[Any]:
        """Return an event as [kind, number of its subject, outcome of a report or 0, values]."""
        model, first = self.statement.model, self.statement.first_slot
        match event:
            case Ask(name, args):
                kinds = [parameter.type for parameter in model.request[name].params]
                return ["ask", self.statement.request[name], 0, values(kinds, args)]
            case Report(name, slot, outcome, results):
                kinds = [parameter.type for parameter in model.request[name].results] if outcome == "ok" else []
                return ["report", first[name] + slot, OUTCOMES.index(outcome), values(kinds, results)]
            case Observe(name, value):
                if name in self.statement.levels:
                    return ["level", [*self.statement.levels].index(name), 0, [value]]
                kind = model.variable[name].type
                return ["observe", [*self.statement.readings].index(name), 0, values([kind], (value,))]
            case Abort(name, slot):
                return ["abort", first[name] + slot, 0, []]
            case AbortWaiting(name):
                return ["give up", self.statement.request[name], 0, []]
            case _:
                assert_never(event)

    def _answer(self, action: Action) -> list[Any]:
        request = self.statement.request
        match action:
            case Launched(name, slot, _, rule, because):
                return ["launch", request[name], slot, UNSAID if rule is None else self._reason[Reason(rule, because)]]
            case Waits(name, rule, because):
                return ["wait", request[name], NONE, self._reason[Reason(rule, because)]]
            case Rejected(name, rule, because):
                own = {"superseded": SUPERSEDED, "aborted": ABORTED}
                return ["reject", request[name], NONE, own.get(rule) or self._reason[Reason(rule, because)]]
            case Killed(name, slot, rule, because):
                return [
                    "kill",
                    request[name],
                    slot,
                    ABORTED if rule == "abort" else self._reason[Reason(rule, because)],
                ]
            case Violated(rule, because):
                return ["violation", NONE, NONE, self._reason[Reason(rule, because)]]
            case _:
                raise TypeError(action)


def values(kinds: list[Type], given: tuple[Value, ...]) -> list[Any]:
    """Return values as JSON has them: a real as the text of a fraction, everything else as its number."""
    pairs = zip(kinds, given, strict=True)
    return [str(Fraction(v)) if isinstance(kind, Real) else ordinal(kind, v) for kind, v in pairs]
