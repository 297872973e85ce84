"""One question of the closed loop per file (docs/checks.md)."""

from collections.abc import Iterator

from exover.checks.questions import (
    completeness,
    consistency,
    deadlock,
    idle_guard,
    lockout,
    obligation,
    property,
    reachability,
    redundancy,
    rule_use,
    safety,
    starvation,
    tables,
    vacuity,
)
from exover.checks.questions.question import Check
from exover.diagnostics import Severity
from exover.loop.claim import Claim
from exover.model.model import Model
from exover.model.property import Properties

CHECKS: tuple[Check, ...] = (
    consistency.CHECK,
    safety.CHECK,
    completeness.CHECK,
    reachability.CHECK,
    deadlock.CHECK,
    obligation.CHECK,
    tables.CHECK,
    property.CHECK,
    rule_use.CHECK,
    lockout.CHECK,
    starvation.CHECK,
    redundancy.CHECK,
    idle_guard.CHECK,
    vacuity.CHECK,
)
"""The checks, in the order of docs/checks.md."""
SEVERITY: dict[str, Severity] = {check.name: check.severity for check in CHECKS}
"""The severity of each check, in the same order."""


def claims(model: Model, properties: Properties) -> Iterator[Claim]:
    """Yield the claim of each check about each subject, in the order of docs/checks.md."""
    for check in CHECKS:
        for subject, _ in check.subjects(model, properties):
            yield check.claim(model, properties, subject)
