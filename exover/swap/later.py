"""Where a rule of NEW may come to be broken in a later step, from whatever state a swap has led to.

What `exover check` proves of NEW it proves of the states that NEW reaches itself. A swap may lead elsewhere, for
example to two active requests of which the guards of NEW let each start only without the other.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from itertools import product

from exover.checks.questions.safety import STRICT
from exover.dataclass import dataclass
from exover.engines.bdd.analysis import Analysis
from exover.engines.bdd.backward_reachability import BackwardReachability, TooWide
from exover.engines.bdd.manager import Set
from exover.engines.bdd.steps import WIDE
from exover.loop.finite.tested_bounds import TooLarge
from exover.model.expression import (
    FALSE,
    TRUE,
    And,
    AtomicCond,
    Compare,
    Cond,
    Const,
    Not,
    Or,
    Reading,
    Status,
    operands,
    with_atoms,
)
from exover.model.model import Kill, KillSlot, Rule, SetState
from exover.model.semantics import Reference
from exover.model.types import Bool, Enum
from exover.ocrd.compile import Compiled
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.vector import Vocabulary
from exover.swap.folding import folded
from exover.swap.latching import Latching

MOST_BITS = 64
"""Bits of a state above which nothing is looked for: it would take minutes."""
MOST_CASES = 1 << 12
"""Cases of activity and readings that are told apart."""
Case = tuple[Set, Cond]


@dataclass(frozen=True)
class BrokenLater:
    """The states just before the swap from which steps of NEW may lead to one in which a rule is broken."""

    new: Compiled

    @cached_property
    def questions(self) -> DecisionContext:
        """The context in which the rules' decisions are built."""
        return DecisionContext(Vocabulary(self.new.model))

    @cached_property
    def _analysis(self) -> Analysis:
        return Analysis(self.new, Reference(self.new.model), lambda _: None)

    @cached_property
    def _found(self) -> dict[int, Cond | None]:
        return {}

    def of(self, rule: Rule) -> Cond | None:
        """Return a condition that holds in all of these states, perhaps in more; None if none was found."""
        if id(rule) not in self._found:
            self._found[id(rule)] = self._of(rule)
        return self._found[id(rule)]

    def _of(self, rule: Rule) -> Cond | None:
        if not self.questions.restored(rule) or _is_killed(rule) or self._is_launched(rule):
            return FALSE
        try:
            if (self._analysis.state_bits or 0) > MOST_BITS:
                return None
            return self._reaching(self._analysis.meaning.rule(rule, once_stopped=rule.kind not in STRICT))
        except (TooLarge, TooWide):
            return None

    def _is_launched(self, rule: Rule) -> bool:
        """Return whether only a launch could break a rule: it grows with activity, and else reads states of modules
        that no report sets to what breaks it.
        """
        model, names = self.new.model, {term.name for term in operands(rule.condition) if isinstance(term, Reading)}
        states = {variable.name for variable in model.variables if variable.kind == "state"}
        ends = (effect for r in model.requests for effect in (*r.on_ok, *r.on_failed, *r.on_interrupted))
        sets = [effect for effect in ends if isinstance(effect, SetState) and effect.state in names]
        grows = self.questions.growing[id(rule)] and rule.slot_of is None and names <= states
        return grows and all(folded(_with(rule.condition, each)) == FALSE for each in sets)

    def _reaching(self, broken: Set) -> Cond | None:
        analysis = self._analysis
        if analysis.excluded(broken):
            return FALSE
        backwards = BackwardReachability(analysis.stepper, analysis.stepper.universe, WIDE)
        found = backwards.possible(broken & backwards.within, lambda _: True, lambda _: False)
        return self._described(found & ~broken, backwards.within & ~broken)

    # ---- a set of states as a condition ----

    def _described(self, states: Set, among: Set) -> Cond | None:
        """Return a condition on activity and readings before the swap that holds wherever it may lead to the states."""
        plain = self._analysis.space.simplified(states, among)
        choices, cases = [*self._activity(plain), *self._readings(plain)], 1
        for choice in choices:
            cases *= len(choice)
        if cases > MOST_CASES:
            return None
        found = []
        for case in product(*choices):
            within = self._analysis.space.conjunction([states, *(each for each, _ in case)])
            if within != self._analysis.space.none:
                found.append(And(tuple(cond for _, cond in case)))
        return folded(Or(tuple(found)))

    def _activity(self, states: Set) -> Iterator[tuple[Case, ...]]:
        """Yield for each request that matters that it is active, and that it is not.

        What the swap has launched was waiting, or is required by a launch rule.
        """
        space = self._analysis.space
        support, required = space.support(states), {launch.request for launch in self.new.model.launches}
        for request in self.new.model.requests:
            active = Status("active", request.name)
            known = self._analysis.meaning.truth(active)
            if space.support(known) & support:
                started = TRUE if request.name in required else Or((active, Status("waiting", request.name)))
                yield (known, started), (~known, Not(active))

    def _readings(self, states: Set) -> Iterator[tuple[Case, ...]]:
        """Yield for each bool and enum that matters its values that are told apart; not for what a launch may set."""
        loop, space = self._analysis.loop, self._analysis.space
        latching, index = Latching(self.new.model), {name: number for number, name in enumerate(loop.names)}
        for name, values in self._values():
            var = loop.index.get(("reading", index[name]))
            if var in space.support(states):
                cells = [loop.reading_cell(index[name], ordinal) for ordinal in range(len(values))]
                yield tuple(
                    (space.is_value(var, cell), latching.latched(_one_of(name, values, cells, cell)))
                    for cell in dict.fromkeys(cells)
                )

    def _values(self) -> Iterator[tuple[str, tuple[bool | str, ...]]]:
        model = self.new.model
        effects = [effect for request in model.requests for effect in request.on_launch]
        changing = {effect.state for effect in effects if isinstance(effect, SetState)}
        for variable in model.variables:
            if variable.name not in changing and isinstance(variable.type, Bool | Enum):
                yield variable.name, variable.type.values if isinstance(variable.type, Enum) else (False, True)
        yield from ((latch.name, (False, True)) for latch in model.latches)


def _one_of(name: str, values: Sequence[bool | str], cells: Sequence[int], cell: int) -> Cond:
    """Return that a reading has one of the values of this cell."""
    wanted = (value for value, its in zip(values, cells, strict=True) if its == cell)
    return Or(tuple(Compare("==", Reading(name), Const(value)) for value in wanted))


def _is_killed(rule: Rule) -> bool:
    """Return whether a kill remedy of a rule restores it wherever it is broken, as the form of its condition shows."""
    return any(
        isinstance(remedy, KillSlot)
        or (isinstance(remedy, Kill) and folded(_without(rule.condition, remedy.requests)) == FALSE)
        for remedy in rule.remedies
    )


def _with(cond: Cond, effect: SetState) -> Cond:
    """Return a condition with a state taken as what an effect sets it to, in comparisons with constants."""

    def known(atom: AtomicCond) -> Cond:
        match atom:
            case Compare(operator, Reading(effect.state), right):
                return Compare(operator, Const(effect.value), right)
            case Compare(operator, left, Reading(effect.state)):
                return Compare(operator, left, Const(effect.value))
            case _:
                return atom

    return with_atoms(cond, known)


def _without(cond: Cond, requests: Collection[str]) -> Cond:
    """Return a condition with these requests taken as idle, in what it says of activity outside of sums."""
    return with_atoms(cond, lambda each: FALSE if isinstance(each, Status) and each.request in requests else each)
