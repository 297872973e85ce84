"""The check of the proof of one claim: bounds on the moments at which its parts are true (docs/certificates.md)."""

from collections.abc import Iterator
from typing import Any

from exover.certificate.check import Checker, State
from exover.certificate.step import FORGOTTEN, Event, inputs, worded
from exover.certificate.table import Refused
from exover.certificate.term import conj, disj, lifted, neg, z3


class Proof:
    """A claim and its proof: a part for each temporal operator, in the order of the claim.

    `promises`: the Bools of a linear claim, which say what is true one moment later; `kept`: the conditions that the
    promises of the moment before are kept; `constraints`: by name, what an infinite run meets again and again.
    """

    def __init__(self, checker: Checker, claim: Any, parts: Any) -> None:
        self.checker, self.claim, self.parts = checker, claim, list(parts)
        self.promises, self.kept = list[Any](), list[Any]()
        slots = range(len(checker.table.owner)) if claim["fair"] else ()
        self.constraints = {f"reported.{slot}": checker.vars[f"phase.{slot}"] == 0 for slot in slots}

    def check(self, verdict: str) -> None:
        """Raise `Refused` unless the proof shows that the verdict on the claim is right."""
        holds = bool(("violated", "holds").index(verdict))
        found, initial = self.bound(self.claim["formula"], holds), self.checker.initial
        if self.claim["linear"]:  # some run that keeps its promises makes it false, or none does
            wrong = neg(found)
            some = self._rule("linear", not holds, self.parts.pop(0), wrong, conj(*self.kept), False)
            found = neg(conj(wrong, some)) if holds else neg(some)
        if self.checker.satisfiable("the claim follows", [], self.checker.at(neg(found) if holds else found, initial)):
            raise Refused("the claim does not follow from the proof")
        if self.parts:
            raise Refused("the proof has more parts than the claim")

    # ---- moments that a formula is true of: inside it, or around it ----

    def bound(self, said: Any, inside: bool) -> Any:
        """Return a set of moments: a subset of those at which a formula is true, or if not `inside` a superset."""
        match said:
            case str():
                return self.checker.formula(said)
            case ["not", part]:
                return neg(self.bound(part, not inside))
            case ["and", *parts]:
                return conj(*[self.bound(part, inside) for part in parts])
            case ["or", *parts]:
                return disj(*[self.bound(part, inside) for part in parts])
            case ["X", _] | ["U", _, _] if self.claim["linear"]:
                return self._promise(*said[1:])
            case ["EX" | "EG", _] | ["EU", _, _] if not self.claim["linear"]:
                return self._before(said, inside)[said[0] != "EX"]
        raise Refused("the claim is none")

    def _promise(self, *parts: Any) -> Any:
        """Return the condition that `X part`, or `left U goal`, is true, by a new promise."""
        number = len(self.promises)
        promise, was = z3().Bools(f"promise.{number} was.{number}")
        self.promises.append(promise)
        *left, goal = [self.bound(part, True) for part in parts]
        until = disj(goal, conj(*left, promise)) if left else goal
        self.kept.append(was == lifted(until))
        if left:
            self.constraints[f"promise.{number}"] = disj(goal, neg(until))
        return until if left else promise

    def _before(self, said: Any, inside: bool) -> tuple[Any, Any]:
        """Return a bound on the moments with a step to the target of an operator; one on those at which it is true."""
        proof, stay, goal = self.parts.pop(0), False, False
        match said:
            case ["EX", ["EU", *_] as part] if proof is None:
                return self._before(part, inside)
            case ["EX", part]:
                goal = self.bound(part, inside)
            case ["EU", left, right]:
                stay, goal = self.bound(left, inside), self.bound(right, inside)
            case ["EG", part]:
                stay = self.bound(part, inside)
                if proof is None and inside:
                    return False, False
        found = self._rule(said[0], inside, proof, True, stay, goal)
        return found, disj(goal, conj(stay, found))

    def _rule(self, operator: str, inside: bool, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the bound N that a proof gives on the moments with a step to `goal`, or to one in `stay` and N."""
        rules: Any = {
            (True, False): {"run": self.run, "layers": self.layers},
            (True, True): {"run": self.lasso},
            (False, True): {"ranking": self.ranking},
            (False, False): {"closed": self.closed, "invariant": self.invariant},
        }
        rule = rules[inside, operator in ("EG", "linear")].get(proof["kind"])
        if rule is None:
            raise Refused("a claim of this form cannot be proved so")
        return rule(proof, first, stay, goal)

    # ---- the rules ----

    def _steps(self, event: Event) -> Iterator[tuple[list[Any], State, State, Any]]:
        """Yield what is given, the moments before and after a step, and the condition that the step happens."""
        for given, before, now, enabled in self.checker.steps(event):
            yield given, before, now.state | self._named("then", "promise"), enabled

    def _named(self, now: str, before: str) -> State:
        """Return the variables of the promises of a moment, and of those of the moment before."""
        moments = (("promise", now), ("was", before))
        return {f"{said}.{n}": z3().Bool(f"{at}.{n}") for said, at in moments for n in range(len(self.promises))}

    def invariant(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the empty set, having checked that the goal is true of no moment after a step."""
        self.checker.refute("it does not follow from what is invariant", self.checker.between, goal)
        return False

    def closed(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return a set from outside of which no step leads to the goal, or to a moment in `stay` and the set."""
        states, at = self.checker.formula(proof["states"]), self.checker.at
        for event in inputs(self.checker.table) if states is not True else ():
            for given, before, after, enabled in self._steps(event):
                leads = at(disj(goal, conj(stay, states)), after)
                what = f"{worded(event)} leads where it should not"
                self.checker.refute(what, given, at(neg(states), before), enabled, leads)
        return states

    def layers(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the union of layers: from each its event leads to the goal, or to a layer before within `stay`."""
        found, at = False, self.checker.at
        for number, layer in enumerate(proof["layers"]):
            states, what = self.checker.formula(layer["states"]), f"layer {number} does not lead on"
            for given, before, after, enabled in self._steps(self.checker.event(layer["event"])):
                leads = conj(enabled, at(disj(goal, conj(stay, found)), after))
                if self.checker.satisfiable(what, given, at(states, before), neg(leads)):
                    if given:
                        raise Refused(what)
                    states = conj(states, neg(self.checker.vars["start"]))
            found = disj(found, states)
        return found

    def ranking(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return what is in no layer: steps within `stay` lead to a layer before, or stay and do not meet `never`."""
        at, promises = self.checker.at, {str(promise): promise for promise in self.promises}
        layers = [(each["never"], self.checker.formula(each["states"], promises)) for each in proof["layers"]]
        for event in inputs(self.checker.table):
            for given, before, after, enabled in self._steps(event):
                lower, left = False, False
                for never, states in layers:
                    stays = conj(at(states, after), neg(at(self._meets(never, event), before)))
                    left = disj(left, conj(at(states, before), neg(disj(lower, stays))))
                    lower = disj(lower, at(states, after))
                what = f"{worded(event)} does not lead down the layers"
                self.checker.refute(what, given, at(stay, before), enabled, at(stay, after), left)
        return neg(disj(*(states for _, states in layers)))

    def _meets(self, name: str | None, event: Event) -> Any:
        """Return the condition that a moment, left by an event, meets a constraint; None is met by every moment."""
        return True if name is None or name == f"{event[0]}ed.{event[1]}" else self.constraints[name]

    def run(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the moment `from` of a run, which ends in the goal and is in the goal or in `stay` between the two."""
        moments, _ = self._moments(proof)
        shown = [self.checker.at(disj(goal, stay), moment) for moment in moments[proof["from"] + 1 : -1]]
        return self._shown(moments[proof["from"]], *shown, self.checker.at(goal, moments[-1]))

    def lasso(self, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return the moment `from` of a lasso: it is in `first`, all later ones in `stay`; each constraint is met."""
        moments, events = self._moments(proof)
        begin, loop, end = proof["from"], proof["loop"], len(events)
        kept = [name for name in self.checker.vars if name.split(".")[0] not in FORGOTTEN]
        if loop not in range(begin, end) or any(moments[loop][name] != moments[end][name] for name in kept):
            raise Refused("the run does not return to where it was")

        def at(expr: Any, number: int, before: int) -> Any:
            return self.checker.at(expr, moments[number] | self._named(f"at.{number}", f"at.{before}"))

        shown = [at(first, begin, begin), at(stay, loop + 1, end)]
        shown += [at(stay, number, number - 1) for number in range(begin + 1, end + 1)]
        leaving = list(enumerate([*events, events[loop]]))[loop + 1 :]
        for name in self.constraints:
            shown.append(disj(*(at(self._meets(name, event), number, number) for number, event in leaving)))
        return self._shown(moments[begin], *shown)

    def _shown(self, moment: State, *parts: Any) -> Any:
        """Return the formula of one moment alone; raises `Refused` unless all of the parts are true."""
        if not self.checker.satisfiable("the run shows what it should", [], *parts):
            raise Refused("the run does not show what it should")
        return conj(*(self.checker.vars[name] == lifted(moment[name]) for name in sorted(self.checker.lasting)))

    # ---- runs ----

    def _moments(self, proof: Any) -> tuple[list[State], list[Event]]:
        """Return the moments of a run and its events; raises `Refused` if the table answers otherwise."""
        checker, moments, events = self.checker, [self.checker.initial], []
        for number, said in enumerate(proof["steps"], 1):
            events.append(self.checker.event(said["event"]))
            now, enabled = checker.whole(events[-1], moments[-1], [])
            moments.append(now.state)
            if now.said() != said["answers"]:
                raise Refused(f"the table answers step {number} of the run otherwise")
            if not checker.true(enabled, now.state):
                raise Refused(f"step {number} of the run cannot be, or is not assumed")
        if proof["from"] not in range(len(events)):
            raise Refused("the run is not so long")
        return moments, events
