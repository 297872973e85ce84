"""Findings with one cause, to be told once: of a useless rule, a rule without a remedy, contradictory assumptions."""

from collections.abc import Iterable, Iterator

from exover.checks.finding import Finding, FindingKey
from exover.checks.questions.property import is_contradiction


def grouped(findings: Iterable[Finding]) -> dict[FindingKey, Finding]:
    """Return for each finding that need not be told by itself the finding that implies it.

    A rule that `rule-use` finds useless is redundant and has idle remedies, and a rule that no remedy restores is not
    safe. Assumptions that contradict each other violate every property. A finding with another excuse than its cause is
    told by itself.
    """
    violated = {finding.key: finding for finding in findings if finding.verdict == "violated"}
    pairs = ((finding, cause) for finding in violated.values() for cause in _causes(finding))
    found = [(finding, violated[cause]) for finding, cause in pairs if cause in violated]
    found += _contradicted(violated.values())
    return {finding.key: cause for finding, cause in found if finding.excuse == cause.excuse}


def _contradicted(violated: Iterable[Finding]) -> Iterator[tuple[Finding, Finding]]:
    """Yield the properties for which the same contradiction of assumptions is told, each with the first of these."""
    first: dict[str, Finding] = {}
    for finding in violated:
        if finding.check == "property" and is_contradiction(finding.message):
            cause = first.setdefault(finding.message, finding)
            if cause is not finding:
                yield finding, cause


def _causes(finding: Finding) -> Iterator[FindingKey]:
    """Yield the keys of the findings that imply this one."""
    match finding.check:
        case "safety":
            yield "completeness", finding.subject
        case "redundancy":
            yield "rule-use", finding.subject
        case "idle-guard":
            yield "rule-use", finding.subject
            yield "rule-use", rule_of(finding.subject)
        case _:
            pass


def rule_of(remedy: str) -> str:
    """Return the name of the rule of a remedy: `still` of `still.reject`, `drive` of `drive.kill nd.goto`."""
    before, kill, _ = remedy.rpartition(".kill ")
    return before if kill else remedy.removesuffix(".reject").removesuffix(".wait")
