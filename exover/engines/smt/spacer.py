"""Moments that no run comes to, by the invariants that Spacer finds (Komuravelli, Gurfinkel, Chaki 2016)."""

from typing import Any

from exover.dataclass import dataclass
from exover.engines.smt.k_induction import ways
from exover.engines.smt.solver import Clock, Translation
from exover.engines.smt.system import System
from exover.loop.exact.term import Term, variables


@dataclass(frozen=True)
class Spacer:
    """Asks Spacer; the lemmas are true of every moment."""

    system: System
    clock: Clock
    lemmas: tuple[Term, ...]

    def excludes(self, bad: Term, least: int) -> bool:
        """Return whether an invariant is found that excludes `bad` after `least` steps or more."""
        import z3

        engine, place = self._horn()
        names = list(self.system.vars.values())
        plain = Translation()
        here = place(*(plain(var) for var in names))
        goal = z3.Function("goal", z3.BoolSort())
        engine.register_relation(goal)
        if least == 0:
            engine.rule(goal(), [here, plain(bad)])
        for way in ways(self.system, bad) if least else ():
            engine.rule(goal(), [here, plain(way)])
        engine.set("timeout", self.clock.left(max(1.0, self.clock.left() / 2000)))
        try:
            return bool(engine.query(goal()) == z3.unsat)
        except z3.Z3Exception:
            return False

    def _horn(self) -> tuple[Any, Any]:
        """Return the moves as rules for one relation: the moments that are reached."""
        import z3

        plain = Translation()
        names = list(self.system.vars.values())
        engine = z3.Fixedpoint()
        engine.set(engine="spacer", ctrl_c=False)
        place = z3.Function("reached", *(plain(var).sort() for var in names), z3.BoolSort())
        engine.register_relation(place)
        bound = {each.var for move in self.system.moves for each in move.inputs}
        bound |= variables(self.lemmas) - set(names)
        engine.declare_var(*(plain(var) for var in [*names, *sorted(bound, key=lambda var: var.name)]))
        engine.rule(place(*(plain(self.system.initial[var]) for var in names)))
        known = [plain(lemma) for lemma in self.lemmas]
        for move in self.system.moves:
            after = [plain(move.after.get(var.name, var)) for var in names]
            engine.rule(place(*after), [place(*(plain(var) for var in names)), plain(move.allowed), *known])
        return engine, place
