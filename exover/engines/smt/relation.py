"""The moves of a system, and all of them as one relation between two moments."""

from collections.abc import Mapping
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.steps import Input
from exover.loop.exact.events import Kind
from exover.loop.exact.term import Term, Terms, variables


@dataclass(frozen=True, slots=True)
class Move:
    """A kind of event as a step from one moment to the next: when it is allowed, and what it changes."""

    kind: Kind
    inputs: tuple[Input, ...]
    allowed: Term
    after: dict[str, Term]


@dataclass(frozen=True)
class Relation:
    """Moves as one transition relation between two moments: a choice of a move, and its effect on the variables.

    It consists of terms and is made once for all unrollings of a system.
    """

    terms: Terms
    vars: Mapping[str, Term]
    moves: tuple[Move, ...]

    @cached_property
    def bits(self) -> tuple[Term, ...]:
        """The variables whose values choose the move."""
        count = max(len(self.moves) - 1, 0).bit_length()
        return tuple(self.terms.var(f"choice {bit}", "Bool") for bit in range(count))

    def chosen(self, number: int) -> Term:
        """Return where the move of this number is chosen."""
        pairs = enumerate(self.bits)
        return self.terms.both(bit if number >> place & 1 else self.terms.negation(bit) for place, bit in pairs)

    @cached_property
    def after(self) -> dict[str, Term]:
        """Maps a variable to its value after the chosen move."""
        terms, found = self.terms, {}
        chosen = [self.chosen(number) for number in range(len(self.moves))]
        for name, var in self.vars.items():
            by_value: dict[Term, list[Term]] = {}
            for where, move in zip(chosen, self.moves, strict=True):
                value = move.after.get(name, var)
                if value is not var:
                    by_value.setdefault(value, []).append(where)
            result = var
            for value, choices in by_value.items():
                result = terms.choose(terms.either(choices), value, result)
            found[name] = result
        return found

    @cached_property
    def next(self) -> dict[str, Term]:
        """Maps a variable to its copy in the second moment."""
        return {name: self.terms.var(f"{name}'", var.sort) for name, var in self.vars.items()}

    @cached_property
    def step(self) -> Term:
        """The relation: the choice is a move, it is allowed, and the second moment is its effect on the first."""
        terms = self.terms
        allowed = terms.either(
            terms.both((self.chosen(number), move.allowed)) for number, move in enumerate(self.moves)
        )
        return terms.both([allowed, *(terms.equal(self.next[name], value) for name, value in self.after.items())])

    @cached_property
    def inputs(self) -> tuple[Term, ...]:
        """The variables of a step that belong to neither moment, by name: its choice and what comes with the event."""
        found = variables([self.step]) - {*self.vars.values(), *self.next.values()}
        return tuple(sorted(found, key=lambda var: var.name))
