"""Is a rule already broken when the robot is switched on?"""

from exover.checks.finding import Finding
from exover.checks.questions.question import Check, Context, Question, rules
from exover.loop.claim import Claim
from exover.model.evaluate import holds
from exover.model.model import Model
from exover.model.property import Broken, Conjunction, Negation, Properties
from exover.model.trace import Trace

IFF = "the rule's condition is false in the initial state"
HOLDS = "the rule is not broken in the initial state"
VIOLATED = "the rule is broken in the initial state"
INITIAL = "initial state"


def decide(context: Context, question: Question) -> Finding:
    """Answer for a rule: holds iff `IFF`.

    Rules that stand for each slot of a request are skipped: they are about active slots, and initially there are none.
    """
    start = context.reference.start()
    named = context.model.rules_named(question.subject)
    if any(rule.slot_of is None and holds(context.model, start, rule.condition) for rule in named):
        return question.violated(VIOLATED, Trace(()), INITIAL)
    return question.holds(HOLDS, INITIAL)


def claim(model: Model, _: Properties, subject: str) -> Claim:
    """Return what `decide` answers, as a formula."""
    kept = Conjunction(tuple(Negation(Broken(rule, once_stopped=False)) for rule in model.rules_named(subject)))
    return Claim("consistency", subject, kept)


CHECK = Check("consistency", "error", IFF, rules, decide, claim, HOLDS, VIOLATED)
