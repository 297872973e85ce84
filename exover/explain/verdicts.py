"""The verdict of each rule, guard and resource in a decision, in a recovery, and on a rule that is not restored."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from exover.dataclass import dataclass
from exover.explain.facts import Facts
from exover.explain.recorder import Decided, Recovered
from exover.model.decision import Instance, NewcomerStates, verdict_without_kill
from exover.model.evaluate import NOTHING, Scope, bind, holds
from exover.model.explanation import Attempt, Demand, Fact, RuleVerdict
from exover.model.model import Guard, Launch, Location, Reject, Rule, Wait
from exover.model.semantics import Reference
from exover.model.state import SlotId, State
from exover.model.wording import remedy_text, slot_text

NOW = "as things are"
STOPPED = f"{NOW}, the stopping slots taken as idle"


@dataclass(frozen=True)
class RuleVerdicts:
    """Computes the verdicts of a model; `written`: the text of each item in the spec, by its location."""

    reference: Reference
    written: Mapping[Location, str]

    # ---- decisions ----

    def of_decision(self, decided: Decided) -> tuple[RuleVerdict, ...]:
        """Return the verdict of every guard, resource and rule in question on a newcomer, in the order of the text.

        Empty if the request is busy, so that nothing is decided.
        """
        newcomer = self.reference.newcomer(decided.state, decided.request, decided.args, every=True)
        if newcomer is None:
            return ()
        found = [(guard.place, self._of_guard(guard, decided, newcomer)) for guard in decided.request.guards]
        found += self._of_consumptions(decided, newcomer)
        found += [
            (instance.rule.place, self._of_rule(index, newcomer)) for index, instance in enumerate(newcomer.questions)
        ]
        return tuple(verdict for _, verdict in sorted(found, key=lambda item: item[0]))

    def _of_guard(self, guard: Guard, decided: Decided, newcomer: NewcomerStates) -> RuleVerdict:
        scope = Scope(bind(decided.request.params, decided.args))
        present = newcomer.state.idle(newcomer.cleared)
        true = holds(self.reference.model, present, guard.condition, scope)
        facts = Facts(self.reference.model, present).of(guard.condition, scope)
        moment = _without(NOW, newcomer.cleared)
        demand: Demand = "nothing" if true else guard.objection
        return self._verdict(guard, demand, moment, facts)

    def _of_consumptions(self, decided: Decided, newcomer: NewcomerStates) -> list[tuple[int, RuleVerdict]]:
        """Return a verdict for each resource that the newcomer consumes, placed at its first clause that applies."""
        model, state, request = self.reference.model, newcomer.state, decided.request
        scope = Scope(bind(request.params, decided.args))
        found = []
        for name, clauses in self.reference.consumed(state, request, scope).items():
            resource, level = model.resource[name], state.levels[name]
            needed = sum(clause.amount for clause in clauses)
            fact = Fact(f"level({name}) >= {needed}", level >= needed, f"level({name}) = {level}")
            demand: Demand = verdict_without_kill(resource.remedies) if level < needed else "nothing"
            because = model.text(clauses[0])
            text = self.written.get(clauses[0].location)
            verdict = RuleVerdict(name, because, text, clauses[0].location, demand, NOW, (fact,))
            found.append((clauses[0].place, verdict))
        return found

    def _of_rule(self, index: int, newcomer: NewcomerStates) -> RuleVerdict:
        """Return the verdict of the rule in question at `index`: that in the end, or `clear` if it cleared slots."""
        reference, instance = self.reference, newcomer.questions[index]
        so_far, with_it = (self._cleared(newcomer, count) for count in (index, index + 1))
        early, final = newcomer.launched.idle(so_far), newcomer.launched.idle(newcomer.cleared)
        demand = self._demand(final, newcomer.slot, instance)
        scene = ImaginedScene({newcomer.slot: "the newcomer"}, f"with {self._named(newcomer.slot)} running")
        attempts = self._attempts(early, instance, newcomer.slot)
        if reference.true_either_way(final, instance):
            return self._rule_verdict(final, instance, demand, scene.without(newcomer.cleared), attempts)
        if demand in ("nothing", "dismiss") and len(with_it) > len(so_far):
            return self._rule_verdict(early, instance, "clear", scene.without(so_far), attempts)
        if demand == "nothing":
            return self._rule_verdict(final, instance, demand, scene.without(newcomer.cleared))
        running = reference.with_clearing(final, newcomer.slot[0])
        imagined = {(name, len(slots)): f"what is clearing at {name}" for name, slots in final.slots.items()}
        scene = ImaginedScene({**imagined, **scene.imagined}, f"{scene.moment}, and what is clearing running too")
        return self._rule_verdict(running, instance, demand, scene.without(newcomer.cleared))

    def _cleared(self, newcomer: NewcomerStates, count: int) -> tuple[SlotId, ...]:
        """Return C after the first `count` rules in question; empty if C is empty in the end."""
        if not newcomer.cleared:
            return ()
        return tuple(self.reference.clear(newcomer.launched, newcomer.slot, newcomer.questions[:count]))

    def _demand(self, final: State, newcomer: SlotId, instance: Instance) -> Demand:
        match self.reference.rule_demands(final, newcomer, instance):
            case []:
                return "nothing"
            case ["wait"]:
                return "wait"
            case ["reject"]:
                return "reject"
            case _:
                return "dismiss"

    def _attempts(self, state: State, instance: Instance, newcomer: SlotId | None) -> tuple[Attempt, ...]:
        """Return the remedies of a rule up to the one that is chosen; empty if the rule is not broken.

        Without a newcomer, in a recovery, only a kill can be chosen.
        """
        if not self.reference.true_either_way(state, instance):
            return ()
        found: list[Attempt] = []
        for remedy in instance.rule.remedies:
            text = remedy_text(remedy)
            if isinstance(remedy, Reject | Wait) and newcomer is None:
                found.append(Attempt(text, False, "it answers a newcomer, and ends nothing that is active"))
                continue
            if isinstance(remedy, Reject | Wait):
                return (*found, Attempt(text, True, "it always applies"))
            others = [slot for slot in self.reference.targets(state, remedy, instance) if slot != newcomer]
            after = state.idle(others)
            still = (
                self.reference.true_either_way(after, instance) if newcomer else self.reference.true(after, instance)
            )
            if not others:
                found.append(Attempt(text, False, "nothing that it could end is active"))
            elif still:
                found.append(Attempt(text, False, f"the rule would be broken without {self._listed(others)}, too"))
            else:
                return (*found, Attempt(text, True, f"it ends {self._listed(others)}"))
        if newcomer is not None:
            found.append(Attempt("reject", True, "no remedy of the rule applies"))
        return tuple(found)

    def _listed(self, slots: Iterable[SlotId]) -> str:
        return ", ".join(self._named(slot) for slot in slots)

    def _named(self, slot: SlotId) -> str:
        """Return a slot in words; an index past the last slot is that of the newcomer."""
        name, index = slot
        inside = index < self.reference.model.request[name].instances
        return slot_text(self.reference.model, name, index) if inside else f"one more {name}"

    # ---- recovering and violations ----

    def of_recovery(self, recovered: Recovered) -> tuple[RuleVerdict, ...]:
        """Return the verdict of the rule for which slots were killed; at most one."""
        return self._broken(recovered.state, recovered.reason.rule, "kill", recovered.slots)[:1]

    def of_violation(self, state: State, rule: str) -> tuple[RuleVerdict, ...]:
        """Return the verdicts of the rules of this name on a state in which they could not be restored."""
        return self._broken(state, rule, "violation", None)

    def _broken(
        self, state: State, name: str, demand: Demand, slots: tuple[SlotId, ...] | None
    ) -> tuple[RuleVerdict, ...]:
        """Return the verdicts of the rules of this name that a state breaks; with `slots`, of those that kill these."""
        found: list[RuleVerdict] = []
        stopped = state.once_stopped()
        for rule in self.reference.model.rules:
            for instance in self.reference.instances(stopped, rule) if rule.name == name else ():
                if not self.reference.true(stopped, instance):
                    continue
                killed = [self.reference.targets(state, kill, instance) for kill in rule.kills]
                if slots is None or list(slots) in killed:
                    scene = ImaginedScene({}, STOPPED)
                    found.append(
                        self._rule_verdict(stopped, instance, demand, scene, self._attempts(stopped, instance, None))
                    )
        return tuple(found)

    def of_rules(self, state: State, names: Iterable[str]) -> tuple[RuleVerdict, ...]:
        """Return the verdicts of the rules of these names on a state in which none of them is broken."""
        wanted, now, later = frozenset(names), ImaginedScene({}, NOW), ImaginedScene({}, STOPPED)
        return tuple(
            self._rule_verdict(state.once_stopped(), instance, "nothing", later)
            if self.reference.true(state, instance)
            else self._rule_verdict(state, instance, "nothing", now)
            for rule in self.reference.model.rules
            if rule.name in wanted
            for instance in self.reference.instances(state, rule)
        )

    # ---- verdicts ----

    def of_launch(self, launch: Launch, state: State) -> RuleVerdict:
        """Return the verdict of a launch rule on a state: `launch` iff its condition holds, else `nothing`."""
        facts = Facts(self.reference.model, state).of(launch.condition)
        demand: Demand = "launch" if holds(self.reference.model, state, launch.condition) else "nothing"
        return self._verdict(launch, demand, NOW, facts)

    def _rule_verdict(
        self,
        state: State,
        instance: Instance,
        demand: Demand,
        scene: "ImaginedScene",
        attempts: tuple[Attempt, ...] = (),
    ) -> RuleVerdict:
        """Return the verdict of a rule with the facts of its F; where F needs it, stopping slots are taken as idle."""
        moment = scene.moment
        if demand != "nothing" and not self.reference.true(state, instance):
            state = state.idle(state.stopping())
            moment += ", the stopping slots taken as idle"
        facts = Facts(self.reference.model, state, scene.imagined)
        scope, slot = NOTHING, instance.slot
        own = (facts.active(slot),) if slot and demand != "nothing" else ()
        if slot:
            content = state.slots[slot[0]][slot[1]]
            if content is None:  # a rule is false of an idle slot, which has no arguments
                return self._verdict(instance.rule, demand, moment, (facts.active(slot),), attempts)
            scope = Scope(bind(self.reference.model.request[slot[0]].params, content.args))
        return self._verdict(instance.rule, demand, moment, own + facts.of(instance.rule.condition, scope), attempts)

    def _verdict(
        self, item: Guard | Rule | Launch, demand: Demand, moment: str, facts: tuple[Fact, ...],
        attempts: tuple[Attempt, ...] = (),
    ) -> RuleVerdict:  # fmt: skip
        written = self.written.get(item.location)
        return RuleVerdict(item.name, item.because, written, item.location, demand, moment, facts, attempts)


@dataclass(frozen=True, slots=True)
class ImaginedScene:
    """The hypothetical part of a moment: the words for what is in each slot that is imagined, and for the moment."""

    imagined: Mapping[SlotId, str]
    moment: str

    def without(self, cleared: Iterable[SlotId]) -> "ImaginedScene":
        """Return the scene with the slots to clear taken as idle."""
        return replace(self, moment=_without(self.moment, cleared))


def _without(moment: str, cleared: Iterable[SlotId]) -> str:
    names = dict.fromkeys(name for name, _ in cleared)
    return f"{moment}, {', '.join(names)} taken as idle" if names else moment
