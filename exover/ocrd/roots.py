"""All diagrams of a model, in one forest."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import field
from functools import partial

from exover.dataclass import dataclass
from exover.model.decision import Reason
from exover.model.expression import TRUE, Cond
from exover.model.model import Location, Model
from exover.ocrd.decision import DecisionList
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import ElementNumber, Manager, TooManyNodes
from exover.ocrd.forest import Forest
from exover.ocrd.order import SiftingWork, sift, support
from exover.ocrd.tables import ALWAYS
from exover.ocrd.vector import Vocabulary
from exover.raised import TablesTooLarge

MOST_NODES = 1_500_000
"""The most nodes that one diagram may have while it is made, and all together: they take less than 1.5 GiB."""


@dataclass
class Roots:
    """The forest of a model and the roots of its diagrams: of requests, rule copies, launch rules, latches, predicates.

    `invariants` are the roots of rule copies that only a launch could break; no event walks them.
    """

    questions: DecisionContext
    forest: Forest
    work: SiftingWork = field(default_factory=SiftingWork)
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
            with _counted(request, self.questions.model.request[request].location):
                self.predicates[request, where] = self.plant(lambda decider: decider.predicate(request, where))
        return self.predicates[request, where]

    def plant(self, build: Callable[[Decider], int]) -> int:
        """Build a diagram, sift it, add it to the forest and return its root."""
        source = Manager(most=MOST_NODES)
        return self._planted(source, build(Decider(self.questions, source)))

    def plant_decision(self, name: str) -> int:
        """Do so with the decision on a request."""
        return self._planted(*decided(self.questions, name))

    def _planted(self, manager: Manager, root: int) -> int:
        return self.forest.plant(*sift(manager, root, self.work))

    def of_events(self) -> list[int]:
        """Return the roots of the diagrams that events walk, in the order in which nodes are numbered."""
        rules = [root for root, _ in self.rules]
        return [*self.decide, *rules, *self.launches, *self.latches, *self.predicates.values()]

    def all(self) -> list[int]:
        """Return every root, in the order in which nodes are numbered."""
        return [*self.of_events(), *(root for root, _ in self.invariants)]


def grow(model: Model) -> Roots:
    """Return the diagrams of a model: of decisions, rules, launch rules and latches; predicates are added later.

    Raises `TablesTooLarge` if one of them, or all together, take more than MOST_NODES nodes.
    """
    questions = DecisionContext(Vocabulary(model))
    roots = Roots(questions, Forest(questions.numbers, MOST_NODES))
    for request in model.requests:
        with _counted(request.name, request.location):
            roots.decide.append(roots.plant_decision(request.name))
    for rule in model.rules:
        with _counted(rule.name, rule.location):
            if questions.restored(rule):
                for instance in questions.instances(rule, None):
                    root = roots.plant(partial(Decider.recover, instance=instance))
                    roots.rules.append((root, instance.reason))
            elif questions.kept(rule):
                for instance in questions.instances(rule, None):
                    root = roots.plant(partial(Decider.broken, instance=instance))
                    roots.invariants.append((root, instance.reason))
    for launch in model.launches:
        with _counted(launch.name, launch.location):
            roots.launches.append(roots.plant(partial(Decider.required, launch=launch)))
    for latch in model.latches:
        with _counted(latch.name, latch.location):
            roots.latches.append(roots.plant(partial(Decider.condition, cond=latch.condition)))
    return roots


@contextmanager
def _counted(name: str, place: Location) -> Iterator[None]:
    """Say what a diagram is of, and where that stands, if it has too many nodes, alone or with those before it."""
    try:
        yield
    except TooManyNodes as reason:
        told = f"the tables for `{name}` tell too many cases apart"
        why = f"{told} (more than {MOST_NODES} nodes{f', {reason}' if str(reason) else ''})"
        advice = "fewer instances, or fewer rules that read arguments, or what other rules kill"
        raise TablesTooLarge(f"{place}: {why}: give it {advice}") from None


def decided(questions: DecisionContext, name: str) -> tuple[Manager, int]:
    """Return the manager and the diagram of the decision on a request."""
    source = Manager(most=MOST_NODES)
    return composed(source, Decider(questions, source).decide(questions.model.request[name]))


def composed(source: Manager, decision: DecisionList) -> tuple[Manager, int]:
    """Return the manager and the diagram of a decision, under the variable order of `demanded`."""
    order = demanded(source, decision)
    if order == sorted(order, key=source.level):
        return source, decision.compose(source)
    target = Manager(order, MOST_NODES)
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
