"""Has the checker a remedy whenever a rule is broken?"""

from exover.checks.finding import Finding
from exover.checks.question import INDUCTION, PREVENTED, Check, Context, Question, rules


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff no reachable step raises `violation` for it."""
    analysis = context.analysis
    if analysis.equivalence.prevents(context.rules[question.subject]):
        return question.holds(PREVENTED, INDUCTION)
    bad = analysis.among(analysis.broken(context.rules[question.subject]), analysis.reached.after)
    if bad == analysis.space.none:
        return question.holds("no step raises a violation of the rule")
    return question.violated("a step breaks the rule, and none of its remedies restores it", analysis.run_into(bad))


CHECK = Check("completeness", "error", rules, decide)
