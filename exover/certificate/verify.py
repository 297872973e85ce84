"""A certificate, finding by finding: what it claims follows from the proof that it gives, or it is refused."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from exover.certificate.check import Checker, lifted
from exover.certificate.step import Event, step
from exover.certificate.table import Refused, Table, decode
from exover.certificate.term import conj, disj, neg, z3

FORMAT = 1
CLAIMS = {"always": 1, "possible": 1, "recoverable": 3}
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
    shape = {"certificate": int, "spec_sha256": str, "table_sha256": str, "assumptions": list, "invariant": list}
    shape |= {"findings": list, "requests": list, "reasons": list}
    if not isinstance(found, dict) or not all(isinstance(found.get(key), kind) for key, kind in shape.items()):
        raise Unreadable("it is no certificate")
    if found["certificate"] != FORMAT:
        raise Unreadable(f"its format is {found['certificate']}, and this program reads {FORMAT}")
    keys = {"check", "subject", "verdict", "claim", "proof"}
    if not all(isinstance(each, dict) and keys <= each.keys() for each in found["findings"]):
        raise Unreadable("a finding of it is none")
    return found


def verify(data: bytes, certificate: dict[str, Any], expected: Sequence[Finding] | None, seconds: float) -> Verified:
    """Return what the certificate proves of the table with these bytes; `Refused` if something in it is not so.

    `expected`: the findings that the spec calls for, with their claims; None if there is no spec to tell. Raises
    `GaveUp` if the solver needs more than so many seconds for one implication.
    """
    table = decode(data)
    if (table.sha256, table.spec) != (certificate["table_sha256"], certificate["spec_sha256"]):
        raise Refused(
            "the certificate is about another table"
            if table.sha256 != certificate["table_sha256"]
            else "the certificate is about another spec"
        )
    _complete(table, certificate, expected)
    checker = Checker(table, seconds)
    checker.assumptions = [checker.formula(text) for text in certificate["assumptions"]]
    checker.induction(certificate["invariant"])
    proved, unproved = [], []
    for finding in certificate["findings"]:
        try:
            reason = Proof(checker, finding).check()
        except Refused as error:
            raise Refused(f"{finding['check']} {finding['subject']}: {error}") from error
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise Refused(f"{finding['check']} {finding['subject']}: the proof is none") from error
        if reason is None:
            proved.append(finding)
        else:
            unproved.append((finding, reason))
    return Verified(tuple(proved), tuple(unproved))


def _complete(table: Table, certificate: dict[str, Any], expected: Sequence[Finding] | None) -> None:
    """Refuse a certificate that leaves out a finding, or claims something else than the spec calls for."""
    there = {(each["check"], each["subject"]): each["claim"] for each in certificate["findings"]}
    if len(there) != len(certificate["findings"]):
        raise Refused("a finding is there twice")
    wanted = {(check, name) for check in ("reachability", "deadlock", "lockout") for name in certificate["requests"]}
    reasons = certificate["reasons"]
    wanted |= {(check, reasons[row.reason]) for check in ("safety", "completeness") for row in table.rules}
    wanted |= {("obligation", reasons[row.reason]) for row in table.launches}
    if len(set(certificate["requests"])) != len(table.requests) or len(reasons) != len(table.reasons):
        raise Refused("the names are not those of the table")
    wanted |= {(each["check"], each["subject"]) for each in expected or ()}
    for check, subject in sorted(wanted - there.keys()):
        raise Refused(f"the finding {check} {subject} is left out")
    if expected is not None and there != {(each["check"], each["subject"]): each["claim"] for each in expected}:
        raise Refused("the claims are not those of the spec")


@dataclass
class Proof:
    """One finding, its claim and its proof."""

    checker: Checker
    finding: Finding

    def check(self) -> str | None:
        """Return None if the proof shows that the verdict on the claim is right, or why there is no proof."""
        claim, proof, verdict = self.finding["claim"], self.finding["proof"], self.finding["verdict"]
        if proof["kind"] == "none":
            return str(proof["reason"])
        if verdict not in ("holds", "violated") or not isinstance(claim, dict) or claim.keys() - CLAIMS.keys():
            raise Refused("nothing is claimed")
        ((form, said),) = claim.items()
        texts = [said] if isinstance(said, str) else [said[key] for key in ("since", "allowed", "goal")]
        if len(texts) != CLAIMS[form]:
            raise Refused("nothing is claimed")
        formulas = [self.checker.formula(text) for text in texts]
        holds = verdict == "holds"
        match (form, holds, proof["kind"]):
            case ("always", True, "invariant"):
                self._always(formulas[0])
            case ("possible", False, "invariant"):
                self._always(neg(formulas[0]))
            case ("always", True, "closed"):
                self._closed(self.checker.formula(proof["states"]), neg(formulas[0]))
            case ("possible", False, "closed"):
                self._closed(self.checker.formula(proof["states"]), formulas[0])
            case ("always", False, "run"):
                self._ends(proof, neg(formulas[0]))
            case ("possible", True, "run"):
                self._ends(proof, formulas[0])
            case ("recoverable", True, "layers"):
                self._layers(proof, *formulas)
            case ("recoverable", False, "trap"):
                self._trap(proof, *formulas)
            case _:
                raise Refused("a claim of this form cannot be proved so")
        return None

    def _always(self, claim: Any) -> None:
        checker = self.checker
        if not checker.true(claim, checker.initial, {}):
            raise Refused("what is claimed is not true at the start")
        checker.refute("what is claimed does not follow from what is invariant", *checker.between, neg(claim))

    def _run(self, proof: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the last moment of a run, every answer of which is that of the table."""
        checker = self.checker
        state, facts = checker.initial, dict[str, Any]()
        for number, moment in enumerate(proof["steps"], 1):
            state, facts, answers = step(checker.table, state, self.event(moment["event"]))
            if [list(answer) for answer in answers] != moment["answers"]:
                raise Refused(f"the table answers step {number} of the run otherwise")
            if not all(checker.true(each, state, facts) for each in checker.assumptions):
                raise Refused(f"step {number} of the run is not one that is assumed")
        return state, facts

    def _ends(self, proof: Any, claim: Any) -> None:
        if not self.checker.true(claim, *self._run(proof)):
            raise Refused("the run does not show what it should")

    def event(self, said: Any) -> Event:
        """Return the event that is said, which must be one of the table; reals are texts of fractions."""
        for event, ranges in self.checker.inputs():
            if list(event[:3]) == said[:3]:
                reals = [z3().is_real(term) for term in event[3]]
                values = [Fraction(value) if real else int(value) for real, value in zip(reals, said[3], strict=True)]
                pairs = [(term, lifted(value)) for term, value in zip(event[3], values, strict=True)]
                if all(z3().is_true(z3().simplify(z3().substitute(part, *pairs))) for part in ranges):
                    return (*event[:3], values)
        raise Refused(f"the table has no event {said}")

    def _layers(self, proof: Any, since: Any, allowed: Any, goal: Any) -> None:
        """Check that from each layer its event leads to the goal or into a layer before, and `since` is in one."""
        checker, reached = self.checker, False
        layers = [(self.event(layer["event"]), checker.formula(layer["states"])) for layer in proof["layers"]]
        for number, (event, states) in enumerate(layers):
            now, enabled = checker.whole(event, [])
            good = conj(*checker.assumptions, allowed, disj(goal, reached))
            after = conj(enabled, checker.at(good, now.state, now.facts))
            checker.refute(f"layer {number} does not lead on", *checker.between, states, neg(after))
            reached = disj(reached, states)
        checker.refute("some states are in no layer", *checker.between, since, neg(reached))
        state, facts = checker.initial, dict[str, Any]()
        if checker.true(since, state, facts):
            below = next((n for n, layer in enumerate(layers) if checker.true(layer[1], state, facts)), len(layers))
            state, facts, _ = step(checker.table, state, layers[below][0])
            ends = conj(*checker.assumptions, allowed, disj(goal, *(states for _, states in layers[:below])))
            if not checker.true(ends, state, facts):
                raise Refused("the layers do not lead on from the start")

    def _trap(self, proof: Any, since: Any, allowed: Any, goal: Any) -> None:
        """Check that a run leads into states that no allowed event leaves, and none reaches the goal from them."""
        checker, states = self.checker, self.checker.formula(proof["states"])
        if not checker.true(conj(since, states), *self._run(proof)):
            raise Refused("the run does not lead into the trap")
        out = conj(allowed, disj(goal, neg(states)))
        self._stays(states, out)
        if not proof["steps"]:
            self._stays(True, out, first=True)

    def _closed(self, states: Any, bad: Any) -> None:
        """Check that the first moment and all after it are not bad, since no event leaves these states."""
        checker = self.checker
        if checker.true(bad, checker.initial, {}):
            raise Refused("what is claimed is not true at the start")
        self._stays(states, disj(bad, neg(states)))
        self._stays(True, disj(bad, neg(states)), first=True)

    def _stays(self, states: Any, out: Any, first: bool = False) -> None:
        """Check that no event leads out of these states; with `first`, none from the initial one."""
        checker = self.checker
        between = [] if first else checker.between
        for event, ranges in checker.inputs():
            now, enabled = checker.whole(event, ranges, first)
            after = checker.at(conj(*checker.assumptions, out), now.state, now.facts)
            checker.refute(f"{event[:3]} leads where it should not", *between, states, enabled, after)
