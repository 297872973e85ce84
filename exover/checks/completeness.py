"""Has the checker a remedy whenever a rule is broken?"""

from exover.checks.finding import Finding
from exover.checks.question import INDUCTION, PREVENTED, RESTORED, Check, Context, Question, rules


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff no reachable step raises `violation` for it."""
    analysis = context.analysis
    if analysis.equivalence.prevents(context.rules[question.subject]):
        return question.holds(PREVENTED, INDUCTION)
    bad = analysis.broken(context.rules[question.subject])
    if analysis.excluded(bad):
        return question.holds(RESTORED, INDUCTION)
    trace = analysis.run_into(bad)
    if trace is None:
        return question.holds("no step raises a violation of the rule")
    return question.violated("a step breaks the rule, and none of its remedies restores it", trace)


CHECK = Check("completeness", "error", rules, decide)
