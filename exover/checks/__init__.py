"""One question of the closed loop per file (docs/checks.md)."""

from exover.checks import (
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
from exover.checks.question import Check

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
