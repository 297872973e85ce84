"""Findings with one cause, to be told once: of a useless rule, and of a rule that lacks a remedy."""

from collections.abc import Iterable, Iterator

from exover.checks.finding import Finding, FindingKey


def grouped(findings: Iterable[Finding]) -> dict[FindingKey, Finding]:
    """Return for each finding that need not be told by itself the finding that implies it.

    A rule that `rule-use` finds useless is redundant and has idle remedies, and a rule that no remedy restores is not
    safe. A finding with another excuse than its cause is told by itself.
    """
    violated = {finding.key: finding for finding in findings if finding.verdict == "violated"}
    pairs = ((finding, cause) for finding in violated.values() for cause in _causes(finding))
    found = ((finding, violated[cause]) for finding, cause in pairs if cause in violated)
    return {finding.key: cause for finding, cause in found if finding.excuse == cause.excuse}


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
