"""What `exover swap` asks of OLD, answered as the command does."""

from exover.limits import Limits
from exover.loop.claim import Verdict
from exover.model.property import Properties, Property
from exover.pipeline import Build, property_findings
from exover.swap.prove import AskProperties


def proved(old: Build) -> AskProperties:
    """Return who answers for the properties of OLD."""

    def ask(asked: tuple[Property, ...]) -> dict[str, Verdict]:
        findings = property_findings(old, Properties(asked), lambda _: None, Limits(jobs=1))
        return {finding.subject: finding.verdict for finding in findings}

    return ask
