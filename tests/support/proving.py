"""What `exover swap` asks of OLD, answered as the command does."""

from exover.checks.schedule.plan import CheckPlan
from exover.limits import Limits
from exover.model.property import Properties, Property
from exover.pipeline import Build, check
from exover.swap.prove import AskProperties


def proved(old: Build) -> AskProperties:
    """Return who answers for the properties of OLD."""

    def ask(asked: tuple[Property, ...]) -> dict[str, str]:
        if not asked:
            return {}
        outcome = check(old, lambda _: None, CheckPlan(("property",), Properties(asked)), limits=Limits(jobs=1))
        return {finding.subject: finding.verdict for finding in outcome.findings}

    return ask  # type: ignore[return-value]
