"""The checks of tables as decision diagrams alone answer them."""

from collections.abc import Collection

from exover.checks.run import CheckOutcome, check_all
from exover.checks.schedule.answers import NO_STORE, AnswerStore
from exover.checks.schedule.engines import DIAGRAMS
from exover.checks.schedule.plan import CheckPlan
from exover.limits import NO_LIMITS, Limits
from exover.model.property import NO_PROPERTIES, Properties
from exover.ocrd.compile import Compiled


def check_by_diagrams(
    compiled: Compiled,
    checks: Collection[str] | None = None,
    properties: Properties = NO_PROPERTIES,
    *,
    count: bool = False,
    limits: Limits = NO_LIMITS,
    store: AnswerStore = NO_STORE,
) -> CheckOutcome:
    """Return the findings of the checks of these names (None: of all) on tables."""
    plan = CheckPlan(checks, properties, DIAGRAMS, count)
    return check_all(compiled, lambda _: None, plan, limits=limits, store=store)
