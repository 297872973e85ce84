"""The certificate of the findings: each finding with its claim and, if one is found, the proof of the claim."""

import json
from collections.abc import Iterable
from hashlib import sha256

from exover.certificate.verify import FORMAT
from exover.checks.finding import Finding
from exover.checks.questions import claims
from exover.loop.claim import Claim, Progress
from exover.model.index import ModelIndex
from exover.model.model import Model
from exover.model.property import Properties
from exover.model.wire import Json
from exover.ocrd.compile import Compiled
from exover.ocrd.reasons import reasons
from exover.proofs.prove import CertificateProver
from exover.proofs.statement import Statement, Unsaid, facts


def certificate(
    compiled: Compiled,
    data: bytes,
    findings: Iterable[Finding],
    properties: Properties,
    version: str,
    progress: Progress,
) -> Json:
    """Return the certificate of findings about the table with these bytes."""
    asked = {(claim.check, claim.subject): claim for claim in claims(compiled.model, properties)}
    said = tuple(findings)
    prover = CertificateProver(compiled, data, properties, asked, said, progress)
    return {
        "certificate": FORMAT,
        "tool": f"exover {version}",
        "spec": compiled.model.name,
        "spec_sha256": compiled.tables.digest.hex(),
        "table_sha256": sha256(data).hexdigest(),
        **_names(compiled.model),
        "assumptions": prover.assumptions,
        "watched": prover.statement.watched(),
        "invariant": prover.invariants.parts,
        "kept": prover.invariants.kept,
        "findings": [prover.finding(finding) for finding in said],
    }


def render(found: Json) -> bytes:
    """Return the certificate as it is written to a file: the same certificate gives the same bytes."""
    return (json.dumps(found, indent=1, ensure_ascii=True) + "\n").encode()


def expected(model: Model, properties: Properties) -> Json:
    """Return what every certificate of a spec and its properties must contain: names, and findings with claims."""
    asked = tuple(claims(model, properties))
    statement = Statement(model, facts(asked, properties))
    return {
        "spec": model.name,
        **_names(model),
        "assumptions": [statement.moment(each.formula) for each in properties.assumptions],
        "watched": statement.watched(),
        "findings": [
            {"check": claim.check, "subject": claim.subject, "claim": _said(statement, claim)} for claim in asked
        ],
    }


def _names(model: Model) -> Json:
    """Return the names of requests and reasons by number."""
    return {
        "requests": list(ModelIndex(model).requests),
        "reasons": [reason.rule for reason in reasons(model)],
    }


def _said(statement: Statement, claim: Claim) -> Json | None:
    try:
        return statement.claim(claim)
    except Unsaid:
        return None
