"""Facts on the rules of a model that decisions use: which are in question, and which need diagrams of their own."""

from collections.abc import Iterator
from functools import cached_property
from typing import assert_never

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.evaluate import holds
from exover.model.expression import And, Compare, Cond, Count, Last, Level, Not, Or, Past, Status, Used, leaves
from exover.model.model import Model, Request, Rule
from exover.model.reads import in_question, rule_reads
from exover.model.semantics import Reference
from exover.model.state import State
from exover.model.waiting import may_clear_for
from exover.ocrd.conflicts import pair
from exover.ocrd.forms import Numbers
from exover.ocrd.vector import Vocabulary
from exover.ocrd.view import ParameterOwner


@dataclass(frozen=True, slots=True)
class SymbolicInstance:
    """A rule, or its copy for one slot of `rule.slot_of`, or for the slot of the newcomer (`newcomer`)."""

    rule: Rule
    slot: int | None = None
    newcomer: bool = False

    @property
    def reason(self) -> Reason:
        """The rule's name and text."""
        return Reason(self.rule.name, self.rule.because)

    @property
    def owner(self) -> ParameterOwner | None:
        """Whose parameters the rule reads: those of the slot or of the newcomer; None of a rule without copies."""
        return ParameterOwner(self.rule.slot_of, self.slot, of_copy=True) if self.rule.slot_of is not None else None


@dataclass(frozen=True)
class DecisionContext:
    """What all decisions of one model share."""

    vocabulary: Vocabulary

    @property
    def model(self) -> Model:
        """The model."""
        return self.vocabulary.model

    @cached_property
    def numbers(self) -> Numbers:
        """The numbers of the quantities and elements."""
        return Numbers(self.vocabulary)

    @cached_property
    def rules(self) -> dict[str, tuple[Rule, ...]]:
        """The rules in question by request."""
        return in_question(self.model)

    @cached_property
    def clearable(self) -> frozenset[str]:
        """The requests that may come to be clearing: all that have a `settle` guard or a kill of another slot."""
        return frozenset(request.name for request in self.model.requests if self._may_clear(request))

    def _may_clear(self, request: Request) -> bool:
        settles = any(guard.kind == "settle" for guard in request.guards)
        return settles or any(may_clear_for(request, rule) for rule in self.rules[request.name])

    def asking(self, rule: Rule) -> list[str]:
        """Return the requests for which a rule is in question."""
        return self._asking.get(id(rule), [])

    @cached_property
    def _asking(self) -> dict[int, list[str]]:
        found: dict[int, list[str]] = {}
        for name, rules in self.rules.items():
            for rule in rules:
                found.setdefault(id(rule), []).append(name)
        return found

    def instances(self, rule: Rule, newcomer: Request | None) -> Iterator[SymbolicInstance]:
        """Yield the rule, or, if it stands for each slot of a request, its copies: for the slots and for the newcomer.

        There is none for a slot that, if active, makes the newcomer busy.
        """
        if rule.slot_of is None:
            yield SymbolicInstance(rule)
            return
        own = newcomer is not None and newcomer.name == rule.slot_of
        request = self.model.request[rule.slot_of]
        if not own or request.instances > 1 or request.interrupts_self:
            for slot in range(request.instances):
                yield SymbolicInstance(rule, slot)
        if own:
            yield SymbolicInstance(rule, None, newcomer=True)

    def restored(self, rule: Rule) -> bool:
        """Return whether a rule may come to be broken and so has diagrams that restore it.

        It cannot if F is false in the initial state and is monotone in activity and shares and reads nothing else:
        then only a launch makes F true, and decisions prevent that.
        """
        if self.pairs[id(rule)]:
            return False
        if rule.slot_of is None and holds(self.model, self.start, rule.condition):
            return True
        kinds = {read.kind for read in rule_reads(rule)}
        return not (kinds <= {"active", "used"} and self.growing[id(rule)])

    def kept(self, rule: Rule) -> bool:
        """Return whether only decisions keep a rule: only a launch could break it, and it is in no bit row."""
        return not self.restored(rule) and self.pairs[id(rule)] is None

    @cached_property
    def pairs(self) -> dict[int, tuple[str, str] | None]:
        """For each rule, by its `id`, the result of `pair`."""
        return {id(rule): pair(rule) for rule in self.model.rules}

    @cached_property
    def growing(self) -> dict[int, bool]:
        """For each rule, by its `id`, whether F is monotone: more active slots never make it false."""
        pairs = self.pairs
        return {id(rule): bool(pairs[id(rule)]) or _only_grows(rule.condition, True) for rule in self.model.rules}

    @cached_property
    def start(self) -> State:
        """The initial state."""
        return Reference(self.model).start()


def _only_grows(cond: Cond, positive: bool) -> bool:
    """Return whether more active slots never make the condition (or, not `positive`, its negation) false."""
    match cond:
        case Not(part):
            return _only_grows(part, not positive)
        case And(parts) | Or(parts):
            return all(_only_grows(part, positive) for part in parts)
        case Status(phase, _, _):
            return positive and phase == "active"
        case Compare(op, left, right):
            counted = [isinstance(term, Used | Count | Level) for side in (left, right) for term in leaves(side)]
            if not any(counted):
                return True
            grows = op in ((">", ">=") if positive else ("<", "<="))
            return grows and isinstance(left, Used | Count) and not any(counted[1:])
        case Past() | Last():
            return False
        case _:
            assert_never(cond)
