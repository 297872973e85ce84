"""All diagrams of a model, in one forest."""

from collections.abc import Callable
from dataclasses import field

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.expression import TRUE, Cond
from exover.model.model import Latch, Launch, Model
from exover.ocrd.decision import DecisionList
from exover.ocrd.decision_context import DecisionContext, SymbolicInstance
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import ElementNumber, Manager
from exover.ocrd.forest import Forest
from exover.ocrd.order import sift, support
from exover.ocrd.tables import ALWAYS
from exover.ocrd.vector import Vocabulary


@dataclass
class Roots:
    """The forest of a model and the roots of its diagrams: of requests, rule copies, launch rules, latches, predicates.

    `invariants` are the roots of rule copies that only a launch could break; no event walks them.
    """

    questions: DecisionContext
    forest: Forest
    decide: list[int] = field(default_factory=list)
    rules: list[tuple[int, Reason]] = field(default_factory=list)
    invariants: list[tuple[int, Reason]] = field(default_factory=list)
    launches: list[int] = field(default_factory=list)
    latches: list[int] = field(default_factory=list)
    predicates: dict[tuple[str, Cond], int] = field(default_factory=dict)
    """The roots by request and condition on its arguments; `predicate` adds them when they are first needed."""

    def predicate(self, request: str, where: Cond | None) -> int:
        """Return the root of the predicate "the loaded arguments satisfy `where`"."""
        if where is None or where == TRUE:
            return ALWAYS
        if (request, where) not in self.predicates:
            self.predicates[request, where] = _plant(
                self.forest, self.questions, lambda decider: decider.predicate(request, where)
            )
        return self.predicates[request, where]

    def of_events(self) -> list[int]:
        """Return the roots of the diagrams that events walk, in the order in which nodes are numbered."""
        rules = [root for root, _ in self.rules]
        return [*self.decide, *rules, *self.launches, *self.latches, *self.predicates.values()]

    def all(self) -> list[int]:
        """Return every root, in the order in which nodes are numbered."""
        return [*self.of_events(), *(root for root, _ in self.invariants)]


def grow(model: Model) -> Roots:
    """Return the diagrams of a model: of decisions, rules, launch rules and latches; predicates are added later."""
    questions = DecisionContext(Vocabulary(model))
    roots = Roots(questions, Forest(questions.numbers))
    roots.decide = [_plant_decision(roots.forest, questions, name) for name in model.request]
    for rule in model.rules:
        if questions.restored(rule):
            for instance in questions.instances(rule, None):
                roots.rules.append((_plant_rule(roots.forest, questions, instance), instance.reason))
        elif questions.kept(rule):
            for instance in questions.instances(rule, None):
                roots.invariants.append((_plant_invariant(roots.forest, questions, instance), instance.reason))
    for launch in model.launches:
        roots.launches.append(_plant_launch(roots.forest, questions, launch))
    for latch in model.latches:
        roots.latches.append(_plant_latch(roots.forest, questions, latch))
    return roots


def _plant_rule(forest: Forest, questions: DecisionContext, instance: SymbolicInstance) -> int:
    return _plant(forest, questions, lambda decider: decider.recover(instance))


def _plant_invariant(forest: Forest, questions: DecisionContext, instance: SymbolicInstance) -> int:
    return _plant(forest, questions, lambda decider: decider.broken(instance))


def _plant_launch(forest: Forest, questions: DecisionContext, launch: Launch) -> int:
    return _plant(forest, questions, lambda decider: decider.required(launch))


def _plant_latch(forest: Forest, questions: DecisionContext, latch: Latch) -> int:
    return _plant(forest, questions, lambda decider: decider.condition(latch.condition))


def _plant(forest: Forest, questions: DecisionContext, build: Callable[[Decider], int]) -> int:
    """Build a diagram, sift it, add it to the forest and return its root."""
    source = Manager()
    root = build(Decider(questions, source))
    return forest.plant(*sift(source, root))


def _plant_decision(forest: Forest, questions: DecisionContext, name: str) -> int:
    return forest.plant(*sift(*decided(questions, name)))


def decided(questions: DecisionContext, name: str) -> tuple[Manager, int]:
    """Return the manager and the diagram of the decision on a request."""
    source = Manager()
    return composed(source, Decider(questions, source).decide(questions.model.request[name]))


def composed(source: Manager, decision: DecisionList) -> tuple[Manager, int]:
    """Return the manager and the diagram of a decision, under the variable order of `demanded`."""
    order = demanded(source, decision)
    if order == sorted(order, key=source.level):
        return source, decision.compose(source)
    target = Manager(order)
    return target, decision.copy(source, target).compose(target)


def demanded(source: Manager, decision: DecisionList) -> list[ElementNumber]:
    """Return the entries of a decision in the order of its conditions, each choice just before the entries that it
    selects from.

    A choice is not put first of all: its value would have to be remembered below tests that do not depend on it.
    """
    tested = [support(source, [condition]) for condition in decision.conditions()]
    first: dict[ElementNumber, int] = {}
    for place, entries in enumerate(tested):
        for entry in entries:
            first.setdefault(entry, place)
    before: dict[int, list[ElementNumber]] = {}
    for choice, among in decision.choices.items():
        place = min((first[entry] for entry in among if entry in first), default=len(tested))
        if place < first.get(choice, 0):
            before.setdefault(place, []).append(choice)
    found: dict[ElementNumber, None] = {}
    for place, entries in enumerate(tested):
        found.update(dict.fromkeys((*before.get(place, ()), *entries)))
    return list(found)
