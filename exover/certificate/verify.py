"""A certificate, finding by finding: what it claims follows from the proof that it gives, or it is refused."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from exover.certificate.check import Checker
from exover.certificate.step import Event, step
from exover.certificate.table import Refused, Table, decode
from exover.certificate.term import conj, disj, lifted, neg, z3

FORMAT = 1
SHAPE = {"certificate": int, "spec_sha256": str, "table_sha256": str, "assumptions": list, "invariant": list}
SHAPE |= {"findings": list, "requests": list, "reasons": list}
FINDING = {"check", "subject", "verdict", "claim", "proof"}
Finding = dict[str, Any]


class Unreadable(ValueError):
    """The file is no certificate at all."""


@dataclass(frozen=True)
class Verified:
    """What a certificate says of a table, all of it checked but for what is `unproved`, each with the reason."""

    proved: tuple[Finding, ...]
    unproved: tuple[tuple[Finding, str], ...]


def read(text: bytes) -> dict[str, Any]:
    """Return the certificate in a file; `Unreadable` if there is none."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable("it is not JSON") from error
    if not isinstance(found, dict) or not all(isinstance(found.get(key), kind) for key, kind in SHAPE.items()):
        raise Unreadable("it is no certificate")
    if found["certificate"] != FORMAT:
        raise Unreadable(f"its format is {found['certificate']}, and this program reads {FORMAT}")
    if not all(isinstance(each, dict) and each.keys() >= FINDING for each in found["findings"]):
        raise Unreadable("a finding of it is none")
    return found


def verify(data: bytes, certificate: dict[str, Any], expected: Sequence[Finding] | None, seconds: float) -> Verified:
    """Return what the certificate proves of the table with these bytes; `Refused` if something in it is not so.

    `expected`: the findings that the spec calls for, with their claims; None if there is no spec to tell. Raises
    `GaveUp` if the solver needs more than so many seconds for one implication.
    """
    table = decode(data)
    for what, its in (("table", table.sha256), ("spec", table.spec)):
        if certificate[f"{what}_sha256"] != its:
            raise Refused(f"the certificate is about another {what}")
    _complete(table, certificate, expected)
    checker = Checker(table, seconds)
    checker.assumptions = [checker.formula(text) for text in certificate["assumptions"]]
    checker.induction(certificate["invariant"])
    proved, unproved = [], []
    for finding in certificate["findings"]:
        try:
            if finding["proof"]["kind"] == "none":
                unproved.append((finding, str(finding["proof"]["reason"])))
            else:
                Proof(checker, finding).check()
                proved.append(finding)
        except Refused as error:
            raise Refused(f"{finding['check']} {finding['subject']}: {error}") from error
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise Refused(f"{finding['check']} {finding['subject']}: the proof is none") from error
    return Verified(tuple(proved), tuple(unproved))


def _complete(table: Table, certificate: dict[str, Any], expected: Sequence[Finding] | None) -> None:
    """Refuse a certificate that leaves out a finding, or claims something else than the spec calls for."""
    there = {(each["check"], each["subject"]): each["claim"] for each in certificate["findings"]}
    requests, reasons = certificate["requests"], certificate["reasons"]
    if len(there) != len(certificate["findings"]):
        raise Refused("a finding is there twice")
    if len(set(requests)) != len(table.requests) or len(reasons) != len(table.reasons):
        raise Refused("the names are not those of the table")
    wanted = {(check, name) for check in ("reachability", "deadlock", "lockout") for name in requests}
    wanted |= {(check, reasons[row.reason]) for check in ("safety", "completeness") for row in table.rules}
    wanted |= {("obligation", reasons[row.reason]) for row in table.launches}
    claims = {(each["check"], each["subject"]): each["claim"] for each in expected or ()}
    for check, subject in sorted((wanted | claims.keys()) - there.keys()):
        raise Refused(f"the finding {check} {subject} is left out")
    if expected is not None and there != claims:
        raise Refused("the claims are not those of the spec")


