"""The inductive invariant of a table: what every event and part of a pass keeps, and what only whole steps keep."""

from collections.abc import Iterable, Sequence
from math import inf
from time import process_time
from typing import Any

from exover.certificate.check import Checker, SolverGaveUp
from exover.certificate.step import TableStep, inputs
from exover.certificate.table import Refused
from exover.certificate.term import conj, neg, z3
from exover.dataclass import dataclass
from exover.proofs.operators import LATE


@dataclass(frozen=True, slots=True)
class Invariants:
    """Formulas that are together kept by every event and every part of a pass; those that whole steps keep besides."""

    parts: list[str]
    kept: list[str]


def houdini(checker: "Hurried", texts: Sequence[str]) -> list[str]:
    """Return those of the formulas that are together invariant: the largest such set (Flanagan, Leino 2001).

    Empty if the deadline of the checker passes first.
    """
    kept = {text: checker.formula(text) for text in dict.fromkeys(texts)}
    kept = {text: part for text, part in kept.items() if checker.true(part, checker.initial)}
    typed = checker.typed()
    while True:
        given = [*typed, *kept.values()]  # of a whole round: what is lost in it counts from the next one on
        for _, enabled, now in checker.operations():
            if process_time() > checker.deadline:
                return []
            while lost := _lost(checker, given, kept, enabled, now):
                kept = {text: part for text, part in kept.items() if text not in lost}
        if len(given) == len(typed) + len(kept):
            return list(kept)


def _lost(checker: Checker, given: list[Any], kept: dict[str, Any], enabled: Any, now: TableStep) -> set[str]:
    """Return formulas that an operation, where `given` is true, does not keep or may not; none iff it keeps all."""
    changed = checker.changed(now)
    touched = {text: part for text, part in kept.items() if checker.reads(part).keys() & changed}
    after = checker.at(conj(*touched.values()), now.state, changed)
    wrong = conj(enabled, neg(after))
    if wrong is False:
        return set()
    solver = checker.solver(given)
    solver.push()
    solver.add(wrong)
    answer, lost = solver.check(), set(touched)
    if answer == z3().sat:
        model, parts = solver.model(), after.children() if len(touched) > 1 else [after]
        truths = (model.eval(part, model_completion=True) for part in parts)
        lost = {text for text, truth in zip(touched, truths, strict=True) if z3().is_false(truth)}
    solver.pop()
    return set() if answer == z3().unsat else lost


class Hurried(Checker):
    """A checker that raises `SolverGaveUp` when asked after `deadline`, in seconds of the processor."""

    deadline: float = inf

    def suppose(self, parts: list[Any]) -> None:
        """Replace the formulas that are taken for invariant, and forget what was derived from the old ones."""
        self.parts = parts
        vars(self).pop("between", None)
        self._steps.clear()
        self._solver = [], None

    def satisfiable(self, what: str, given: list[Any], *parts: Any) -> bool:
        """Return whether some state satisfies what is given and all of the parts."""
        if process_time() > self.deadline:
            raise SolverGaveUp(LATE)
        return super().satisfiable(what, given, *parts)


def kept_by_steps(checker: Hurried, parts: list[Any], texts: Iterable[str]) -> list[str]:
    """Return those of the formulas that whole steps keep together, where `parts` are invariant: by Houdini again.

    Empty if the solver gives up, the deadline passes, or steps cannot be shown to end.
    """
    kept = {text: checker.formula(text) for text in dict.fromkeys(texts)}
    try:
        while kept:
            given = list(kept)
            checker.suppose([*parts, *kept.values()])
            for event in inputs(checker.table):
                for known, _, now, enabled in checker.steps(event):
                    while lost := _lost(checker, known, kept, enabled, now):
                        kept = {text: part for text, part in kept.items() if text not in lost}
            if given == list(kept):
                break
        return list(kept)
    except (SolverGaveUp, Refused):
        return []


def never(checker: Checker, text: str) -> bool:
    """Return whether the invariant implies that a formula is false after every step; False if the solver gives up."""
    try:
        return not checker.satisfiable("it is true of some moment", checker.between, checker.formula(text))
    except SolverGaveUp:
        return False
