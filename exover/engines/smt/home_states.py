"""Home states: every moment leads, by observations and reports alone, to one in which nothing is active.

docs/architecture.md has the proof. The solver checks its premises for every state between steps: each of these steps is
allowed and, but for launches of waiting requests, makes nothing wait or become active.
"""

from collections.abc import Iterator
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.relation import Move
from exover.engines.smt.solver import Prover
from exover.engines.smt.system import System
from exover.loop.exact.actions import tried
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.term import Term, variables
from exover.model.index import ModelIndex

ATTEMPTS = 8
"""The number of readings of the posters that are tried to disable the launch rules."""


@dataclass
class HomeStateProof:
    """Proves that home states can always be reached by steps after each of which `allowed` is true."""

    system: System
    prover: Prover
    allowed: Term

    def __post_init__(self) -> None:
        self.terms, self.layout = self.system.terms, self.system.layout

    @cached_property
    def home(self) -> Term:
        """The home states: nothing is active, and the posters have readings that disable the launch rules."""
        idle = [self.terms.negation(self.layout.vars[self.layout.slots[key].active]) for key in self._slots()]
        return self.terms.both((*idle, self.disabling))

    @cached_property
    def applies(self) -> bool:
        """Whether it is proved that home states can be reached from every moment."""
        return self.disabling is not self.terms.false and self._can_disable() and all(map(self._leaves, self._slots()))

    # ---- launch rules ----

    @cached_property
    def _due(self) -> Term:
        """The condition that some launch rule is due."""
        steps = self.system.steps
        found = []
        for number, launch in enumerate(steps.actions.tables.launches):
            frame = SymbolicState(self.terms, self.layout.vars | {tried(number): self.terms.false})
            found.append(steps.actions.vector.agrees(frame, launch.condition, None))
        return self.terms.either(found)

    @cached_property
    def _posters(self) -> list[Term]:
        posters = [self.layout.vars[poster.name] for _, poster in ModelIndex(self.layout.model).posters]
        read = variables([self._due])
        return [poster for poster in posters if poster in read]

    @cached_property
    def _readings(self) -> dict[Term, Term] | None:
        """Readings of the posters with which no launch rule is ever due; None if none were found."""
        rest = self.terms.negation(self._due)
        for _ in range(ATTEMPTS if self._posters else 1):
            model = self.prover.model((rest,), self.system.steps.lemmas)
            if model is None or model.model is None:
                break
            values = {var: self.terms.literal(model.value(var), var.sort) for var in self._posters}
            here = self.terms.both(self.terms.equal(var, value) for var, value in values.items())
            if not self.prover.satisfiable((here, self._due), self.system.steps.lemmas):
                return values
            rest = self.terms.both((rest, self.terms.negation(here)))
        return None

    @cached_property
    def disabling(self) -> Term:
        """The condition that the posters have these readings; false if none were found."""
        if self._readings is None:
            return self.terms.false
        return self.terms.both(self.terms.equal(var, value) for var, value in self._readings.items())

    def _can_disable(self) -> bool:
        """Return whether observations of these readings, one after the other, are always allowed.

        A move has no input if its poster is outside the cone of influence: then nothing depends on the reading.
        """
        values = self._readings or {}
        for move in self.system.moves:
            var = self.layout.vars.get(move.kind.name) if move.kind.verb == "observe" else None
            if var in values and not self.may(move, {each.var: values[var] for each in move.inputs}, self.terms.true):
                return False
        return True

    # ---- reports ----

    def _slots(self) -> list[tuple[str, int]]:
        """Return the slots in the cone of influence of the system."""
        return [key for key, slot in self.layout.slots.items() if slot.active in self.system.vars]

    def _reports(self, slot: tuple[str, int]) -> Iterator[tuple[Move, dict[Term, Term]]]:
        """Yield the reports of a slot, each with resting values as results."""
        for move in self.system.moves:
            if move.kind.reported == slot:
                yield move, {each.var: self.layout.resting(each.parameter.type) for each in move.inputs}

    def _leaves(self, slot: tuple[str, int]) -> bool:
        """Return whether, with `disabling` readings, some report of the slot is always allowed and `_shrinks`."""
        since = self.terms.both((self.layout.vars[self.layout.slots[slot].active], self.disabling))
        return any(
            self.may(move, inputs, since) and self._shrinks(move, inputs, since) for move, inputs in self._reports(slot)
        )

    def reported(self, slot: tuple[str, int]) -> bool:
        """Return whether some report of the slot is allowed whenever the slot is active."""
        active = self.layout.vars[self.layout.slots[slot].active]
        return any(self.may(move, inputs, active) for move, inputs in self._reports(slot))

    @cached_property
    def fair(self) -> bool:
        """Whether every run has a continuation with fair reports, since every active slot can be reported."""
        return all(map(self.reported, self._slots()))

    def may(self, move: Move, inputs: dict[Term, Term], since: Term) -> bool:
        """Return whether a move with these values is allowed from all moments of `since`."""
        after = self.terms.both((move.allowed, self.system.before(self.allowed, move)))
        bad = self.terms.negation(self.terms.replaced(after, inputs))
        return not self.prover.satisfiable((since, self.system.assumed, bad), self.system.lemmas)

    def _shrinks(self, move: Move, inputs: dict[Term, Term], since: Term) -> bool:
        """Return whether after the move nothing newly waits, and only requests that have left their places are newly
        active.
        """
        bad = []
        for name, place in self.layout.places.items():
            taken, then = self.layout.vars[place.taken], self._then(move, place.taken, inputs)
            bad.append(self.terms.both((then, self.terms.negation(taken))))
            left = self.terms.both((taken, self.terms.negation(then)))
            for number in range(self.layout.model.request[name].instances):
                active = self.layout.slots[name, number].active
                fresh = self.terms.both(
                    (self._then(move, active, inputs), self.terms.negation(self.layout.vars[active]))
                )
                bad.append(self.terms.both((fresh, self.terms.negation(left))))
        return not self.prover.satisfiable((since, self.terms.either(bad)), self.system.lemmas)

    def _then(self, move: Move, name: str, inputs: dict[Term, Term]) -> Term:
        return self.terms.replaced(move.after.get(name, self.layout.vars[name]), inputs)
