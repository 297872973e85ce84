"""What a rule changes: whether some step of some run decides something that it would decide otherwise without it.

The loop runs with all its rules. At every moment of a step at which something is decided, what the rules decide is
compared with what they decide without those of one name, both read from the model as conditions of one manager and
told of the same frame. Where they differ the step passes a mark (`otherwise`), and so the question is one about a
step, on the same graph as all others. Reasons are left aside.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.aig.circuit.graph import FALSE, TRUE, Graph, Literal
from exover.engines.aig.circuit.words import Words, lit
from exover.engines.aig.encoding.encoder import Encoding
from exover.loop.exact.actions import Newcomer, TableActions
from exover.loop.exact.conditions import Conditions
from exover.loop.exact.layout import Layout
from exover.loop.exact.symbolic_state import SymbolicState
from exover.loop.exact.table_encoding import RequestArguments
from exover.loop.exact.term import Term
from exover.model.model import Model, Rule
from exover.model.property import Broken, Disjunction, Label
from exover.ocrd.compile import Compiled
from exover.ocrd.decision import DecisionEffect, DecisionList, DoDismiss, DoReject, DoSettle, DoWait
from exover.ocrd.decision_context import DecisionContext
from exover.ocrd.demand import Decider
from exover.ocrd.diagram import Manager, deep
from exover.ocrd.vector import Element, Vocabulary

EffectLiterals = dict[DecisionEffect, Literal]
"""By effect where a decision has it."""


def otherwise(rule: str) -> Label:
    """Return the mark of steps in which something is decided that is decided otherwise without the rules of a name."""
    return "without", rule


@dataclass(frozen=True)
class ContrastedDecision:
    """A decision as all rules make it, `mine`, and as it would be without the rules of a name, by that name, `others`.

    What is killed to restore rules is taken for a decision, too: one without demands.
    """

    manager: Manager
    mine: DecisionList
    others: dict[str, DecisionList]

    @property
    def roots(self) -> Iterator[int]:
        """The conditions that the decisions ask."""
        for decision in (self.mine, *self.others.values()):
            yield from (where for where, _ in decision.demands)
            yield from (where for where, _, _ in decision.hits)


@dataclass
class Contrasts:
    """Observes an encoding (`exover.loop.exact.actions.Observer`) and marks what would be decided otherwise."""

    compiled: Compiled
    _choices: dict[int, ContrastedDecision] = field(default_factory=dict)

    @cached_property
    def _questions(self) -> DecisionContext:
        return DecisionContext(Vocabulary(self._model))

    @property
    def _model(self) -> Model:
        return self.compiled.model

    @cached_property
    def _entries(self) -> dict[Element, int]:
        """By element its entry in the tables."""
        return {element: number for number, element in enumerate(self.compiled.entries)}

    # ---- what is compared ----

    def _choice(self, number: int) -> ContrastedDecision:
        """Return the decision on a request, and what it is without each of the rules in question."""
        if number not in self._choices:
            request = self._model.requests[number]
            rules = self._questions.rules[request.name]
            with deep():
                decider = Decider(self._questions, Manager())
                mine = decider.decide(request)
                others = {name: decider.decide(request.without_rules({name}), left) for name, left in _lacking(rules)}
            self._choices[number] = ContrastedDecision(decider.manager, mine, _different(mine, others))
        return self._choices[number]

    @cached_property
    def _restoring(self) -> ContrastedDecision:
        """What is killed to restore rules, and what is without each of them."""
        rules = tuple(rule for rule in self._model.rules if self._questions.restored(rule))
        with deep():
            decider = Decider(self._questions, Manager())
            mine = DecisionList({}, (), tuple(decider.restore(rules)))
            others = {name: DecisionList({}, (), tuple(decider.restore(left))) for name, left in _lacking(rules)}
        return ContrastedDecision(decider.manager, mine, _different(mine, others))

    # ---- moments ----

    def decides(self, actions: TableActions, frame: SymbolicState, guard: Term, newcomer: Newcomer) -> None:
        """Mark where the decision on a newcomer is another without some rules."""
        request, choice = self._model.requests[newcomer.request], self._choice(newcomer.request)
        moment = self._moment(actions, frame, choice, RequestArguments(newcomer.request, newcomer.args))
        mine, taken = moment.effects(choice.mine), moment.is_true(actions.layout.places[request.name].taken)
        for name, decision in choice.others.items():
            differs = moment.differ(mine, moment.effects(decision))
            if not newcomer.settling and request.without_rules({name}) is not request:
                differs = moment.graph.choose(taken, mine["reject",] ^ 1, differs)  # it would be rejected as busy
            frame.mark(actions.terms.both((guard, moment.bit(differs))), *otherwise(name))

    def restores(self, actions: TableActions, frame: SymbolicState) -> None:
        """Mark where other slots are killed without some rules."""
        choice = self._restoring
        moment = self._moment(actions, frame, choice, None)
        mine = moment.killed(choice.mine, TRUE)
        for name, decision in choice.others.items():
            differs = moment.differ(mine, moment.killed(decision, TRUE))
            frame.mark(moment.bit(differs), *otherwise(name))

    def _moment(
        self, actions: TableActions, frame: SymbolicState, choice: ContrastedDecision, looked: RequestArguments | None
    ) -> "DecisionEffects":
        conditions = Conditions(actions.vector, self._questions.numbers, self._entries, frame, looked)
        truths = conditions.truths(choice.manager, choice.roots)
        return DecisionEffects(actions.layout, frame, {number: lit(term) for number, term in truths.items()})


@dataclass(frozen=True)
class DecisionEffects:
    """The effects of decisions in one frame. `truths`: by number of a condition where it is true."""

    layout: Layout
    frame: SymbolicState
    truths: Mapping[int, Literal]

    @property
    def graph(self) -> Graph:
        """The graph of the literals."""
        assert isinstance(self.frame.terms, Words)
        return self.frame.terms.graph

    def bit(self, literal: Literal) -> Term:
        """Return a literal as a term."""
        assert isinstance(self.frame.terms, Words)
        return self.frame.terms.bit(literal)

    def is_true(self, flag: str) -> Literal:
        """Return where a variable of the frame is true."""
        return lit(self.frame[flag])

    def effects(self, decision: DecisionList) -> EffectLiterals:
        """Return by effect where a decision has it."""
        graph, truths = self.graph, self.truths
        demanded: dict[type, list[Literal]] = {}
        for where, do in decision.demands:
            demanded.setdefault(type(do), []).append(truths[where])
        found: EffectLiterals = {}
        left = TRUE
        for verdict, wheres in (
            ("reject", demanded.get(DoReject, [])),
            ("wait", demanded.get(DoWait, [])),
            ("clear", [truths[where] for where, _, _ in decision.hits]),
            ("settle", demanded.get(DoSettle, [])),
        ):
            where = graph.any(wheres)
            found[verdict,] = graph.conjunction(left, where)
            left = graph.conjunction(left, where ^ 1)
        found |= self.killed(decision, found["clear",])
        for number, do in decision.demands:
            if isinstance(do, DoDismiss):
                effect = ("dismiss", do.request)
                where = graph.conjunction(left, truths[number])
                found[effect] = graph.any((found.get(effect, FALSE), where))
        return found

    def killed(self, decision: DecisionList, guard: Literal) -> EffectLiterals:
        """Return by kill of a slot where a decision does it, as far as `guard` is true."""
        wheres: dict[DecisionEffect, list[Literal]] = {}
        for where, targets, _ in decision.hits:
            for name, at in targets:
                for slot in range(self.layout.model.request[name].instances) if at is None else [at]:
                    wheres.setdefault(("kill", name, slot), []).append(self.truths[where])
        return {effect: self.graph.conjunction(guard, self.graph.any(found)) for effect, found in wheres.items()}

    def differ(self, mine: EffectLiterals, other: EffectLiterals) -> Literal:
        """Return where one has an effect that the other has not."""
        graph, found = self.graph, []
        for effect in {**mine, **other}:
            differs = graph.differ(mine.get(effect, FALSE), other.get(effect, FALSE))
            if differs != FALSE:
                found.append(graph.conjunction(differs, self._met(effect)))
        return graph.any(found)

    def _met(self, effect: DecisionEffect) -> Literal:
        """Return where an effect changes anything: the slot to kill is running, the place to dismiss is taken."""
        match effect:
            case ("kill", str(name), int(number)):
                slot = self.layout.slots[name, number]
                return self.graph.conjunction(self.is_true(slot.active), self.is_true(slot.stopping) ^ 1)
            case ("dismiss", str(name)):
                return self.is_true(self.layout.places[name].taken)
            case _:
                return TRUE


def _lacking(rules: Sequence[Rule]) -> Iterator[tuple[str, tuple[Rule, ...]]]:
    """Yield the names of rules, each with the rules of other names."""
    for name in dict.fromkeys(rule.name for rule in rules):
        yield name, tuple(rule for rule in rules if rule.name != name)


def _different(mine: DecisionList, others: dict[str, DecisionList]) -> dict[str, DecisionList]:
    """Return those of the other decisions that ask or do something else than `mine`."""
    return {name: other for name, other in others.items() if _plain(other) != _plain(mine)}


def _plain(decision: DecisionList) -> tuple[object, ...]:
    """Return what a decision asks and does, without reasons."""
    demands = {(where, do.request if isinstance(do, DoDismiss) else type(do)) for where, do in decision.demands}
    return demands, {(where, target) for where, targets, _ in decision.hits for target in targets}


# ---- questions and answers ----


def changes(encoding: Encoding, rule: str) -> Literal:
    """Return where a step decides something that it would decide otherwise without the rules of a name.

    That a violation is not raised is another answer as well. The encoding is one whose observer is `Contrasts`.
    """
    rules = encoding.compiled.model.rules_named(rule)
    broken = encoding.moments.truth(Disjunction(tuple(Broken(each, once_stopped=True) for each in rules)))
    return encoding.graph.conjunction(
        encoding.legal, encoding.graph.any((encoding.moments.mark(otherwise(rule)), broken))
    )
