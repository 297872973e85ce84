"""Has the checker a remedy whenever a rule is broken?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, rules, unbroken
from exover.loop.claim import Claim, after_every_step
from exover.model.model import Model
from exover.model.property import Broken, Conjunction, Negation, Properties

IFF = "no reachable step raises `violation` for the rule"
HOLDS = "no step raises a violation of the rule"
VIOLATED = "a step breaks the rule, and none of its remedies restores it"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff `IFF`."""
    return unbroken(context, question, lambda rule: context.analysis.broken((rule,)), HOLDS, VIOLATED)


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    kept = Conjunction(tuple(Negation(Broken(rule, once_stopped=True)) for rule in model.rules_named(subject)))
    return Claim("completeness", subject, after_every_step(kept))


CHECK = Check("completeness", "error", IFF, rules, decide, claim, HOLDS, VIOLATED)
