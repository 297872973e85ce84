"""Sets of states of the loop as BDDs: variables as bits, tests of the tables as sets."""

import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, reduce
from operator import and_, or_

from exover.engines.bdd.effort import Meter
from exover.engines.bdd.few_bits import FewBits
from exover.engines.bdd.manager import BddManager, Set
from exover.loop.finite.builder import ClosedLoop
from exover.loop.finite.variable_order import arrange
from exover.loop.finite.variables import MEMORY, GuardedValue

REMEMBERED = 1 << 14
"""The initial size of CUDD's computed table, which grows on demand; dd's default takes 8 MB at once."""


def new_manager() -> BddManager:
    """Return CUDD's manager where dd has it (Linux on x86-64), else dd's own; dynamic reordering off."""
    room = {"initial_cache_size": REMEMBERED}
    with _missing("networkx"):  # dd needs it only to draw graphs; importing it takes 200 ms
        try:
            from dd.cudd import BDD
        except ImportError:
            from exover.engines.bdd.python_manager import PythonManager as BDD

            room = {}
    manager: BddManager = BDD(**room)
    manager.configure(reordering=False)
    if type(manager).__module__ != "dd.cudd":
        return manager
    return FewBits(manager, manager.true, manager.false, Meter(manager))


def restriction(manager: BddManager) -> Callable[[Set, Set], Set] | None:
    """Return the manager's operator `restrict(set, care)`; None if it has none."""
    if not isinstance(manager, FewBits):
        return None
    from dd.cudd import restrict

    return restrict  # type: ignore[no-any-return]


@contextmanager
def _missing(module: str) -> Iterator[None]:
    """Let an import of this module fail, as if it were not installed, unless it is imported already."""
    if module in sys.modules:
        yield
        return
    sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[module]


