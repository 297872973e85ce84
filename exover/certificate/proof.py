"""The proof of one claim: sets of moments inside of the claim's parts, or around them (docs/certificates.md)."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from exover.certificate.check import Checker
from exover.certificate.step import FORGOTTEN, Event, inputs, step, within
from exover.certificate.table import REAL, Refused
from exover.certificate.term import conj, disj, lifted, neg, z3

State = dict[str, Any]


class Proof:
    """A claim and its proof: a part for each temporal operator, in the order of the claim.

    `promises`: the Bools of a linear claim, which say what is true one moment later; `kept`: that those of the moment
    before are; `constraints`: what a run without end meets again and again, by name.
    """

    def __init__(self, checker: Checker, claim: Any, parts: Any) -> None:
        self.checker, self.claim, self.parts = checker, claim, list(parts)
        self.promises: list[Any] = []
        self.kept: list[Any] = []
        slots = range(len(checker.table.owner)) if claim["fair"] else ()
        self.constraints = {f"reported.{slot}": checker.vars[f"phase.{slot}"] == 0 for slot in slots}

    def check(self, verdict: str) -> None:
        """Return if the proof shows that the verdict on the claim is right; `Refused` if it does not."""
        holds = {"holds": True, "violated": False}[verdict]
        found, initial = self.bound(self.claim["formula"], holds), self.checker.initial
        if self.claim["linear"]:  # some run that keeps its promises makes it false, or none does
            wrong = neg(found)
            some = self._rule("linear", not holds, self.parts.pop(0), wrong, conj(*self.kept), False)
            found = neg(conj(wrong, some)) if holds else neg(some)
        if self.checker.satisfiable("the claim follows", self.checker.at(neg(found) if holds else found, initial)):
            raise Refused("the claim does not follow from the proof")
        if self.parts:
            raise Refused("the proof has more parts than the claim")

    # ---- moments that a formula is true of: inside it, or around it ----

    def bound(self, said: Any, inside: bool) -> Any:
        """Return a set of moments in all of which a formula is true; or, if not `inside`, in none but which it is."""
        match said:
            case str():
                return self.checker.formula(said)
            case ["not", part]:
                return neg(self.bound(part, not inside))
            case ["and", *parts]:
                return conj(*[self.bound(part, inside) for part in parts])
            case ["or", *parts]:
                return disj(*[self.bound(part, inside) for part in parts])
            case ["X" | "U", *parts] if self.claim["linear"]:
                return self._promise(*parts)
            case ["EX" | "EU" | "EG", *_] if not self.claim["linear"]:
                return self._before(said, inside)[said[0] != "EX"]
        raise Refused("the claim is none")

    def _promise(self, first: Any, *more: Any) -> Any:
        """Return the truth of `X first` or `first U more`."""
        number = len(self.promises)
        promise, was = z3().Bools(f"promise.{number} was.{number}")
        self.promises.append(promise)
        left, *right = [self.bound(part, True) for part in (first, *more)]
        if not more:
            self.kept.append(was == lifted(left))
            return promise
        (goal,) = right
        until = disj(goal, conj(left, promise))
        self.kept.append(was == until)
        self.constraints[f"promise.{number}"] = disj(goal, neg(until))
        return until

    def _before(self, said: Any, inside: bool) -> tuple[Any, Any]:
        """Return a bound on the moments with a step to where an operator wants runs to be, and one on the operator."""
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
            case _:
                raise Refused("the claim is none")
        found = self._rule(said[0], inside, proof, True, stay, goal)
        return found, disj(goal, conj(stay, found))

    def _rule(self, operator: str, inside: bool, proof: Any, first: Any, stay: Any, goal: Any) -> Any:
        """Return a bound on the moments with a step to the goal, or to where it can stay and are of the bound again."""
        match proof["kind"], operator:
            case "run", "EG" | "linear" if inside:
                return self.lasso(proof, first, stay)
            case "run", "EX" | "EU" if inside:
                return self.run(proof, stay, goal)
            case "layers", "EX" | "EU" if inside:
                return self.layers(proof, stay, goal)
            case "ranking", "EG" | "linear" if not inside:
                return self.ranking(proof, stay)
            case "closed", "EX" | "EU" if not inside:
                return self.closed(proof, stay, goal)
            case "invariant", "EX" | "EU" if not inside:
                self.checker.refute("it does not follow from what is invariant", *self.checker.between, goal)
                return False
        raise Refused("a claim of this form cannot be proved so")

    # ---- the rules ----

    def _steps(self, event: Event) -> Iterator[tuple[list[Any], State, State, Any]]:
        """Yield for the start, and for all moments between steps, what is given, the moments before and after a step by
        an event, and when there is one that is assumed."""
        checker = self.checker
        names = {f"promise.{n}": z3().Bool(f"then.{n}") for n in range(len(self.promises))}
        names |= {f"was.{n}": promise for n, promise in enumerate(self.promises)}
        for given, before in (([], checker.initial), (checker.between, {})):
            now, enabled = checker.whole(event, bool(before))
            assumed = [checker.at(each, now.state) for each in checker.assumptions]
            yield given, before, now.state | names, conj(enabled, *assumed)

    def closed(self, proof: Any, stay: Any, goal: Any) -> Any:
        """Return states from outside of which no step leads to the goal, or to where one can stay and into them."""
        states, at = self.checker.formula(proof["states"]), self.checker.at
        for event in inputs(self.checker.table) if states is not True else ():
            for given, before, after, enabled in self._steps(event):
                outside, leads = at(neg(states), before), at(disj(goal, conj(stay, states)), after)
                self.checker.refute(f"{event[:3]} leads where it should not", *given, outside, enabled, leads)
        return states

    def layers(self, proof: Any, stay: Any, goal: Any) -> Any:
        """Return all layers, from each of which its event leads to the goal, or to where one can stay and before."""
        found, at = False, self.checker.at
        for number, layer in enumerate(proof["layers"]):
            states = self.checker.formula(layer["states"])
            for given, before, after, enabled in self._steps(self.event(layer["event"])):
                what, leads = f"layer {number} does not lead on", at(disj(goal, conj(stay, found)), after)
                if self.checker.satisfiable(what, *given, at(states, before), neg(conj(enabled, leads))):
                    if not before:
                        raise Refused(what)
                    states = conj(states, neg(self.checker.vars["start"]))
            found = disj(found, states)
        return found

    def ranking(self, proof: Any, stay: Any) -> Any:
        """Return what is in no layer: runs that stay leave each for one before, as it does not meet a constraint."""
        at = self.checker.at
        layers = [(each["never"], self._set(each["states"])) for each in proof["layers"]]
        for event in inputs(self.checker.table):
            for given, before, after, enabled in self._steps(event):
                lower, left = False, False
                for never, states in layers:
                    stays = conj(at(states, after), neg(at(self._meets(never, event), before)))
                    left = disj(left, conj(at(states, before), neg(lower), neg(stays)))
                    lower = disj(lower, at(states, after))
                staying = (at(stay, before), enabled, at(stay, after))
                self.checker.refute(f"{event[:3]} does not lead down the layers", *given, *staying, left)
        return neg(disj(*(states for _, states in layers)))

    def run(self, proof: Any, stay: Any, goal: Any) -> Any:
        """Return the moment of a run from which it stays where it can until it comes to the goal."""
        moments, _ = self._moments(proof["steps"])
        rest = moments[self._number(proof["from"], len(moments) - 1) + 1 :]
        for number, moment in enumerate(rest, 1):
            if not self.checker.true(disj(goal, stay) if number < len(rest) else goal, moment):
                raise Refused("the run does not show what it should")
        return self._exactly(moments[proof["from"]])

    def lasso(self, proof: Any, first: Any, stay: Any) -> Any:
        """Return the moment of a run without end that is `first`, keeps its promises and meets all constraints."""
        moments, events = self._moments(proof["steps"])
        end, begin = len(events), proof["from"]
        loop = self._number(proof["loop"], end)
        kept = [name for name in self.checker.vars if name.split(".")[0] not in FORGOTTEN]
        if self._number(begin, end) > loop or any(moments[loop][name] != moments[end][name] for name in kept):
            raise Refused("the run does not return to where it was")

        def at(expr: Any, number: int, before: int = 0) -> Any:
            names = {f"promise.{n}": z3().Bool(f"promise.{n}.{number}") for n in range(len(self.promises))}
            names |= {f"was.{n}": z3().Bool(f"promise.{n}.{before}") for n in range(len(self.promises))}
            return self.checker.at(expr, moments[number] | names)

        follow = [(number, number - 1) for number in range(begin + 1, end + 1)] + [(loop + 1, end)]
        met = [
            disj(*(at(self._meets(name, (*events, events[loop])[k]), k) for k in range(loop + 1, end + 1)))
            for name in self.constraints
        ]
        stays = [at(stay, *pair) for pair in follow]
        if not self.checker.satisfiable("the run shows what it should", at(first, begin), *stays, *met):
            raise Refused("the run does not show what it should")
        return self._exactly(moments[begin])

    # ---- what proofs are made of ----

    def _set(self, text: str) -> Any:
        return self.checker.formula(text, {str(promise): promise for promise in self.promises})

    def _meets(self, name: str | None, event: Event) -> Any:
        """Return when a moment that is left by an event meets a constraint; every one meets none."""
        return True if name is None or name == f"{event[0]}ed.{event[1]}" else self.constraints[name]

    def _number(self, value: Any, end: int) -> int:
        if type(value) is not int or not 0 <= value < end:
            raise Refused("the run is not so long")
        return value

    def _exactly(self, moment: State) -> Any:
        return conj(*(self.checker.vars[name] == lifted(moment[name]) for name in self.checker.lasting))

    def _moments(self, steps: Any) -> tuple[list[State], list[Event]]:
        """Return the moments of a run, every answer of which is that of the table, and its events."""
        moments, events = [self.checker.initial], []
        for number, said in enumerate(steps, 1):
            events.append(self.event(said["event"]))
            state, answers = step(self.checker.table, moments[-1], events[-1])
            if [list(answer) for answer in answers] != said["answers"]:
                raise Refused(f"the table answers step {number} of the run otherwise")
            if not self.checker.true(conj(*self.checker.assumptions), state):
                raise Refused(f"step {number} of the run is not one that is assumed")
            moments.append(state)
        return moments, events

    def event(self, said: Any) -> Event:
        """Return the event that is said, which must be one of the table; reals are texts of fractions."""
        for event in inputs(self.checker.table):
            if list(event[:3]) == said[:3]:
                pairs = list(zip(event[3], said[3], strict=True))
                values = [Fraction(v) if getattr(row, "type", None) == REAL else int(v) for row, v in pairs]
                if all(within(row, value) for (row, _), value in zip(pairs, values, strict=True)):
                    return (*event[:3], values)
        raise Refused(f"the table has no event {said}")
