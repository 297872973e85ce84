"""The check of a certificate, finding by finding: each claim must follow from its proof, or it is refused."""

import json
from dataclasses import dataclass
from typing import Any

from exover.certificate.check import Checker
from exover.certificate.proof import Proof
from exover.certificate.table import Refused, Table, decode
from exover.certificate.term import z3

FORMAT = 3
NAMED = ("spec", "requests", "reasons", "assumptions", "watched")
"""The keys of a certificate that a spec and its properties determine, as they do the claims."""
KEYS = {*NAMED, "findings", "tool", "spec_sha256", "table_sha256", "invariant", "kept"}
FINDING = {"check", "subject", "verdict", "claim", "proof"}


class Unreadable(ValueError):
    """The file is no certificate at all."""


@dataclass(frozen=True)
class Verified:
    """The findings of a certificate: `proved` of the table, and `unproved`, each with the reason that it states."""

    proved: tuple[dict[str, Any], ...]
    unproved: tuple[tuple[dict[str, Any], str], ...]


def read(text: bytes) -> dict[str, Any]:
    """Return the certificate in the bytes of a file; raises `Unreadable` if they are none."""
    try:  # an object in which a key stands twice is none
        found = json.loads(text, object_pairs_hook=lambda said: dict(said) if len(dict(said)) == len(said) else None)
    except (ValueError, RecursionError) as error:
        raise Unreadable("it is not JSON") from error
    if not isinstance(found, dict) or "certificate" not in found:
        raise Unreadable("it is no certificate")
    if json.dumps(found["certificate"]) != str(FORMAT):
        raise Unreadable(f"its format is {json.dumps(found['certificate'])}, and this program reads {FORMAT}")
    findings = found["findings"] if isinstance(found.get("findings"), list) else ()
    for what, said, keys in [("it", found, KEYS), *(("a finding", each, FINDING) for each in findings)]:
        if lacking := keys - (said.keys() if isinstance(said, dict) else set()):
            raise Unreadable(f"it is no certificate: {what} lacks `{min(lacking)}`")
    return found


def verify(data: bytes, certificate: dict[str, Any], expected: dict[str, Any] | None, seconds: float) -> Verified:
    """Return what the certificate proves of the table with these bytes; raises `Refused` if a check of it fails.

    `expected`: the findings with their claims, and the keys in `NAMED`, as derived from the spec; None if there is no
    spec. Raises `SolverGaveUp` if the solver needs more than `seconds` for one implication.
    """
    proved, unproved, about = [], [], ""
    try:
        table = decode(data)
        for what, its in (("table", table.sha256), ("spec", table.spec)):
            if certificate[f"{what}_sha256"] != its:
                raise Refused(f"the certificate is about another {what}")
        _complete(table, certificate, expected or certificate)
        checker = Checker(table, seconds, watched=certificate["watched"])
        checker.assumptions = [checker.formula(text) for text in certificate["assumptions"]]
        checker.induction(certificate["invariant"])
        checker.keep(certificate["kept"])
        for finding in certificate["findings"]:
            about = f"{finding['check']} {finding['subject']}: "
            if finding["verdict"] not in ("holds", "violated", "unknown"):
                raise Refused(f"{json.dumps(finding['verdict'])} is no verdict")
            if finding["proof"]["kind"] == "none":
                unproved.append((finding, str(finding["proof"]["reason"])))
            else:
                Proof(checker, finding["claim"], finding["proof"]["parts"]).check(finding["verdict"])
                proved.append(finding)
    except (Refused, LookupError, TypeError, ValueError, AttributeError, RecursionError, z3().Z3Exception) as error:
        lacks: Any = {KeyError: f"lacks {error}", IndexError: "has fewer parts than the claim"} if about else {}
        what = lacks.get(type(error), "has not the form that docs/certificates.md says")
        what = str(error) if isinstance(error, Refused) else f"{'the proof' if about else 'it, or the table,'} {what}"
        raise Refused(f"{about}{what}") from error
    return Verified(tuple(proved), tuple(unproved))


def _complete(table: Table, certificate: dict[str, Any], expected: dict[str, Any]) -> None:
    """Refuse a certificate that leaves out a finding, or in which names or claims are not those expected."""
    there, claims = ({(f["check"], f["subject"]): f["claim"] for f in c["findings"]} for c in (certificate, expected))
    requests, reasons = certificate["requests"], certificate["reasons"]
    if len(there) != len(certificate["findings"]):
        raise Refused("a finding is there twice")
    for key in NAMED:
        if certificate[key] != expected[key]:
            raise Refused(f"its `{key}` is not what the spec and its properties say")
    if len(set(requests)) != len(table.requests) or len(reasons) != len(table.reasons):
        raise Refused("the names are not those of the table")
    rules = {reasons[row.reason] for row in table.rules}
    wanted = {(check, name) for check in ("reachability", "deadlock", "lockout", "starvation") for name in requests}
    wanted |= {(check, name) for check in ("consistency", "safety", "completeness", "rule-use") for name in rules}
    wanted |= {(check, reasons[row.reason]) for check in ("obligation", "rule-use") for row in table.launches}
    for check, subject in sorted((wanted | claims.keys()) - there.keys()):
        raise Refused(f"the finding {check} {subject} is left out")
    if there != claims:
        raise Refused("the claims are not those of the spec")