class Space:
    """The bits of a loop's variables, and the sets of states in which they have given values."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.loop = loop
        self.bdd = new_manager()
        self.none: Set = self.bdd.false
        self.all: Set = self.bdd.true
        self.bits = [
            [f"v{number}_{bit}" for bit in range((variable.size - 1).bit_length())]
            for number, variable in enumerate(loop.variables)
        ]
        for number in arrange(loop):
            self.bdd.declare(*self.bits[number])
        self._values: dict[tuple[int, int], Set] = {}
        self._literals = [
            [{name: bool(value >> bit & 1) for bit, name in enumerate(names)} for value in range(variable.size)]
            for names, variable in zip(self.bits, loop.variables, strict=True)
        ]
        self._large = 1000
        self._restrict = restriction(self.bdd)
        self._owner = {name: var for var, names in enumerate(self.bits) for name in names}
        self._tests: dict[tuple[int, int], Set] = {}
        self._sums: dict[int, dict[int, Set]] = {}
        self._totals: dict[tuple[tuple[int, GuardedValue], ...], dict[int, Set]] = {}

    def complement(self, states: Set) -> Set:
        """Return the states that are not among these."""
        return ~states

    def conjunction(self, parts: Iterable[Set]) -> Set:
        """Return the states that are in all parts."""
        return reduce(and_, parts, self.all)

    def disjunction(self, parts: Iterable[Set]) -> Set:
        """Return the states that are in some part."""
        return reduce(or_, parts, self.none)

    def sifted(self, states: Set) -> int:
        """Return the number of nodes of a set; if it is large, sift the order of the variables first (Rudell 1993).

        Large is more than 1000 nodes at first, and then twice what was left the last time.
        """
        if len(states) > self._large:
            self.bdd.reorder()
            self._large = 2 * max(len(states), self._large)
        return len(states)

    def simplified(self, states: Set, care: Set) -> Set:
        """Return a set, probably smaller, that equals `states` within `care` (restrict; Coudert, Madre 1990)."""
        return states if self._restrict is None or care == self.none else self._restrict(states, care)

    def on(self, states: Set, variables: Collection[int]) -> Set:
        """Return the projection of a set to these variables."""
        return self.bdd.exist(
            [name for var in self.support(states) - set(variables) for name in self.bits[var]], states
        )

    def literals(self, var: int, value: int) -> dict[str, bool]:
        """Return the bits of a variable that has this value."""
        return self._literals[var][value]

    def support(self, states: Set) -> set[int]:
        """Return the variables on which a set depends."""
        return {self._owner[name] for name in self.bdd.support(states) if name in self._owner}

    def passenger(self, name: str) -> str:
        """Declare a bit that no program reads or writes, so that steps leave it as it is; return its name."""
        self.bdd.declare(name)
        return name

    def owner(self, name: str) -> int:
        """Return the variable to which a bit belongs."""
        return self._owner[name]

    def is_value(self, var: int, value: int) -> Set:
        """Return the states in which a variable has this value."""
        key = (var, value)
        if key not in self._values:
            found = self.all  # not by `cube`, which looks at all bits there are
            for name, positive in self.literals(var, value).items():
                found &= self.bdd.var(name) if positive else ~self.bdd.var(name)
            self._values[key] = found
        return self._values[key]

    def among(self, var: int, values: Iterable[int]) -> Set:
        """Return the states in which a variable has one of these values."""
        return self.disjunction(self.is_value(var, value) for value in values)

    def assigned(self, states: Set, var: int, value: int) -> Set:
        """Return the states with the variable set to this value."""
        if not self.bits[var]:
            return states
        return self.bdd.exist(self.bits[var], states) & self.is_value(var, value)

    def before_cleared(self, states: Set, var: int) -> Set:
        """Return the states that are in `states` once the variable is set to 0."""
        return self.bdd.let(self.literals(var, 0), states) if self.bits[var] else states

    @cached_property
    def initial(self) -> Set:
        """The initial state."""
        return self.cube([variable.initial for variable in self.loop.variables])

    def cube(self, values: list[int]) -> Set:
        """Return the one state with these values."""
        return self._cube(enumerate(values))

    def cube_of(self, values: list[int]) -> Set:
        """Return the states with these values, `happened` variables left open."""
        kept = ((var, value) for var, value in enumerate(values) if self.loop.variables[var].key[0] != "happened")
        return self._cube(kept)

    def _cube(self, values: Iterable[tuple[int, int]]) -> Set:
        literals: dict[str, bool] = {}
        for var, value in values:
            literals |= self.literals(var, value)
        return self.bdd.cube(literals)

    @cached_property
    def constraints(self) -> list[Set]:
        """For each variable: the states in which it has one of its values, and 0 if its slot or place is empty."""
        return [self._constraint(number) for number in range(len(self.loop.variables))]

    def _constraint(self, number: int) -> Set:
        variable = self.loop.variables[number]
        found = self.among(number, range(variable.size))
        owner = {"class": "phase", "order": "phase", "cell": "place", "standing": "place"}.get(str(variable.key[0]))
        if owner:
            absent = self.is_value(self.loop.index[owner, variable.key[1]], 0)
            found &= ~absent | self.is_value(number, 0)
        return found

    @cached_property
    def domain(self) -> Set:
        """The states that satisfy all constraints, and in which variables that steps only remember are 0."""
        found = self.all
        for number in sorted(range(len(self.bits)), key=self.depth, reverse=True):  # bottom up, so that sets stay small
            found &= self.constraints[number]
            if self.loop.variables[number].key[0] in MEMORY:
                found &= self.is_value(number, 0)
        return found

    def depth(self, var: int) -> int:
        """Return the level of a variable's lowest bit in the order."""
        return max((self.bdd.level_of_var(name) for name in self.bits[var]), default=0)

    def local_domain(self, states: Set) -> Set:
        """Return the constraints on the variables on which a set depends."""
        return self.conjunction(self.constraints[var] for var in self.support(states))

    def at_most(self, entry: int, bound: int) -> Set:
        """Return the states in which `v[entry] <= bound`."""
        key = (entry, bound)
        if key not in self._tests:
            self._tests[key] = self._up_to(bound, self.distribution(entry))
        return self._tests[key]

    def _up_to(self, bound: int, sums: Mapping[int, Set]) -> Set:
        """Return the states in which a value is at most `bound`; `sums`: for each value those in which it is that."""
        return self.disjunction(states for value, states in sums.items() if value <= bound)

    def test(self, entry: int, bound: int, fixed: dict[int, int]) -> Set:
        """Return the states in which `v[entry] <= bound`, entries of `fixed` having these values."""
        if entry in fixed:
            return self.all if fixed[entry] <= bound else self.none
        parts = self.loop.bounds.sums.get(entry, ())
        known = [(part, factor) for part, factor in parts if part in fixed]
        if not known:
            return self.at_most(entry, bound)
        rest = [(f, term) for part, f in parts if part not in fixed for term in self.loop.terms.get(part, ())]
        shifted = bound - sum(factor * fixed[part] for part, factor in known)
        return self._up_to(shifted, self.sum_of(rest))

    def distribution(self, entry: int) -> dict[int, Set]:
        """Return for each value of an entry the states in which it has it."""
        if entry not in self._sums:
            self._sums[entry] = self.sum_of(self.loop.all_terms(entry))
        return self._sums[entry]

    def sum_of(self, terms: list[tuple[int, GuardedValue]]) -> dict[int, Set]:
        """Return for each value of `sum(factor * term)` the states in which it has it; many conditions read one sum."""
        asked = tuple(terms)
        if asked not in self._totals:
            self._totals[asked] = self._sum_of(terms)
        return self._totals[asked]

    def _sum_of(self, terms: list[tuple[int, GuardedValue]]) -> dict[int, Set]:
        sums = {0: self.all}
        for factor, term in terms:
            parts = [(factor * weight, self._guarded(guard)) for guard, weight in term]
            rest = self.all
            for _, states in parts:
                rest &= ~states
            grown: dict[int, Set] = {}
            for total, states in sums.items():
                for weight, where in [*parts, (0, rest)]:
                    both = self.bdd.apply("&", states, where)
                    if both != self.none:
                        grown[total + weight] = grown.get(total + weight, self.none) | both
            sums = grown
        return sums

    def _guarded(self, guard: Iterable[tuple[int, Iterable[int]]]) -> Set:
        return self.conjunction(self.among(var, values) for var, values in guard)
