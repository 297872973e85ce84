"""Findings that have one cause, told once: a useless rule, and a rule that is broken for want of a remedy."""

from collections.abc import Iterable, Iterator

from exover.checks.finding import Finding

FindingKey = tuple[str, str]
"""Check and subject, which name a finding of one report."""


def key(finding: Finding) -> FindingKey:
    """Return what names a finding."""
    return finding.check, finding.subject


def grouped(findings: Iterable[Finding]) -> dict[FindingKey, Finding]:
    """Return by finding that need not be told by itself the one that tells it as well.

    A rule that `rule-use` finds useless is redundant and has idle remedies, and one that no remedy restores is not
    safe either. What is excused otherwise is told by itself.
    """
    violated = {key(finding): finding for finding in findings if finding.verdict == "violated"}
    pairs = ((finding, cause) for finding in violated.values() for cause in _causes(finding))
    found = ((finding, violated[cause]) for finding, cause in pairs if cause in violated)
    return {key(finding): cause for finding, cause in found if finding.excuse == cause.excuse}


def _causes(finding: Finding) -> Iterator[FindingKey]:
    """Yield the findings that tell this one as well, if they are there."""
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
    """Return the rule of a remedy by its name, as `still` of `still.reject` and `drive` of `drive.kill nd.goto`."""
    before, kill, _ = remedy.rpartition(".kill ")
    return before if kill else remedy.removesuffix(".reject").removesuffix(".wait")
