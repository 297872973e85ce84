"""Symbolic states: each variable at a point of a step, as a term over the state before the step and its inputs."""

from collections.abc import Iterable, Mapping
from dataclasses import field
from itertools import compress
from operator import is_not

from exover.dataclass import dataclass
from exover.loop.exact.term import Term, Terms
from exover.model.property import Label, Occurrence


@dataclass(frozen=True, slots=True)
class Note:
    """An occurrence (a launch, a kill, …) of a request with these arguments, in steps in which `guard` holds."""

    occurrence: Occurrence
    request: str
    guard: Term
    args: tuple[Term, ...]


@dataclass
class SymbolicState:
    """The values of the variables, and the marks and notes of the step so far."""

    terms: Terms
    values: dict[str, Term]
    marks: dict[Label, Term] = field(default_factory=dict)
    """Maps a mark to the condition under which it was passed."""
    notes: list[Note] = field(default_factory=list)

    def copy(self) -> "SymbolicState":
        """Return a copy, to be changed independently."""
        return SymbolicState(self.terms, dict(self.values), dict(self.marks), list(self.notes))

    def __getitem__(self, name: str) -> Term:
        """Return the current value of a variable."""
        return self.values[name]

    def all(self, names: Iterable[str]) -> tuple[Term, ...]:
        """Return the current values of variables."""
        return tuple(self.values[name] for name in names)

    def put(self, guard: Term, name: str, value: Term) -> None:
        """Give a variable a value where `guard` holds."""
        self.values[name] = self.terms.choose(guard, value, self.values[name])

    def put_all(self, guard: Term, names: Iterable[str], values: Iterable[Term]) -> None:
        """Give each variable its value where `guard` holds."""
        for name, value in zip(names, values, strict=True):
            self.put(guard, name, value)

    def mark(self, guard: Term, *label: str) -> None:
        """Pass a mark where `guard` holds."""
        if guard is not self.terms.false:
            self.marks[label] = self.terms.either((self.marks.get(label, self.terms.false), guard))

    def note(self, guard: Term, occurrence: Occurrence, request: str, args: tuple[Term, ...]) -> None:
        """Add a note with this guard, unless it is false."""
        if guard is not self.terms.false:
            self.notes.append(Note(occurrence, request, guard, args))

    def written(self, before: Mapping[str, Term]) -> list[str]:
        """Return the variables whose terms are not those of `before`: values at an earlier point, in this order."""
        return list(compress(self.values, map(is_not, self.values.values(), before.values())))

    def changed(self, before: "SymbolicState") -> dict[str, Term]:
        """Return the variables that may differ from `before`, each with the condition under which it does."""
        found = {}
        for name in self.written(before.values):
            differs = self.terms.negation(self.terms.equal(self.values[name], before.values[name]))
            if differs is not self.terms.false:
                found[name] = differs
        return found
