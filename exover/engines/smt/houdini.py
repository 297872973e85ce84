"""Houdini: inductive invariants of the states between steps, over one or two flags (Flanagan, Leino 2001).

Candidates say that a flag is never or always set, that two are never set together, or that one implies another. Random
runs refute most of them; of the others those are kept that every step preserves together.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations, permutations
from random import Random

from exover.dataclass import dataclass
from exover.engines.smt.solver import Prover, Valuation
from exover.engines.smt.steps import SymbolicSteps
from exover.loop.exact.events import Kind, event_of
from exover.loop.exact.term import Term
from exover.model.event import Event
from exover.model.semantics import Reference
from exover.model.types import Bool, Enum, Int, Real, Type, Value, resting_value
from exover.ocrd.vector import Vocabulary

RUNS, LENGTH = 12, 40
"""The number of random runs, and the steps of each."""
MOST = 120
"""The number of flags up to which pairs of them are candidates."""
FEW = 4
"""The greatest number of values of an integer for which each value is a flag."""


@dataclass
class Houdini:
    """Finds invariants of one closed loop."""

    steps: SymbolicSteps
    prover: Prover

    def __post_init__(self) -> None:
        self.layout, self.terms = self.steps.layout, self.steps.terms
        self.random = Random(0)

    def found(self) -> tuple[Term, ...]:
        """Return terms that are true of every state between steps; raises `Inconclusive`."""
        kept = self._candidates()
        preserved = False
        while kept and not preserved:
            preserved = True
            for step in self.steps.all:
                after = {self.layout.vars[name]: term for name, term in step.after.items()}
                memory: dict[Term, Term] = {}
                then = {each: self.terms.replaced(each, after, memory) for each in kept}
                changed = [each for each in kept if then[each] is not each]
                while changed:
                    broken = self.terms.negation(self.terms.both(then[each] for each in changed))
                    model = self.prover.model((step.enabled, broken, *kept), self.steps.lemmas)
                    if model is None:
                        break
                    lost = {each for each in changed if self._broken(model, then[each])}
                    kept = [each for each in kept if each not in lost]
                    changed = [each for each in changed if each not in lost]
                    preserved = False
        return tuple(kept)

    def _broken(self, model: Valuation, term: Term) -> bool:
        """Return whether a term is false in a model; True if the solver gave up without a model."""
        return model.model is None or not model.value(term)

    # ---- candidates ----

    def _candidates(self) -> list[Term]:
        """Return the candidates that no random run refutes."""
        states = self._visited()
        everywhere = (1 << len(states)) - 1
        seen: dict[Term, int] = {}
        for flag in self._flags():
            truths = (self.terms.replaced(flag, state) is self.terms.true for state in states)
            seen[flag] = sum(truth << number for number, truth in enumerate(truths))
        never = [self.terms.negation(flag) for flag, where in seen.items() if not where]
        always = [flag for flag, where in seen.items() if where == everywhere]
        some = {flag: where for flag, where in seen.items() if where not in (0, everywhere)}
        if len(some) > MOST:
            return never + always
        pairs = (pair for pair in combinations(some, 2) if not some[pair[0]] & some[pair[1]])
        apart = [self.terms.negation(self.terms.both(pair)) for pair in pairs]
        within = [self.terms.implies(*pair) for pair in permutations(some, 2) if not some[pair[0]] & ~some[pair[1]]]
        return list(dict.fromkeys(never + always + apart + within))

    def _flags(self) -> Iterator[Term]:
        for name, var in self.layout.vars.items():
            if name in self.layout.held:
                continue
            match self.layout.types[name]:
                case Bool():
                    yield var
                case Enum(values):
                    yield from (self.terms.equal(var, self.terms.constant(n, "Int")) for n in range(len(values)))
                case Int(low, high) if high - low < FEW:
                    yield from (self.terms.equal(var, self.terms.constant(n, "Int")) for n in range(low, high + 1))
                case _:
                    pass

    # ---- runs ----

    def _visited(self) -> list[dict[Term, Term]]:
        """Return states of random runs, the initial one first."""
        reference = Reference(self.steps.model)
        found = [reference.start()]
        for _ in range(RUNS):
            state = reference.start()
            for _ in range(LENGTH):
                event = self._event()
                if reference.validate(state, event) is None:
                    state, _ = reference.step(state, event)
                    found.append(state)
        return [{self.layout.vars[name]: v for name, v in self.layout.of_state(state).items()} for state in found]

    def _event(self) -> Event:
        kind: Kind = self.random.choice(self.steps.kinds)
        inputs = self.steps.inputs(kind)
        return event_of(kind, tuple(self._value(each.parameter.type) for each in inputs))

    def _value(self, kind: Type) -> Value:
        match kind:
            case Bool():
                return self.random.random() < 0.5
            case Enum(values):
                return self.random.choice(values)
            case Int(low, high):
                return self.random.choice((low, high, self.random.randint(low, high)))
            case Real(low, high):
                cuts = [cut for cuts in self._thresholds for cut in cuts if low <= cut <= high]
                ends = (end for end in (low, high) if abs(end) < 1e308)
                return self.random.choice((resting_value(kind), *cuts, *ends))

    @cached_property
    def _thresholds(self) -> list[tuple[float, ...]]:
        return list(Vocabulary(self.steps.model).thresholds.values())