@dataclass
class Proof:
    """One finding, its claim and its proof."""

    checker: Checker
    finding: Finding

    def check(self) -> None:
        """Return if the proof shows that the verdict on the claim is right; `Refused` if it does not."""
        formula, proof = self.checker.formula, self.finding["proof"]
        holds = {"holds": True, "violated": False}[self.finding["verdict"]]
        if len(self.finding["claim"]) != 1:
            raise Refused("it claims more than one thing")
        match self.finding["claim"], proof["kind"]:
            case {"always": said}, kind:
                self._possible(neg(formula(said)), not holds, kind, proof)
            case {"possible": said}, kind:
                self._possible(formula(said), holds, kind, proof)
            case {"recoverable": {"since": since, "allowed": allowed, "goal": goal}}, "layers" if holds:
                self._layers(proof["layers"], formula(since), formula(allowed), formula(goal))
            case {"recoverable": {"since": since, "allowed": allowed, "goal": goal}}, "closed" if not holds:
                self._closed(proof["steps"], proof["states"], formula(since), formula(allowed), formula(goal))
            case _:
                raise Refused("a claim of this form cannot be proved so")

    def _possible(self, goal: Any, yes: bool, kind: str, proof: Any) -> None:
        """Check that some run leads to a moment that is so; or, if not `yes`, that none does."""
        checker = self.checker
        if yes and kind == "run":
            if not checker.true(goal, *self._run(proof["steps"])):
                raise Refused("the run does not show what it should")
        elif yes or kind not in ("invariant", "closed"):
            raise Refused("a claim of this form cannot be proved so")
        elif checker.true(goal, checker.initial, {}):
            raise Refused("what is claimed is not true at the start")
        elif kind == "invariant":
            checker.refute("what is claimed does not follow from what is invariant", *checker.between, goal)
        else:
            self._closed([], proof["states"], True, True, goal)

    def _run(self, steps: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the last state of a run, every answer of which is that of the table, and the facts of its step."""
        checker = self.checker
        state, facts = checker.initial, dict[str, Any]()
        for number, moment in enumerate(steps, 1):
            state, facts, answers = step(checker.table, state, self.event(moment["event"]))
            if [list(answer) for answer in answers] != moment["answers"]:
                raise Refused(f"the table answers step {number} of the run otherwise")
            if not checker.true(conj(*checker.assumptions), state, facts):
                raise Refused(f"step {number} of the run is not one that is assumed")
        return state, facts

    def event(self, said: Any) -> Event:
        """Return the event that is said, which must be one of the table; reals are texts of fractions."""
        for event, ranges in self.checker.inputs():
            if list(event[:3]) == said[:3]:
                pairs = zip(event[3], said[3], strict=True)
                values = [Fraction(value) if z3().is_real(term) else int(value) for term, value in pairs]
                given = [(term, lifted(value)) for term, value in zip(event[3], values, strict=True)]
                if z3().is_true(z3().simplify(z3().substitute(lifted(conj(*ranges)), *given))):
                    return (*event[:3], values)
        raise Refused(f"the table has no event {said}")

    def _layers(self, said: Any, since: Any, allowed: Any, goal: Any) -> None:
        """Check that from each layer its event leads to the goal or into a layer before, and `since` is in one."""
        checker, before = self.checker, dict[str, Any]()
        layers = [(self.event(layer["event"]), checker.formula(layer["states"])) for layer in said]
        starts = checker.true(since, checker.initial, before)
        reached: Any = False
        for number, (event, states) in enumerate(layers):
            now, enabled = checker.whole(event, [])
            good = conj(*checker.assumptions, allowed, disj(goal, reached))
            after = conj(enabled, checker.at(good, now.state, now.facts))
            checker.refute(f"layer {number} does not lead on", *checker.between, states, neg(after))
            if starts and checker.true(states, checker.initial, before):
                starts = not checker.true(good, *step(checker.table, checker.initial, event)[:2])
            reached = disj(reached, states)
        checker.refute("some states are in no layer", *checker.between, since, neg(reached))
        if starts:
            raise Refused("the layers do not lead on from the start")

    def _closed(self, steps: Any, said: Any, since: Any, allowed: Any, goal: Any) -> None:
        """Check that a run leads into states that no allowed event leaves, and none reaches the goal from them."""
        checker, states, first = self.checker, self.checker.formula(said), not steps
        if not checker.true(since if first else conj(since, states), *self._run(steps)):
            raise Refused("the run does not lead into these states")
        out = conj(*checker.assumptions, allowed, disj(goal, neg(states)))
        for event, ranges in checker.inputs():
            for start in (False, True) if first else (False,):
                now, enabled = checker.whole(event, ranges, start)
                given = [] if start else [*checker.between, states]
                after = checker.at(out, now.state, now.facts)
                checker.refute(f"{event[:3]} leads where it should not", *given, enabled, after)
